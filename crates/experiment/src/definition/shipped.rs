//! Experiments by name: the shipped ones and users' files.

use std::path::Path;

use b2b_base::suggestion::nearest;
use b2b_learn::train::merge;

use super::experiment::Experiment;
use super::validation;
use crate::error::{Error, Result, at};

/// The shipped experiments by name.
const SHIPPED: [(&str, &str); 16] = [
    ("ppo", include_str!("../../data/ppo.toml")),
    ("direct", include_str!("../../data/direct.toml")),
    ("residual", include_str!("../../data/residual.toml")),
    ("rewards", include_str!("../../data/rewards.toml")),
    ("dynamics", include_str!("../../data/dynamics.toml")),
    ("dynamics-office-small", include_str!("../../data/dynamics-office-small.toml")),
    ("dynamics-office-medium", include_str!("../../data/dynamics-office-medium.toml")),
    ("climates", include_str!("../../data/climates.toml")),
    ("cross-domain", include_str!("../../data/cross-domain.toml")),
    ("board", include_str!("../../data/board.toml")),
    ("memory", include_str!("../../data/memory.toml")),
    ("memory-specialists", include_str!("../../data/memory-specialists.toml")),
    ("weights", include_str!("../../data/weights.toml")),
    ("operation", include_str!("../../data/operation.toml")),
    ("supervision", include_str!("../../data/supervision.toml")),
    ("speed", include_str!("../../data/speed.toml")),
];

impl Experiment {
    /// Returns the shipped experiments.
    pub fn all() -> impl Iterator<Item = Self> {
        let parse = |(name, text)| Self::parse(name, text).expect("a test reads every shipped experiment");
        SHIPPED.into_iter().map(parse)
    }

    /// Returns a shipped experiment by name, or reads one from a TOML file.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the most similar name; [`Error::Definition`]; [`Error::Io`].
    pub fn named(name: &str) -> Result<Self> {
        if let Some((name, text)) = SHIPPED.iter().find(|(known, _)| *known == name) {
            return Self::parse(name, text);
        }
        let path = Path::new(name);
        if path.extension().is_some_and(|extension| extension == "toml") {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            return Self::parse(&stem, &std::fs::read_to_string(path).map_err(at(path))?);
        }
        let near = nearest(name, SHIPPED.iter().map(|(known, _)| *known));
        Err(Error::Unknown { name: name.to_owned(), near })
    }

