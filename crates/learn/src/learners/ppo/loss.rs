//! The losses of PPO and their gradients with respect to the outputs of the networks.

use crate::credit::Credit;
use crate::gaussian::{entropy, log_density, log_density_gradient};

/// Losses and statistics of a minibatch, as means over its rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// Clipped surrogate (Schulman et al. 2017, eq. 7), negated.
    pub policy: f64,
    /// Squared error of the values.
    pub value: f64,
    /// Entropy of the policy.
    pub entropy: f64,
    /// Divergence of the policy from the one that made the steps: mean of ratio - 1 - ln ratio, as in
    /// Stable-Baselines3, averaged over the groups of actions too.
    pub kl: f64,
    /// Share of clipped ratios.
    pub clipped: f64,
}

impl Losses {
    /// Adds other losses.
    pub fn add(&mut self, other: &Self) {
        self.policy += other.policy;
        self.value += other.value;
        self.entropy += other.entropy;
        self.kl += other.kl;
        self.clipped += other.clipped;
    }

    /// Returns the losses times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            policy: self.policy * factor,
            value: self.value * factor,
            entropy: self.entropy * factor,
            kl: self.kl * factor,
            clipped: self.clipped * factor,
        }
    }
}

/// The loss of the policy, as a mean over the rows of a minibatch: clipped surrogate - coefficient × entropy +
/// coefficient × squares of means beyond [-1, 1].
#[derive(Clone, Copy, Debug)]
pub struct PolicyLoss<'a> {
    /// Groups of actions.
    pub credit: &'a Credit,
    /// ε of the clipped ratio.
    pub clip_range: f32,
    /// Coefficient of the entropy.
    pub entropy_coefficient: f32,
    /// Coefficient of the squares by which means exceed [-1, 1].
    pub bound_coefficient: f32,
    /// Number of rows of the minibatch.
    pub rows: usize,
}

/// A step of the rollout and the actor's current distribution for it. A building may have fewer actions than a group.
#[derive(Clone, Copy, Debug)]
pub struct ActorStep<'a> {
    /// Action, not clipped.
    pub action: &'a [f32],
    /// Mean of each action.
    pub mean: &'a [f32],
    /// Logarithm of the standard deviation of each action.
    pub log_std: &'a [f32],
    /// Logarithm of the density of the actions of each group under the policy that made the step.
    pub old: &'a [f32],
    /// Advantage of each group.
    pub advantages: &'a [f32],
}

impl PolicyLoss<'_> {
    /// Adds a step to the losses, and its gradients to the gradients of means and log standard deviations.
    pub fn add(&self, step: &ActorStep<'_>, means: &mut [f32], log_stds: &mut [f32], losses: &mut Losses) {
        let share = 1.0 / self.rows as f32;
        for group in 0..self.credit.groups() {
            let weight = share * self.add_surrogate(step, group, losses);
            for action in self.credit.actions(group, step.action.len()) {
                let (of_mean, of_log_std) =
                    log_density_gradient(step.action[action], step.mean[action], step.log_std[action]);
                means[action] += weight * of_mean;
                log_stds[action] += weight * of_log_std;
            }
        }
        for (mean, gradient) in step.mean.iter().zip(means) {
            *gradient += 2.0 * share * self.bound_coefficient * (mean - mean.clamp(-1.0, 1.0));
        }
        for (log_std, gradient) in step.log_std.iter().zip(log_stds) {
            losses.entropy += f64::from(entropy(*log_std)) / self.rows as f64;
            *gradient -= share * self.entropy_coefficient;
        }
    }

    /// Adds the surrogate of a group to the losses, and returns the derivative of its loss with respect to the log
    /// density.
    fn add_surrogate(&self, step: &ActorStep<'_>, group: usize, losses: &mut Losses) -> f32 {
        let (advantage, rows) = (step.advantages[group], self.rows as f64);
        let log_ratio =
            group_log_density(self.credit, group, step.action, step.mean, step.log_std) - step.old[group];
        let ratio = log_ratio.exp();
        let surrogate = advantage * ratio;
        let clipped = advantage * ratio.clamp(1.0 - self.clip_range, 1.0 + self.clip_range);
        losses.policy -= f64::from(if surrogate <= clipped { surrogate } else { clipped }) / rows;
        let ratios = rows * self.credit.groups() as f64;
        losses.kl += f64::from(ratio - 1.0 - log_ratio) / ratios;
        losses.clipped += f64::from(u8::from((ratio - 1.0).abs() > self.clip_range)) / ratios;
        if surrogate <= clipped { -surrogate } else { 0.0 }
    }
}

/// Returns the logarithm of the density of the actions of a group.
pub fn group_log_density(
    credit: &Credit,
    group: usize,
    action: &[f32],
    mean: &[f32],
    log_std: &[f32],
) -> f32 {
    credit.actions(group, action.len()).map(|each| log_density(action[each], mean[each], log_std[each])).sum()
}

