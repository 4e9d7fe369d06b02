//! Control of a unitary system: a PI loop stages supply air temperature and air flow, and trim-and-respond resets the
//! supply air temperature.

use b2b_building::hvac::{self, Actuator};
use serde::{Deserialize, Serialize};

use super::pi::{Gains, Pi};
use super::trim_respond::{Request, TrimRespond};
use super::zone::ZoneSlots;

/// Parameters of the controller of a unitary system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct UnitaryParameters {
    /// Gains from temperature error to demand: −1 is full cooling, 1 full heating.
    pub gains: Gains,
    /// Error beyond target required to change between heating and cooling, K; 0 to 2.
    pub deadband: f64,
    /// Change of the target within a step that resets the integral term, K; 0.1 to 50.
    pub restart_jump: f64,
    /// Share of the demand met by the supply air temperature at minimum flow, before the flow increases; 0.05 to 0.95.
    /// Without it the supply air temperature would jump whenever the demand changes sign.
    pub temperature_share: f64,
    /// Minimum air flow, as a fraction of the design flow; 0 to 1.
    pub min_flow: f64,
    /// Supply air temperature in heating without reset, K above target; 0 to 30.
    pub heating_lift: f64,
    /// Supply air temperature in cooling without reset, K below target; 0 to 15.
    pub cooling_drop: f64,
    /// Trim-and-respond reset of these supply air temperatures.
    pub trim_respond: TrimRespond,
}

impl Default for UnitaryParameters {
    fn default() -> Self {
        Self {
            gains: Gains { proportional: 0.2, integral: 1.0 },
            deadband: 0.02,
            restart_jump: 0.5,
            temperature_share: 0.5,
            min_flow: 0.5,
            heating_lift: 10.0,
            cooling_drop: 6.0,
            trim_respond: TrimRespond {
                respond: 10.0,
                max_requests: 1.0,
                trim: 10.0,
                threshold: 0.7,
                hysteresis: 0.0,
                ignored_requests: 0.0,
            },
        }
    }
}

/// Operating mode of the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Heating,
    Cooling,
}

/// The controller of a unitary system.
#[derive(Clone, Debug)]
pub(super) struct Unitary {
    parameters: UnitaryParameters,
    slots: ZoneSlots,
    hours: f64,
    flow: f64,
    supply: (f64, f64),
    demand: Pi,
    mode: Option<Mode>,
    /// Reset of the supply air temperature in heating and in cooling, K.
    reset: [f64; 2],
    /// Requests of the zone in heating and in cooling.
    requests: [Request; 2],
}

impl Unitary {
    pub(super) fn new(
        [flow, supply_temperature]: [&Actuator; 2],
        slots: ZoneSlots,
        hours: f64,
        parameters: &UnitaryParameters,
    ) -> Self {
        Self {
            slots,
            hours,
            flow: flow.high,
            supply: (supply_temperature.low, supply_temperature.high),
            demand: Pi::new(parameters.gains, [-1.0, 1.0], hours, parameters.restart_jump),
            mode: None,
            reset: [0.0; 2],
            requests: [Request::default(); 2],
            parameters: parameters.clone(),
        }
    }

    pub(super) fn reset(&mut self) {
        self.demand.reset();
        self.mode = None;
        self.reset = [0.0; 2];
        self.requests = [Request::default(); 2];
    }

    pub(super) fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        let target = self.slots.target.of(observation);
        let error = target - observation[self.slots.temperature];
        let demand = self.demand(error, target);
        let parameters = &self.parameters;
        let (low, high) = self.supply;
        // With extreme targets there is no room left for a reset.
        let max_heating_reset = (high - target - parameters.heating_lift).max(0.0);
        let max_cooling_reset = (target - parameters.cooling_drop - low).max(0.0);
        let rule = &parameters.trim_respond;
        for (side, sign, max_reset) in [(0, 1.0, max_heating_reset), (1, -1.0, max_cooling_reset)] {
            let requests = self.requests[side].count(rule, sign * demand, sign * error);
            self.reset[side] = rule.step(self.reset[side], requests, self.hours, max_reset);
        }
        let offset = match demand >= 0.0 {
            true => parameters.heating_lift + self.reset[0],
            false => -parameters.cooling_drop - self.reset[1],
        };
        let split = parameters.temperature_share;
        let by_temperature = (demand.abs() / split).min(1.0);
        let by_flow = ((demand.abs() - split) / (1.0 - split)).max(0.0);
        action[hvac::Unitary::FLOW] =
            self.flow * (parameters.min_flow + (1.0 - parameters.min_flow) * by_flow);
        action[hvac::Unitary::SUPPLY_TEMPERATURE] = (target + offset * by_temperature).clamp(low, high);
    }

    /// Returns the demand, from −1 for full cooling to 1 for full heating. Within the deadband the current mode ends
    /// and the other does not start.
    fn demand(&mut self, error: f64, target: f64) -> f64 {
        let demand = self.demand.step(error, target);
        let wanted = if demand >= 0.0 { Mode::Heating } else { Mode::Cooling };
        let unchanged = self.mode.is_none_or(|mode| mode == wanted);
        if unchanged || error.abs() >= self.parameters.deadband {
            self.mode = Some(wanted);
            return demand;
        }
        self.demand.hold(0.0);
        0.0
    }
}
