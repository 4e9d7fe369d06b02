//! One temperature day and night: the reactive controllers with a constant target, whatever the task asks for.

use std::collections::BTreeMap;

use b2b_building::{Parameter, PreparedBuilding};
use b2b_env::{Target, Task};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::kind::{self, AnyController, Case};
use crate::{Error, Reactive, ReactiveParameters, Result};

/// The temperature that is held.
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
    /// Returns the middle of a usual comfort band, 21 to 24 °C.
    fn with(reactive: ReactiveParameters) -> Self {
        Self { target: 22.5, reactive }
    }

    fn to_json(&self) -> Value {
        serde_json::to_value(self).expect("plain numbers always serialize")
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
        Parameters::with(ReactiveParameters::default()).to_json()
    }

    fn tuned(&self, building: &PreparedBuilding, task: &Task) -> Value {
        Parameters::with(ReactiveParameters::tuned_for(building, task)).to_json()
    }

    fn changed(&self, values: Value, changes: &BTreeMap<String, f64>) -> Result<Value> {
        let read = serde_json::from_value::<Parameters>(values);
        let mut parameters = read.map_err(|error| Error::Values { why: error.to_string() })?;
        for (name, value) in changes {
            if name != TARGET.name {
                let (controller, known) = (self.name(), vec![TARGET.name]);
                return Err(Error::UnknownParameter { controller, name: name.clone(), known });
            }
            TARGET.check(*value)?;
            parameters.target = *value;
        }
        Ok(parameters.to_json())
    }

    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>> {
        let Parameters { target, reactive } = kind::values(case)?;
        Ok(Box::new(Reactive::at(Target::Always(target), case.spaces, &reactive)))
    }
}
