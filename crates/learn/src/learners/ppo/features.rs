//! Normalization of observations: of the features of nodes, one for all nodes of a type in all buildings, or of the
//! slots of a flat network.

use b2b_agent::network::Layer;
use b2b_agent::network::graph::NodeWidths;

use super::networks::Networks;
use crate::error::Result;
use crate::rollout::Rollout;
use crate::state::State;

/// Smallest deviation of a feature: features are of the order of one, and one that has hardly varied so far may vary
/// later.
const SMALLEST: f64 = 0.1;
/// Smallest deviation of a slot of a flat network, whose bounds are -1 and 1: 0.075 K of a zone temperature.
const SMALLEST_OF_SLOT: f64 = 1e-3;

/// Mean and deviation of observations over all steps so far.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FeatureScale {
    kind: Kind,
    moments: Vec<Moments>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Moments of the features of each node type. They are parameters of the networks, which `normalize` writes.
    Nodes { normalize: bool },
    /// Moments of the slots of a flat network, which learns from normalized observations.
    Slots,
}

#[derive(Clone, Debug, PartialEq)]
struct Moments {
    count: f64,
    means: Vec<f64>,
    /// Sums of squared deviations from the mean.
    squares: Vec<f64>,
}

impl FeatureScale {
    /// Returns the scale of node types. It changes no parameters without `normalize`.
    pub fn of_nodes(types: &[NodeWidths], normalize: bool) -> Self {
        let moments = types.iter().map(|node| Moments::new(node.features)).collect();
        Self { kind: Kind::Nodes { normalize }, moments }
    }

    /// Returns the scale of a flat network's observations of a width. It changes nothing without `normalize`.
    pub fn of_slots(width: usize, normalize: bool) -> Self {
        match normalize {
            true => Self { kind: Kind::Slots, moments: vec![Moments::new(width)] },
            false => Self::of_nodes(&[], false),
        }
    }

    /// Returns the node types that had a node.
    pub fn seen(&self) -> Vec<usize> {
        let is_seen = |index: &usize| self.kind != Kind::Slots && self.moments[*index].count > 0.0;
        (0..self.moments.len()).filter(is_seen).collect()
    }

    /// Adds the observations of a rollout, rows of a width.
    pub fn update(&mut self, rollout: &Rollout, width: usize) {
        if self.kind == Kind::Slots {
            return self.moments[0].add(rollout.observations.chunks_exact(width));
        }
        for (number, scene) in rollout.scenes.iter().enumerate() {
            let next = rollout.scenes.get(number + 1).filter(|next| next.environment == scene.environment);
            let first = scene.environment * rollout.steps;
            let rows = first + scene.step..first + next.map_or(rollout.steps, |next| next.step);
            let observations = &rollout.observations[rows.start * width..rows.end * width];
            for (node, node_type) in scene.graph.types.iter().enumerate() {
                let columns = scene.graph.features[node]..scene.graph.features[node + 1];
                self.moments[*node_type]
                    .add(observations.chunks_exact(width).map(|row| &row[columns.clone()]));
            }
        }
    }

    /// Writes the normalization of nodes to the parameters of actor and critic.
    pub fn write(&self, networks: &Networks, parameters: &mut [f32]) {
        if self.kind != (Kind::Nodes { normalize: true }) {
            return;
        }
        for (moments, places) in self.moments.iter().zip(networks.feature_places()) {
            for place in places.iter().filter(|_| moments.count > 0.0) {
                let means = parameters[place.mean.clone()].iter_mut().zip(&moments.means);
                means.for_each(|(parameter, mean)| *parameter = *mean as f32);
                let scales = parameters[place.scale.clone()].iter_mut().zip(moments.scales(SMALLEST));
                scales.for_each(|(parameter, scale)| *parameter = scale as f32);
            }
        }
    }

    /// Normalizes observations of a flat network, row by row.
    pub fn normalize(&self, observations: &mut [f32]) {
        let Some(slots) = self.slots() else { return };
        for row in observations.chunks_exact_mut(slots.len()) {
            let values = row.iter_mut().zip(&slots);
            values.for_each(|(value, (mean, scale))| *value = ((f64::from(*value) - mean) * scale) as f32);
        }
    }

    /// Changes the first layer of a flat network that learned from normalized observations to one for observations as
    /// they are.
    pub fn fold(&self, layer: &Layer, parameters: &mut [f32]) {
        let Some(slots) = self.slots() else { return };
        let mut shifts = vec![0.0; layer.outputs];
        let rows = parameters[layer.weights.clone()].chunks_exact_mut(layer.outputs);
        for (weights, (mean, scale)) in rows.zip(slots) {
            for (weight, shift) in weights.iter_mut().zip(&mut shifts) {
                let folded = f64::from(*weight) * scale;
                *shift += folded * mean;
                *weight = folded as f32;
            }
        }
        let biases = parameters[layer.biases.clone()].iter_mut().zip(shifts);
        biases.for_each(|(bias, shift)| *bias = (f64::from(*bias) - shift) as f32);
    }

    /// Returns the mean and the scale of every slot; `None` before the first rollout, and for graph networks.
    fn slots(&self) -> Option<Vec<(f64, f64)>> {
        let moments = self.moments.first().filter(|first| self.kind == Kind::Slots && first.count > 0.0)?;
        Some(moments.means.iter().copied().zip(moments.scales(SMALLEST_OF_SLOT)).collect())
    }

    /// Adds the statistics to a state.
    pub fn save(&self, state: &mut State) {
        for (index, moments) in self.moments.iter().enumerate() {
            state.put_f64(&format!("features.{index}"), &moments.numbers());
        }
    }

    /// Restores the statistics from a state.
    ///
    /// # Errors
    /// When the state does not contain them.
    pub fn restore(&mut self, state: &State) -> Result<()> {
        for (index, moments) in self.moments.iter_mut().enumerate() {
            let mut numbers = moments.numbers();
            state.read_f64(&format!("features.{index}"), &mut numbers)?;
            let features = moments.means.len();
            moments.count = numbers[0];
            moments.means.copy_from_slice(&numbers[1..=features]);
            moments.squares.copy_from_slice(&numbers[1 + features..]);
        }
        Ok(())
    }
}

impl Moments {
    fn new(width: usize) -> Self {
        Self { count: 0.0, means: vec![0.0; width], squares: vec![0.0; width] }
    }

    /// Returns one over the deviation of each value, or over `smallest` if that is larger.
    fn scales(&self, smallest: f64) -> impl Iterator<Item = f64> {
        self.squares.iter().map(move |squares| 1.0 / (squares / self.count).sqrt().max(smallest))
    }

    /// Adds rows of features, one by one (Welford 1962). A row that is not finite is left out.
    fn add<'a>(&mut self, rows: impl Iterator<Item = &'a [f32]>) {
        for row in rows.filter(|row| row.iter().all(|value| value.is_finite())) {
            self.count += 1.0;
            for ((value, mean), squares) in row.iter().zip(&mut self.means).zip(&mut self.squares) {
                let before = f64::from(*value) - *mean;
                *mean += before / self.count;
                *squares += before * (f64::from(*value) - *mean);
            }
        }
    }

    fn numbers(&self) -> Vec<f64> {
        [&[self.count][..], &self.means, &self.squares].concat()
    }
}