    pub(super) fn parse(name: &str, text: &str) -> Result<Self> {
        let invalid = |why: String| Error::Definition { path: name.to_owned(), why };
        let mut experiment: Self = toml::from_str(text).map_err(|error| invalid(error.to_string()))?;
        name.clone_into(&mut experiment.name);
        for agent in &mut experiment.agents {
            let own = std::mem::replace(&mut agent.options, experiment.options.clone());
            merge(&mut agent.options, own);
        }
        "quick".clone_into(&mut experiment.quick.name);
        "full".clone_into(&mut experiment.full.name);
        experiment.budgets.iter_mut().for_each(|(name, budget)| name.clone_into(&mut budget.name));
        validation::fault(&experiment).map_or(Ok(experiment), |why| Err(invalid(why)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use b2b_building::BuildingType;
    use b2b_dataset::BuildingId;

    #[test]
    fn every_shipped_experiment_is_valid() {
        assert_eq!(Experiment::all().count(), SHIPPED.len());
    }

    #[test]
    fn a_misspelled_name_is_answered_with_the_right_one() {
        let said = Experiment::named("dynamic").unwrap_err().to_string();
        assert!(said.contains("did you mean `dynamics`?"), "{said}");
        assert!(!Experiment::named("xyz").unwrap_err().to_string().contains("did you mean"));
    }

    #[test]
    fn test_buildings_are_spread_over_the_list() {
        let experiment = Experiment::named("ppo").unwrap();
        let all = experiment.buildings(BuildingType::OfficeSmall, 8);
        assert_eq!(all.len(), 8);
        assert_eq!(experiment.buildings(BuildingType::OfficeSmall, 2), [all[2], all[6]]);
        assert_eq!(experiment.buildings(BuildingType::OfficeSmall, 99), all);
    }

    #[test]
    fn test_buildings_are_in_the_climate_zones() {
        let experiment = Experiment::named("climates").unwrap();
        let zone = |id: &BuildingId| b2b_dataset::row(*id).building.location().ashrae_zone().unwrap();
        let ids = experiment.buildings(BuildingType::OfficeSmall, 100);
        assert!(ids.len() > 10 && ids.iter().all(|id| ["1A", "2A", "7", "8"].contains(&zone(id))));
        let Experiment { agents, climate_zones, .. } = experiment;
        let excluded = agents[1].options["excluded_climate_zones"].as_array().unwrap();
        assert!(excluded.iter().map(|zone| zone.as_str().unwrap()).eq(&climate_zones));
    }

    #[test]
    fn a_definition_with_a_fault_is_refused() {
        let text = SHIPPED[0].1;
        for (old, new, word) in [
            ("\"winter\"", "\"monsoon\"", "monsoon"),
            ("learning_rate", "lerning_rate", "learning_rate"),
            ("name = \"residual\"", "name = \"paper\"", "two agents are named"),
            ("small_test", "smal_test", "smal_test"),
            ("options = { ", "options = { steps = 3, ", "`options.steps` is set by the experiment"),
        ] {
            let broken = text.replacen(old, new, 1);
            if old == "learning_rate" && broken == text {
                continue;
            }
            assert_ne!(broken, text, "{old}");
            let said = Experiment::parse("x", &broken).unwrap_err().to_string();
            assert!(said.contains(word), "{said}");
        }
    }

    #[test]
    fn an_unknown_controller_or_an_agent_with_the_name_of_one_is_refused() {
        let text = SHIPPED.iter().find(|(name, _)| *name == "operation").unwrap().1;
        for (old, new, word) in [
            ("\"own\"", "\"onw\"", "onw"),
            ("\"own\"", "\"reactive\"", "listed twice"),
            ("mixed", "mixd", "mixd"),
        ] {
            let said = Experiment::parse("x", &text.replacen(old, new, 1)).unwrap_err().to_string();
            assert!(said.contains(word), "{said}");
        }
        let text = SHIPPED[0].1.replacen("name = \"residual\"", "name = \"guideline36\"", 1);
        let said = Experiment::parse("x", &text).unwrap_err().to_string();
        assert!(said.contains("two agents are named `guideline36`"), "{said}");
    }

    #[test]
    fn an_operation_report_adds_up_periods_of_one_training() {
        let text = SHIPPED.iter().find(|(name, _)| *name == "supervision").unwrap().1;
        let said =
            Experiment::parse("x", &text.replacen("all_periods = true", "", 1)).unwrap_err().to_string();
        assert!(said.contains("agent `graph`") && said.contains("`all_periods` to true"), "{said}");
    }

    #[test]
    fn tasks_and_periods_of_an_entry_are_those_of_its_problem() {
        let text = SHIPPED.iter().find(|(name, _)| *name == "memory").unwrap().1;
        for option in ["all_tasks", "all_periods"] {
            let text = text.replacen("trains = ", &format!("{option} = true\ntrains = "), 1);
            let said = Experiment::parse("x", &text).unwrap_err().to_string();
            assert!(said.contains("agent `flat`") && said.contains("no effect"), "{said}");
        }
    }

    #[test]
    fn a_misspelled_budget_is_answered_with_the_right_one_and_a_faulty_one_refused() {
        let said = Experiment::named("ppo").unwrap().budget("paper-prat").unwrap_err().to_string();
        assert!(
            said.contains("did you mean `paper-part`?") && said.contains("quick, full, paper-part"),
            "{said}"
        );
        let text = SHIPPED[0].1;
        for (old, new, word) in [
            ("agents = [\"paper\"]", "agents = [\"papr\"]", "no agent `papr`"),
            ("[budgets.paper-part]", "[budgets.quick]", "two budgets are named `quick`"),
            ("[budgets.paper-part]", "[budgets.\"a b\"]", "invalid budget name `a b`"),
            ("SingleFamilyHouse = 8", "House = 8", "House"),
            ("with_best = true", "tasks = [\"occupnacy\"]", "occupnacy"),
            ("with_best = true", "tasks = []", "`tasks` is empty"),
            ("with_best = true", "tasks = ['constant', 'constant']", "`constant` is listed twice"),
            (
                "[[agents]]\nname = \"residual\"",
                "[[agents]]\nname = \"residual\"\nbudgets = { paper-part = { seeds = 2 } }",
                "does not have it",
            ),
            (
                "buildings = { SingleFamilyHouse = 8, others = 2 }",
                "buildings = ['Warehouse-0350', 'Warehouse-0350']",
                "lists Warehouse-0350 twice",
            ),
            (
                "buildings = { SingleFamilyHouse = 8, others = 2 }",
                "buildings = ['Warehouse-0350']",
                "lists no OfficeSmall",
            ),
            (
                "buildings = { SingleFamilyHouse = 8, others = 2 }",
                "buildings = ['Warehouse-0001']",
                "lists Warehouse-0001",
            ),
        ] {
            let broken = text.replacen(old, new, 1);
            assert_ne!(broken, text, "{old}");
            let said = Experiment::parse("x", &broken).unwrap_err().to_string();
            assert!(said.contains(word), "{said}");
        }
        let text = SHIPPED.iter().find(|(name, _)| *name == "dynamics").unwrap().1;
        let said =
            Experiment::parse("x", &text.replace("budgets.paper-part = ", "budgets.part = ")).unwrap_err();
        assert!(said.to_string().contains("no budget `part`"), "{said}");
    }
}
