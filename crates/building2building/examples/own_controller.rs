//! A custom controller, compared with the built-in ones, and an observer that watches the episode.
//!
//! `cargo run --release -p building2building --example own_controller`

use building2building::env::ActionSpace;
use building2building::{Constant, Controller, Reactive, Step, make, rollout};

/// Holds every actuator at the same share of its range.
struct Share {
    action: Vec<f64>,
}

impl Share {
    fn new(space: &ActionSpace, share: f64) -> Self {
        let bounds = space.low().iter().zip(space.high());
        Self { action: bounds.map(|(low, high)| low * (1.0 - share) + high * share).collect() }
    }
}

impl Controller for Share {
    fn reset(&mut self) {}

    fn act(&mut self, _observation: &[f64], action: &mut [f64]) {
        action.copy_from_slice(&self.action);
    }
}

fn main() -> building2building::Result<()> {
    let mut env = make("SingleFamilyHouse")?.task("constant").period("01-01..01-01").build()?;
    let controllers: [(&str, Box<dyn Controller>); 3] = [
        ("reactive", Box::new(Reactive::for_env(&env))),
        ("middle of the range", Box::new(Constant::middle(env.action_space()))),
        ("a fifth of the range", Box::new(Share::new(env.action_space(), 0.2))),
    ];
    for (name, mut controller) in controllers {
        let mut worst: f64 = 0.0;
        let mut watch = |step: &Step<'_>| {
            worst = worst.max(step.reward.temperature_penalty);
            Ok(())
        };
        let metrics = rollout(&mut env, controller.as_mut(), &mut watch)?;
        println!("{name}: return {:.1}, worst step {worst:.1}", metrics.episode_return);
    }
    Ok(())
}
