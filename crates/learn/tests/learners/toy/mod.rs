//! Small environments that compute in microseconds, and a collector of their steps in this process.

mod hidden;
mod local;
mod pendulum;
mod room;

pub use hidden::Hidden;
pub use local::{Local, mean_return};
pub use pendulum::Pendulum;
pub use room::Room;

use b2b_learn::random::RandomStream;
use b2b_learn::rollout::Widths;

/// An environment.
pub trait Toy {
    /// Widths of observation, action and reward.
    const WIDTHS: Widths;
    /// Steps of an episode.
    const STEPS: usize;
    /// Factor of the rewards that a learner reads.
    const REWARD_SCALE: f32;

    /// Returns an environment at the beginning of an episode.
    fn reset(random: &mut RandomStream) -> Self;

    /// Writes the observation.
    fn observe(&self, observation: &mut [f32]);

    /// Makes a step with an action, which is clipped to -1 to 1, and writes the parts of its reward.
    fn step(&mut self, action: &[f32], random: &mut RandomStream, rewards: &mut [f32]);
}
