//! The benchmark's problems, as data: what a policy is trained on, what it is tested on, and by which rules.
//!
//! 1. A [`Problem`] has two [`Side`]s, buildings and tasks and actuators to train on and to test on, and a [`Protocol`].
//!    Those with a name are JSON files under `data/problems`; a file of a user's own is read the same way.
//! 2. [`Problem::check`] refuses what could not tell whether a policy generalises, such as a test building to train on.
//! 3. [`Changes`] make another problem of one, such as other days, and its [`Problem::hash`] says so.
//! 4. [`Through`] puts a policy behind what a side shows and lets drive.

mod changes;
mod interface;
mod protocol;
mod restriction;
mod side;
mod spelled;

use std::collections::HashSet;
use std::fmt;
use std::path::Path;
use std::str::FromStr;
use std::sync::OnceLock;

use b2b_building::BuildingType;
use b2b_dataset::{BuildingId, Split};
use b2b_env::Task;
use serde::{Deserialize, Serialize};

pub use changes::Changes;
pub(crate) use changes::differences;
pub use interface::Through;
pub use protocol::{Attributes, Protocol};
pub use restriction::{LeftTo, Restricted, Restriction};
pub use side::{Buildings, Part, Side, Size};

use crate::error::at;
use crate::subject::hex;
use crate::{Episode, Error, Result};
use side::words;

/// A question about generalisation, and the rules by which it is answered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Problem {
    /// What it is called.
    pub name: String,
    /// Raised whenever anything but the words of the question changes.
    pub version: u32,
    /// What differs between training and test.
    pub family: Family,
    /// What is asked, for people.
    pub question: String,
    /// What a policy may be trained on.
    pub train: Side,
    /// What it is tested on.
    pub test: Side,
    /// The rules.
    pub protocol: Protocol,
}

/// What differs between training and test: the paper's four.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// The task, in the same building.
    GoalAdaptation,
    /// The building, of the same type.
    DynamicsAdaptation,
    /// The actuators, in the same building under the same task.
    ActionSpaceTransfer,
    /// The type of building.
    CrossDomain,
}

/// A part of a benchmark run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Test environments, without a step of training there.
    Test,
    /// A sample of training environments.
    Train,
    /// Test environments under random actions: what a policy that knows nothing does.
    Untrained,
    /// Test environments, after so many steps of training on each.
    Adapted(u64),
}

/// The shipped files.
const SHIPPED: [&str; 13] = [
    include_str!("../../data/problems/goal-energy-weight.json"),
    include_str!("../../data/problems/goal-setpoint-mode.json"),
    include_str!("../../data/problems/goal-leave-one-out.json"),
    include_str!("../../data/problems/dynamics-house.json"),
    include_str!("../../data/problems/dynamics-office-small.json"),
    include_str!("../../data/problems/dynamics-office-medium.json"),
    include_str!("../../data/problems/unitary-5-10.json"),
    include_str!("../../data/problems/unitary-10-5.json"),
    include_str!("../../data/problems/central-33-36.json"),
    include_str!("../../data/problems/central-36-33.json"),
    include_str!("../../data/problems/retail-to-office-small.json"),
    include_str!("../../data/problems/retail-to-warehouse.json"),
    include_str!("../../data/problems/office-small-to-office-medium.json"),
];

