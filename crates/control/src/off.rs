//! Everything off: a building without heating, cooling and ventilation.

use std::ops::Range;

use b2b_building::hvac::Quantity;
use b2b_env::{ActionSpace, ObservationSpace};

use crate::kind::{self, AnyController, Case};
use crate::{Controller, Result};

/// Closes dampers, stops fans, and sets thermostats to their lowest heating and highest cooling setpoints. Outdoor air
/// that the task requires for people passes unconditioned: the supply air temperature follows the outdoor temperature
/// within its bounds.
#[derive(Clone, Debug)]
pub struct Off {
    low: Vec<f64>,
    /// Cooling setpoints: index, and upper bound.
    cooling: Vec<(usize, f64)>,
    /// Supply air temperatures: index, and bounds.
    supply: Vec<(usize, [f64; 2])>,
    outdoor_temperature: usize,
}

impl Off {
    /// Creates the controller of the actuators of a space.
    pub fn new(action: &ActionSpace, observation: &ObservationSpace) -> Self {
        let all: Range<usize> = 0..action.len();
        let is_supply = |index: &usize| action.quantities()[*index] == Quantity::SupplyAirTemperature;
        let is_cooling = |index: &usize| action.quantities()[*index] == Quantity::CoolingSetpoint;
        let bounds = |index: usize| (index, [action.low()[index], action.high()[index]]);
        Self {
            low: action.low().to_vec(),
            cooling: all.clone().filter(is_cooling).map(|index| (index, action.high()[index])).collect(),
            supply: all.filter(is_supply).map(bounds).collect(),
            outdoor_temperature: observation.outdoor_temperature(),
        }
    }
}

impl Controller for Off {
    fn reset(&mut self) {}

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        action.copy_from_slice(&self.low);
        for (index, high) in &self.cooling {
            action[*index] = *high;
        }
        let outdoor = observation[self.outdoor_temperature];
        for (index, [low, high]) in &self.supply {
            action[*index] = outdoor.clamp(*low, *high);
        }
    }
}

/// The kind `off`.
pub(crate) struct Kind;

impl kind::Kind for Kind {
    fn name(&self) -> &'static str {
        "off"
    }

    fn help(&self) -> &'static str {
        "everything off: the least energy"
    }

    fn controls_whole_building(&self) -> bool {
        true
    }

    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>> {
        Ok(Box::new(Off::new(&case.spaces.action, &case.spaces.observation)))
    }
}
