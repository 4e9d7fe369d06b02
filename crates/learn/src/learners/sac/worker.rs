//! Passes of a chunk of a minibatch through actor and critics.

use std::ops::Range;

use super::loss::{SacLosses, Sampled, act, actor_gradients, critic_loss, target};
use super::networks::{Parameters, SacNetworks};
use super::replay::ReplayBatch;
use crate::nn::{Pass, sized};

/// Inputs that all chunks of a minibatch share.
#[derive(Clone, Copy)]
pub(super) struct SacMinibatch<'a> {
    pub networks: &'a SacNetworks,
    pub parameters: &'a Parameters,
    pub batch: &'a ReplayBatch,
}

/// The buffers of a chunk, and its losses and gradients.
#[derive(Clone, Debug)]
pub(super) struct SacWorker {
    actor: Pass,
    critics: [Pass; 2],
    /// Inputs of critics, observation and action: rows × width.
    inputs: Vec<f32>,
    /// Log densities of sampled actions: rows.
    densities: Vec<f32>,
    /// Targets of the critics: rows.
    targets: Vec<f32>,
    /// Gradients of outputs of a network.
    outputs: Vec<f32>,
    /// Gradients of the inputs of each critic: rows × width.
    input_gradients: [Vec<f32>; 2],
    /// Gradients of the parameters of the actor.
    pub actor_gradients: Vec<f32>,
    /// Gradients of the parameters of both critics.
    pub critic_gradients: Vec<f32>,
    /// Share in the losses of the minibatch.
    pub losses: SacLosses,
}

impl SacWorker {
    pub fn new(networks: &SacNetworks) -> Self {
        let critic = Pass::new(&networks.critic);
        Self {
            actor: Pass::new(&networks.actor),
            critics: [critic.clone(), critic],
            inputs: Vec::new(),
            densities: Vec::new(),
            targets: Vec::new(),
            outputs: Vec::new(),
            input_gradients: Default::default(),
            actor_gradients: vec![0.0; networks.actor.parameters()],
            critic_gradients: vec![0.0; 2 * networks.critic.parameters()],
            losses: SacLosses::default(),
        }
    }

    /// Computes the loss of the critics and their gradients for rows of a minibatch.
    pub fn learn_critics(&mut self, minibatch: &SacMinibatch<'_>, rows: Range<usize>) {
        self.losses = SacLosses::default();
        self.critic_gradients.fill(0.0);
        self.set_targets(minibatch, rows.clone());
        let SacMinibatch { networks, parameters, batch } = minibatch;
        let (observation, actions) = (networks.actor.inputs(), networks.actions);
        let observations = &batch.observations[times(&rows, observation)];
        let inputs = sized(&mut self.inputs, rows.len() * networks.critic.inputs());
        write_columns(inputs, observations, observation, 0);
        write_columns(inputs, &batch.actions[times(&rows, actions)], actions, observation);
        let gradients = sized(&mut self.outputs, rows.len());
        let size = networks.critic.parameters();
        for (index, critic) in self.critics.iter_mut().enumerate() {
            let own = index * size..(index + 1) * size;
            let values = critic.forward(&parameters.critics[own.clone()], inputs, rows.len());
            if index == 0 {
                self.losses.value = sum(values) / batch.rows as f64;
            }
            self.losses.critics += critic_loss(values, &self.targets, batch.rows, gradients);
            let sums = &mut self.critic_gradients[own.clone()];
            critic.backward(&parameters.critics[own], inputs, gradients, Some(sums), None);
        }
    }

    fn set_targets(&mut self, minibatch: &SacMinibatch<'_>, rows: Range<usize>) {
        let SacMinibatch { parameters, batch, .. } = minibatch;
        self.sample_actions(minibatch, &batch.next, &batch.next_normals, rows.clone());
        self.evaluate(minibatch, &parameters.targets, rows.len());
        let temperature = parameters.log_temperature.exp();
        self.targets.clear();
        for (row, density) in rows.clone().zip(&self.densities) {
            let values = [0, 1].map(|critic: usize| self.critics[critic].outputs()[row - rows.start]);
            self.targets.push(target(
                batch.returns[row],
                batch.discounts[row],
                values,
                temperature,
                *density,
            ));
        }
    }

