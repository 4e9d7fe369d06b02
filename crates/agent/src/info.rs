//! The description of an agent in its folder.

use b2b_env::Task;
use serde::{Deserialize, Serialize};

use crate::interface::Interface;
use crate::network::{Distribution, Shape};

/// Version of the folder format. Format 1, whose descriptions do not state their own SHA-256, can be read, too.
pub const FORMAT: u32 = 2;

/// The description of an agent in `agent.json`: its observation, its actions and its training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AgentInfo {
    /// [`FORMAT`] of the folder.
    pub format: u32,
    /// Form of observations and meaning of actions.
    pub interface: Interface,
    /// Name of every observation slot of the network; for a graph network, of all node types, trained or not.
    pub slots: Vec<String>,
    /// Name of every action: an actuator or a shift. For a graph network, of all node types.
    pub actuators: Vec<String>,
    /// Node types that a graph network was trained with. With direct actions, it controls only buildings whose
    /// actuators all belong to nodes of these types.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub node_types: Vec<String>,
    /// Shape of the network.
    pub network: Shape,
    /// Consecutive episodes in a building that its memory spans, as in training. `None`: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory_episodes: Option<u32>,
    /// Distribution of its actions in training.
    pub distribution: Distribution,
    /// Task that it was trained for.
    pub task: Task,
    /// How it was trained.
    pub training: TrainingInfo,
    /// SHA-256 of the weights file.
    pub weights: String,
}

/// How an agent was trained.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrainingInfo {
    /// Algorithm, such as `ppo`.
    pub algorithm: String,
    /// Training buildings, as the user named them.
    pub buildings: String,
    /// Tasks, separated by commas. Empty: the agent's task alone.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub tasks: String,
    /// Benchmark problem on whose training side it was trained; empty if none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub problem: String,
    /// Run period.
    pub period: String,
    /// Zone time steps per hour.
    pub steps_per_hour: u32,
    /// Environment steps so far.
    pub steps: u64,
    /// Random seed.
    pub seed: u64,
    /// Version of this package.
    pub package: String,
    /// Version of the building generator and its dataset.
    pub generator: String,
    /// Version of EnergyPlus.
    pub engine: String,
    /// For an agent that corrects the reactive controllers or shifts their targets, the hash of their parameters; for
    /// one that supervises `guideline36`, its revision, and at the end the identity of the rules that it supervises from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base_controllers: Option<String>,
}
