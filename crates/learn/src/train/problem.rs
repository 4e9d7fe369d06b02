//! Training for a benchmark problem: on its training side.

use std::path::Path;

use b2b_agent::ObservationForm;
use b2b_benchmark::Problem;
use b2b_benchmark::problem::{Attributes, Buildings, Subset};
use b2b_building::BuildingType;
use b2b_dataset::BuildingName;

use super::config::TrainConfig;
use super::policy::Policy;
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
        let types = types(&problem, &self.policy)?;
        let whole_split = Buildings::Subset { types: types.clone(), subset: Subset::Train, count: None };
        let buildings = match side.buildings == whole_split {
            true => Vec::new(),
            false => side.buildings.ids().iter().map(ToString::to_string).collect(),
        };
        let (mut observation, mut policy) = (self.observation, self.policy.clone());
        let are_given = protocol.attributes == Attributes::Given;
        let has_roles = types == [BuildingType::SingleFamilyHouse] && protocol.observation.is_roles();
        match &mut policy {
            Policy::Graph(graph) => graph.attributes |= are_given,
            Policy::Flat => {
                observation.attributes |= are_given;
                if has_roles && observation.form == ObservationForm::Raw {
                    observation.form = ObservationForm::Roles;
                }
            }
        }
        Ok(Self {
            building_type: match buildings.is_empty() {
                true => types.iter().map(ToString::to_string).collect(),
                false => Vec::new(),
            },
            buildings,
            problem: name.to_owned(),
            task: side.tasks.iter().cloned().collect(),
            period: protocol.training_period.to_string(),
            steps_per_hour: protocol.steps_per_hour,
            steps: protocol.training_steps,
            observation,
            policy,
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
        if let Some(task) = self.task.as_slice().iter().find(|task| !side.tasks.contains(task)) {
            let expected: Vec<String> = side.tasks.iter().map(ToString::to_string).collect();
            return Err(beyond(&problem, "task", task, &expected.join(", ")));
        }
        if self.run_period()? != protocol.training_period {
            return Err(beyond(&problem, "run period", &self.period, &protocol.training_period));
        }
        if self.steps_per_hour != protocol.steps_per_hour {
            return Err(beyond(&problem, "steps per hour", &self.steps_per_hour, &protocol.steps_per_hour));
        }
        if self.steps > protocol.training_steps {
            let budget = format!("at most {}", protocol.training_steps);
            return Err(beyond(&problem, "steps", &self.steps, &budget));
        }
        let observes_attributes = match &self.policy {
            Policy::Graph(graph) => graph.attributes,
            Policy::Flat => self.observation.attributes,
        };
        if observes_attributes && protocol.attributes == Attributes::Withheld {
            return Err(beyond(&problem, "attributes", &"given", &protocol.attributes));
        }
        Ok(())
    }
}

fn read(name: &str) -> Result<Problem> {
    let is_file = name.to_ascii_lowercase().ends_with(".json");
    Ok(if is_file { Problem::read(Path::new(name))? } else { Problem::named(name)? })
}

/// Returns the building types that are trained on for a problem: one, with the same observation and actuators in all buildings,
/// unless the network is a graph.
fn types(problem: &Problem, policy: &Policy) -> Result<Vec<BuildingType>> {
    let name = &problem.name;
    let [train, test] = [&problem.train, &problem.test];
    if train.restriction.is_some() || test.restriction.is_some() {
        let why =
            format!("no agent can be trained for {name}: it withholds actuators, and an agent controls all");
        return Err(Error::Invalid(why));
    }
    let types = train.buildings.types();
    if *policy == Policy::Flat && (types.len() > 1 || test.buildings.types() != types) {
        let why = format!(
            "the buildings of {name} are of several types, which are for graph networks; choose the preset graph"
        );
        return Err(Error::Invalid(why));
    }
    Ok(types)
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
        assert_eq!((houses.task.to_string().as_str(), houses.steps), ("constant", 4_000_000));
        houses.check().unwrap();
        let goals = of("goal-setpoint-mode").unwrap();
        assert_eq!(goals.buildings, ["OfficeSmall-0005"]);
        assert_eq!(goals.task.as_slice().len(), 4);
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
        assert!(
            wrong(TrainConfig { task: "constant,random".parse().unwrap(), ..valid.clone() })
                .contains("random")
        );
        assert!(wrong(TrainConfig { period: "summer".into(), ..valid.clone() }).contains("winter"));
        let mut attributes = valid;
        attributes.observation.attributes = true;
        assert!(wrong(attributes).contains("withheld"));
    }

    #[test]
    fn several_types_are_for_graph_networks_and_withheld_actuators_for_no_agent() {
        for (problem, why) in [("unitary-10-5", "withholds actuators"), ("four-types", "several types")] {
            let said = of(problem).unwrap_err().to_string();
            assert!(said.contains(problem) && said.contains(why), "{said}");
        }
        let graph = TrainConfig::preset("graph").unwrap().with_problem("four-types").unwrap();
        // A run reads it from its folder, and users may write it without a preset.
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("config.toml"), graph.to_toml()).unwrap();
        assert_eq!(TrainConfig::of_run(folder.path()).unwrap(), graph);
        let own = "problem = 'four-types'\npolicy = { kind = 'graph' }";
        assert!(TrainConfig::preset("residual").unwrap().with_changes(own).unwrap().check().is_ok());
        let flat =
            TrainConfig::preset("residual").unwrap().with_changes("problem = 'four-types'").unwrap_err();
        assert!(flat.contains("preset graph"), "{flat}");
        assert_eq!(graph.building_type.len(), 4);
        graph.check().unwrap();
        assert!(of("dynamics-hose").unwrap_err().to_string().contains("dynamics-house"));
    }
}
