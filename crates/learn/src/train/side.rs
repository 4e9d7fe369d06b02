//! The training side of a benchmark problem, as a training run uses it.

use std::fmt::Display;

use b2b_agent::ObservationForm;
use b2b_building::{BuildingType, RunPeriod};
use b2b_dataset::{BuildingId, BuildingName, Control};
use b2b_env::Task;

use super::config::{AgentConfig, Budget, TrainingSet};
use crate::error::{Error, Result};
use crate::policy::PolicyConfig;

/// The training side of a benchmark problem: what a run may train on.
pub(super) struct TrainingSide {
    /// Name of the problem.
    pub(super) name: String,
    /// Types of the buildings.
    pub(super) types: Vec<BuildingType>,
    /// Whether all training and test buildings are of one type.
    pub(super) is_one_type: bool,
    /// Buildings; `None` for the whole training split of the types.
    pub(super) listed: Option<Vec<BuildingId>>,
    /// Description of the buildings.
    pub(super) buildings: String,
    /// Returns an error for a building that may not be trained on.
    pub(super) check_building: Box<dyn Fn(BuildingId) -> Result<()>>,
    /// Tasks.
    pub(super) tasks: Vec<Task>,
    /// Run period.
    pub(super) period: RunPeriod,
    /// Zone time steps per hour.
    pub(super) steps_per_hour: u32,
    /// Largest number of environment steps.
    pub(super) steps: u64,
    /// Whether building attributes are given rather than withheld.
    pub(super) gives_attributes: bool,
    /// Whether zones are observed by their role.
    pub(super) is_by_role: bool,
}

impl TrainingSide {
    /// Sets the options of a run to this side.
    ///
    /// # Errors
    /// [`Error::Invalid`] where the agent is for one type of buildings and the problem has several.
    pub(super) fn apply(
        &self,
        set: &mut TrainingSet,
        agent: &mut AgentConfig,
        budget: &mut Budget,
    ) -> Result<()> {
        match &mut agent.policy {
            PolicyConfig::Graph(graph) => graph.attributes |= self.gives_attributes,
            _ if !self.is_one_type => {
                return Err(Error::Invalid(format!(
                    "the buildings of {} are of several types, which are for graph networks; choose the preset graph",
                    self.name
                )));
            }
            _ => {
                agent.observation.attributes |= self.gives_attributes;
                let has_roles = self.is_by_role && self.types == [BuildingType::SingleFamilyHouse];
                if has_roles && agent.observation.form == ObservationForm::Raw {
                    agent.observation.form = ObservationForm::Roles;
                }
            }
        }
        set.buildings = self.listed.iter().flatten().map(ToString::to_string).collect();
        set.building_type = match self.listed {
            None => self.types.iter().map(ToString::to_string).collect(),
            Some(_) => Vec::new(),
        };
        set.task = self.tasks.iter().cloned().collect();
        set.period = self.period.to_string();
        set.steps_per_hour = self.steps_per_hour;
        budget.steps = self.steps;
        Ok(())
    }

    /// Checks that a run does not go beyond this side.
    ///
    /// # Errors
    /// [`Error::Invalid`] or [`Error::Evaluation`], with the allowed values.
    pub(super) fn check(&self, set: &TrainingSet, agent: &AgentConfig, budget: &Budget) -> Result<()> {
        self.check_buildings(set)?;
        if let Some(task) = set.task.as_slice().iter().find(|task| !self.tasks.contains(task)) {
            let expected: Vec<String> = self.tasks.iter().map(ToString::to_string).collect();
            return Err(self.beyond("task", task, &expected.join(", ")));
        }
        if set.periods()? != [self.period.into()] {
            return Err(self.beyond("run period", &set.period, &self.period));
        }
        if set.control != Control::Actuators {
            return Err(self.beyond("control", &set.control.name(), &Control::Actuators.name()));
        }
        if let Some(site) = set.site_text() {
            return Err(self.beyond("site", &site, &"the buildings' own"));
        }
        if set.keep_design_days {
            return Err(self.beyond("design days", &"of the model", &"of the site"));
        }
        if set.steps_per_hour != self.steps_per_hour {
            return Err(self.beyond("steps per hour", &set.steps_per_hour, &self.steps_per_hour));
        }
        if budget.steps > self.steps {
            return Err(self.beyond("steps", &budget.steps, &format!("at most {}", self.steps)));
        }
        if agent.observes_attributes() && !self.gives_attributes {
            return Err(self.beyond("attributes", &"given", &"withheld"));
        }
        let hours = agent.observation.forecast;
        if hours > 0 {
            return Err(self.beyond("forecast", &format!("{hours} h"), &"none"));
        }
        Ok(())
    }

    fn check_buildings(&self, set: &TrainingSet) -> Result<()> {
        for name in set.named()? {
            match name {
                BuildingName::Id(id) => (self.check_building)(id)?,
                _ => return Err(self.beyond("building", &name, &self.buildings)),
            }
        }
        match set.building_types()?.iter().find(|each| !self.types.contains(each)) {
            Some(building_type) => Err(self.beyond("building type", building_type, &self.buildings)),
            None => Ok(()),
        }
    }

    fn beyond(&self, what: &str, is: &dyn Display, expected: &dyn Display) -> Error {
        Error::Invalid(format!(
            "{what} of a run for {}: {is}; expected {expected}, or train without `problem`",
            self.name
        ))
    }
}
