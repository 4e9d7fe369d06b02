//! Log densities and values of a rollout under recurrent networks, before the epochs of an update.
//!
//! The networks pass through the sequences of all environments at a time, from the states that they had when the rollout began.
//! The actor's are known from the collection; the critic's are what it had after the previous rollout, before that update.

use b2b_agent::network::graph::Batch;

use super::advantage::RolloutValues;
use super::learner::Ppo;
use super::worker::{ACTOR, CRITIC, Inputs};
use crate::error::{Error, Result};
use crate::nn::Sequences;
use crate::rollout::Rollout;

impl Ppo {
    /// Checks that a rollout has the states and the whole sequences of recurrent networks.
    pub(super) fn check_sequences(&self, rollout: &Rollout) -> Result<()> {
        let (length, [width, _]) = (self.networks.sequence, self.networks.states());
        let states = rollout.environments * width;
        let wrong = |name, length, expected| Err(Error::Rollout { name, length, expected });
        match rollout.steps % length {
            _ if rollout.states.len() != states => wrong("states", rollout.states.len(), states),
            0 => Ok(()),
            rest => wrong("steps", rollout.steps, rollout.steps - rest),
        }
    }

    /// Computes the log densities of the actions, and the states before every sequence. Returns the outputs of the critic.
    pub(super) fn evaluate_sequences(&mut self, rollout: &Rollout) -> RolloutValues {
        let (rows, [actor, critic]) = (rollout.rows(), self.networks.states());
        let sequences = rows / self.networks.sequence;
        self.samples.old = vec![0.0; rows * self.groups];
        self.samples.states = [vec![0.0; sequences * actor], vec![0.0; sequences * critic]];
        self.critic_states.resize(rollout.environments * critic, 0.0);
        self.minibatch.states = [rollout.states.clone(), std::mem::take(&mut self.critic_states)];
        let mut values = vec![0.0; rows * self.widths.parts];
        // States of the critic after every step.
        let mut after = vec![0.0; rows * critic];
        for number in 0..rollout.steps / self.networks.sequence {
            self.evaluate_sequence(number, rollout, &mut values, &mut after);
        }
        self.critic_states = std::mem::take(&mut self.minibatch.states[CRITIC]);
        let of_ends = rollout.ends.iter().map(|end| end.environment * rollout.steps + end.step);
        let of_ends = gathered(&after, of_ends, critic);
        let ends: Vec<f32> = rollout.ends.iter().flat_map(|end| &end.observation).copied().collect();
        RolloutValues {
            next: self.value_after(&rollout.next, &self.critic_states.clone()),
            ends: self.value_after(&ends, &of_ends),
            steps: values,
        }
    }

    /// Evaluates the sequences of this number of all environments. The minibatch has the states before them, and then those after.
    fn evaluate_sequence(&mut self, number: usize, rollout: &Rollout, values: &mut [f32], after: &mut [f32]) {
        let Self {
            workers, networks, credits, groups, parameters, widths, graphs, samples, minibatch, ..
        } = self;
        let (length, count) = (networks.sequence, rollout.steps / networks.sequence);
        let sequences = (0..rollout.environments).map(|environment| environment * count + number);
        let rows: Vec<usize> =
            sequences.clone().flat_map(|each| each * length..(each + 1) * length).collect();
        minibatch.gather_steps(samples, &rows, *widths);
        for (network, width) in networks.states().into_iter().enumerate() {
            scatter(&mut samples.states[network], &minibatch.states[network], sequences.clone(), width);
        }
        let (observations, of_rows) = (&minibatch.observations[..], &minibatch.scenes[..]);
        let batch = Batch { graphs, of_rows, observations, width: widths.observation };
        let inputs = |network: usize| Inputs {
            batch,
            sequences: Sequences { length, states: &minibatch.states[network], starts: &minibatch.starts },
        };
        let (worker, mut densities, mut found) = (&mut workers[0], Vec::new(), Vec::new());
        let actions = (inputs(ACTOR), &minibatch.actions[..]);
        worker.log_densities(networks, (&credits[..], *groups), parameters, actions, &mut densities);
        worker.values(networks, parameters, inputs(CRITIC), &mut found);
        scatter(&mut samples.old, &densities, rows.iter().copied(), *groups);
        scatter(values, &found, rows.iter().copied(), widths.parts);
        scatter(after, worker.states()[CRITIC], rows.iter().copied(), networks.states()[CRITIC]);
        let last = (0..rollout.environments).map(|environment| (environment + 1) * length - 1);
        for (network, width) in networks.states().into_iter().enumerate() {
            minibatch.states[network] = gathered(worker.states()[network], last.clone(), width);
        }
    }

    /// Returns the outputs of the critic for observations after these states.
    fn value_after(&mut self, observations: &[f32], states: &[f32]) -> Vec<f32> {
        let Self { workers, networks, parameters, widths, graphs, .. } = self;
        let count = observations.len() / widths.observation;
        let (of_rows, starts) = (&vec![0; count][..], &vec![false; count][..]);
        let batch = Batch { graphs, of_rows, observations, width: widths.observation };
        let mut values = Vec::new();
        let sequences = Sequences { length: 1, states, starts };
        workers[0].values(networks, parameters, Inputs { batch, sequences }, &mut values);
        values
    }
}

/// Returns rows of values of a width.
fn gathered(values: &[f32], rows: impl Iterator<Item = usize>, width: usize) -> Vec<f32> {
    rows.flat_map(|row| &values[row * width..(row + 1) * width]).copied().collect()
}

/// Writes values of a width to rows.
fn scatter(values: &mut [f32], from: &[f32], rows: impl Iterator<Item = usize>, width: usize) {
    for (row, from) in rows.zip(from.chunks_exact(width)) {
        values[row * width..][..width].copy_from_slice(from);
    }
}
