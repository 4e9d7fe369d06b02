//! The networks of PPO, and where their parameters are.

use std::ops::Range;

use b2b_agent::network::graph::{EncoderPlaces, NodeWidths};
use b2b_agent::network::recurrent::GATES;
use b2b_agent::network::{Actor, Distribution, Graph, GraphNetwork, LOG_STD, Layer, Mlp, Recurrent, Shape};

use super::{LogStd, PpoConfig};
use crate::nn::graph::Readout;
use crate::nn::{InitialGains, graph, initialize_recurrent, orthogonal};
use crate::policy::RecurrentPolicy;
use crate::random::RandomStream;
use crate::rollout::Widths;

/// The shapes of actor and critic. All parameters are one slice: the actor's, the log standard deviations
/// that do not depend on the observation, and the critic's.
#[derive(Clone, Debug)]
pub(super) struct Networks {
    /// Shape of the actor: outputs are means and, if they depend on the observation, logarithms of standard deviations.
    pub actor: Shape,
    /// Shape of the critic: a value per part of the reward. A graph network has a value per node; if the reward is not
    /// in parts, their mean is the value.
    pub critic: Shape,
    pub widths: Widths,
    /// Steps of backpropagation through time in networks with a memory; 1 for other networks.
    pub sequence: usize,
    /// Whether standard deviations depend on the observation.
    of_state: bool,
    /// Ends of the actor's parameters, the log standard deviations, and the critic's parameters.
    ends: [usize; 3],
    /// Lower bound of the logarithm of the standard deviation.
    minimum: f32,
}

