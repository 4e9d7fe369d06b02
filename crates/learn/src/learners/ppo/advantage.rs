//! Generalized advantage estimation (Schulman et al. 2016, eq. 16).

use crate::rollout::Rollout;

/// Values of the observations of a rollout, by part of the reward.
#[derive(Clone, Debug, Default)]
pub struct RolloutValues {
    /// Value before each step: environments × steps × parts.
    pub steps: Vec<f32>,
    /// Value after the last step: environments × parts.
    pub next: Vec<f32>,
    /// Value of the final observation of each episode that ended: ends × parts.
    pub ends: Vec<f32>,
}

/// Writes the advantages, environments × steps × parts.
///
/// Every end is a truncation: the value of the final observation replaces the rest of the return, and the advantages of
/// the next episode do not flow back into it.
pub fn advantages(
    rollout: &Rollout,
    values: &RolloutValues,
    gamma: f32,
    lambda: f32,
    advantages: &mut [f32],
) {
    let parts = values.next.len() / rollout.environments.max(1);
    let mut ends = rollout.ends.len();
    for environment in (0..rollout.environments).rev() {
        let mut next = &values.next[environment * parts..][..parts];
        let mut carried = vec![0.0; parts];
        for step in (0..rollout.steps).rev() {
            if ends > 0
                && (rollout.ends[ends - 1].environment, rollout.ends[ends - 1].step) == (environment, step)
            {
                ends -= 1;
                next = &values.ends[ends * parts..][..parts];
                carried.fill(0.0);
            }
            let at = (environment * rollout.steps + step) * parts;
            let now = &values.steps[at..at + parts];
            for part in 0..parts {
                let error = rollout.rewards[at + part] + gamma * next[part] - now[part];
                carried[part] = error + gamma * lambda * carried[part];
                advantages[at + part] = carried[part];
            }
            next = now;
        }
    }
}

/// Centers the advantages of each pair of environments with opposite noise on the pair's mean, wherever both are at the
/// same step of the same episode. This leaves the effect of the noise, because value errors and the cost of noise of
/// either sign are nearly the same in both.
pub fn center_pairs(rollout: &Rollout, parts: usize, advantages: &mut [f32]) {
    let width = rollout.steps * parts;
    for (pair, steps) in advantages.chunks_exact_mut(2 * width).zip(&rollout.pairs) {
        let (one, other) = pair.split_at_mut(width);
        for (one, other) in one.iter_mut().zip(other).take(steps * parts) {
            let half = 0.5 * (*one - *other);
            (*one, *other) = (half, -half);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rollout::End;

    #[test]
    fn advantages_stop_at_a_truncation_and_count_its_value() {
        // γ = 0.5, λ = 0.5. Environment 0 ends after its second step, environment 1 does not.
        let rollout = Rollout {
            environments: 2,
            steps: 3,
            rewards: vec![1.0, 2.0, 3.0, 1.0, 0.0, -1.0],
            ends: vec![End { environment: 0, step: 1, observation: vec![] }],
            ..Rollout::default()
        };
        let values = RolloutValues {
            steps: vec![4.0, 2.0, 6.0, 0.0, 2.0, 4.0],
            next: vec![8.0, -2.0],
            ends: vec![10.0],
        };
        let mut found = [0.0; 6];
        advantages(&rollout, &values, 0.5, 0.5, &mut found);
        // Step 2: 3 + 0.5 × 8 - 6 = 1. Step 1: 2 + 0.5 × 10 - 2 = 5. Step 0: 1 + 0.5 × 2 - 4 + 0.25 × 5 = -0.75.
        assert_eq!(found[..3], [-0.75, 5.0, 1.0]);
        // Step 2: -1 - 1 - 4 = -6. Step 1: 0 + 2 - 2 - 0.25 × 6 = -1.5. Step 0: 1 + 1 - 0 - 0.25 × 1.5 = 1.625.
        assert_eq!(found[3..], [1.625, -1.5, -6.0]);
    }

    #[test]
    fn an_end_at_the_last_step_replaces_the_next_observation() {
        let mut rollout = Rollout { environments: 1, steps: 1, rewards: vec![1.0], ..Rollout::default() };
        let values = RolloutValues { steps: vec![2.0], next: vec![100.0], ends: vec![6.0] };
        let mut found = [0.0];
        rollout.ends.push(End { environment: 0, step: 0, observation: vec![] });
        advantages(&rollout, &values, 0.5, 0.9, &mut found);
        assert_eq!(found, [1.0 + 0.5 * 6.0 - 2.0]);
    }

    #[test]
    fn parts_are_separate() {
        let rollout =
            Rollout { environments: 1, steps: 2, rewards: vec![1.0, 10.0, 2.0, 20.0], ..Rollout::default() };
        let values = RolloutValues { steps: vec![0.0; 4], next: vec![4.0, 40.0], ends: vec![] };
        let mut found = [0.0; 4];
        advantages(&rollout, &values, 0.5, 1.0, &mut found);
        assert_eq!(found, [3.0, 30.0, 4.0, 40.0]);
    }

    #[test]
    fn a_pair_keeps_its_differences_as_long_as_it_is_in_step() {
        let rollout = Rollout { environments: 3, steps: 2, pairs: vec![1], ..Rollout::default() };
        // Two environments with noise that is good for the first part and bad for the second; the third is alone.
        let mut values = vec![5.0, 1.0, 7.0, 7.0, 3.0, 4.0, 9.0, 9.0, 2.0, 2.0, 2.0, 2.0];
        center_pairs(&rollout, 2, &mut values);
        assert_eq!(values, [1.0, -1.5, 7.0, 7.0, -1.0, 1.5, 9.0, 9.0, 2.0, 2.0, 2.0, 2.0]);
    }
}
