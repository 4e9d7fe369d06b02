//! What an agent observes, and what its actions mean.

use serde::{Deserialize, Serialize};

use crate::acting::Acting;
use crate::observation::options::ObservationOptions;
use crate::plan::NodeForm;

/// The observation of an agent and the meaning of its actions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interface {
    /// Options of its observation.
    pub observation: ObservationOptions,
    /// Meaning of its actions.
    pub acting: Acting,
    /// How a graph network observes the nodes of a building; `None` for other networks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodes: Option<NodeForm>,
}