/// Writes the gradients of `coefficient` × mean squared error of a step's values, as a mean over a minibatch of `rows`
/// rows, and returns the step's share of the mean squared error. Parts without rewards do not count.
pub fn value_loss(
    values: &[f32],
    returns: &[f32],
    credit: &Credit,
    (coefficient, rows): (f32, usize),
    gradients: &mut [f32],
) -> f64 {
    let count = rows * credit.parts().iter().flatten().count();
    let mut squares = 0.0;
    gradients.fill(0.0);
    for (part, _) in credit.parts().iter().enumerate().filter(|(_, kind)| kind.is_some()) {
        let error = values[part] - returns[part];
        squares += f64::from(error * error);
        gradients[part] = coefficient * 2.0 * error / count as f32;
    }
    squares / count as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nn::reference::{assert_gradients, wide};
    use crate::random::RandomStream;
    use crate::rollout::Widths;

    const ROWS: usize = 40;
    const ACTIONS: usize = 3;

    /// Returns the loss of the policy in double precision; outputs have means, then logarithms of standard deviations,
    /// of each row.
    fn loss(outputs: &[f64], actions: &[f32], old: &[f32], advantages: &[f32], credit: &Credit) -> f64 {
        let groups = credit.groups();
        let mut sum = 0.0;
        for (row, outputs) in outputs.chunks(2 * ACTIONS).enumerate() {
            let (means, log_stds) = outputs.split_at(ACTIONS);
            for group in 0..groups {
                let density = |action: usize| {
                    let normal =
                        (f64::from(actions[row * ACTIONS + action]) - means[action]) / log_stds[action].exp();
                    -0.5 * normal * normal - log_stds[action] - 0.5 * std::f64::consts::TAU.ln()
                };
                let log_density: f64 = credit.actions(group, ACTIONS).map(density).sum();
                let ratio = (log_density - f64::from(old[row * groups + group])).exp();
                let advantage = f64::from(advantages[row * groups + group]);
                sum -= (advantage * ratio).min(advantage * ratio.clamp(0.8, 1.2));
            }
            sum -=
                0.1 * log_stds.iter().map(|each| 0.5 + 0.5 * std::f64::consts::TAU.ln() + each).sum::<f64>();
        }
        sum / ROWS as f64 + beyond_bounds(outputs)
    }

    /// Returns 0.2 × the squares by which means exceed [-1, 1], as a mean over the rows.
    fn beyond_bounds(outputs: &[f64]) -> f64 {
        let means = outputs.chunks(2 * ACTIONS).flat_map(|outputs| &outputs[..ACTIONS]);
        0.2 * means.map(|mean| (mean.abs() - 1.0).max(0.0).powi(2)).sum::<f64>() / ROWS as f64
    }

    fn assert_policy_gradients(credit: &Credit) {
        let (mut random, groups) = (RandomStream::new(9, 0), credit.groups());
        let mut draw = |count: usize, scale: f32| -> Vec<f32> {
            (0..count).map(|_| scale * random.normal() as f32).collect()
        };
        let (outputs, actions) = (draw(ROWS * 2 * ACTIONS, 0.5), draw(ROWS * ACTIONS, 1.0));
        let (noise, advantages) = (draw(ROWS * groups, 0.3), draw(ROWS * groups, 1.0));
        let mut old = noise;
        let mut gradients = vec![0.0; outputs.len()];
        let mut losses = Losses::default();
        let policy = PolicyLoss {
            credit,
            clip_range: 0.2,
            entropy_coefficient: 0.1,
            bound_coefficient: 0.2,
            rows: ROWS,
        };
        for row in 0..ROWS {
            let (mean, log_std) = outputs[row * 2 * ACTIONS..][..2 * ACTIONS].split_at(ACTIONS);
            let (means, log_stds) = gradients[row * 2 * ACTIONS..][..2 * ACTIONS].split_at_mut(ACTIONS);
            let (action, groups) = (&actions[row * ACTIONS..][..ACTIONS], row * groups..(row + 1) * groups);
            for (group, old) in old[groups.clone()].iter_mut().enumerate() {
                *old += group_log_density(credit, group, action, mean, log_std);
            }
            let step = ActorStep {
                action,
                mean,
                log_std,
                old: &old[groups.clone()],
                advantages: &advantages[groups],
            };
            policy.add(&step, means, log_stds, &mut losses);
        }
        let outputs = wide(&outputs);
        let expected = loss(&outputs, &actions, &old, &advantages, credit);
        let beyond = beyond_bounds(&outputs);
        assert!(beyond > 0.0 && (losses.policy - 0.1 * losses.entropy + beyond - expected).abs() < 1e-5);
        assert!(losses.clipped > 0.2 && losses.clipped < 0.9, "{losses:?}");
        assert_gradients(&outputs, &gradients, |outputs| loss(outputs, &actions, &old, &advantages, credit));
    }

    #[test]
    fn gradients_of_the_policy_match_finite_differences() {
        let widths = Widths { observation: 1, action: ACTIONS, parts: 2, nodes: 1 };
        assert_policy_gradients(&Credit::new(None, widths).unwrap());
        let matrix = [vec![1.0, 0.0], vec![0.0, 1.0], vec![1.0, 1.0]];
        assert_policy_gradients(&Credit::new(Some(&matrix), widths).unwrap());
    }

    #[test]
    fn gradients_of_values_match_finite_differences() {
        let (values, returns) = ([0.5, -1.0, 2.0, 0.3], [0.0, 1.0, 2.5, -0.1]);
        let mut gradients = [0.0; 4];
        let credit = Credit::joint(Widths { observation: 1, action: ACTIONS, parts: 4, nodes: 1 });
        let found = value_loss(&values, &returns, &credit, (0.5, 1), &mut gradients);
        let loss = |values: &[f64]| {
            values
                .iter()
                .zip(&returns)
                .map(|(value, target)| (value - f64::from(*target)).powi(2))
                .sum::<f64>()
                / 4.0
        };
        assert!((found - loss(&wide(&values))).abs() < 1e-6);
        assert_gradients(&wide(&values), &gradients, |values| 0.5 * loss(values));
    }
}