/// The kind of networks.
#[derive(Clone, Copy)]
pub(super) enum NetworkKind<'a> {
    Flat,
    Recurrent(&'a RecurrentPolicy),
    /// Graph networks with an actor of this shape, and the steps of a sequence.
    Graph(&'a GraphNetwork, usize),
}

impl Networks {
    /// Returns the shapes.
    pub fn new(widths: Widths, config: &PpoConfig, kind: NetworkKind<'_>) -> Self {
        let of_state = config.log_std == LogStd::OfState;
        let halves = if of_state { 2 } else { 1 };
        let mlp = |inputs, hidden: &[usize], outputs| Mlp::new(inputs, hidden, outputs, config.activation);
        let (actor, critic) = match kind {
            NetworkKind::Flat | NetworkKind::Recurrent(_) => {
                let shape = |hidden: &[usize], outputs| match kind {
                    NetworkKind::Recurrent(RecurrentPolicy { width, .. }) => Shape::Recurrent(Recurrent {
                        encoder: mlp(widths.observation, hidden, GATES * width),
                        head: mlp(*width, &[], outputs),
                    }),
                    _ => Shape::Mlp(mlp(widths.observation, hidden, outputs)),
                };
                let actor = shape(&config.actor_hidden, halves * widths.action);
                (actor, shape(&config.critic_hidden, widths.parts))
            }
            NetworkKind::Graph(network, _) => {
                let with = |outputs: &dyn Fn(usize) -> usize| {
                    let types = network.types.iter();
                    let types = types.map(|node| NodeWidths { outputs: outputs(node.outputs), ..*node });
                    Shape::Graph(GraphNetwork { types: types.collect(), ..network.clone() })
                };
                (with(&|actions| halves * actions), with(&|_| 1))
            }
        };
        let free = match &actor {
            _ if of_state => 0,
            Shape::Mlp(_) | Shape::Recurrent(_) => widths.action,
            Shape::Graph(network) => network.types.iter().map(|node| node.outputs).sum(),
        };
        let end = actor.parameters();
        let ends = [end, end + free, end + free + critic.parameters()];
        let sequence = match kind {
            NetworkKind::Recurrent(policy) => policy.sequence,
            NetworkKind::Graph(network, sequence) if network.memory > 0 => sequence,
            NetworkKind::Flat | NetworkKind::Graph(..) => 1,
        };
        Self { actor, critic, widths, sequence, of_state, ends, minimum: config.minimum_log_std }
    }

    /// Returns initial parameters.
    pub fn initialize(&self, config: &PpoConfig, random: &mut RandomStream) -> Vec<f32> {
        let mut parameters = self.initialize_shape(&self.actor, config.actor_gain, random);
        if self.of_state {
            for (biases, start) in self.log_std_biases() {
                parameters[biases][start..].fill(config.initial_log_std);
            }
        }
        parameters.extend(self.log_stds().map(|_| config.initial_log_std));
        parameters.extend(self.initialize_shape(&self.critic, 1.0, random));
        self.project(&mut parameters);
        parameters
    }

    fn initialize_shape(&self, shape: &Shape, last: f32, random: &mut RandomStream) -> Vec<f32> {
        match shape {
            Shape::Mlp(mlp) => {
                orthogonal(mlp, InitialGains { hidden: std::f32::consts::SQRT_2, last }, random)
            }
            Shape::Recurrent(network) => initialize_recurrent(network, last, self.sequence, random),
            Shape::Graph(network) => graph::initialize(network, last, self.sequence, random),
        }
    }

    /// Returns the widths of the states of actor and critic in the largest building; 0 if the networks keep none.
    pub fn states(&self) -> [usize; 2] {
        [&self.actor, &self.critic].map(|shape| shape.state() * self.widths.nodes)
    }

    /// Returns the biases of the actor's last layers, and the index where the log standard deviations begin.
    fn log_std_biases(&self) -> Vec<(Range<usize>, usize)> {
        let half = |layer: Layer| (layer.biases, layer.outputs / 2);
        match &self.actor {
            Shape::Mlp(_) | Shape::Recurrent(_) => last_layer(&self.actor).map(half).into_iter().collect(),
            Shape::Graph(network) => network.places().decoders.into_iter().map(half).collect(),
        }
    }

    /// Returns the width of a row of outputs of the actor.
    pub fn outputs(&self) -> usize {
        if self.of_state { 2 * self.widths.action } else { self.widths.action }
    }

    /// Returns where the feature means and scales, which are not learned, are among all parameters: for each node type,
    /// in the actor and in the critic.
    pub fn feature_places(&self) -> Vec<[EncoderPlaces; 2]> {
        let of = |shape: &Shape, start: usize| -> Vec<EncoderPlaces> {
            let places = shape.graph().map(|network| network.places().encoders).unwrap_or_default();
            let moved = |range: Range<usize>| moved(range, start);
            places
                .into_iter()
                .map(|place| EncoderPlaces { mean: moved(place.mean), scale: moved(place.scale), ..place })
                .collect()
        };
        let critic = of(&self.critic, self.critics().start);
        of(&self.actor, 0).into_iter().zip(critic).map(|(actor, critic)| [actor, critic]).collect()
    }

    /// Returns the range of the actor's parameters.
    pub fn actors(&self) -> Range<usize> {
        0..self.ends[0]
    }

    /// Returns the range of the free logarithms of standard deviations. A graph network has one for every action of a
    /// node type.
    pub fn log_stds(&self) -> Range<usize> {
        self.ends[0]..self.ends[1]
    }

    /// Returns the range of the critic's parameters.
    pub fn critics(&self) -> Range<usize> {
        self.ends[1]..self.ends[2]
    }

    /// Returns the critic's last layers and their outputs with the values of a kind of reward part: a node type
    /// of a graph network, otherwise the part itself. Places are relative to the critic's parameters.
    pub fn value_outputs(&self, kind: usize) -> Vec<(Layer, usize)> {
        match &self.critic {
            Shape::Mlp(_) | Shape::Recurrent(_) => {
                last_layer(&self.critic).map(|layer| (layer, kind)).into_iter().collect()
            }
            Shape::Graph(network) => {
                let decoders = network.places().decoders.into_iter().enumerate();
                let is_read = |(node_type, _): &(usize, Layer)| !self.is_by_node() || *node_type == kind;
                decoders.filter(is_read).map(|(_, layer)| (layer, 0)).collect()
            }
        }
    }

    /// Returns the number of kinds of parts of the reward.
    pub fn value_kinds(&self) -> usize {
        match &self.critic {
            Shape::Graph(network) if self.is_by_node() => network.types.len(),
            Shape::Mlp(_) | Shape::Recurrent(_) | Shape::Graph(_) => self.widths.parts,
        }
    }

    /// Returns how a graph network's outputs become values.
    pub fn values(&self) -> Readout {
        match self.is_by_node() {
            true => Readout::Nodes { nodes: self.widths.parts },
            false => Readout::Mean,
        }
    }

    /// Returns whether the reward has a part for every node of a building.
    pub fn is_by_node(&self) -> bool {
        self.critic.graph().is_some() && self.widths.parts > 1
    }

    /// Returns the actor with these parameters.
    pub fn actor(&self, parameters: &[f32]) -> Actor {
        let distribution = match self.of_state {
            true => Distribution::GaussianOfState { minimum: self.minimum },
            false => Distribution::Gaussian { log_std: parameters[self.log_stds()].to_vec() },
        };
        Actor { shape: self.actor.clone(), parameters: parameters[self.actors()].to_vec(), distribution }
    }

    /// Returns the actor's first layer; `None` for a graph network.
    pub fn first_layer(&self) -> Option<Layer> {
        match &self.actor {
            Shape::Mlp(mlp) => mlp.layers().next(),
            // The encoder is the first of its parts.
            Shape::Recurrent(network) => network.encoder.layers().next(),
            Shape::Graph(_) => None,
        }
    }

    /// Returns whether standard deviations depend on the observation.
    pub fn of_state(&self) -> bool {
        self.of_state
    }

    /// Writes the logarithms of standard deviations for the outputs of the actor, in the building of a graph network.
    pub fn write_log_std(
        &self,
        parameters: &[f32],
        outputs: &[f32],
        graph: Option<&Graph>,
        log_std: &mut [f32],
    ) {
        let free = &parameters[self.log_stds()];
        match graph {
            _ if self.of_state => log_std.copy_from_slice(&outputs[self.widths.action..]),
            None => log_std.copy_from_slice(free),
            Some(graph) => {
                let places = log_std.iter_mut().zip(&graph.actions);
                places.for_each(|(value, place)| *value = free[place.number]);
            }
        }
        log_std.iter_mut().for_each(|value| *value = value.clamp(self.minimum, *LOG_STD.end()));
    }

    /// Adds the gradients of a row's log standard deviations to the gradients of the free parameters.
    pub fn add_log_std_gradients(&self, gradients: &[f32], graph: Option<&Graph>, sums: &mut [f32]) {
        match graph {
            None => sums.iter_mut().zip(gradients).for_each(|(sum, gradient)| *sum += gradient),
            Some(graph) => {
                let places = graph.actions.iter().zip(gradients);
                places.for_each(|(place, gradient)| sums[place.number] += gradient);
            }
        }
    }

    /// Zeros the gradients where the log standard deviation of these outputs is outside its bounds.
    pub fn clamp_gradients(&self, outputs: &[f32], gradients: &mut [f32]) {
        let range = self.minimum..=*LOG_STD.end();
        for (output, gradient) in outputs[self.widths.action..].iter().zip(gradients) {
            if !range.contains(output) {
                *gradient = 0.0;
            }
        }
    }

    /// Clamps the free log standard deviations to their bounds.
    pub fn project(&self, parameters: &mut [f32]) {
        let (minimum, maximum) = (self.minimum, *LOG_STD.end());
        parameters[self.log_stds()].iter_mut().for_each(|value| *value = value.clamp(minimum, maximum));
    }
}

/// Returns the last layer of a network that is not a graph network.
fn last_layer(shape: &Shape) -> Option<Layer> {
    match shape {
        Shape::Mlp(mlp) => mlp.layers().last(),
        Shape::Recurrent(network) => {
            let (last, start) = (network.head.layers().last()?, network.places().head.start);
            Some(Layer { weights: moved(last.weights, start), biases: moved(last.biases, start), ..last })
        }
        Shape::Graph(_) => None,
    }
}

/// Returns a range that begins later by `start`.
fn moved(range: Range<usize>, start: usize) -> Range<usize> {
    range.start + start..range.end + start
}
