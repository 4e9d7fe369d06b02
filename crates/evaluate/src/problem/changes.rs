//! Changes to a problem, such as other run periods or buildings.

use b2b_building::Period;
use b2b_dataset::BuildingId;
use b2b_env::Task;
use serde::Deserialize;
use serde_json::Value;

use super::as_text;
use super::buildings::Buildings;
use super::definition::Problem;
use super::protocol::{Attributes, Memory, Protocol};
use super::restriction::Fallback;
use super::side::Side;
use crate::HouseForm;
use crate::Result;

/// Changes to a problem; none by default.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Changes {
    /// Buildings of both sides, for problems whose sides have the same buildings.
    #[serde(with = "as_text::list")]
    pub buildings: Vec<BuildingId>,
    /// Training buildings.
    #[serde(with = "as_text::list")]
    pub train: Vec<BuildingId>,
    /// Test buildings.
    #[serde(with = "as_text::list")]
    pub test: Vec<BuildingId>,
    /// Training tasks.
    #[serde(with = "as_text::list")]
    pub train_tasks: Vec<Task>,
    /// Test tasks.
    #[serde(with = "as_text::list")]
    pub test_tasks: Vec<Task>,
    /// The test task among the six standard tasks; the other five are the training tasks.
    pub left_out: Option<String>,
    /// Run periods of the test; the first, if it is a range of days, is also that of training.
    pub windows: Vec<Period>,
    /// How long a policy with memory keeps it.
    pub memory: Option<Memory>,
    /// Seeds.
    pub seeds: Vec<u64>,
    /// Zone time steps per hour.
    pub steps_per_hour: Option<u32>,
    /// Whether observations include the building's attributes.
    pub attributes: Option<Attributes>,
    /// Form of the observations of houses.
    pub observation: Option<HouseForm>,
    /// Width to which observations in model order are zero-padded.
    pub observation_width: Option<usize>,
    /// Control of the withheld actuators.
    pub fallback: Option<Fallback>,
    /// Value at which withheld actuators are pinned.
    pub pin: Option<f64>,
}

impl Problem {
    /// Returns the problem with these changes, checked.
    ///
    /// # Errors
    /// [`Error::Problem`](crate::Error::Problem) for changes that do not apply to it; errors from [`Problem::check`].
    pub fn with(mut self, changes: &Changes) -> Result<Self> {
        if let Some(task) = &changes.left_out {
            let tested: Task = task.parse()?;
            let six: Vec<Task> =
                Task::NAMED.iter().map(|name| name.parse()).collect::<std::result::Result<_, _>>()?;
            if !six.contains(&tested) {
                return Err(
                    self.error(format!("unknown task `{task}`; expected one of {}", Task::NAMED.join(", ")))
                );
            }
            let others: Vec<Task> = six.into_iter().filter(|task| *task != tested).collect();
            self.train.replace_tasks(&others);
            self.test.replace_tasks(&[tested]);
        }
        let restricted = self.train.restriction.is_some() || self.test.restriction.is_some();
        if !restricted && (changes.fallback.is_some() || changes.pin.is_some()) {
            return Err(self
                .error("no actuators are withheld; fallback and pin apply to action-space transfer".into()));
        }
        let Changes { buildings, train, test, .. } = changes;
        for (side, own, tasks) in
            [(&mut self.train, train, &changes.train_tasks), (&mut self.test, test, &changes.test_tasks)]
        {
            side.replace_buildings(if own.is_empty() { buildings } else { own });
            if !tasks.is_empty() {
                side.replace_tasks(tasks);
            }
            if let Some(restriction) = &mut side.restriction {
                restriction.fallback = changes.fallback.unwrap_or(restriction.fallback);
                restriction.pin = changes.pin.unwrap_or(restriction.pin);
            }
        }
        self.protocol.change(changes);
        self.check()?;
        Ok(self)
    }

    /// Returns the paths of the fields but `question` that differ from the shipped problem of the same name; `None` if
    /// there is none.
    pub fn changes(&self) -> Option<Vec<String>> {
        let shipped = Self::all().iter().find(|problem| problem.name == self.name)?;
        let value = |problem: &Self| serde_json::to_value(problem).expect("plain data always serializes");
        let mut found = Vec::new();
        differences("", &value(shipped), &value(self), &mut found);
        found.retain(|path| path != "question");
        // Buildings listed by id and selected by type are one field.
        for path in &mut found {
            if let Some(at) = path.find(".buildings") {
                path.truncate(at + ".buildings".len());
            }
        }
        found.dedup();
        Some(found)
    }
}

impl Protocol {
    fn change(&mut self, changes: &Changes) {
        if let Some(first) = changes.windows.first() {
            self.windows.clone_from(&changes.windows);
            // Two-week periods that differ by building are only for tests.
            if let Period::Days(first) = first {
                self.training_period = *first;
            }
        }
        if !changes.seeds.is_empty() {
            self.seeds.clone_from(&changes.seeds);
        }
        self.steps_per_hour = changes.steps_per_hour.unwrap_or(self.steps_per_hour);
        self.memory = changes.memory.unwrap_or(self.memory);
        self.attributes = changes.attributes.unwrap_or(self.attributes);
        self.observation = changes.observation.unwrap_or(self.observation);
        self.observation_width = changes.observation_width.or(self.observation_width);
    }
}

impl Side {
    fn replace_tasks(&mut self, tasks: &[Task]) {
        if self.tasks != tasks {
            self.tasks = tasks.to_vec();
            // The sizes of observations depend on the task.
            self.sizes.clear();
        }
    }

    fn replace_buildings(&mut self, ids: &[BuildingId]) {
        if ids.is_empty() {
            return;
        }
        self.buildings = Buildings::Listed { ids: ids.to_vec() };
        // The sizes of other types are unknown.
        let types = self.buildings.types();
        self.sizes.retain(|size| types.contains(&size.building_type));
    }
}

/// Collects the paths of the fields in which two values differ.
pub fn differences(path: &str, there: &Value, here: &Value, found: &mut Vec<String>) {
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
