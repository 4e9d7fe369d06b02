//! The definition of an experiment.

use std::path::Path;

use b2b_benchmark::Problem;
use b2b_building::{BuildingType, RunPeriod};
use b2b_dataset::{BuildingId, Row, Split};
use b2b_env::Task;
use b2b_learn::train::TrainConfig;
use serde::{Deserialize, Serialize};
use toml::Table;

use crate::error::{Error, Result, at};

/// The shipped experiments by name.
const SHIPPED: [(&str, &str); 11] = [
    ("ppo", include_str!("../data/ppo.toml")),
    ("residual", include_str!("../data/residual.toml")),
    ("rewards", include_str!("../data/rewards.toml")),
    ("dynamics", include_str!("../data/dynamics.toml")),
    ("dynamics-office-small", include_str!("../data/dynamics-office-small.toml")),
    ("dynamics-office-medium", include_str!("../data/dynamics-office-medium.toml")),
    ("climates", include_str!("../data/climates.toml")),
    ("cross-domain", include_str!("../data/cross-domain.toml")),
    ("board", include_str!("../data/board.toml")),
    ("weights", include_str!("../data/weights.toml")),
    ("speed", include_str!("../data/speed.toml")),
];

/// An experiment.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Name: that of the shipped experiment or of the file.
    #[serde(skip)]
    pub name: String,
    /// Title of the report.
    pub title: String,
    /// The question that the experiment answers.
    pub question: String,
    /// The result of the paper that it reproduces, or what it adds.
    pub paper: String,
    /// Kind of the report.
    pub report: ReportKind,
    /// Building types.
    #[serde(default)]
    pub types: Vec<BuildingType>,
    /// Benchmark problems, on which agents are entered instead of being evaluated on test buildings of the types.
    #[serde(default)]
    pub problems: Vec<String>,
    /// Test buildings: the eight of each type in the small test, or the whole test split.
    #[serde(default)]
    pub small_test: bool,
    /// ASHRAE 169 climate zones of the test buildings, such as `1A`, or `1` for 1A to 1C. Empty: all.
    #[serde(default)]
    pub climate_zones: Vec<String>,
    /// Tasks.
    #[serde(default)]
    pub tasks: Vec<String>,
    /// Run periods.
    #[serde(default)]
    pub periods: Vec<String>,
    /// Whether the episodes of the reactive controllers are kept, too; those of random actions as well on problems.
    #[serde(default)]
    pub reactive: bool,
    /// Agents.
    #[serde(default)]
    pub agents: Vec<Agent>,
    /// Arguments of one `b2b` command with `--json` that measures; the experiment has no agents then.
    #[serde(default)]
    pub measure: Vec<String>,
    /// What two cores do in a few hours.
    pub quick: Budget,
    /// What the paper spends.
    pub full: Budget,
}

/// An agent of an experiment.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Agent {
    /// Name in folders and tables.
    pub name: String,
    /// The scope of its training runs.
    pub trains: Training,
    /// Whether one training covers all tasks of the experiment instead of one each.
    #[serde(default)]
    pub all_tasks: bool,
    /// The problems that it is entered on, among those of the experiment.
    #[serde(default)]
    pub problems: Vec<String>,
    /// Options of `b2b train`, as in a file for its `--config`.
    pub options: Table,
    /// Changes of the quick budget.
    #[serde(default)]
    pub quick: BudgetChange,
    /// Changes of the full budget.
    #[serde(default)]
    pub full: BudgetChange,
}

/// The scope of an agent's training runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Training {
    /// One training on each test building: specialists.
    Building,
    /// One training on the training split of each type, evaluated on the test buildings of the type.
    Type,
    /// One training on the training splits of all types together, evaluated on the test buildings of all.
    AllTypes,
    /// One training per seed on the training side of each problem, all entered on it.
    Problem,
}

/// The kind of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReportKind {
    /// Scores by type, task and period.
    Scores,
    /// Distributions of the rewards of single steps.
    StepRewards,
    /// Median scores of agents over test buildings, and RMS deviations.
    Adaptation,
    /// Distributions of scores by type.
    Transfer,
    /// Temperature deviation and energy by the weight of energy.
    Weights,
    /// Times of a step by type.
    StepTimes,
    /// The leaderboard of the problems.
    Board,
}

/// The name of a budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BudgetName {
    /// What two cores do in a few hours.
    Quick,
    /// What the paper spends.
    Full,
}

/// The budget of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// Environment steps of each training.
    pub steps: u64,
    /// Number of seeds.
    pub seeds: u64,
    /// Number of test buildings of each type, evenly spaced in the list of the dataset.
    pub buildings: usize,
}

/// The changes of an agent to a budget.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BudgetChange {
    steps: Option<u64>,
    seeds: Option<u64>,
    buildings: Option<usize>,
}

impl Experiment {
    /// Returns the shipped experiments.
    pub fn all() -> impl Iterator<Item = Self> {
        let parse = |(name, text)| Self::parse(name, text).expect("a test reads every shipped experiment");
        SHIPPED.into_iter().map(parse)
    }

