//! Actors: networks that compute actions from observations.

use std::ops::RangeInclusive;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::graph::{Batch, Places, Tape};
use super::recurrent::RecurrentScratch;
use super::{Graph, Layer, Shape, tanh};

/// Bounds of the logarithm of the standard deviation of a squashed Gaussian. Haarnoja et al. 2018 use -20 and 2; the
/// higher lower bound keeps densities finite in single precision.
pub const LOG_STD: RangeInclusive<f32> = -5.0..=2.0;

/// The distribution of actions, given the outputs of the network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Distribution {
    /// A Gaussian whose mean is the output. Samples are not bounded.
    Gaussian {
        /// Logarithm of the standard deviation of each action.
        log_std: Vec<f32>,
    },
    /// A Gaussian whose mean is the first half of the output. The second half is the logarithm of the standard
    /// deviation. Samples are not bounded.
    GaussianOfState {
        /// Lower bound of the logarithm of the standard deviation; the upper bound is [`LOG_STD`]'s.
        minimum: f32,
    },
    /// The hyperbolic tangent of a Gaussian with the two halves of the output as mean and logarithm of the standard
    /// deviation, within [`LOG_STD`] (Haarnoja et al. 2018, appendix C). Samples are between -1 and 1.
    SquashedGaussian,
}

/// A network and the distribution of its actions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actor {
    /// Shape of the network.
    pub shape: Shape,
    /// Parameters of the network.
    pub parameters: Vec<f32>,
    /// Distribution of the actions. For a graph network, a [`Distribution::Gaussian`] has one logarithm of a standard
    /// deviation per action of all node types.
    pub distribution: Distribution,
}

/// Buffers of an actor in a building, reused from step to step, and the state of a network with a memory.
#[derive(Clone, Debug)]
pub struct Scratch {
    form: Form,
    /// Width of an observation.
    observations: usize,
    /// Means, followed by logarithms of standard deviations if they depend on the state.
    outputs: Vec<f32>,
    /// Index of each action in the learned logarithms of standard deviations.
    free: Vec<usize>,
}

#[derive(Clone, Debug)]
enum Form {
    Flat { layers: Vec<f32> },
    Recurrent(RecurrentScratch),
    Graph { graph: Arc<Graph>, places: Places, tape: Box<Tape>, state: Vec<f32> },
}

impl Actor {
    /// Returns buffers for [`Actor::mean`] and [`Actor::sample`] in a building; a graph network needs its graph.
    ///
    /// # Panics
    /// If `graph` is `None` for a graph network.
    pub fn scratch(&self, graph: Option<&Arc<Graph>>) -> Scratch {
        let flat = |form, observations, outputs: usize| {
            let actions = if self.depends_on_state() { outputs / 2 } else { outputs };
            Scratch { form, observations, outputs: vec![0.0; outputs], free: (0..actions).collect() }
        };
        match (&self.shape, graph) {
            (Shape::Mlp(mlp), _) => flat(Form::Flat { layers: mlp.scratch() }, mlp.inputs(), mlp.outputs()),
            (Shape::Recurrent(network), _) => {
                let form = Form::Recurrent(network.scratch());
                flat(form, network.encoder.inputs(), network.head.outputs())
            }
            (Shape::Graph(network), Some(graph)) => {
                let actions = graph.actions.len();
                let outputs = vec![0.0; if self.depends_on_state() { 2 * actions } else { actions }];
                let free = graph.actions.iter().map(|place| place.number).collect();
                let (graph, places) = (Arc::clone(graph), network.places());
                let observations = graph.width();
                let state = vec![0.0; graph.nodes() * network.memory];
                let form = Form::Graph { graph, places, tape: Box::default(), state };
                Scratch { form, observations, outputs, free }
            }
            (Shape::Graph(_), None) => panic!("a graph network acts on the graph of a building"),
        }
    }

    /// Writes the action without exploration: the mean, squashed if the distribution is. Here and in [`Actor::sample`],
    /// a network with a memory advances to its next state. Allocates only at the first call.
    ///
    /// # Panics
    /// If the length of a slice does not match the shape, or `scratch` belongs to another network.
    pub fn mean(&self, observation: &[f32], scratch: &mut Scratch, action: &mut [f32]) {
        self.forward(observation, scratch);
        action.copy_from_slice(&scratch.outputs[..scratch.actions()]);
        self.squash(action);
    }

    /// Writes an action of the distribution: mean + standard deviation × normal, squashed if the distribution is.
    /// `normals` has a standard normal number per action. Allocates only at the first call.
    ///
    /// # Panics
    /// If the length of a slice does not match the shape, or `scratch` belongs to another network.
    pub fn sample(&self, observation: &[f32], normals: &[f32], scratch: &mut Scratch, action: &mut [f32]) {
        assert_eq!(normals.len(), scratch.actions(), "one normal number per action");
        self.forward(observation, scratch);
        action.copy_from_slice(&scratch.outputs[..scratch.actions()]);
        for (index, (value, normal)) in action.iter_mut().zip(normals).enumerate() {
            *value += self.log_std(index, scratch).exp() * normal;
        }
        self.squash(action);
    }