impl Problem {
    /// Those with a name, family by family.
    pub fn all() -> &'static [Self] {
        static ALL: OnceLock<Vec<Problem>> = OnceLock::new();
        ALL.get_or_init(|| {
            SHIPPED.iter().map(|text| serde_json::from_str(text).expect("a test reads it")).collect()
        })
    }

    /// The one of a name.
    ///
    /// # Errors
    /// [`Error::UnknownProblem`] with names that are near.
    pub fn named(name: &str) -> Result<Self> {
        let found = Self::all().iter().find(|problem| problem.name == name);
        found.cloned().ok_or_else(|| {
            let mut near: Vec<_> = Self::all().iter().map(|problem| problem.name.as_str()).collect();
            let likeness = |known: &str| strsim::jaro_winkler(known, &name.to_lowercase().replace('_', "-"));
            near.sort_by(|a, b| likeness(b).total_cmp(&likeness(a)));
            near.retain(|known| likeness(known) > 0.8);
            near.truncate(2);
            Error::UnknownProblem { text: name.to_owned(), near: near.join(" or ") }
        })
    }

    /// Reads a file: JSON, as the shipped ones are.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::ProblemFile`] with what is wrong in it; those of [`Problem::check`].
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(at(path))?;
        let problem: Self = serde_json::from_str(&text)
            .map_err(|error| Error::ProblemFile { path: path.to_owned(), why: error.to_string() })?;
        problem.check()?;
        Ok(problem)
    }

    /// From any types to any others, by the rules of the named cross-domain problems.
    ///
    /// # Errors
    /// Those of [`Problem::check`].
    pub fn cross_domain(train: &[BuildingType], test: &[BuildingType]) -> Result<Self> {
        let like = Self::named("retail-to-office-small")?;
        let side = |side: &Side, types: &[BuildingType], split| {
            let buildings = Buildings::Part { types: types.to_vec(), split };
            Side { buildings, sizes: Vec::new(), ..side.clone() }
        };
        let names =
            |types: &[BuildingType]| types.iter().map(|each| each.name()).collect::<Vec<_>>().join("+");
        let problem = Self {
            name: format!("{}-to-{}", names(train), names(test)),
            question: format!(
                "A policy has learned in buildings of {}: what does it do in those of {}?",
                words(train),
                words(test)
            ),
            train: side(&like.train, train, Part::Train),
            test: side(&like.test, test, Part::Test),
            ..like
        };
        problem.check()?;
        Ok(problem)
    }

    /// SHA-256 of all of it but the words of the question, in hexadecimal.
    pub fn hash(&self) -> String {
        // In the order of the fields: that of a map depends on how the library was built.
        let wordless = Self { question: String::new(), ..self.clone() };
        hex(serde_json::to_string(&wordless).expect("it is plain data").as_bytes())
    }

    /// In what it differs from the shipped one of its name: paths of fields. `None` when there is no such name.
    pub fn changes(&self) -> Option<Vec<String>> {
        let shipped = Self::all().iter().find(|problem| problem.name == self.name)?;
        let value = |problem: &Self| serde_json::to_value(problem).expect("it is plain data");
        let mut found = Vec::new();
        differences("", &value(shipped), &value(self), &mut found);
        found.retain(|path| path != "question");
        // Buildings by their ids and by their types are one field.
        for path in &mut found {
            if let Some(at) = path.find(".buildings") {
                path.truncate(at + ".buildings".len());
            }
        }
        found.dedup();
        Some(found)
    }

    /// The side of a stage.
    pub fn side(&self, stage: Stage) -> &Side {
        match stage {
            Stage::Train => &self.train,
            Stage::Test | Stage::Untrained | Stage::Adapted(_) => &self.test,
        }
    }

    /// The episodes of a stage, with these seeds.
    pub fn episodes(&self, stage: Stage, seeds: &[u64]) -> Vec<Episode> {
        let Protocol { windows, steps_per_hour, train_sample, .. } = &self.protocol;
        let side = self.side(stage);
        let buildings = match stage {
            Stage::Train => side.buildings.sample(*train_sample),
            _ => side.buildings.ids(),
        };
        side.episodes(&buildings, windows, seeds, *steps_per_hour)
    }

    /// Whether a policy may learn in a building.
    ///
    /// # Errors
    /// [`Error::ForTests`] naming it.
    pub fn check_training_building(&self, id: BuildingId) -> Result<()> {
        let ids = self.train.buildings.ids();
        if ids.contains(&id) {
            return Ok(());
        }
        let why = if self.test.buildings.ids().contains(&id) {
            "it is tested on"
        } else if b2b_dataset::row(id).split == Split::Test {
            "it is of the dataset's test split"
        } else {
            "it is not on the problem's training side"
        };
        Err(Error::ForTests { problem: self.name.clone(), building: id.to_string(), why: why.into() })
    }

    /// Whether it can tell what it asks.
    ///
    /// # Errors
    /// [`Error::Problem`] naming what is wrong.
    pub fn check(&self) -> Result<()> {
        let fault = self
            .protocol
            .fault()
            .or_else(|| self.train.fault("train"))
            .or_else(|| self.test.fault("test"))
            .or_else(|| self.split_fault())
            .or_else(|| self.family_fault());
        match fault {
            None => Ok(()),
            Some(why) => Err(Error::Problem { name: self.name.clone(), why }),
        }
    }

    /// Whoever trains on test buildings of the dataset cannot be compared with anybody on any problem.
    fn split_fault(&self) -> Option<String> {
        let for_tests = |id: &BuildingId| b2b_dataset::row(*id).split == Split::Test;
        let ids: Vec<_> = self.train.buildings.ids().into_iter().filter(for_tests).collect();
        (!ids.is_empty()).then(|| {
            format!(
                "the training side has buildings of the dataset's test split: {}; train on others",
                some(&ids)
            )
        })
    }

    fn family_fault(&self) -> Option<String> {
        let (train, test) = (&self.train, &self.test);
        match self.family {
            Family::GoalAdaptation => self.same_buildings().or_else(|| {
                let both: Vec<_> = common(&train.tasks, &test.tasks);
                overlap("tasks", &both).or_else(|| self.same_actuators())
            }),
            Family::DynamicsAdaptation | Family::CrossDomain => {
                let (train_ids, test_ids) = (train.buildings.ids(), test.buildings.ids());
                let known: HashSet<_> = train_ids.iter().collect();
                let both: Vec<_> = test_ids.into_iter().filter(|id| known.contains(id)).collect();
                overlap("buildings", &both).or_else(|| self.types_fault()).or_else(|| self.same_actuators())
            }
            Family::ActionSpaceTransfer => self.same_buildings().or_else(|| {
                (train.tasks != test.tasks)
                    .then(|| "the tasks of both sides differ: only the actuators may".to_owned())
                    .or_else(|| {
                        let same = train.restriction.is_some() == test.restriction.is_some();
                        same.then(|| "one side needs a restriction, and only one".to_owned())
                    })
            }),
        }
    }

    fn types_fault(&self) -> Option<String> {
        let (train, test) = (self.train.buildings.types(), self.test.buildings.types());
        let both = common(&train, &test);
        match self.family {
            Family::CrossDomain => overlap("types", &both),
            _ if train != test => {
                Some(format!("it trains on {} and tests on {}", words(&train), words(&test)))
            }
            _ => None,
        }
    }

    fn same_buildings(&self) -> Option<String> {
        let same = self.train.buildings.ids() == self.test.buildings.ids();
        (!same).then(|| "both sides need the same buildings".to_owned())
    }

    fn same_actuators(&self) -> Option<String> {
        let same = self.train.restriction == self.test.restriction;
        (!same).then(|| "both sides need the same actuators".to_owned())
    }
}

