//! A unitary system: the zone's error drives the flow, and lasting demand the supply temperature.

use b2b_building::hvac;
use serde::{Deserialize, Serialize};

use super::ZoneSlots;
use super::pi::{Gains, Pi};
use super::trim_respond::{Request, TrimRespond};

/// Parameters of the controller of a unitary system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct UnitaryParameters {
    /// Demand per K of error: −1 is full cooling, 1 full heating.
    pub gains: Gains,
    /// Between heating and cooling the error has to pass the target by this much, K; 0 to 2.
    pub deadband: f64,
    /// Change of the target within a step that makes the loop start anew, K; 0.1 to 50.
    pub restart_jump: f64,
    /// Share of the demand that the supply temperature meets at least flow before the flow rises; 0.05 to 0.95.
    /// Without it the supply would jump between heating and cooling whenever the demand crosses zero.
    pub temperature_share: f64,
    /// Least flow, as a share of the design flow; 0 to 1.
    pub least_flow: f64,
    /// Supply temperature in heating without push, K above target; 0 to 30.
    pub heating_lift: f64,
    /// Supply temperature in cooling without push, K below target; 0 to 15.
    pub cooling_drop: f64,
    /// How the supply temperature is pushed away from there.
    pub trim_respond: TrimRespond,
}

impl Default for UnitaryParameters {
    fn default() -> Self {
        Self {
            gains: Gains { proportional: 0.2, integral: 1.0 },
            deadband: 0.02,
            restart_jump: 0.5,
            temperature_share: 0.5,
            least_flow: 0.5,
            heating_lift: 10.0,
            cooling_drop: 6.0,
            trim_respond: TrimRespond {
                respond: 10.0,
                most_requests: 1.0,
                trim: 10.0,
                threshold: 0.7,
                release: 0.0,
                ignored: 0.0,
            },
        }
    }
}

/// What a system does for its zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Regime {
    Heating,
    Cooling,
}

#[derive(Clone, Debug)]
pub(super) struct Unitary {
    parameters: UnitaryParameters,
    slots: ZoneSlots,
    hours: f64,
    flow: f64,
    supply: (f64, f64),
    demand: Pi,
    regime: Option<Regime>,
    /// Push of the supply temperature in heating and in cooling, K.
    push: [f64; 2],
    /// What the zone asks for, in heating and in cooling.
    requests: [Request; 2],
}

impl Unitary {
    pub(super) fn new(
        unit: &hvac::Unitary,
        slots: ZoneSlots,
        hours: f64,
        parameters: &UnitaryParameters,
    ) -> Self {
        Self {
            slots,
            hours,
            flow: unit.flow.high,
            supply: (unit.supply_temperature.low, unit.supply_temperature.high),
            demand: Pi::new(parameters.gains, [-1.0, 1.0], hours, parameters.restart_jump),
            regime: None,
            push: [0.0; 2],
            requests: [Request::default(); 2],
            parameters: parameters.clone(),
        }
    }

    pub(super) fn reset(&mut self) {
        self.demand.reset();
        self.regime = None;
        self.push = [0.0; 2];
        self.requests = [Request::default(); 2];
    }

    pub(super) fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        let target = self.slots.target.of(observation);
        let error = target - observation[self.slots.temperature];
        let demand = self.demand(error, target);
        let parameters = &self.parameters;
        let (low, high) = self.supply;
        // Far targets leave the supply no room to be pushed.
        let warmest = (high - target - parameters.heating_lift).max(0.0);
        let coldest = (target - parameters.cooling_drop - low).max(0.0);
        let rule = &parameters.trim_respond;
        for (side, sign, room) in [(0, 1.0, warmest), (1, -1.0, coldest)] {
            let requests = self.requests[side].count(rule, sign * demand, sign * error);
            self.push[side] = rule.step(self.push[side], requests, self.hours, room);
        }
        let offset = match demand >= 0.0 {
            true => parameters.heating_lift + self.push[0],
            false => -parameters.cooling_drop - self.push[1],
        };
        let split = parameters.temperature_share;
        let by_temperature = (demand.abs() / split).min(1.0);
        let by_flow = ((demand.abs() - split) / (1.0 - split)).max(0.0);
        action[0] = self.flow * (parameters.least_flow + (1.0 - parameters.least_flow) * by_flow);
        action[1] = (target + offset * by_temperature).clamp(low, high);
    }

    /// From full cooling, −1, to full heating, 1. Within the deadband what is done ends, and the contrary does not
    /// begin.
    fn demand(&mut self, error: f64, target: f64) -> f64 {
        let demand = self.demand.step(error, target);
        let wanted = if demand >= 0.0 { Regime::Heating } else { Regime::Cooling };
        let stays = self.regime.is_none_or(|regime| regime == wanted);
        if stays || error.abs() >= self.parameters.deadband {
            self.regime = Some(wanted);
            return demand;
        }
        self.demand.hold(0.0);
        0.0
    }
}
