//! Passes of a chunk of a minibatch through actor and critic.

use std::ops::Range;
use std::sync::Arc;

use b2b_agent::network::graph::Batch;
use b2b_agent::network::{Graph, Shape};

use super::PpoConfig;
use super::loss::{ActorStep, Losses, PolicyLoss, group_log_density, value_loss};
use super::networks::Networks;
use super::samples::Samples;
use crate::credit::Credit;
use crate::nn::graph::{GraphPass, Readout};
use crate::nn::{Pass, RecurrentPass, Sequences, sized};

/// Index of the actor's states and optimizer, and of the critic's.
pub(super) const ACTOR: usize = 0;
pub(super) const CRITIC: usize = 1;

/// Inputs of a network.
#[derive(Clone, Copy)]
pub(super) struct Inputs<'a> {
    /// Observations.
    pub batch: Batch<'a>,
    /// The sequences of networks with a memory.
    pub sequences: Sequences<'a>,
}

/// Inputs that all chunks of a minibatch share.
#[derive(Clone, Copy)]
pub(super) struct Minibatch<'a> {
    pub config: &'a PpoConfig,
    pub networks: &'a Networks,
    /// Credits of the buildings.
    pub credits: &'a [Arc<Credit>],
    /// Width of a row of advantages.
    pub groups: usize,
    pub parameters: &'a [f32],
    pub samples: &'a Samples,
    /// Buildings of the scenes of the rollout.
    pub graphs: &'a [Arc<Graph>],
    /// Number of rows.
    pub rows: usize,
    /// Whether the actor does not learn.
    pub critic_only: bool,
}

impl<'a> Minibatch<'a> {
    /// Returns the step of a row with these outputs of the actor.
    fn step(&self, row: usize, outputs: &'a [f32], log_std: &'a [f32]) -> ActorStep<'a> {
        let (groups, actions) = (self.groups, log_std.len());
        ActorStep {
            action: &self.samples.actions[row * self.networks.widths.action..][..actions],
            mean: &outputs[..actions],
            log_std,
            old: &self.samples.old[row * groups..][..groups],
            advantages: &self.samples.advantages[row * groups..][..groups],
        }
    }

    /// Returns the inputs of the actor or the critic in rows.
    fn inputs(&self, rows: &Range<usize>, network: usize) -> Inputs<'a> {
        let (width, samples) = (self.networks.widths.observation, self.samples);
        let batch = Batch {
            graphs: self.graphs,
            of_rows: &samples.scenes[rows.clone()],
            observations: &samples.observations[times(rows, width)],
            width,
        };
        let (length, width) = (self.networks.sequence, self.networks.states()[network]);
        let sequences = match width {
            0 => Sequences::none(),
            _ => Sequences {
                length,
                states: &samples.states[network][times(&(rows.start / length..rows.end / length), width)],
                starts: &samples.starts[rows.clone()],
            },
        };
        Inputs { batch, sequences }
    }

    /// Returns the credit of a row.
    fn credit(&self, row: usize) -> &'a Credit {
        &self.credits[self.samples.scenes[row]]
    }

    /// Returns the building of a row, for graph networks.
    fn graph(&self, row: usize) -> Option<&'a Graph> {
        self.graphs.get(self.samples.scenes[row]).map(|graph| &**graph)
    }
}

/// Passes of a kind of network.
#[derive(Clone, Debug)]
enum NetworkPass {
    Flat(Pass),
    Recurrent(Box<RecurrentPass>),
    Graph(Box<GraphPass>),
}

impl NetworkPass {
    fn new(shape: &Shape, readout: Readout) -> Self {
        match shape {
            Shape::Mlp(mlp) => Self::Flat(Pass::new(mlp)),
            Shape::Recurrent(network) => Self::Recurrent(Box::new(RecurrentPass::new(network))),
            Shape::Graph(network) => Self::Graph(Box::new(GraphPass::new(network, readout))),
        }
    }

