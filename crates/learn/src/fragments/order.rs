//! Orders of fragments: what a worker needs to run one.

use b2b_agent::network::{Actor, Distribution, Shape};
use b2b_agent::{Interface, NodePlan};
use serde::{Deserialize, Serialize};

use super::blocks::Block;

/// The purpose of a fragment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Purpose {
    /// Samples actions, and records every step.
    Explore,
    /// Replays the actions in the block, to bring an episode back to a step that it had reached.
    Replay,
}

/// Returns the number of the random stream that a fragment explores with. A fragment is the steps of one environment
/// and episode in a rollout; fragments are numbered from 0 in each rollout. No two fragments of a run share a stream,
/// unless their noise is mirrored.
pub(crate) fn stream(rollout: u64, environment: usize, fragment: u64) -> u64 {
    (fragment >> 8) << 56 | rollout << 24 | (environment as u64) << 8 | fragment & 0xff
}

/// A fragment that a worker runs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FragmentOrder {
    /// Observation of the agent and meaning of its actions.
    pub interface: Interface,
    /// The building, for a graph network.
    pub plan: Option<NodePlan>,
    /// Attributes of the building that the agent observes: see [`b2b_agent::attributes`].
    pub attributes: Vec<f64>,
    /// Shape of its network.
    pub shape: Shape,
    /// Distribution of its actions. The parameters of a [`Distribution::Gaussian`] follow the network's.
    pub distribution: Distribution,
    /// Place of the parameters in the shared memory.
    pub parameters: usize,
    /// Version of the parameters; a worker reads them again when it changes.
    pub version: u64,
    /// Whether to explore or to replay.
    pub purpose: Purpose,
    /// Number of decisions. A decision is one step, unless the agent holds its decisions for several.
    pub steps: usize,
    /// Block of shared memory to write to.
    pub block: Block,
    /// Decisions already in the block.
    pub done: usize,
    /// Random seed and stream of exploration.
    pub random: (u64, u64),
    /// Correlation of the exploration noise between consecutive steps.
    pub correlation: f32,
    /// Whether the exploration noise is negated.
    pub mirrored: bool,
    /// Discount γ per step, for the rewards while a decision is held.
    pub discount: f32,
    /// Factor that multiplies the penalty of discomfort.
    pub comfort_weight: f32,
    /// Cost of a full stroke, averaged over the actuators, in the unit of the environment's rewards.
    pub travel_cost: f32,
}

impl FragmentOrder {
    /// Returns the parameters of an actor that a worker needs: the network's, then those of a Gaussian distribution.
    pub fn numbers(actor: &Actor) -> Vec<f32> {
        let mut numbers = actor.parameters.clone();
        if let Distribution::Gaussian { log_std } = &actor.distribution {
            numbers.extend_from_slice(log_std);
        }
        numbers
    }
}
