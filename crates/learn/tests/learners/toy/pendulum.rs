//! The pendulum of Gymnasium's `Pendulum-v1`, with actions from -1 to 1.

use std::f32::consts::{PI, TAU};

use b2b_learn::random::RandomStream;
use b2b_learn::rollout::Widths;

use super::Toy;

/// A pendulum. Observation: cosine and sine of the angle from upright, and speed over 8 rad/s. Action: torque over
/// 2 N m. Reward: -(angle² + 0.1 speed² + 0.001 torque²). Returns are about -1200 at random and -150 for a good policy.
pub struct Pendulum {
    angle: f32,
    speed: f32,
}

const STEP: f32 = 0.05;
const GRAVITY: f32 = 10.0;
const TORQUE: f32 = 2.0;
const SPEED: f32 = 8.0;

impl Toy for Pendulum {
    const WIDTHS: Widths = Widths { observation: 3, action: 1, parts: 1, nodes: 1 };
    const STEPS: usize = 200;
    const REWARD_SCALE: f32 = 0.1;

    fn reset(random: &mut RandomStream) -> Self {
        let mut uniform = |size: f32| (2.0 * random.uniform() as f32 - 1.0) * size;
        Self { angle: uniform(PI), speed: uniform(1.0) }
    }

    fn observe(&self, observation: &mut [f32]) {
        observation.copy_from_slice(&[self.angle.cos(), self.angle.sin(), self.speed / SPEED]);
    }

    fn step(&mut self, action: &[f32], _: &mut RandomStream, rewards: &mut [f32]) {
        let torque = TORQUE * action[0].clamp(-1.0, 1.0);
        let angle = (self.angle + PI).rem_euclid(TAU) - PI;
        rewards[0] = -(angle * angle + 0.1 * self.speed * self.speed + 0.001 * torque * torque);
        let speed = self.speed + (1.5 * GRAVITY * self.angle.sin() + 3.0 * torque) * STEP;
        self.speed = speed.clamp(-SPEED, SPEED);
        self.angle += self.speed * STEP;
    }
}
