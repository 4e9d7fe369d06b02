//! Log densities and values of a rollout under networks with a memory, before the epochs of an update.
//!
//! The networks start from their states at the beginning of the rollout: the actor's come from the collection, the
//! critic's from the end of the previous rollout, before that update.

use std::ops::Range;

use b2b_agent::network::Shape;
use b2b_agent::network::graph::Batch;

use super::advantage::RolloutValues;
use super::learner::Ppo;
use super::networks::Networks;
use super::update::BLOCK;
use super::worker::{ACTOR, CRITIC, Inputs, Worker};
use crate::error::{Error, Result};
use crate::nn::Sequences;
use crate::rollout::{End, Rollout};

impl Ppo {
    /// Checks that a rollout has the states and the whole sequences of networks with a memory.
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

    /// Computes the log densities of the actions, and the states before every sequence. Returns the outputs of the
    /// critic.
    pub(super) fn evaluate_sequences(
        &mut self,
        rollout: &Rollout,
        [of_ends, of_next]: &[Vec<usize>; 2],
    ) -> RolloutValues {
        let (rows, widths, length) = (rollout.rows(), self.networks.states(), self.networks.sequence);
        self.samples.old = vec![0.0; rows * self.groups];
        self.samples.states = widths.map(|width| vec![0.0; rows / length * width]);
        self.critic_states.resize(rollout.environments * widths[CRITIC], 0.0);
        let mut walk = Walk {
            states: [rollout.states.clone(), std::mem::take(&mut self.critic_states)],
            values: vec![0.0; rows * self.widths.parts],
            ends: vec![0.0; rollout.ends.len() * widths[CRITIC]],
        };
        // Graph networks take some environments at a time.
        let count = match self.networks.critic {
            Shape::Graph(_) => (BLOCK / length).max(1),
            Shape::Mlp(_) | Shape::Recurrent(_) => rollout.environments,
        };
        for number in 0..rollout.steps / length {
            for first in (0..rollout.environments).step_by(count) {
                let environments = first..rollout.environments.min(first + count);
                self.evaluate_sequence(number, environments, rollout, &mut walk);
            }
        }
        let Walk { states: [_, after], values: steps, ends: before_ends } = walk;
        self.critic_states = after;
        let [ends, next] = self.observations_after(rollout);
        RolloutValues {
            next: self.value_after(&next, of_next, &self.critic_states.clone()),
            ends: self.value_after(&ends, of_ends, &before_ends),
            steps,
        }
    }

    /// Evaluates sequence `number` of some environments.
    fn evaluate_sequence(
        &mut self,
        number: usize,
        environments: Range<usize>,
        rollout: &Rollout,
        walk: &mut Walk,
    ) {
        let Self {
            workers, networks, credits, groups, parameters, widths, graphs, samples, minibatch, ..
        } = self;
        let (length, count) = (networks.sequence, rollout.steps / networks.sequence);
        let sequences = environments.clone().map(|environment| environment * count + number);
        let rows: Vec<usize> =
            sequences.clone().flat_map(|each| each * length..(each + 1) * length).collect();
        minibatch.gather_steps(samples, &rows, *widths);
        let states = [ACTOR, CRITIC].map(|network| {
            let width = networks.states()[network];
            let before = &walk.states[network][environments.start * width..environments.end * width];
            scatter(&mut samples.states[network], before, sequences.clone(), width);
            before.to_vec()
        });
        let (observations, of_rows) = (&minibatch.observations[..], &minibatch.scenes[..]);
        let batch = Batch { graphs, of_rows, observations, width: widths.observation };
        let inputs = |network: usize| Inputs {
            batch,
            sequences: Sequences { length, states: &states[network], starts: &minibatch.starts },
        };
        let (worker, mut densities, mut found) = (&mut workers[0], Vec::new(), Vec::new());
        let actions = (inputs(ACTOR), &minibatch.actions[..]);
        worker.log_densities(networks, (&credits[..], *groups), parameters, actions, &mut densities);
        worker.values(networks, parameters, inputs(CRITIC), &mut found);
        scatter(&mut samples.old, &densities, rows.iter().copied(), *groups);
        scatter(&mut walk.values, &found, rows.iter().copied(), widths.parts);
        walk.take_states(worker, networks, (number, environments), rollout);
    }

    /// Returns the outputs of the critic for observations in these scenes, after these states.
    fn value_after(&mut self, observations: &[f32], of_rows: &[usize], states: &[f32]) -> Vec<f32> {
        let Self { workers, networks, parameters, widths, graphs, .. } = self;
        let starts = &vec![false; of_rows.len()][..];
        let batch = Batch { graphs, of_rows, observations, width: widths.observation };
        let mut values = Vec::new();
        let sequences = Sequences { length: 1, states, starts };
        workers[0].values(networks, parameters, Inputs { batch, sequences }, &mut values);
        values
    }
}

/// What a walk through the sequences of a rollout computes.
struct Walk {
    /// States of actor and critic before the next sequences: environments × width.
    states: [Vec<f32>; 2],
    /// Outputs of the critic.
    values: Vec<f32>,
    /// States of the critic after the last steps of episodes: ends × width.
    ends: Vec<f32>,
}

impl Walk {
    /// Copies the states after sequence `number` of some environments from the worker that evaluated it.
    fn take_states(
        &mut self,
        worker: &Worker,
        networks: &Networks,
        (number, environments): (usize, Range<usize>),
        rollout: &Rollout,
    ) {
        let (length, first) = (networks.sequence, environments.start);
        for (network, width) in networks.states().into_iter().enumerate() {
            for environment in environments.clone() {
                let state = &mut self.states[network][environment * width..][..width];
                worker.write_state(network, (environment - first + 1) * length - 1, state);
            }
        }
        let width = networks.states()[CRITIC];
        let is_here = |end: &End| environments.contains(&end.environment) && end.step / length == number;
        for (index, end) in rollout.ends.iter().enumerate().filter(|(_, end)| is_here(end)) {
            let row = (end.environment - first) * length + end.step % length;
            worker.write_state(CRITIC, row, &mut self.ends[index * width..][..width]);
        }
    }
}

/// Writes values of a width to rows.
fn scatter(values: &mut [f32], from: &[f32], rows: impl Iterator<Item = usize>, width: usize) {
    for (row, from) in rows.zip(from.chunks_exact(width)) {
        values[row * width..][..width].copy_from_slice(from);
    }
}
