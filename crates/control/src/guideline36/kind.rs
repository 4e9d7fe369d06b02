//! The kind `guideline36`.

use std::collections::BTreeMap;
use std::path::Path;

use b2b_building::Parameter;
use serde_json::Value;

use super::{Guideline36, Guideline36Parameters};
use crate::Result;
use crate::kind::{self, AnyController, Case};
use crate::parameter_set::{from_json, to_json};

/// The kind `guideline36`.
pub struct Kind;

impl kind::Kind for Kind {
    fn name(&self) -> &'static str {
        "guideline36"
    }

    fn help(&self) -> &'static str {
        "sequences of operation of ASHRAE Guideline 36"
    }

    fn controls_whole_building(&self) -> bool {
        true
    }

    fn parameters(&self) -> Vec<Parameter> {
        Guideline36Parameters::TABLE.into_iter().map(|field| field.parameter).collect()
    }

    fn defaults(&self) -> Value {
        to_json(&Guideline36Parameters::default())
    }

    fn changed(&self, values: Value, changes: &BTreeMap<String, f64>) -> Result<Value> {
        let mut parameters: Guideline36Parameters = from_json(&values)?;
        changes.iter().try_for_each(|(name, value)| parameters.set(name, *value))?;
        parameters.check()?;
        Ok(to_json(&parameters))
    }

    fn read(&self, path: &Path) -> Result<Value> {
        Ok(to_json(&Guideline36Parameters::read(path)?))
    }

    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>> {
        let parameters: Guideline36Parameters = kind::values(case)?;
        Ok(Box::new(Guideline36::new(case.spaces, &parameters)))
    }
}
