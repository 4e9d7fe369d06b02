//! An experiment as its file defines it.

use std::collections::BTreeMap;

use b2b_base::suggestion::nearest;
use b2b_building::BuildingType;
use b2b_dataset::{BuildingId, Row, Split};
use serde::{Deserialize, Serialize};
use toml::Table;

use super::agent::Agent;
use super::budget::{Budget, Buildings};
use crate::error::{Error, Result};

/// Name of the reactive controllers, listed next to the agents' names.
pub const REACTIVE: &str = "reactive";
/// Name of random actions, listed next to the agents' names.
pub const RANDOM: &str = "random";

/// An experiment.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Name of the shipped experiment or of the file.
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
    /// Whether test buildings are the eight of each type in the small test, instead of the whole test split.
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
    /// Whether to keep the episodes of the reactive controllers and, on problems, of random actions too.
    #[serde(default)]
    pub reactive: bool,
    /// Controllers that need no training, such as `guideline36`, evaluated on the test buildings of the types.
    #[serde(default)]
    pub controllers: Vec<String>,
    /// Options of `b2b train` for all agents, unless an agent sets its own.
    #[serde(default)]
    pub(super) options: Table,
    /// Agents.
    #[serde(default)]
    pub agents: Vec<Agent>,
    /// The benchmark that it runs. Such an experiment has no agents.
    #[serde(default)]
    pub measure: Option<Benchmark>,
    /// Budget for two cores and a few hours.
    pub(super) quick: Budget,
    /// The paper's budget.
    pub(super) full: Budget,
    /// Further budgets, by name.
    #[serde(default)]
    pub(super) budgets: BTreeMap<String, Budget>,
}

/// A benchmark of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Benchmark {
    /// The time of a step, as `b2b bench speed` measures it.
    Speed,
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
    /// Temperature deviation and energy by energy weight.
    Weights,
    /// Cost, energy, discomfort and peak demand of controllers by type and period.
    Operation,
    /// Times of a step by type.
    StepTimes,
    /// The leaderboard of the problems.
    Board,
}

/// Returns the name of the agent that did best on held-out days, which is kept along with the last agent of the same
/// training.
pub fn best_of(agent: &str) -> String {
    format!("{agent}, best")
}

/// A policy with results in an experiment: an agent, or its best version by held-out days.
#[derive(Clone, Debug)]
pub struct Policy<'a> {
    /// Name in tables.
    pub name: String,
    /// The agent.
    pub agent: &'a Agent,
}

impl Experiment {
    /// Returns the budgets: quick, full and the others by name.
    pub fn budgets(&self) -> impl Iterator<Item = &Budget> {
        [&self.quick, &self.full].into_iter().chain(self.budgets.values())
    }

    /// Returns the budget with a name.
    ///
    /// # Errors
    /// [`Error::UnknownBudget`], with the known names.
    pub fn budget(&self, name: &str) -> Result<&Budget> {
        let names = || self.budgets().map(|budget| budget.name.as_str());
        self.budgets().find(|budget| budget.name == name).ok_or_else(|| Error::UnknownBudget {
            name: name.to_owned(),
            experiment: self.name.clone(),
            near: nearest(name, names()),
            known: names().collect::<Vec<_>>().join(", "),
        })
    }

    /// Returns the experiment with the tasks of a budget.
    #[must_use]
    pub fn with_tasks_of(&self, budget: &Budget) -> Self {
        let tasks = budget.tasks.as_ref().unwrap_or(&self.tasks).clone();
        Self { tasks, ..self.clone() }
    }

    /// Returns the controllers whose episodes on test buildings are kept.
    pub fn kept_controllers(&self) -> impl Iterator<Item = &str> {
        let reactive = self.reactive && !self.types.is_empty();
        reactive.then_some(REACTIVE).into_iter().chain(self.controllers.iter().map(String::as_str))
    }

    /// Returns the agents of a budget.
    pub fn agents_of(&self, budget: &Budget) -> impl Iterator<Item = &Agent> {
        self.agents.iter().filter(|agent| budget.has(&agent.name))
    }

    /// Returns the policies with results in a budget: its agents, each followed by its best version by held-out days if
    /// the budget evaluates both.
    pub fn policies(&self, budget: &Budget) -> Vec<Policy<'_>> {
        let mut policies = Vec::new();
        for agent in self.agents_of(budget) {
            policies.push(Policy { name: agent.name.clone(), agent });
            if budget.with_best {
                policies.push(Policy { name: best_of(&agent.name), agent });
            }
        }
        policies
    }

    /// Returns the test buildings of a type in a budget or one of its agents.
    pub fn tests(&self, building_type: BuildingType, buildings: &Buildings) -> Vec<BuildingId> {
        match buildings.ids() {
            [] => self.buildings(building_type, buildings.of(building_type)),
            ids => ids.iter().copied().filter(|id| id.building_type() == building_type).collect(),
        }
    }

    /// Returns at most `count` test buildings of a type, evenly spaced in the list of the dataset.
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
