//! The losses of SAC and their gradients with respect to the outputs of the networks.

use b2b_agent::network::LOG_STD;

use crate::gaussian::{Squashed, squash};

/// Losses and statistics of a minibatch, as means over its rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SacLosses {
    /// Half the squared error of the values, summed over both critics (Haarnoja et al. 2018b, eq. 5).
    pub critics: f64,
    /// Temperature × log density - smaller value (eq. 9).
    pub actor: f64,
    /// Log density of the actions of the actor.
    pub log_density: f64,
    /// Value of the steps by the first critic.
    pub value: f64,
}

impl SacLosses {
    /// Adds other losses.
    pub fn add(&mut self, other: &Self) {
        self.critics += other.critics;
        self.actor += other.actor;
        self.log_density += other.log_density;
        self.value += other.value;
    }
}

/// Writes squashed actions of outputs of the actor, and the log density of each row.
///
/// `outputs` has means, then logarithms of standard deviations: rows × 2 actions. `normals` has rows × actions. Actions
/// go to the last columns of `inputs`, rows × (observation + actions).
pub fn act(outputs: &[f32], normals: &[f32], actions: usize, inputs: &mut [f32], densities: &mut Vec<f32>) {
    densities.clear();
    let width = inputs.len() / (outputs.len() / (2 * actions)).max(1);
    let rows = outputs.chunks_exact(2 * actions).zip(normals.chunks_exact(actions));
    for ((outputs, normals), input) in rows.zip(inputs.chunks_exact_mut(width)) {
        let (means, log_stds) = outputs.split_at(actions);
        let mut density = 0.0;
        for (index, action) in input[width - actions..].iter_mut().enumerate() {
            let squashed: Squashed = squash(means[index], clamp(log_stds[index]), normals[index]);
            *action = squashed.action;
            density += squashed.log_density;
        }
        densities.push(density);
    }
}

/// Returns the targets of the critics: return + discount × (smaller target value - temperature × log density).
pub fn target(sum: f32, discount: f32, values: [f32; 2], temperature: f32, log_density: f32) -> f32 {
    sum + discount * (values[0].min(values[1]) - temperature * log_density)
}

/// Writes the gradients of half the mean squared error of a critic's values over a minibatch of `rows`, and returns the
/// share of these values in the error.
pub fn critic_loss(values: &[f32], targets: &[f32], rows: usize, gradients: &mut [f32]) -> f64 {
    let mut squares = 0.0;
    for ((value, target), gradient) in values.iter().zip(targets).zip(gradients) {
        let error = value - target;
        squares += f64::from(error * error);
        *gradient = error / rows as f32;
    }
    0.5 * squares / rows as f64
}

/// A sampled action of the actor, and the derivative of its value.
#[derive(Clone, Copy, Debug)]
pub struct Sampled {
    /// Log standard deviation, as output by the actor.
    pub log_std: f32,
    /// Standard normal number of the sample.
    pub normal: f32,
    /// Action.
    pub action: f32,
    /// Derivative of the smaller value with respect to the action.
    pub of_value: f32,
}

/// Returns the derivatives of temperature × log density - smaller value with respect to the mean and the logarithm of
/// the standard deviation of an action, which is reparameterized (Haarnoja et al. 2018b, eq. 10).
///
/// With u = mean + σ × normal and action = tanh u, the log density has the term -ln(1 - tanh² u), whose derivative is
/// 2 tanh u.
pub fn actor_gradients(sampled: &Sampled, temperature: f32) -> (f32, f32) {
    let Sampled { log_std, normal, action, of_value } = *sampled;
    let of_mean = 2.0 * temperature * action - of_value * (1.0 - action * action);
    let of_log_std = of_mean * clamp(log_std).exp() * normal - temperature;
    (of_mean, if LOG_STD.contains(&log_std) { of_log_std } else { 0.0 })
}

/// Returns the derivative of the loss of the temperature, -log temperature × (log density + target entropy), with
/// respect to its logarithm, as Stable-Baselines3 has it.
pub fn temperature_gradient(log_density: f64, target_entropy: f64) -> f64 {
    -(log_density + target_entropy)
}

fn clamp(log_std: f32) -> f32 {
    log_std.clamp(*LOG_STD.start(), *LOG_STD.end())
}
