//! The checks that a problem measures generalization.

use std::collections::HashSet;
use std::fmt;

use b2b_building::BuildingType;
use b2b_dataset::{BuildingId, Split};
use b2b_env::Task;

use super::definition::{Family, Problem};
use super::list::{joined, shortened};
use super::side::{Side, Size};
use crate::{HouseForm, Result};

impl Problem {
    /// Errors unless the problem can answer its question.
    ///
    /// # Errors
    /// [`Error::Problem`](crate::Error::Problem) with the fault.
    pub fn check(&self) -> Result<()> {
        let fault = self
            .protocol
            .fault()
            .or_else(|| self.train.fault("train"))
            .or_else(|| self.test.fault("test"))
            .or_else(|| self.width_fault())
            .or_else(|| self.split_fault())
            .or_else(|| self.family_fault());
        match fault {
            None => Ok(()),
            Some(why) => Err(self.error(why)),
        }
    }

    /// Observations in model order must fit into the width to which they are padded.
    fn width_fault(&self) -> Option<String> {
        let width = self.protocol.observation_width?;
        let by_role = self.protocol.observation == HouseForm::Roles;
        let in_order = |size: &&Size| !(by_role && size.building_type == BuildingType::SingleFamilyHouse);
        let mut sizes = self.train.sizes.iter().chain(&self.test.sizes).filter(in_order);
        let size = sizes.find(|size| size.observation[1] > width)?;
        Some(format!(
            "observation_width is {width}, but observations of {} have up to {} values",
            size.building_type, size.observation[1]
        ))
    }

    /// A policy trained on the dataset's test buildings cannot be compared on any problem.
    fn split_fault(&self) -> Option<String> {
        let for_tests = |id: &BuildingId| b2b_dataset::row(*id).split == Split::Test;
        let ids: Vec<_> = self.train.buildings.ids().into_iter().filter(for_tests).collect();
        (!ids.is_empty()).then(|| {
            format!(
                "the training side contains buildings of the dataset's test split: {}; choose buildings of the train split",
                shortened(&ids)
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
                    .then(|| "both sides need the same tasks: only the actuators may differ".to_owned())
                    .or_else(|| {
                        let same = train.restriction.is_some() == test.restriction.is_some();
                        same.then(|| "exactly one side needs a restriction".to_owned())
                    })
            }),
        }
    }

    fn types_fault(&self) -> Option<String> {
        let (train, test) = (self.train.buildings.types(), self.test.buildings.types());
        match self.family {
            Family::CrossDomain if train.len() == 1 && train == test => Some(format!(
                "it trains and tests on {} alone; choose several types, or a problem of dynamics adaptation",
                joined(&train)
            )),
            Family::CrossDomain => None,
            _ if train != test => {
                Some(format!("it trains on {} and tests on {}", joined(&train), joined(&test)))
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
            return Some(format!("side `{name}` has no buildings"));
        }
        let mut seen = HashSet::new();
        if let Some(id) = ids.iter().find(|id| !seen.insert(**id)) {
            return Some(format!("side `{name}` lists {id} twice"));
        }
        if self.tasks.is_empty() {
            return Some(format!("side `{name}` has no tasks"));
        }
        let repeated =
            self.tasks.iter().enumerate().find(|(place, task)| self.tasks[..*place].contains(task));
        if let Some((_, task)) = repeated {
            return Some(format!("side `{name}` lists task {task} twice"));
        }
        if let Some(fault) = self.tasks.iter().find_map(|task: &Task| task.check().err()) {
            return Some(format!("side `{name}`: {fault}"));
        }
        let types = self.buildings.types();
        let size = self.sizes.iter().find(|size| !types.contains(&size.building_type));
        if let Some(size) = size {
            return Some(format!(
                "side `{name}` has sizes for {}, but no building of that type",
                size.building_type
            ));
        }
        let pin = self.restriction.map_or(0.0, |restriction| restriction.pin);
        (!pin.is_finite()).then(|| format!("side `{name}`: pin is {pin}; expected a finite number"))
    }
}

/// Describes items that are on both sides but must not be.
fn overlap<T: fmt::Display>(what: &str, both: &[T]) -> Option<String> {
    (!both.is_empty()).then(|| format!("{what} are on both sides: {}", shortened(both)))
}

fn common<T: PartialEq + Clone>(train: &[T], test: &[T]) -> Vec<T> {
    train.iter().filter(|each| test.contains(each)).cloned().collect()
}
