//! Descriptions from which worker processes create controllers.

use std::path::{Path, PathBuf, absolute};
use std::sync::Arc;

use b2b_control::{Controller, KindDescription, Noise, Noisy};
use b2b_env::Spaces;
use serde::{Deserialize, Serialize};

use crate::agent::Agent;
use crate::error::at;
use crate::pilot::Pilot;
use crate::plan::NodePlan;
use crate::{Error, Result};

/// All data needed to create a controller for a building after its model has been dropped.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerDescription {
    /// A controller that needs no file: see [`b2b_control::Kind`].
    BuiltIn(KindDescription),
    /// An agent in a folder.
    Agent {
        /// Its folder.
        folder: PathBuf,
        /// SHA-256 of its description and weights.
        sha256: String,
        /// The building, for a graph network.
        plan: Option<NodePlan>,
        /// Attributes of the building that it observes.
        attributes: Vec<f64>,
    },
    /// Another controller with noise on its actions.
    Noisy {
        /// The other controller.
        of: Box<Self>,
        /// The noise.
        noise: Noise,
    },
}

impl ControllerDescription {
    /// Makes the controller.
    ///
    /// # Errors
    /// The errors of [`Agent::read`] and [`Pilot::without_model`]; [`Error::Damaged`] if the agent has changed since;
    /// [`Error::Control`] for a built-in controller that cannot be made.
    pub fn controller(&self, spaces: &Arc<Spaces>) -> Result<Box<dyn Controller>> {
        Ok(match self {
            Self::BuiltIn(description) => description.controller(spaces)?,
            Self::Agent { folder, sha256, plan, attributes } => {
                let agent = read_unchanged(folder, sha256)?;
                let interface = agent.info().interface;
                let pilot = Pilot::without_model(interface, spaces, plan.as_ref(), attributes)?;
                Box::new(agent.controller_of(pilot))
            }
            Self::Noisy { of, noise } => Box::new(Noisy::new(of.controller(spaces)?, &spaces.action, *noise)),
        })
    }
}

impl Agent {
    /// Returns the description of its controller for a building that still has its model; `None` for an agent without a
    /// folder.
    ///
    /// # Errors
    /// The errors of [`Agent::controller`]; [`Error::Io`] if the current directory is unknown.
    pub fn description(&self, spaces: &Arc<Spaces>) -> Result<Option<ControllerDescription>> {
        if self.sha256().is_empty() {
            return Ok(None);
        }
        let (plan, attributes) = self.model_parts(spaces)?;
        self.pilot_without_model(spaces, plan.as_ref(), &attributes)?;
        let folder = absolute(self.folder()).map_err(at(self.folder()))?;
        let sha256 = self.sha256().to_owned();
        Ok(Some(ControllerDescription::Agent { folder, sha256, plan, attributes }))
    }
}

fn read_unchanged(folder: &Path, sha256: &str) -> Result<Agent> {
    let agent = Agent::read(folder)?;
    if agent.sha256() != sha256 {
        let why = "it was replaced while it was evaluated".to_owned();
        return Err(Error::Damaged { path: folder.to_owned(), why });
    }
    Ok(agent)
}
