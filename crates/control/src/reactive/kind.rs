//! The kind `reactive`.

use std::collections::BTreeMap;
use std::path::Path;

use b2b_building::{Parameter, PreparedBuilding};
use b2b_env::Task;
use serde_json::Value;

use super::{Reactive, ReactiveParameters};
use crate::Result;
use crate::kind::{self, AnyController, Case, KindDescription};
use crate::parameter_set::{from_json, to_json};

/// The kind `reactive`.
pub struct Kind;

impl kind::Kind for Kind {
    fn name(&self) -> &'static str {
        "reactive"
    }

    fn help(&self) -> &'static str {
        "rule-based baseline, after ASHRAE Guideline 36"
    }

    fn controls_whole_building(&self) -> bool {
        true
    }

    fn parameters(&self) -> Vec<Parameter> {
        ReactiveParameters::TABLE.into_iter().map(|field| field.parameter).collect()
    }

    fn defaults(&self) -> Value {
        to_json(&ReactiveParameters::default())
    }

    fn tuned(&self, building: &PreparedBuilding, task: &Task) -> Value {
        to_json(&ReactiveParameters::tuned_for(building, task))
    }

    fn changed(&self, values: Value, changes: &BTreeMap<String, f64>) -> Result<Value> {
        let mut parameters: ReactiveParameters = from_json(&values)?;
        changes.iter().try_for_each(|(name, value)| parameters.set(name, *value))?;
        parameters.check()?;
        Ok(to_json(&parameters))
    }

    fn read(&self, path: &Path) -> Result<Value> {
        Ok(to_json(&ReactiveParameters::read(path)?))
    }

    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>> {
        Ok(Box::new(Reactive::of_case(case)?))
    }
}

impl Reactive {
    /// Returns the description from which a worker makes the controllers.
    pub fn description(parameters: &ReactiveParameters) -> Value {
        let name = kind::Kind::name(&Kind).to_owned();
        KindDescription { name, seed: 0, values: to_json(parameters) }.to_order()
    }

    /// Makes the controllers of a case.
    pub(crate) fn of_case(case: &Case<'_>) -> Result<Self> {
        let spaces = case.spaces;
        let parameters: ReactiveParameters = kind::values(case)?;
        Ok(Self::new(&spaces.building, &spaces.observation, spaces.episode.steps_per_hour, &parameters))
    }
}
