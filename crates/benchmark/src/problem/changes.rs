//! Another problem made from one: other days, other buildings.

use b2b_building::RunPeriod;
use b2b_dataset::BuildingId;
use b2b_env::Task;
use serde::Deserialize;
use serde_json::Value;

use super::{Attributes, Buildings, LeftTo, Problem, Side, spelled};
use crate::{Error, Result};

/// What is to be otherwise; nothing by default.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Changes {
    /// Buildings of both sides, for problems whose sides have the same.
    #[serde(with = "spelled::list")]
    pub buildings: Vec<BuildingId>,
    /// Buildings to train on.
    #[serde(with = "spelled::list")]
    pub train: Vec<BuildingId>,
    /// Buildings to test on.
    #[serde(with = "spelled::list")]
    pub test: Vec<BuildingId>,
    /// Tasks to train on.
    #[serde(with = "spelled::list")]
    pub train_tasks: Vec<Task>,
    /// Tasks to test on.
    #[serde(with = "spelled::list")]
    pub test_tasks: Vec<Task>,
    /// The one of the six tasks that is tested on; the five others are to train on.
    pub left_out: Option<String>,
    /// Days to train on and to test on.
    pub windows: Vec<RunPeriod>,
    /// Seeds.
    pub seeds: Vec<u64>,
    /// Zone time steps an hour.
    pub steps_per_hour: Option<u32>,
    /// Whether attributes are given.
    pub attributes: Option<Attributes>,
    /// Who drives the actuators that are taken away.
    pub left_to: Option<LeftTo>,
    /// Where they are pinned.
    pub pin: Option<f64>,
}

impl Problem {
    /// The problem with these changes; checked.
    ///
    /// # Errors
    /// [`Error::Problem`] when they do not suit it; those of [`Problem::check`].
    pub fn with(mut self, changes: &Changes) -> Result<Self> {
        let misfit = |why: String| Error::Problem { name: self.name.clone(), why };
        if let Some(task) = &changes.left_out {
            let tested: Task = task.parse()?;
            let six: Vec<Task> =
                Task::NAMED.iter().map(|name| name.parse()).collect::<std::result::Result<_, _>>()?;
            if !six.contains(&tested) {
                return Err(misfit(format!("`{task}` is none of the six tasks: {}", Task::NAMED.join(", "))));
            }
            self.train.tasks = six.into_iter().filter(|task| *task != tested).collect();
            self.test.tasks = vec![tested];
        }
        let restricted = self.train.restriction.is_some() || self.test.restriction.is_some();
        if !restricted && (changes.left_to.is_some() || changes.pin.is_some()) {
            return Err(misfit("no actuator is taken away: nothing is to be left to anybody".into()));
        }
        let Changes { buildings, train, test, .. } = changes;
        for (side, own, tasks) in
            [(&mut self.train, train, &changes.train_tasks), (&mut self.test, test, &changes.test_tasks)]
        {
            side.replace_buildings(if own.is_empty() { buildings } else { own });
            if !tasks.is_empty() {
                side.tasks.clone_from(tasks);
            }
            if let Some(restriction) = &mut side.restriction {
                restriction.left_to = changes.left_to.unwrap_or(restriction.left_to);
                restriction.pin = changes.pin.unwrap_or(restriction.pin);
            }
        }
        let protocol = &mut self.protocol;
        if let Some(first) = changes.windows.first() {
            protocol.windows.clone_from(&changes.windows);
            protocol.training_period = *first;
        }
        if !changes.seeds.is_empty() {
            protocol.seeds.clone_from(&changes.seeds);
        }
        protocol.steps_per_hour = changes.steps_per_hour.unwrap_or(protocol.steps_per_hour);
        protocol.attributes = changes.attributes.unwrap_or(protocol.attributes);
        self.check()?;
        Ok(self)
    }
}

impl Side {
    fn replace_buildings(&mut self, ids: &[BuildingId]) {
        if ids.is_empty() {
            return;
        }
        self.buildings = Buildings::Listed { ids: ids.to_vec() };
        // Of other types nothing is said.
        let types = self.buildings.types();
        self.sizes.retain(|size| types.contains(&size.building_type));
    }
}

/// Paths of the fields in which two values differ.
pub(crate) fn differences(path: &str, there: &Value, here: &Value, found: &mut Vec<String>) {
    match (there, here) {
        (Value::Object(there), Value::Object(here)) => {
            let names: std::collections::BTreeSet<_> = there.keys().chain(here.keys()).collect();
            for name in names {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                let value = |of: &serde_json::Map<String, Value>| of.get(name).cloned().unwrap_or_default();
                differences(&path, &value(there), &value(here), found);
            }
        }
        _ if there != here => found.push(path.to_owned()),
        _ => {}
    }
}
