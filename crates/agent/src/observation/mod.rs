//! Observations of agents: the environment's observation, scaled to numbers of order one.

mod agent_observation;
mod appended;
mod feature;
mod features;
mod memory;
mod nodes;
pub(crate) mod options;
mod outdoor;
mod past;
mod scaled;
mod supervised;

pub use agent_observation::AgentObservation;
pub use appended::attributes;
pub use feature::Feature;
pub(crate) use feature::LinearFeature;
pub use nodes::{NodeSpaces, NodeView};
pub use options::{ObservationForm, ObservationOptions};
pub(crate) use past::Past;
