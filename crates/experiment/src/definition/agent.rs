//! An agent of an experiment.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use toml::Table;

use super::budget::{Budget, BudgetChange};

/// An agent of an experiment.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Agent {
    /// Name in folders and tables.
    pub name: String,
    /// The scope of its training runs.
    pub trains: Training,
    /// Whether one training run covers all tasks of the experiment, instead of one run per task.
    #[serde(default)]
    pub all_tasks: bool,
    /// Whether one training run covers all periods of the experiment, instead of one run per period.
    #[serde(default)]
    pub all_periods: bool,
    /// The experiment's problems that the agent is entered on.
    #[serde(default)]
    pub problems: Vec<String>,
    /// Options of `b2b train`, as in a file for its `--config`.
    pub options: Table,
    #[serde(default)]
    quick: BudgetChange,
    #[serde(default)]
    full: BudgetChange,
    /// Changes of the experiment's other budgets, by name.
    #[serde(default)]
    budgets: BTreeMap<String, BudgetChange>,
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

impl Agent {
    /// Returns a budget of the experiment with the agent's changes.
    pub fn budget(&self, of_experiment: &Budget) -> Budget {
        of_experiment.with(match &of_experiment.name[..] {
            "quick" => Some(&self.quick),
            "full" => Some(&self.full),
            name => self.budgets.get(name),
        })
    }

    /// Returns the names of the budgets that it changes, other than quick and full.
    pub(super) fn changed_budgets(&self) -> impl Iterator<Item = &str> {
        self.budgets.keys().map(String::as_str)
    }
}
