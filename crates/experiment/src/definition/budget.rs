//! Budgets by name.

use std::collections::BTreeMap;

use b2b_building::BuildingType;
use b2b_dataset::BuildingId;
use serde::Deserialize;
use toml::Value;

/// The budget of an experiment.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// Name: `quick`, `full`, or its key under `[budgets]`.
    #[serde(skip)]
    pub name: String,
    /// Environment steps of each training.
    pub steps: u64,
    /// Number of seeds.
    pub seeds: u64,
    /// Test buildings.
    pub buildings: Buildings,
    /// Names of the agents included; `None`: all.
    #[serde(default)]
    pub agents: Option<Vec<String>>,
    /// Tasks; `None`: the experiment's.
    #[serde(default)]
    pub tasks: Option<Vec<String>>,
    /// Whether training runs keep the best agent by held-out days as well as the last one, and both are evaluated.
    #[serde(default)]
    pub with_best: bool,
}

/// Test buildings: numbers of them, evenly spaced in the list of the dataset, or their ids.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(try_from = "Value")]
pub struct Buildings {
    by_type: BTreeMap<BuildingType, usize>,
    others: usize,
    /// If not empty, the buildings.
    ids: Vec<BuildingId>,
}

/// The changes of an agent to a budget.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BudgetChange {
    steps: Option<u64>,
    seeds: Option<u64>,
    buildings: Option<Buildings>,
}

/// Key for the number of buildings of types that are not named.
const OTHERS: &str = "others";

impl Budget {
    /// Returns whether the budget has an agent.
    pub fn has(&self, agent: &str) -> bool {
        self.agents.as_ref().is_none_or(|names| names.iter().any(|name| name == agent))
    }

    /// Returns the budget with the changes of an agent.
    pub(super) fn with(&self, change: Option<&BudgetChange>) -> Self {
        let Some(change) = change else { return self.clone() };
        Self {
            steps: change.steps.unwrap_or(self.steps),
            seeds: change.seeds.unwrap_or(self.seeds),
            buildings: change.buildings.as_ref().unwrap_or(&self.buildings).clone(),
            ..self.clone()
        }
    }
}

impl Buildings {
    /// Returns the number for a type.
    pub fn of(&self, building_type: BuildingType) -> usize {
        self.by_type.get(&building_type).copied().unwrap_or(self.others)
    }

    /// Returns the number if it is the same for all types.
    pub fn of_all(&self) -> Option<usize> {
        (self.by_type.is_empty() && self.ids.is_empty()).then_some(self.others)
    }

    /// Returns the ids; empty if only numbers are given.
    pub fn ids(&self) -> &[BuildingId] {
        &self.ids
    }
}

impl TryFrom<Value> for Buildings {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        let count = |value: &Value| {
            let count = value.as_integer().and_then(|count| usize::try_from(count).ok());
            count.ok_or_else(|| {
                format!(
                    "`buildings` is {value}; expected a number, a table of numbers by type, or a list of ids"
                )
            })
        };
        let table = match &value {
            Value::Table(table) => table,
            Value::Array(ids) if !ids.is_empty() => {
                let id = |id: &Value| {
                    let text = id.as_str().map_or_else(|| id.to_string(), str::to_owned);
                    text.parse().map_err(|error: b2b_dataset::Error| error.to_string())
                };
                return Ok(Self { ids: ids.iter().map(id).collect::<Result<_, _>>()?, ..Self::default() });
            }
            _ => return Ok(Self { others: count(&value)?, ..Self::default() }),
        };
        let mut buildings = Self::default();
        for (name, value) in table {
            if name == OTHERS {
                buildings.others = count(value)?;
            } else {
                let building_type = name.parse().map_err(|error: b2b_building::Error| error.to_string())?;
                buildings.by_type.insert(building_type, count(value)?);
            }
        }
        Ok(buildings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn buildings(text: &str) -> Result<Buildings, String> {
        let budget = format!("steps = 1\nseeds = 1\nbuildings = {text}");
        toml::from_str::<Budget>(&budget).map(|budget| budget.buildings).map_err(|error| error.to_string())
    }

    #[test]
    fn buildings_are_a_number_numbers_by_type_or_ids() {
        let by_type = buildings("{ SingleFamilyHouse = 8, others = 2 }").unwrap();
        assert_eq!(by_type.of(BuildingType::SingleFamilyHouse), 8);
        assert_eq!((by_type.of(BuildingType::Warehouse), by_type.of_all()), (2, None));
        assert_eq!(buildings("3").unwrap().of_all(), Some(3));
        assert!(buildings("{ House = 8 }").unwrap_err().contains("House"));
        assert!(buildings("-1").unwrap_err().contains("`buildings` is -1"));
        assert!(buildings("[]").unwrap_err().contains("`buildings` is []"));
        let named = buildings("['Warehouse-0007']").unwrap();
        assert_eq!((named.ids().len(), named.of_all()), (1, None));
        assert!(buildings("['Warehouse-x']").unwrap_err().contains("Warehouse-x"));
    }
}
