//! Training for a benchmark problem: on its training side.

use std::path::Path;

use b2b_agent::ObservationForm;
use b2b_benchmark::Problem;
use b2b_benchmark::problem::{Attributes, Buildings, Subset};
use b2b_building::BuildingType;
use b2b_dataset::BuildingName;

use super::config::TrainConfig;
use crate::error::{Error, Result};

impl TrainConfig {
    /// Returns the configuration for the training side of a benchmark problem, by name or JSON file: its buildings, tasks, run
    /// period, steps per hour, training budget and attributes.
    ///
    /// # Errors
    /// [`Error::Evaluation`] for an unknown problem; [`Error::Invalid`] for one that an agent cannot be trained for, because its
    /// buildings differ in what they observe or control.
    pub fn with_problem(self, name: &str) -> Result<Self> {
        let problem = read(name)?;
        let (side, protocol) = (&problem.train, &problem.protocol);
        let building_type = one_type(&problem)?;
        let whole_split =
            Buildings::Subset { types: vec![building_type], subset: Subset::Train, count: None };
        let buildings = match side.buildings == whole_split {
            true => Vec::new(),
            false => side.buildings.ids().iter().map(ToString::to_string).collect(),
        };
        let mut observation = self.observation;
        observation.attributes |= protocol.attributes == Attributes::Given;
        let is_house = building_type == BuildingType::SingleFamilyHouse;
        if is_house && protocol.observation.is_roles() && observation.form == ObservationForm::Raw {
            observation.form = ObservationForm::Roles;
        }
        let tasks: Vec<String> = side.tasks.iter().map(ToString::to_string).collect();
        Ok(Self {
            building_type: if buildings.is_empty() { vec![building_type.to_string()] } else { Vec::new() },
            buildings,
            problem: name.to_owned(),
            task: tasks.join(","),
            period: protocol.training_period.to_string(),
            steps_per_hour: protocol.steps_per_hour,
            steps: protocol.training_steps,
            observation,
            ..self
        })
    }

    /// Checks that the run does not go beyond the training side of its problem, if it is for one.
    pub(super) fn check_problem(&self) -> Result<()> {
        if self.problem.is_empty() {
            return Ok(());
        }
        let problem = read(&self.problem)?;
        let (side, protocol) = (&problem.train, &problem.protocol);
        for name in self.named()? {
            match name {
                BuildingName::Id(id) => problem.check_training_building(id)?,
                _ => return Err(beyond(&problem, "building", &name, &side.buildings)),
            }
        }
        let types = self.building_types()?;
        if let Some(building_type) = types.iter().find(|each| !side.buildings.types().contains(each)) {
            return Err(beyond(&problem, "building type", building_type, &side.buildings));
        }
        let tasks: Vec<String> = side.tasks.iter().map(ToString::to_string).collect();
        if let Some(task) = self.tasks()?.iter().find(|task| !side.tasks.contains(task)) {
            return Err(beyond(&problem, "task", task, &tasks.join(", ")));
        }
        if self.run_period()? != protocol.training_period {
            return Err(beyond(&problem, "run period", &self.period, &protocol.training_period));
        }
        if self.steps_per_hour != protocol.steps_per_hour {
            return Err(beyond(&problem, "steps per hour", &self.steps_per_hour, &protocol.steps_per_hour));
        }
        if self.steps > protocol.training_steps {
            let most = format!("at most {}", protocol.training_steps);
            return Err(beyond(&problem, "steps", &self.steps, &most));
        }
        if self.observation.attributes && protocol.attributes == Attributes::Withheld {
            return Err(beyond(&problem, "attributes", &"given", &protocol.attributes));
        }
        Ok(())
    }
}

fn read(name: &str) -> Result<Problem> {
    let is_file = name.to_ascii_lowercase().ends_with(".json");
    Ok(if is_file { Problem::read(Path::new(name))? } else { Problem::named(name)? })
}

