//! The model's own controls, run by the engine.

use b2b_building::Controls;

use crate::kind::{self, AnyController, Case};
use crate::{Controller, Error, Result};

/// Revision of the controls of generated buildings. 2: the load of a thermostat includes the air that makes up for
/// exhaust fans.
const REVISION: u32 = 2;

/// Does nothing, in a building under its own controls.
#[derive(Clone, Debug)]
pub struct Own;

impl Controller for Own {
    fn reset(&mut self) {}

    fn act(&mut self, _observation: &[f64], _action: &mut [f64]) {}
}

/// The kind `own`.
pub(crate) struct Kind;

impl kind::Kind for Kind {
    fn name(&self) -> &'static str {
        "own"
    }

    fn help(&self) -> &'static str {
        "the model's own thermostats and schedules, run by the engine"
    }

    fn identity(&self) -> String {
        format!("{}#{REVISION}", self.name())
    }

    fn controls(&self) -> Controls {
        Controls::Own
    }

    fn controls_whole_building(&self) -> bool {
        true
    }

    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>> {
        let task = &case.spaces.episode.task;
        if !task.faults.is_none() {
            return Err(Error::FaultsWithoutEffect { task: task.to_string() });
        }
        match case.action.len() {
            0 => Ok(Box::new(Own)),
            actuators => Err(Error::OwnControls { building: case.spaces.building.name.clone(), actuators }),
        }
    }
}
