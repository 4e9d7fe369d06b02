//! Normalization of the features of nodes, one for all nodes of a type in all buildings.

use b2b_agent::network::graph::NodeWidths;

use super::networks::Networks;
use crate::error::Result;
use crate::rollout::Rollout;
use crate::state::State;

/// Smallest deviation of a feature: features are of the order of one, and one that has hardly varied so far may vary
/// later.
const SMALLEST: f64 = 0.1;

/// Mean and deviation of the features of the nodes of each type, over all steps so far.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FeatureScale {
    normalize: bool,
    types: Vec<Moments>,
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
    pub fn new(types: &[NodeWidths], normalize: bool) -> Self {
        let moments = |node: &NodeWidths| Moments {
            count: 0.0,
            means: vec![0.0; node.features],
            squares: vec![0.0; node.features],
        };
        Self { normalize, types: types.iter().map(moments).collect() }
    }

    /// Returns the types that had a node.
    pub fn seen(&self) -> Vec<usize> {
        (0..self.types.len()).filter(|index| self.types[*index].count > 0.0).collect()
    }

    /// Adds the observations of a rollout, rows of a width.
    pub fn update(&mut self, rollout: &Rollout, width: usize) {
        for (number, scene) in rollout.scenes.iter().enumerate() {
            let next = rollout.scenes.get(number + 1).filter(|next| next.environment == scene.environment);
            let first = scene.environment * rollout.steps;
            let rows = first + scene.step..first + next.map_or(rollout.steps, |next| next.step);
            let observations = &rollout.observations[rows.start * width..rows.end * width];
            for (node, node_type) in scene.graph.types.iter().enumerate() {
                let columns = scene.graph.features[node]..scene.graph.features[node + 1];
                self.types[*node_type].add(observations.chunks_exact(width).map(|row| &row[columns.clone()]));
            }
        }
    }

    /// Writes the normalization to the parameters of actor and critic.
    pub fn write(&self, networks: &Networks, parameters: &mut [f32]) {
        if !self.normalize {
            return;
        }
        for (moments, places) in self.types.iter().zip(networks.feature_places()) {
            for place in places.iter().filter(|_| moments.count > 0.0) {
                let means = parameters[place.mean.clone()].iter_mut().zip(&moments.means);
                means.for_each(|(parameter, mean)| *parameter = *mean as f32);
                let scales = parameters[place.scale.clone()].iter_mut().zip(&moments.squares);
                scales.for_each(|(parameter, squares)| {
                    *parameter = (1.0 / (squares / moments.count).sqrt().max(SMALLEST)) as f32;
                });
            }
        }
    }

    /// Adds the statistics to a state.
    pub fn save(&self, state: &mut State) {
        for (index, moments) in self.types.iter().enumerate() {
            state.put_f64(&format!("features.{index}"), &moments.numbers());
        }
    }

    /// Restores the statistics from a state.
    ///
    /// # Errors
    /// When the state does not contain them.
    pub fn restore(&mut self, state: &State) -> Result<()> {
        for (index, moments) in self.types.iter_mut().enumerate() {
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
