//! An episode of a small office, step by step, under the reactive controllers.
//!
//! `cargo run --release -p building2building --example one_episode -- OfficeSmall winter`

use building2building::{Controller, Reactive, Term, make};

fn main() -> building2building::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let building = arguments.next().unwrap_or_else(|| "OfficeSmall".into());
    let period = arguments.next().unwrap_or_else(|| "01-01..01-01".into());
    let mut env = make(&building)?.task("occupancy").period(&period).build()?;
    println!("{} actuators: {}", env.action_space().len(), env.action_space().names().join(", "));

    let mut controller = Reactive::for_env(&env);
    let mut action = vec![0.0; env.action_space().len()];
    let mut observation = env.reset()?;
    loop {
        controller.act(observation, &mut action);
        let step = env.step(&action)?;
        if step.truncated {
            break;
        }
        observation = step.observation;
    }
    let metrics = env.metrics();
    println!("{} steps, return {:.1}", metrics.steps, metrics.episode_return);
    let electricity = metrics.total(Term::Electricity);
    println!("RMS deviation {:.2} K, electricity {electricity:.0} Wh/m²", metrics.rms_deviation());
    Ok(())
}