    /// Returns the number of rows per pass, in sequences of this length: the whole chunk, or as many buildings as fit
    /// in the processor's cache.
    fn rows(&self, length: usize) -> usize {
        match self {
            Self::Flat(_) | Self::Recurrent(_) => usize::MAX,
            Self::Graph(_) => (32 / length).max(1) * length,
        }
    }

    fn forward(&mut self, parameters: &[f32], inputs: Inputs<'_>) -> &[f32] {
        let Inputs { batch, sequences } = inputs;
        match self {
            Self::Flat(pass) => pass.forward(parameters, batch.observations, batch.of_rows.len()),
            Self::Recurrent(pass) => pass.forward(parameters, batch.observations, sequences),
            Self::Graph(pass) => pass.forward(parameters, batch, sequences),
        }
    }

    fn outputs(&self) -> &[f32] {
        match self {
            Self::Flat(pass) => pass.outputs(),
            Self::Recurrent(pass) => pass.outputs(),
            Self::Graph(pass) => pass.outputs(),
        }
    }

    /// Returns the state after a row of the last forward pass; empty without a memory.
    fn state(&self, row: usize) -> &[f32] {
        match self {
            Self::Flat(_) => &[],
            Self::Recurrent(pass) => pass.state(row),
            Self::Graph(pass) => pass.state(row),
        }
    }

    fn backward(&mut self, parameters: &[f32], inputs: Inputs<'_>, gradients: &[f32], sums: &mut [f32]) {
        let Inputs { batch, .. } = inputs;
        match self {
            Self::Flat(pass) => pass.backward(parameters, batch.observations, gradients, Some(sums), None),
            Self::Recurrent(pass) => pass.backward(parameters, batch.observations, gradients, sums),
            Self::Graph(pass) => pass.backward(parameters, batch, gradients, sums),
        }
    }
}