/// Returns the one building type of a problem, all of whose buildings have the same observation and actuators.
fn one_type(problem: &Problem) -> Result<BuildingType> {
    let unsuitable = |why: &str| {
        let problem = &problem.name;
        Error::Invalid(format!(
            "no agent can be trained for {problem}: {why}; an agent has one network, for one observation and one set of \
             actuators"
        ))
    };
    let [train, test] = [&problem.train, &problem.test];
    if train.restriction.is_some() || test.restriction.is_some() {
        return Err(unsuitable("it withholds actuators in training or in the test"));
    }
    match train.buildings.types()[..] {
        [building_type] if test.buildings.types() == [building_type] => Ok(building_type),
        _ => Err(unsuitable("its buildings are of several types")),
    }
}

fn beyond(
    problem: &Problem,
    what: &str,
    is: &dyn std::fmt::Display,
    expected: &dyn std::fmt::Display,
) -> Error {
    let name = &problem.name;
    Error::Invalid(format!(
        "{what} of a run for {name}: {is}; expected {expected}, or train without `problem`"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(problem: &str) -> Result<TrainConfig> {
        TrainConfig::preset("residual")?.with_problem(problem)
    }

    #[test]
    fn a_problem_sets_its_training_side_and_its_budget() {
        let houses = of("dynamics-house").unwrap();
        assert_eq!(
            (&houses.building_type[..], houses.buildings.len()),
            (&["SingleFamilyHouse".to_owned()][..], 0)
        );
        assert_eq!((houses.task.as_str(), houses.steps), ("constant", 4_000_000));
        houses.check().unwrap();
        let goals = of("goal-setpoint-mode").unwrap();
        assert_eq!(goals.buildings, ["OfficeSmall-0005"]);
        assert_eq!(goals.tasks().unwrap().len(), 4);
        goals.check().unwrap();
        let paper = TrainConfig::preset("paper").unwrap().with_problem("dynamics-house").unwrap();
        assert_eq!(paper.observation.form, ObservationForm::Roles);
        // A file that says all of it reads back as it is, and may lower the budget.
        let file = TrainConfig { steps: 1000, ..goals };
        assert_eq!(TrainConfig::default().with_changes(&file.to_toml()).unwrap(), file);
        file.check().unwrap();
        let preset = of("dynamics-house").unwrap().with_changes("preset = \"paper\"").unwrap();
        assert_eq!(preset, paper, "a preset in a file keeps the problem");
    }

    #[test]
    fn a_run_beyond_the_training_side_is_an_error_that_names_what_is_allowed() {
        let wrong = |config: TrainConfig| config.check().unwrap_err().to_string();
        let valid = of("dynamics-office-small").unwrap();
        let listed = |name: &str| TrainConfig {
            buildings: vec![name.into()],
            building_type: Vec::new(),
            ..valid.clone()
        };
        let test = b2b_dataset::rows(BuildingType::OfficeSmall)
            .iter()
            .find(|row| row.split == b2b_dataset::Split::Test)
            .unwrap();
        assert!(wrong(listed(&test.id.to_string())).contains("test building of the problem"));
        assert!(wrong(listed("OfficeMedium-0001")).contains("not on the training side"));
        assert!(wrong(listed("OfficeSmall")).contains("building of a run for dynamics-office-small"));
        let said = wrong(TrainConfig { steps: 5_000_000, ..valid.clone() });
        assert!(said.contains("5000000") && said.contains("at most 4000000"), "{said}");
        assert!(wrong(TrainConfig { task: "constant,random".into(), ..valid.clone() }).contains("random"));
        assert!(wrong(TrainConfig { period: "summer".into(), ..valid.clone() }).contains("winter"));
        let mut attributes = valid;
        attributes.observation.attributes = true;
        assert!(wrong(attributes).contains("withheld"));
    }

    #[test]
    fn a_problem_with_several_types_or_withheld_actuators_is_not_for_agents() {
        for (problem, why) in [("unitary-10-5", "withholds actuators"), ("four-types", "several types")] {
            let said = of(problem).unwrap_err().to_string();
            assert!(said.contains(problem) && said.contains(why), "{said}");
        }
        assert!(of("dynamics-hose").unwrap_err().to_string().contains("dynamics-house"));
    }
}