    /// Returns the shipped experiment of a name, or that of a TOML file.
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
        let similarity = |known: &str| strsim::jaro_winkler(known, name);
        let near = SHIPPED.iter().map(|(known, _)| *known).filter(|known| similarity(known) > 0.75);
        let near = near.max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
        Err(Error::Unknown {
            name: name.to_owned(),
            near: near.map_or_else(String::new, |near| format!("`{near}`")),
        })
    }

    fn parse(name: &str, text: &str) -> Result<Self> {
        let invalid = |why: String| Error::Definition { path: name.to_owned(), why };
        let mut experiment: Self = toml::from_str(text).map_err(|error| invalid(error.to_string()))?;
        name.clone_into(&mut experiment.name);
        experiment.check().map_err(invalid)?;
        Ok(experiment)
    }

    /// Checks the constraints that the types do not enforce.
    fn check(&self) -> std::result::Result<(), String> {
        for task in &self.tasks {
            task.parse::<Task>().map_err(|error| error.to_string())?;
        }
        for period in &self.periods {
            period.parse::<RunPeriod>().map_err(|error| error.to_string())?;
        }
        let names: Vec<&str> = self.agents.iter().map(|agent| agent.name.as_str()).collect();
        for (number, agent) in self.agents.iter().enumerate() {
            let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-';
            if agent.name.is_empty() || !agent.name.chars().all(is_plain) {
                return Err(format!(
                    "invalid agent name `{}`; expected letters, digits and hyphens",
                    agent.name
                ));
            }
            if names[..number].contains(&agent.name.as_str()) || [REACTIVE, RANDOM].contains(&&agent.name[..])
            {
                return Err(format!("two agents are named `{}`", agent.name));
            }
            TrainConfig::default()
                .with_changes(&toml::to_string(&agent.options).map_err(|error| error.to_string())?)
                .map_err(|error| format!("agent `{}`: {error}", agent.name))?;
        }
        self.check_entries()?;
        let runs = self.reactive || !self.agents.is_empty();
        let is_board = self.report == ReportKind::Board;
        match () {
            () if is_board == self.problems.is_empty() => {
                Err("`problems` belongs to `report = \"board\"`, which needs it".into())
            }
            () if is_board => Ok(()),
            () if self.types.is_empty() => Err("`types` is empty".into()),
            () if self.types.iter().any(|each| self.buildings(*each, 1).is_empty()) => {
                Err(format!("no test building is in the climate zones {}", self.climate_zones.join(", ")))
            }
            () if runs && (self.tasks.is_empty() || self.periods.is_empty()) => {
                Err("it has agents, but `tasks` or `periods` is empty".into())
            }
            () if runs != self.measure.is_empty() => {
                Err("it has either agents (or `reactive = true`) or a command under `measure`".into())
            }
            () => Ok(()),
        }
    }

    /// Checks the problems, and that an agent is entered on some if and only if the report is their leaderboard.
    fn check_entries(&self) -> std::result::Result<(), String> {
        for name in &self.problems {
            Problem::named(name).map_err(|error| error.to_string())?;
        }
        for agent in &self.agents {
            let is_entered = agent.trains == Training::Problem;
            if is_entered != (self.report == ReportKind::Board) || is_entered == agent.problems.is_empty() {
                return Err(format!(
                    "agent `{}`: an agent is entered on `problems` if it `trains = \"problem\"` for `report = \"board\"`, and \
                     only then",
                    agent.name
                ));
            }
            if let Some(other) = agent.problems.iter().find(|name| !self.problems.contains(name)) {
                return Err(format!(
                    "agent `{}`: `{other}` is not in the experiment's `problems`",
                    agent.name
                ));
            }
        }
        Ok(())
    }

    /// Returns the budget of this name.
    pub fn budget(&self, name: BudgetName) -> Budget {
        match name {
            BudgetName::Quick => self.quick,
            BudgetName::Full => self.full,
        }
    }

    /// Returns `count` test buildings of a type, evenly spaced in the list of the dataset.
    pub fn buildings(&self, building_type: BuildingType, count: usize) -> Vec<BuildingId> {
        let is_in_zone = |row: &&Row| {
            self.climate_zones.is_empty()
                || self.climate_zones.iter().any(|zone| row.is_in_climate_zone(zone))
        };
        let is_test = |row: &&Row| match self.small_test {
            true => row.test_small,
            false => row.split == Split::Test,
        };
        let ids: Vec<BuildingId> = b2b_dataset::rows(building_type)
            .iter()
            .filter(is_test)
            .filter(is_in_zone)
            .map(|row| row.id)
            .collect();
        let count = count.min(ids.len());
        (0..count).map(|index| ids[(2 * index + 1) * ids.len() / (2 * count)]).collect()
    }
}

/// Name of the reactive controllers beside those of agents.
pub(crate) const REACTIVE: &str = "reactive";
/// Name of random actions beside those of agents.
pub(crate) const RANDOM: &str = "random";

impl Agent {
    /// Returns the budget of a training run of this agent.
    pub fn budget(&self, experiment: &Experiment, name: BudgetName) -> Budget {
        let budget = experiment.budget(name);
        let change = match name {
            BudgetName::Quick => self.quick,
            BudgetName::Full => self.full,
        };
        Budget {
            steps: change.steps.unwrap_or(budget.steps),
            seeds: change.seeds.unwrap_or(budget.seeds),
            buildings: change.buildings.unwrap_or(budget.buildings),
        }
    }
}

impl std::str::FromStr for BudgetName {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "quick" => Ok(Self::Quick),
            "full" => Ok(Self::Full),
            _ => Err(format!("unknown budget `{text}`; expected quick or full")),
        }
    }
}

impl std::fmt::Display for BudgetName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Quick => "quick",
            Self::Full => "full",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
