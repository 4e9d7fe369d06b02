//! The controllers that a run can have.

use b2b_building::PreparedBuilding;
use b2b_control::{Constant, Controller, Random, Reactive, ReactiveParameters};
use b2b_env::Env;

/// Who acts.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub enum Kind {
    /// Proportional and staged control of every system, as a building would come with
    Reactive,
    /// A fresh uniform action at every step
    Random,
    /// The middle of every bound, always
    Constant,
}

impl Kind {
    /// Name, as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reactive => "reactive",
            Self::Random => "random",
            Self::Constant => "constant",
        }
    }

    /// A controller of this kind for an environment.
    pub fn build(self, env: &Env, seed: u64) -> Box<dyn Controller> {
        let building: &PreparedBuilding = env.building();
        match self {
            Self::Reactive => {
                let (space, steps_per_hour) = (env.observation_space(), env.episode().steps_per_hour);
                Box::new(Reactive::new(building, space, steps_per_hour, &ReactiveParameters::default()))
            }
            Self::Random => Box::new(Random::new(env.action_space(), seed)),
            Self::Constant => Box::new(Constant::middle(env.action_space())),
        }
    }
}
