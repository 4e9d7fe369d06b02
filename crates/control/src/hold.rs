//! One temperature day and night: the reactive controllers with a constant target, regardless of the task.

use std::collections::BTreeMap;

use b2b_building::{Parameter, PreparedBuilding};
use b2b_env::{Target, Task};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::kind::{self, AnyController, Case};
use crate::parameter_set::{from_json, to_json};
use crate::{Error, Reactive, ReactiveParameters, Result};

/// The temperature to hold.
const TARGET: Parameter = Parameter::new("target", "°C", 15.0, 30.0);

/// The kind `hold`.
pub(crate) struct Kind;

/// The temperature, and the parameters of the reactive controllers.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Parameters {
    /// °C.
    target: f64,
    reactive: ReactiveParameters,
}

impl Parameters {
    /// Returns parameters with the middle of a usual comfort band, 21 to 24 °C, as the target.
    fn with(reactive: ReactiveParameters) -> Self {
        Self { target: 22.5, reactive }
    }
}

impl kind::Kind for Kind {
    fn name(&self) -> &'static str {
        "hold"
    }

    fn help(&self) -> &'static str {
        "reactive controllers that hold one temperature day and night"
    }

    fn controls_whole_building(&self) -> bool {
        true
    }

    fn parameters(&self) -> Vec<Parameter> {
        vec![TARGET]
    }

    fn defaults(&self) -> Value {
        to_json(&Parameters::with(ReactiveParameters::default()))
    }

    fn tuned(&self, building: &PreparedBuilding, task: &Task) -> Value {
        to_json(&Parameters::with(ReactiveParameters::tuned_for(building, task)))
    }

    fn changed(&self, values: Value, changes: &BTreeMap<String, f64>) -> Result<Value> {
        let mut parameters: Parameters = from_json(&values)?;
        for (name, value) in changes {
            if name != TARGET.name {
                let (controller, known) = (self.name(), vec![TARGET.name]);
                return Err(Error::UnknownParameter { controller, name: name.clone(), known });
            }
            TARGET.check(*value)?;
            parameters.target = *value;
        }
        Ok(to_json(&parameters))
    }

    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>> {
        let Parameters { target, reactive } = kind::values(case)?;
        Ok(Box::new(Reactive::at(Target::Always(target), case.spaces, &reactive)))
    }
}
