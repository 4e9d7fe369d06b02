//! Agents: what they observe, how they act, their networks and their folders.
//!
//! An [`Agent`] is read from a folder and makes an [`AgentController`] for a building. A [`Pilot`] stands between
//! environment and network: it computes the agent's observation ([`AgentObservation`]) and converts the output of the
//! network to a physical action ([`Acting`]). Training uses the same pilot, so observations are the same in training and
//! in use.

mod acting;
mod agent;
mod description;
mod error;
mod folder;
mod info;
mod interface;
pub mod network;
mod observation;
mod onnx;
mod pilot;
mod plan;
pub mod protobuf;
mod shifted_targets;
mod supervisor;

pub use acting::Acting;
pub use agent::{Agent, AgentController};
pub use description::ControllerDescription;
pub use error::{Error, Result};
pub use folder::{FILES, INFO};
pub use info::{AgentInfo, FORMAT, TrainingInfo};
pub use interface::Interface;
pub use observation::{
    AgentObservation, Feature, NodeSpaces, NodeView, ObservationForm, ObservationOptions, attributes,
};
pub use pilot::Pilot;
pub use plan::{NodeForm, NodePlan, PlannedNode};