impl Side {
    fn fault(&self, name: &str) -> Option<String> {
        let ids = self.buildings.ids();
        if ids.is_empty() {
            return Some(format!("side `{name}` has no building"));
        }
        let mut seen = HashSet::new();
        if let Some(id) = ids.iter().find(|id| !seen.insert(**id)) {
            return Some(format!("side `{name}` has {id} twice"));
        }
        if self.tasks.is_empty() {
            return Some(format!("side `{name}` has no task"));
        }
        let repeated =
            self.tasks.iter().enumerate().find(|(place, task)| self.tasks[..*place].contains(task));
        if let Some((_, task)) = repeated {
            return Some(format!("side `{name}` has task {task} twice"));
        }
        if let Some(fault) = self.tasks.iter().find_map(|task: &Task| task.check().err()) {
            return Some(format!("side `{name}`: {fault}"));
        }
        let types = self.buildings.types();
        let size = self.sizes.iter().find(|size| !types.contains(&size.building_type));
        if let Some(size) = size {
            return Some(format!("side `{name}` has sizes of {}, and no such building", size.building_type));
        }
        let pin = self.restriction.map_or(0.0, |restriction| restriction.pin);
        (!pin.is_finite()).then(|| format!("side `{name}`: the pin is {pin}"))
    }
}

/// What is on both sides and must not be.
fn overlap<T: fmt::Display>(what: &str, both: &[T]) -> Option<String> {
    (!both.is_empty()).then(|| format!("{what} are on both sides: {}", some(both)))
}

fn common<T: PartialEq + Clone>(train: &[T], test: &[T]) -> Vec<T> {
    train.iter().filter(|each| test.contains(each)).cloned().collect()
}

/// The first few of them.
fn some<T: fmt::Display>(all: &[T]) -> String {
    const FEW: usize = 5;
    let more = all.len().saturating_sub(FEW);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    words(&all[..all.len().min(FEW)]) + &more
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::GoalAdaptation => "goal adaptation",
            Self::DynamicsAdaptation => "dynamics adaptation",
            Self::ActionSpaceTransfer => "action-space transfer",
            Self::CrossDomain => "cross-domain generalisation",
        })
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Test => f.write_str("test"),
            Self::Train => f.write_str("train"),
            Self::Untrained => f.write_str("untrained"),
            Self::Adapted(steps) => write!(f, "adapted-{steps}"),
        }
    }
}

impl FromStr for Stage {
    type Err = ();

    fn from_str(text: &str) -> std::result::Result<Self, ()> {
        match text {
            "test" => Ok(Self::Test),
            "train" => Ok(Self::Train),
            "untrained" => Ok(Self::Untrained),
            _ => {
                let steps = text.strip_prefix("adapted-").and_then(|steps| steps.parse().ok());
                steps.map(Self::Adapted).ok_or(())
            }
        }
    }
}

#[cfg(test)]
mod tests;
