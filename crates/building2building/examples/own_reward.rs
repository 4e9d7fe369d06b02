//! A custom reward: only the coldest zone counts, and energy costs half as much at night.
//!
//! `cargo run --release -p building2building --example own_reward`

use building2building::{Reactive, Reward, RewardFunction, StepView, Term, make, rollout};

#[derive(Debug)]
struct ColdestZone;

impl RewardFunction for ColdestZone {
    fn reward(&mut self, step: &StepView<'_>) -> Reward {
        let coldest = step.zones.iter().map(|zone| zone.target - zone.temperature).fold(0.0, f64::max);
        let price = if (6.0..22.0).contains(&step.hour) { 1.0 } else { 0.5 };
        Reward { temperature_penalty: coldest, energy_penalty: price * step.terms[Term::Energy] }
    }
}

fn main() -> building2building::Result<()> {
    let env = make("OfficeSmall")?.task("occupancy").period("01-01..01-01").build()?;
    let mut env = env.with_reward(ColdestZone);
    let mut controller = Reactive::for_env(&env);
    let metrics = rollout(&mut env, &mut controller, &mut ())?;
    println!("return {:.1}", metrics.episode_return);
    Ok(())
}
