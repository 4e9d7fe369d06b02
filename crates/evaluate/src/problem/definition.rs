//! A problem of the benchmark.

use std::fmt;

use b2b_base::digest::sha256;
use b2b_dataset::{BuildingId, Split};
use serde::{Deserialize, Serialize};

use super::protocol::Protocol;
use super::side::Side;
use super::stage::Stage;
use crate::EpisodePlan;
use crate::{Error, Result};

/// A benchmark problem: a question about generalization, and the protocol to answer it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Problem {
    /// Name.
    pub name: String,
    /// Incremented whenever anything but the wording of the question changes.
    pub version: u32,
    /// What differs between training and test.
    pub family: Family,
    /// The question in words.
    pub question: String,
    /// Buildings, tasks and actuators that a policy may be trained on.
    pub train: Side,
    /// Buildings, tasks and actuators that a policy is tested on.
    pub test: Side,
    /// Training budget, run periods, seeds and tests.
    pub protocol: Protocol,
}

/// What differs between training and test: the four families of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// The task, in the same building.
    GoalAdaptation,
    /// The building, of the same type.
    DynamicsAdaptation,
    /// The actuators, in the same building under the same task.
    ActionSpaceTransfer,
    /// The types of buildings, or the building where one policy controls several types.
    CrossDomain,
}

impl Problem {
    /// Returns the SHA-256 of everything but the wording of the question, in hexadecimal.
    pub fn hash(&self) -> String {
        // In the order of the fields: the order of a map depends on how the library was built.
        let unworded = Self { question: String::new(), ..self.clone() };
        sha256(serde_json::to_string(&unworded).expect("plain data always serializes"))
    }

    /// Returns the side of a stage.
    pub fn side(&self, stage: Stage) -> &Side {
        match stage {
            Stage::Train => &self.train,
            Stage::Test | Stage::Untrained | Stage::Adapted(_) | Stage::UpperBound => &self.test,
        }
    }

    /// Returns the episodes of a stage with these seeds.
    pub fn episodes(&self, stage: Stage, seeds: &[u64]) -> Vec<EpisodePlan> {
        let Protocol { windows, steps_per_hour, train_sample, .. } = &self.protocol;
        let side = self.side(stage);
        let buildings = match stage {
            Stage::Train => side.buildings.sample(*train_sample),
            _ => side.buildings.ids(),
        };
        side.episodes(&buildings, windows, seeds, *steps_per_hour)
    }

    /// Returns an [`Error::Problem`] for this problem with the fault.
    pub fn error(&self, why: String) -> Error {
        Error::Problem { name: self.name.clone(), why }
    }

    /// Errors unless a policy may be trained on a building.
    ///
    /// # Errors
    /// [`Error::NotForTraining`] with the reason.
    pub fn check_training_building(&self, id: BuildingId) -> Result<()> {
        let ids = self.train.buildings.ids();
        if ids.contains(&id) {
            return Ok(());
        }
        let why = if self.test.buildings.ids().contains(&id) {
            "it is a test building of the problem"
        } else if b2b_dataset::row(id).split == Split::Test {
            "it belongs to the dataset's test split"
        } else {
            "it is not on the training side"
        };
        Err(Error::NotForTraining { problem: self.name.clone(), building: id.to_string(), why: why.into() })
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::GoalAdaptation => "goal adaptation",
            Self::DynamicsAdaptation => "dynamics adaptation",
            Self::ActionSpaceTransfer => "action-space transfer",
            Self::CrossDomain => "cross-domain generalization",
        })
    }
}
