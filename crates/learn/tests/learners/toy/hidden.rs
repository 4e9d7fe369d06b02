//! A context that is seen only once.

use b2b_learn::random::RandomStream;
use b2b_learn::rollout::Widths;

use super::Toy;

/// A hidden sign, the same in all steps of an episode. Reward: sign × action. Observation: whether the step is the
/// first; the reward of the first step, in the second step and no other; the sign, if `SEEN`. With the sign in sight,
/// returns reach 20; with a memory of the first reward, 19 on average; without one, 1.
pub struct Hidden<const SEEN: bool> {
    sign: f32,
    step: usize,
    first_reward: f32,
}

impl<const SEEN: bool> Toy for Hidden<SEEN> {
    const WIDTHS: Widths = Widths { observation: 3, action: 1, parts: 1, nodes: 1 };
    const STEPS: usize = 20;
    const REWARD_SCALE: f32 = 1.0;

    fn reset(random: &mut RandomStream) -> Self {
        Self { sign: if random.below(2) == 0 { -1.0 } else { 1.0 }, step: 0, first_reward: 0.0 }
    }

    fn observe(&self, observation: &mut [f32]) {
        let is = |step: usize| f32::from(u8::from(self.step == step));
        let sign = if SEEN { self.sign } else { 0.0 };
        observation.copy_from_slice(&[is(0), is(1) * self.first_reward, sign]);
    }

    fn step(&mut self, action: &[f32], _: &mut RandomStream, rewards: &mut [f32]) {
        rewards[0] = self.sign * action[0].clamp(-1.0, 1.0);
        if self.step == 0 {
            self.first_reward = rewards[0];
        }
        self.step += 1;
    }
}