    fn forward(&self, observation: &[f32], scratch: &mut Scratch) {
        match (&self.shape, &mut scratch.form) {
            (Shape::Mlp(mlp), Form::Flat { layers }) => {
                mlp.forward(&self.parameters, observation, layers, &mut scratch.outputs);
            }
            (Shape::Recurrent(network), Form::Recurrent(scratch_of_step)) => {
                network.forward(&self.parameters, observation, scratch_of_step, &mut scratch.outputs);
            }
            (Shape::Graph(network), Form::Graph { graph, places, tape, state }) => {
                assert_eq!(observation.len(), graph.width(), "width of an observation");
                let batch = Batch::of_one(graph, observation);
                tape.forward(network, places, &self.parameters, batch, state, Layer::forward_rows);
                let count = graph.actions.len();
                for (action, place) in graph.actions.iter().enumerate() {
                    let outputs = tape.outputs_of(network, 0, place.node);
                    scratch.outputs[action] = outputs[place.output];
                    if self.depends_on_state() {
                        scratch.outputs[count + action] = outputs[outputs.len() / 2 + place.output];
                    }
                }
            }
            _ => panic!("the scratch belongs to another network"),
        }
    }

    fn log_std(&self, action: usize, scratch: &Scratch) -> f32 {
        let of_state = || scratch.outputs[scratch.actions() + action];
        match &self.distribution {
            Distribution::Gaussian { log_std } => log_std[scratch.free[action]],
            Distribution::GaussianOfState { minimum } => of_state().clamp(*minimum, *LOG_STD.end()),
            Distribution::SquashedGaussian => of_state().clamp(*LOG_STD.start(), *LOG_STD.end()),
        }
    }

    /// Returns whether the standard deviations depend on the state.
    fn depends_on_state(&self) -> bool {
        !matches!(self.distribution, Distribution::Gaussian { .. })
    }

    fn squash(&self, action: &mut [f32]) {
        if self.distribution == Distribution::SquashedGaussian {
            action.iter_mut().for_each(|value| *value = tanh(*value));
        }
    }
}

impl Scratch {
    /// Returns the number of actions.
    pub fn actions(&self) -> usize {
        self.free.len()
    }

    /// Returns the state after the last step, node by node for a graph network; empty without a memory.
    pub fn state(&self) -> &[f32] {
        match &self.form {
            Form::Recurrent(own) => &own.state,
            Form::Graph { state, .. } => state,
            Form::Flat { .. } => &[],
        }
    }

    /// Returns the state mutably. Zeros are an empty memory.
    pub fn state_mut(&mut self) -> &mut [f32] {
        match &mut self.form {
            Form::Recurrent(own) => &mut own.state,
            Form::Graph { state, .. } => state,
            Form::Flat { .. } => &mut [],
        }
    }

    /// Returns the width of an observation.
    pub fn observations(&self) -> usize {
        self.observations
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::{Activation, Mlp};

    /// Returns an actor of one input x without hidden layers: a mean of 2 x and, if it has a second output, -x.
    fn actor(distribution: Distribution) -> Actor {
        let outputs = if matches!(distribution, Distribution::Gaussian { .. }) { 1 } else { 2 };
        let shape = Mlp::new(1, &[], outputs, Activation::Tanh);
        let mut parameters = vec![0.0; shape.parameters()];
        parameters[..outputs].copy_from_slice(&[2.0, -1.0][..outputs]);
        Actor { shape: Shape::Mlp(shape), parameters, distribution }
    }

    fn action(actor: &Actor, x: f32, normal: f32) -> f32 {
        let mut action = [0.0];
        actor.sample(&[x], &[normal], &mut actor.scratch(None), &mut action);
        action[0]
    }

    #[test]
    fn a_sample_is_the_mean_plus_deviations() {
        let free = actor(Distribution::Gaussian { log_std: vec![0.5f32.ln()] });
        assert_eq!(action(&free, 1.0, 3.0), 3.5);
        let of_state = actor(Distribution::GaussianOfState { minimum: -1.0 });
        assert_eq!(action(&of_state, 0.5, 2.0), 1.0 + 2.0 * (-0.5f32).exp());
        assert_eq!(action(&of_state, 4.0, 2.0), 8.0 + 2.0 * (-1.0f32).exp());
        let squashed = actor(Distribution::SquashedGaussian);
        assert_eq!(action(&squashed, 0.5, 2.0), tanh(1.0 + 2.0 * (-0.5f32).exp()));
    }

    #[test]
    fn the_mean_is_a_sample_without_noise() {
        for distribution in [Distribution::GaussianOfState { minimum: -1.0 }, Distribution::SquashedGaussian]
        {
            let actor = actor(distribution);
            let mut mean = [0.0];
            actor.mean(&[0.3], &mut actor.scratch(None), &mut mean);
            assert_eq!(mean[0], action(&actor, 0.3, 0.0));
        }
    }
}
