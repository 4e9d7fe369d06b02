//! Passes of a chunk of a minibatch through actor and critic.

use std::ops::Range;

use super::PpoConfig;
use super::credit::Credit;
use super::loss::{Losses, PolicyLoss, Step, group_log_density, value_loss};
use super::networks::Networks;
use super::samples::Samples;
use crate::nn::Pass;

/// Inputs that all chunks of a minibatch share.
#[derive(Clone, Copy)]
pub(super) struct Minibatch<'a> {
    pub config: &'a PpoConfig,
    pub networks: &'a Networks,
    pub credit: &'a Credit,
    pub parameters: &'a [f32],
    pub samples: &'a Samples,
    /// Number of rows.
    pub rows: usize,
}

impl<'a> Minibatch<'a> {
    /// Returns the step of a row with these outputs of the actor.
    fn step(&self, row: usize, outputs: &'a [f32], log_std: &'a [f32]) -> Step<'a> {
        let row = row..row + 1;
        let groups = times(&row, self.credit.groups());
        Step {
            action: &self.samples.actions[times(&row, self.networks.actions)],
            mean: &outputs[..self.networks.actions],
            log_std,
            old: &self.samples.old[groups.clone()],
            advantages: &self.samples.advantages[groups],
        }
    }
}

/// The buffers of a chunk, and its losses and gradients.
#[derive(Clone, Debug)]
pub(super) struct Worker {
    actor: Pass,
    critic: Pass,
    /// Logarithms of the standard deviations of a row, and their gradients.
    log_std: [Vec<f32>; 2],
    /// Gradients of the outputs of actor and critic.
    outputs: [Vec<f32>; 2],
    /// Gradients of all parameters.
    pub gradients: Vec<f32>,
    /// Share in the losses of the minibatch.
    pub losses: Losses,
}

impl Worker {
    pub fn new(networks: &Networks) -> Self {
        Self {
            actor: Pass::new(&networks.actor),
            critic: Pass::new(&networks.critic),
            log_std: [vec![0.0; networks.actions], vec![0.0; networks.actions]],
            outputs: Default::default(),
            gradients: vec![0.0; networks.critics().end],
            losses: Losses::default(),
        }
    }

    /// Computes losses and gradients of rows of a minibatch.
    pub fn learn(&mut self, batch: &Minibatch<'_>, rows: Range<usize>) {
        self.gradients.fill(0.0);
        self.losses = Losses::default();
        self.learn_policy(batch, rows.clone());
        self.learn_values(batch, rows);
    }

    fn learn_policy(&mut self, batch: &Minibatch<'_>, rows: Range<usize>) {
        let Minibatch { networks, samples, .. } = batch;
        let parameters = &batch.parameters[networks.actors()];
        let inputs = &samples.observations[times(&rows, networks.actor.inputs())];
        let length = self.actor.forward(parameters, inputs, rows.len()).len();
        self.outputs[0].clear();
        self.outputs[0].resize(length, 0.0);
        self.add_policy_loss(batch, rows);
        let sums = &mut self.gradients[networks.actors()];
        self.actor.backward(parameters, inputs, &self.outputs[0], Some(sums), None);
    }

    /// Adds the loss of the policy in these rows, and writes the gradients of the outputs of the actor.
    fn add_policy_loss(&mut self, batch: &Minibatch<'_>, rows: Range<usize>) {
        let Minibatch { networks, config, .. } = batch;
        let width = networks.actor.outputs();
        let loss = PolicyLoss {
            credit: batch.credit,
            clip_range: config.clip_range,
            entropy_coefficient: config.entropy_coefficient,
            rows: batch.rows,
        };
        let [log_std, log_std_gradients] = &mut self.log_std;
        let outputs = self.actor.outputs().chunks_exact(width);
        for (row, (outputs, gradients)) in rows.zip(outputs.zip(self.outputs[0].chunks_exact_mut(width))) {
            networks.write_log_std(batch.parameters, outputs, log_std);
            let step = batch.step(row, outputs, log_std);
            let (means, of_state) = gradients.split_at_mut(networks.actions);
            if networks.of_state() {
                loss.add(&step, means, of_state, &mut self.losses);
                networks.clamp_gradients(outputs, of_state);
            } else {
                log_std_gradients.fill(0.0);
                loss.add(&step, means, log_std_gradients, &mut self.losses);
                let sums = &mut self.gradients[networks.log_stds()];
                sums.iter_mut().zip(&*log_std_gradients).for_each(|(sum, gradient)| *sum += gradient);
            }
        }
    }

    fn learn_values(&mut self, batch: &Minibatch<'_>, rows: Range<usize>) {
        let Minibatch { networks, samples, config, .. } = batch;
        let parameters = &batch.parameters[networks.critics()];
        let inputs = &samples.observations[times(&rows, networks.critic.inputs())];
        let parts = networks.critic.outputs();
        let returns = &samples.returns[times(&rows, parts)];
        let values = self.critic.forward(parameters, inputs, rows.len());
        let gradients = &mut self.outputs[1];
        gradients.resize(values.len(), 0.0);
        let total = batch.rows * parts;
        self.losses.value = value_loss(values, returns, config.value_coefficient, total, gradients);
        let sums = &mut self.gradients[networks.critics()];
        self.critic.backward(parameters, inputs, gradients, Some(sums), None);
    }

    /// Appends the log densities of groups of actions: rows × groups.
    pub fn log_densities(
        &mut self,
        networks: &Networks,
        credit: &Credit,
        parameters: &[f32],
        (observations, actions): (&[f32], &[f32]),
        densities: &mut Vec<f32>,
    ) {
        let rows = observations.len() / networks.actor.inputs();
        let outputs = self.actor.forward(&parameters[networks.actors()], observations, rows);
        let log_std = &mut self.log_std[0];
        let per_row =
            outputs.chunks_exact(networks.actor.outputs()).zip(actions.chunks_exact(networks.actions));
        for (outputs, action) in per_row {
            networks.write_log_std(parameters, outputs, log_std);
            let mean = &outputs[..networks.actions];
            let density = |group| group_log_density(credit, group, action, mean, log_std);
            densities.extend((0..credit.groups()).map(density));
        }
    }

    /// Appends the outputs of the critic: rows × parts.
    pub fn values(
        &mut self,
        networks: &Networks,
        parameters: &[f32],
        observations: &[f32],
        values: &mut Vec<f32>,
    ) {
        let rows = observations.len() / networks.critic.inputs();
        values.extend_from_slice(self.critic.forward(&parameters[networks.critics()], observations, rows));
    }
}

/// Returns the place of rows of this width.
fn times(rows: &Range<usize>, width: usize) -> Range<usize> {
    rows.start * width..rows.end * width
}
