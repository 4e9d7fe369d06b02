//! The kind `linear-supervisor`.

use std::collections::BTreeMap;
use std::path::Path;

use b2b_building::PreparedBuilding;
use b2b_env::Task;
use serde_json::Value;

use super::{LinearSupervisor, Rule};
use crate::Result;
use crate::kind::{self, AnyController, Case};
use crate::parameter_set::to_json;

/// The rules that ship with the program, by building type.
const SHIPPED: &str = include_str!("../../data/linear_supervisor.json");

/// The kind `linear-supervisor`. Its values are rules for the days; the last one stays in effect.
pub(crate) struct Kind;

/// Returns the identity of the rules that ship with the program.
pub fn identity() -> String {
    kind::shipped_identity("linear-supervisor", SHIPPED)
}

/// Returns the shipped rule of a building's type; the guideline itself for a type without one, or a model of your own.
pub fn rule_of(building: &PreparedBuilding) -> Rule {
    building.class.map(|class| shipped(class.building_type.name())).unwrap_or_default()
}

/// Returns the shipped rule of a building type; the guideline itself for a type without one.
fn shipped(building_type: &str) -> Rule {
    let rules: BTreeMap<String, Rule> =
        serde_json::from_str(SHIPPED).expect("a test reads the shipped rules");
    rules.get(building_type).cloned().unwrap_or_default()
}

impl kind::Kind for Kind {
    fn name(&self) -> &'static str {
        "linear-supervisor"
    }

    fn help(&self) -> &'static str {
        "guideline36 under one rule of shifts, linear in the weather and in what zones need, for all buildings of a type; \
         guideline36 itself for a type without a rule"
    }

    fn identity(&self) -> String {
        identity()
    }

    fn controls_whole_building(&self) -> bool {
        true
    }

    fn defaults(&self) -> Value {
        to_json(&[Rule::default()])
    }

    fn tuned(&self, building: &PreparedBuilding, _: &Task) -> Value {
        to_json(&[rule_of(building)])
    }

    fn read(&self, path: &Path) -> Result<Value> {
        Ok(to_json(&[Rule::read(path)?]))
    }

    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>> {
        let rules: Vec<Rule> = kind::values(case)?;
        Ok(Box::new(LinearSupervisor::new(case.spaces, &rules)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_rules_are_valid_and_a_type_without_one_has_no_weights() {
        let rules: BTreeMap<String, Rule> = serde_json::from_str(SHIPPED).unwrap();
        for (name, rule) in &rules {
            name.parse::<b2b_building::BuildingType>().unwrap();
            rule.check().unwrap();
        }
        assert_eq!(shipped("none"), Rule::default());
    }

    #[test]
    fn results_of_other_shipped_rules_have_another_identity() {
        let [own, other] = [SHIPPED, "{}"].map(|rules| kind::shipped_identity("linear-supervisor", rules));
        assert_eq!(identity(), own);
        assert_ne!(own, other);
    }
}
