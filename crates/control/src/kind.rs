//! Kinds of controllers: each has a name, parameters with bounds, and makes controllers for episodes.
//!
//! A kind is registered in [`KINDS`](crate::KINDS). Commands, evaluations, worker processes and Python find it there by
//! its name.

use std::collections::BTreeMap;
use std::path::Path;

use b2b_base::digest::sha256;
use b2b_building::{Controls, Parameter, PreparedBuilding};
use b2b_env::{ActionSpace, Controller, Spaces, Task};
use b2b_workers::Episode;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::{Error, KINDS, Result, parameter_set};

/// A kind of controller that needs no file.
pub trait Kind: Sync {
    /// Returns the name.
    fn name(&self) -> &'static str;

    /// Returns a few words for help texts.
    fn help(&self) -> &'static str;

    /// Returns whether the actions depend on the seed.
    fn is_stochastic(&self) -> bool {
        false
    }

    /// Returns what decides its actions beside an episode: its name, and for some kinds a digest of their shipped
    /// schedules or rules or a revision, so that results of others are not reused.
    fn identity(&self) -> String {
        self.name().to_owned()
    }

    /// Returns whether controllers observe and control the whole building, even if a problem withholds actuators.
    fn controls_whole_building(&self) -> bool {
        false
    }

    /// Returns who controls the building for which controllers are made.
    fn controls(&self) -> Controls {
        Controls::Actuators
    }

    /// Returns the parameters with their units and bounds.
    fn parameters(&self) -> Vec<Parameter> {
        Vec::new()
    }

    /// Returns the default values of the parameters as JSON; null without parameters.
    fn defaults(&self) -> Value {
        Value::Null
    }

    /// Returns the values for a building and a task as JSON; null without parameters.
    fn tuned(&self, _building: &PreparedBuilding, _task: &Task) -> Value {
        self.defaults()
    }

    /// Returns `values` with changes by the names of parameters.
    ///
    /// # Errors
    /// [`Error::NoParameters`]; [`Error::UnknownParameter`]; [`Error::Parameter`] for a value out of bounds.
    fn changed(&self, values: Value, changes: &BTreeMap<String, f64>) -> Result<Value> {
        match changes.keys().next() {
            None => Ok(values),
            Some(_) => Err(Error::NoParameters { name: self.name() }),
        }
    }

    /// Reads values from a JSON file.
    ///
    /// # Errors
    /// [`Error::NoParameters`]; [`Error::Io`]; [`Error::ParameterFile`]; [`Error::Parameter`].
    fn read(&self, _path: &Path) -> Result<Value> {
        Err(Error::NoParameters { name: self.name() })
    }

    /// Makes a controller for an episode.
    ///
    /// # Errors
    /// [`Error::NeedsEpisode`] if the kind must plan the episode; [`Error::OwnControls`]; [`Error::NotOperation`];
    /// [`Error::Values`]; [`Error::Env`].
    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>>;

    /// Plans an episode by running it, copies of it or days before it, for kinds that plan. Returns a controller that
    /// carries out the plan; `None` for other kinds. `step` is called as often as the episode has steps, for progress.
    ///
    /// # Errors
    /// The errors of [`Episode`]; [`Error::Values`]; [`Error::NotOperation`].
    fn plan(
        &self,
        _case: &Case<'_>,
        _episode: &mut Episode,
        _step: &mut dyn FnMut(),
    ) -> Result<Option<Box<dyn AnyController>>> {
        Ok(None)
    }

    /// Returns whether [`Kind::plan`] replaces [`Kind::make`].
    fn plans(&self) -> bool {
        false
    }
}

/// The episode that a controller is made for.
#[derive(Clone, Copy)]
pub struct Case<'a> {
    /// Building, spaces and task.
    pub spaces: &'a Spaces,
    /// The controlled actuators: all of the building's, or the ones that a problem does not withhold.
    pub action: &'a ActionSpace,
    /// Random seed.
    pub seed: u64,
    /// Values of the parameters, as [`Kind::defaults`] and [`Kind::tuned`] return them.
    pub values: &'a Value,
}

/// The description of a controller, from which a worker makes the same one for a whole building.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct KindDescription {
    /// Name of the kind.
    pub name: String,
    /// Random seed.
    pub seed: u64,
    /// Values of the parameters.
    pub values: Value,
}

impl KindDescription {
    /// Returns the order from which a worker makes the controller.
    pub fn to_order(&self) -> Value {
        json!({ "built_in": self })
    }

    /// Makes the controller.
    ///
    /// # Errors
    /// [`Error::UnknownKind`]; errors from [`Kind::make`].
    pub fn controller(&self, spaces: &Spaces) -> Result<Box<dyn AnyController>> {
        let Self { name, seed, values } = self;
        let unknown =
            || Error::UnknownKind { name: name.clone(), known: KINDS.map(|kind| kind.name()).to_vec() };
        kind(name).ok_or_else(unknown)?.make(&Case { spaces, action: &spaces.action, seed: *seed, values })
    }
}

/// A controller that can be copied with its state.
pub trait AnyController: Controller + Send {
    /// Returns a copy.
    fn boxed_clone(&self) -> Box<dyn AnyController>;
}

impl<T: Controller + Clone + Send + 'static> AnyController for T {
    fn boxed_clone(&self) -> Box<dyn AnyController> {
        Box::new(self.clone())
    }
}

/// Returns the kind with this name.
pub fn kind(name: &str) -> Option<&'static dyn Kind> {
    KINDS.into_iter().find(|kind| kind.name() == name)
}

/// Returns the identity of a kind with a digest of its shipped data.
pub(crate) fn shipped_identity(name: &str, shipped: &str) -> String {
    format!("{name}#{}", &sha256(shipped)[..12])
}

/// Returns the baseline of a task: Guideline 36 in operation, the reactive controllers in tracking.
pub fn baseline(task: &Task) -> &'static dyn Kind {
    if task.is_operation() { &crate::guideline36::Kind } else { &crate::reactive::Kind }
}

/// Returns a function that spreads the steps of an episode over this many calls, for the progress of a plan.
pub(crate) fn spread<'a>(steps: usize, calls: usize, step: &'a mut dyn FnMut()) -> impl FnMut() + 'a {
    let (mut done, mut told) = (0, 0);
    move || {
        done += 1;
        let due = steps * done / calls;
        (told..due).for_each(|_| step());
        told = due;
    }
}

/// Reads the parameters of a kind from the values of a case.
pub(crate) fn values<T: serde::de::DeserializeOwned>(case: &Case<'_>) -> Result<T> {
    parameter_set::from_json(case.values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_found_by_its_own_name() {
        for each in KINDS {
            assert_eq!(kind(each.name()).unwrap().name(), each.name());
            assert!(!each.help().is_empty());
        }
        assert!(kind("reactiv").is_none());
    }

    #[test]
    fn default_values_are_within_the_bounds_and_a_change_is_checked() {
        for each in KINDS {
            let unchanged = each.changed(each.defaults(), &BTreeMap::new()).unwrap();
            assert_eq!(unchanged, each.defaults());
            for parameter in each.parameters() {
                let change = BTreeMap::from([(parameter.name.to_owned(), parameter.high + 1.0)]);
                let said = each.changed(each.defaults(), &change).unwrap_err().to_string();
                assert!(said.contains(parameter.name), "{said}");
            }
            let unknown = BTreeMap::from([("x".to_owned(), 1.0)]);
            assert!(each.changed(each.defaults(), &unknown).is_err());
        }
    }
}