/// The buffers of a chunk, and its losses and gradients.
#[derive(Clone, Debug)]
pub(super) struct Worker {
    actor: NetworkPass,
    critic: NetworkPass,
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
        let (actions, of_state) = (networks.widths.action, networks.of_state());
        Self {
            actor: NetworkPass::new(&networks.actor, Readout::Actions { actions, of_state }),
            critic: NetworkPass::new(&networks.critic, networks.values()),
            log_std: [vec![0.0; actions], vec![0.0; actions]],
            outputs: Default::default(),
            gradients: vec![0.0; networks.critics().end],
            losses: Losses::default(),
        }
    }

    /// Computes losses and gradients of rows of a minibatch.
    pub fn learn(&mut self, batch: &Minibatch<'_>, rows: Range<usize>) {
        self.gradients.fill(0.0);
        self.losses = Losses::default();
        let size = self.actor.rows(batch.networks.sequence);
        let mut first = rows.start;
        while first < rows.end {
            let block = first..rows.end.min(first.saturating_add(size));
            first = block.end;
            if !batch.critic_only {
                self.learn_policy(batch, block.clone());
            }
            self.learn_values(batch, block);
        }
    }

    fn learn_policy(&mut self, batch: &Minibatch<'_>, rows: Range<usize>) {
        let parameters = &batch.parameters[batch.networks.actors()];
        let inputs = batch.inputs(&rows, ACTOR);
        let length = self.actor.forward(parameters, inputs).len();
        self.outputs[0].clear();
        self.outputs[0].resize(length, 0.0);
        self.add_policy_loss(batch, rows);
        let sums = &mut self.gradients[batch.networks.actors()];
        self.actor.backward(parameters, inputs, &self.outputs[0], sums);
    }

    /// Adds the loss of the policy in these rows, and writes the gradients of the outputs of the actor.
    fn add_policy_loss(&mut self, batch: &Minibatch<'_>, rows: Range<usize>) {
        let Minibatch { networks, config, .. } = batch;
        let width = networks.outputs();
        let [log_std, log_std_gradients] = &mut self.log_std;
        let outputs = self.actor.outputs().chunks_exact(width);
        for (row, (outputs, gradients)) in rows.zip(outputs.zip(self.outputs[0].chunks_exact_mut(width))) {
            let graph = batch.graph(row);
            networks.write_log_std(batch.parameters, outputs, graph, log_std);
            let actions = graph.map_or(networks.widths.action, |graph| graph.actions.len());
            let step = batch.step(row, outputs, &log_std[..actions]);
            let loss = PolicyLoss {
                credit: batch.credit(row),
                clip_range: config.clip_range,
                entropy_coefficient: config.entropy_coefficient,
                bound_coefficient: config.bound_coefficient,
                rows: batch.rows,
            };
            let (means, of_state) = gradients.split_at_mut(networks.widths.action);
            if networks.of_state() {
                loss.add(&step, means, of_state, &mut self.losses);
                networks.clamp_gradients(outputs, of_state);
            } else {
                log_std_gradients.fill(0.0);
                loss.add(&step, means, log_std_gradients, &mut self.losses);
                let sums = &mut self.gradients[networks.log_stds()];
                networks.add_log_std_gradients(log_std_gradients, graph, sums);
            }
        }
    }

    fn learn_values(&mut self, batch: &Minibatch<'_>, rows: Range<usize>) {
        let Minibatch { networks, samples, config, .. } = batch;
        let parameters = &batch.parameters[networks.critics()];
        let inputs = batch.inputs(&rows, CRITIC);
        let parts = networks.widths.parts;
        let returns = samples.returns[times(&rows, parts)].chunks_exact(parts);
        let values = self.critic.forward(parameters, inputs);
        let gradients = sized(&mut self.outputs[1], values.len());
        let share = (config.value_coefficient, batch.rows);
        let steps = values.chunks_exact(parts).zip(returns).zip(gradients.chunks_exact_mut(parts));
        for (row, ((values, returns), gradients)) in rows.zip(steps) {
            self.losses.value += value_loss(values, returns, batch.credit(row), share, gradients);
        }
        let sums = &mut self.gradients[networks.critics()];
        self.critic.backward(parameters, inputs, gradients, sums);
    }

    /// Appends the log densities of groups of actions: rows × groups.
    pub fn log_densities(
        &mut self,
        networks: &Networks,
        (credits, groups): (&[Arc<Credit>], usize),
        parameters: &[f32],
        (inputs, actions): (Inputs<'_>, &[f32]),
        densities: &mut Vec<f32>,
    ) {
        let outputs = self.actor.forward(&parameters[networks.actors()], inputs);
        let outputs = outputs.chunks_exact(networks.outputs());
        let rows = outputs.zip(actions.chunks_exact(networks.widths.action)).zip(inputs.batch.of_rows);
        for ((outputs, action), of_row) in rows {
            let graph = inputs.batch.graphs.get(*of_row).map(|graph| &**graph);
            networks.write_log_std(parameters, outputs, graph, &mut self.log_std[0]);
            let count = graph.map_or(action.len(), |graph| graph.actions.len());
            let (action, mean, log_std) = (&action[..count], &outputs[..count], &self.log_std[0][..count]);
            let density = |group| group_log_density(&credits[*of_row], group, action, mean, log_std);
            densities.extend((0..groups).map(density));
        }
    }

    /// Appends the outputs of the critic: rows × parts.
    pub fn values(
        &mut self,
        networks: &Networks,
        parameters: &[f32],
        inputs: Inputs<'_>,
        values: &mut Vec<f32>,
    ) {
        values.extend_from_slice(self.critic.forward(&parameters[networks.critics()], inputs));
    }

    /// Writes the state of the actor or the critic after a row of its last pass. Padding behind it stays as it is.
    pub fn write_state(&self, network: usize, row: usize, to: &mut [f32]) {
        let state = [&self.actor, &self.critic][network].state(row);
        to[..state.len()].copy_from_slice(state);
    }
}

/// Returns the range of rows of this width.
fn times(rows: &Range<usize>, width: usize) -> Range<usize> {
    rows.start * width..rows.end * width
}
