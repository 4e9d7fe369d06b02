//! The kind `guideline36`.

use std::collections::BTreeMap;
use std::path::Path;

use b2b_building::{Parameter, PreparedBuilding};
use b2b_env::Task;
use serde_json::Value;

use super::{Guideline36, Guideline36Parameters, inputs};
use crate::Result;
use crate::kind::{self, AnyController, Case};
use crate::parameter_set::{from_json, to_json};

/// Lift of the supply air of a heat pump up to which flow is not raised, K. Its efficiency grows with the flow: in a small
/// office in January, 7 instead of 11 K saves 3 % of energy, while 4 K saves no more.
const HEAT_PUMP_LIFT: f64 = 7.0;

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

    /// The defaults, with the economizer and the compressor of the building's units.
    fn tuned(&self, building: &PreparedBuilding, _: &Task) -> Value {
        let mut parameters = Guideline36Parameters::default();
        parameters.unitary.economizer = f64::from(u8::from(inputs::has_economizer(building)));
        if let Some([lift, cutoff]) = inputs::compressor(building) {
            let unitary = &mut parameters.unitary;
            (unitary.compressor_lift, unitary.compressor_cutoff) =
                (lift.min(60.0), cutoff.clamp(-60.0, 20.0));
            unitary.heating_lift = HEAT_PUMP_LIFT;
        }
        to_json(&parameters)
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
