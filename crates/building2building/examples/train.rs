//! Trains an agent that corrects the reactive controllers, and compares both.
//!
//! `cargo run --release -p building2building --example train -- runs/example OfficeSmall-0509 01-01..01-31 100000`

use building2building::agent::Agent;
use building2building::learn::train::TrainConfig;
use building2building::{Controller, Env, Reactive, make, rollout, run_if_worker, train};

fn main() -> building2building::Result<()> {
    // A worker starts this program again.
    run_if_worker();
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or_else(|| "runs/example".into());
    let building = arguments.next().unwrap_or_else(|| "SingleFamilyHouse-0014".into());
    let period = arguments.next().unwrap_or_else(|| "01-08..01-14".into());
    let steps = arguments.next().and_then(|steps| steps.parse().ok()).unwrap_or(10_000);

    let mut config = TrainConfig::preset("residual")?;
    config.training_set.buildings = vec![building.clone()];
    config.training_set.task = "occupancy".parse()?;
    config.training_set.period.clone_from(&period);
    config.training_set.window_days = 1;
    config.budget.steps = steps;
    config.budget.environments = 4;
    let summary = train(&config, &folder)?;
    println!("{} steps at {:.0}/s", summary.steps, summary.steps_per_s);
    if let Some(scores) = summary.scores {
        println!("score {:.4}", scores.mean.score);
    }

    let mut env = make(&building)?.task("occupancy").period(&period).build()?;
    let mut reactive = Reactive::for_env(&env);
    report("reactive", &mut env, &mut reactive)?;
    let mut agent = Agent::read(folder.as_ref())?.controller(env.spaces())?;
    report("agent", &mut env, &mut agent)
}

fn report(name: &str, env: &mut Env, controller: &mut dyn Controller) -> building2building::Result<()> {
    let metrics = rollout(env, controller, &mut ())?;
    println!(
        "{name}: return {:.3}, RMS deviation {:.3} K, {:.1} strokes/day",
        metrics.episode_return,
        metrics.rms_deviation(),
        metrics.daily_travel()
    );
    Ok(())
}