    /// Computes the loss of the actor and its gradients for rows of a minibatch.
    pub fn learn_actor(&mut self, minibatch: &SacMinibatch<'_>, rows: Range<usize>) {
        let SacMinibatch { parameters, batch, .. } = minibatch;
        self.actor_gradients.fill(0.0);
        self.sample_actions(minibatch, &batch.observations, &batch.normals, rows.clone());
        self.evaluate(minibatch, &parameters.critics, rows.len());
        let temperature = parameters.log_temperature.exp();
        for (row, density) in self.densities.iter().enumerate() {
            let value = self.critics[0].outputs()[row].min(self.critics[1].outputs()[row]);
            self.losses.actor += f64::from(temperature * density - value) / batch.rows as f64;
            self.losses.log_density += f64::from(*density) / batch.rows as f64;
        }
        self.differentiate_values(minibatch, rows.len());
        self.differentiate_actor(minibatch, rows, temperature);
    }

    /// Samples actions for rows of observations. They and the observations become the inputs of the critics.
    fn sample_actions(
        &mut self,
        minibatch: &SacMinibatch<'_>,
        observations: &[f32],
        normals: &[f32],
        rows: Range<usize>,
    ) {
        let SacMinibatch { networks, parameters, .. } = minibatch;
        let observations = &observations[times(&rows, networks.actor.inputs())];
        let outputs = self.actor.forward(&parameters.actor, observations, rows.len());
        let inputs = sized(&mut self.inputs, rows.len() * networks.critic.inputs());
        write_columns(inputs, observations, networks.actor.inputs(), 0);
        act(outputs, &normals[times(&rows, networks.actions)], networks.actions, inputs, &mut self.densities);
    }

    /// Computes the values of the inputs by both critics with these parameters.
    fn evaluate(&mut self, minibatch: &SacMinibatch<'_>, parameters: &[f32], rows: usize) {
        let inputs = &self.inputs[..rows * minibatch.networks.critic.inputs()];
        let each = parameters.chunks_exact(minibatch.networks.critic.parameters());
        for (critic, parameters) in self.critics.iter_mut().zip(each) {
            critic.forward(parameters, inputs, rows);
        }
    }

    /// Computes the gradients of the smaller value with respect to the inputs of the critics, each critic in its rows.
    fn differentiate_values(&mut self, minibatch: &SacMinibatch<'_>, rows: usize) {
        let SacMinibatch { networks, parameters, .. } = minibatch;
        let length = rows * networks.critic.inputs();
        let gradients = sized(&mut self.outputs, rows);
        for (index, parameters) in parameters.critics.chunks_exact(networks.critic.parameters()).enumerate() {
            let (first, second) = (self.critics[0].outputs(), self.critics[1].outputs());
            for (row, gradient) in gradients.iter_mut().enumerate() {
                let smaller = usize::from(second[row] < first[row]);
                *gradient = f32::from(u8::from(smaller == index));
            }
            let of_inputs = sized(&mut self.input_gradients[index], length);
            self.critics[index].backward(
                parameters,
                &self.inputs[..length],
                gradients,
                None,
                Some(of_inputs),
            );
        }
    }

    fn differentiate_actor(&mut self, minibatch: &SacMinibatch<'_>, rows: Range<usize>, temperature: f32) {
        let SacMinibatch { networks, parameters, batch } = minibatch;
        let (observation, actions) = (networks.actor.inputs(), networks.actions);
        let (width, share) = (networks.critic.inputs(), 1.0 / batch.rows as f32);
        let outputs = self.actor.outputs();
        let gradients = sized(&mut self.outputs, outputs.len());
        for row in 0..rows.len() {
            for action in 0..actions {
                let (place, mean) = (row * width + observation + action, row * 2 * actions + action);
                let sampled = Sampled {
                    log_std: outputs[mean + actions],
                    normal: batch.normals[(rows.start + row) * actions + action],
                    action: self.inputs[place],
                    of_value: self.input_gradients[0][place] + self.input_gradients[1][place],
                };
                let (of_mean, of_log_std) = actor_gradients(&sampled, temperature);
                gradients[mean] = share * of_mean;
                gradients[mean + actions] = share * of_log_std;
            }
        }
        let observations = &batch.observations[times(&rows, observation)];
        let sums = &mut self.actor_gradients;
        self.actor.backward(&parameters.actor, observations, gradients, Some(sums), None);
    }
}

/// Returns the range of rows of this width.
fn times(rows: &Range<usize>, width: usize) -> Range<usize> {
    rows.start * width..rows.end * width
}

/// Writes columns from `first` on.
fn write_columns(rows: &mut [f32], columns: &[f32], width: usize, first: usize) {
    let count = columns.len() / width;
    let all = rows.len() / count.max(1);
    for (row, columns) in rows.chunks_exact_mut(all).zip(columns.chunks_exact(width)) {
        row[first..first + width].copy_from_slice(columns);
    }
}

fn sum(values: &[f32]) -> f64 {
    values.iter().map(|value| f64::from(*value)).sum()
}
