//! Benchmark problems in training runs. The rest of the crate sees only their [`TrainingSide`].

use std::path::Path;

use b2b_evaluate::problem::{Attributes, Buildings, Problem, Subset};

use super::side::TrainingSide;
use crate::error::{Error, Result};

/// Returns the training side of a problem, by name or JSON file.
///
/// # Errors
/// [`Error::Evaluation`] for an unknown problem; [`Error::Invalid`] for one that withholds actuators.
pub(super) fn training_side(name: &str) -> Result<TrainingSide> {
    let is_file = name.to_ascii_lowercase().ends_with(".json");
    let problem = if is_file { Problem::read(Path::new(name))? } else { Problem::named(name)? };
    let (train, test, protocol) = (&problem.train, &problem.test, &problem.protocol);
    if train.restriction.is_some() || test.restriction.is_some() {
        return Err(Error::Invalid(format!(
            "no agent can be trained for {}: it withholds actuators, and an agent controls all",
            problem.name
        )));
    }
    let types = train.buildings.types();
    let whole_split = Buildings::Subset { types: types.clone(), subset: Subset::Train, count: None };
    Ok(TrainingSide {
        name: problem.name.clone(),
        is_one_type: types.len() == 1 && test.buildings.types() == types,
        types,
        listed: (train.buildings != whole_split).then(|| train.buildings.ids()),
        buildings: train.buildings.to_string(),
        tasks: train.tasks.clone(),
        period: protocol.training_period,
        steps_per_hour: protocol.steps_per_hour,
        steps: protocol.training_steps,
        gives_attributes: protocol.attributes == Attributes::Given,
        is_by_role: protocol.observation.is_roles(),
        check_building: Box::new(move |id| Ok(problem.check_training_building(id)?)),
    })
}

#[cfg(test)]
mod tests {
    use b2b_agent::ObservationForm;
    use b2b_building::BuildingType;

    use crate::error::Result;
    use crate::train::TrainConfig;

    fn of(problem: &str) -> Result<TrainConfig> {
        TrainConfig::preset("residual")?.with_problem(problem)
    }

    #[test]
    fn a_problem_sets_its_training_side_and_its_budget() {
        let houses = of("dynamics-house").unwrap();
        assert_eq!(
            (&houses.training_set.building_type[..], houses.training_set.buildings.len()),
            (&["SingleFamilyHouse".to_owned()][..], 0)
        );
        assert_eq!(
            (houses.training_set.task.to_string().as_str(), houses.budget.steps),
            ("constant", 4_000_000)
        );
        houses.check().unwrap();
        let goals = of("goal-setpoint-mode").unwrap();
        assert_eq!(goals.training_set.buildings, ["OfficeSmall-0005"]);
        assert_eq!(goals.training_set.task.as_slice().len(), 4);
        goals.check().unwrap();
        let paper = TrainConfig::preset("paper").unwrap().with_problem("dynamics-house").unwrap();
        assert_eq!(paper.agent.observation.form, ObservationForm::Roles);
        // A complete file reads back unchanged, and may lower the budget.
        let mut file = goals;
        file.budget.steps = 1000;
        assert_eq!(TrainConfig::default().with_changes(&file.to_toml()).unwrap(), file);
        file.check().unwrap();
        let preset = of("dynamics-house").unwrap().with_changes("preset = \"paper\"").unwrap();
        assert_eq!(preset, paper, "a preset in a file keeps the problem");
    }

    #[test]
    fn a_run_beyond_the_training_side_is_an_error_that_names_what_is_allowed() {
        let valid = of("dynamics-office-small").unwrap();
        let wrong = |changes: &str| valid.with_changes(changes).unwrap().check().unwrap_err().to_string();
        let listed = |name: &str| wrong(&format!("buildings = ['{name}']\nbuilding_type = []"));
        let test = b2b_dataset::rows(BuildingType::OfficeSmall)
            .iter()
            .find(|row| row.split == b2b_dataset::Split::Test)
            .unwrap();
        assert!(listed(&test.id.to_string()).contains("test building of the problem"));
        assert!(listed("OfficeMedium-0001").contains("not on the training side"));
        assert!(listed("OfficeSmall").contains("building of a run for dynamics-office-small"));
        let said = wrong("steps = 5000000");
        assert!(said.contains("5000000") && said.contains("at most 4000000"), "{said}");
        assert!(wrong("task = 'constant,random'").contains("random"));
        assert!(wrong("period = 'summer'").contains("winter"));
        assert!(wrong("steps_per_hour = 6").contains("steps per hour"));
        assert!(wrong("control = 'setpoints'").contains("expected actuators"));
        assert!(wrong("observation = { attributes = true }").contains("withheld"));
    }

    #[test]
    fn several_types_are_for_graph_networks_and_withheld_actuators_for_no_agent() {
        for (problem, why) in [("unitary-10-5", "withholds actuators"), ("four-types", "several types")] {
            let said = of(problem).unwrap_err().to_string();
            assert!(said.contains(problem) && said.contains(why), "{said}");
        }
        let graph = TrainConfig::preset("graph").unwrap().with_problem("four-types").unwrap();
        // A run reads it from its folder; users may write it without a preset.
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("config.toml"), graph.to_toml()).unwrap();
        assert_eq!(TrainConfig::of_run(folder.path()).unwrap(), graph);
        let own = "problem = 'four-types'\npolicy = { kind = 'graph' }";
        assert!(TrainConfig::preset("residual").unwrap().with_changes(own).unwrap().check().is_ok());
        let flat =
            TrainConfig::preset("residual").unwrap().with_changes("problem = 'four-types'").unwrap_err();
        assert!(flat.contains("preset graph"), "{flat}");
        assert_eq!(graph.training_set.building_type.len(), 4);
        graph.check().unwrap();
        assert!(of("dynamics-hose").unwrap_err().to_string().contains("dynamics-house"));
    }
}
