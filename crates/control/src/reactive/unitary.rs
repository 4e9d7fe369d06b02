//! A unitary system: the zone's error drives the flow, and lasting demand the supply temperature.

use b2b_building::hvac;

use super::ZoneSlots;
use super::pi::{Gains, Pi};
use super::trim_respond::TrimRespond;

/// Parameters of the controller of a unitary system.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitaryParameters {
    /// Demand per K of error: −1 is full cooling, 1 full heating.
    pub gains: Gains,
    /// Share of the demand that the supply temperature meets at least flow before the flow rises, in (0, 1).
    /// Without it the supply would jump between heating and cooling whenever the demand crosses zero.
    pub temperature_share: f64,
    /// Least flow, as a share of the design flow.
    pub least_flow: f64,
    /// Supply temperature in heating without push, K above target.
    pub heating_lift: f64,
    /// Supply temperature in cooling without push, K below target.
    pub cooling_drop: f64,
    /// How the supply temperature is pushed away from there.
    pub trim_respond: TrimRespond,
}

impl Default for UnitaryParameters {
    fn default() -> Self {
        Self {
            gains: Gains { proportional: 0.2, integral: 1.0 },
            temperature_share: 0.5,
            least_flow: 0.5,
            heating_lift: 10.0,
            cooling_drop: 6.0,
            trim_respond: TrimRespond { respond: 10.0, trim: 10.0, threshold: 0.7 },
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Unitary {
    parameters: UnitaryParameters,
    slots: ZoneSlots,
    hours: f64,
    flow: f64,
    supply: (f64, f64),
    demand: Pi,
    /// Push of the supply temperature in heating and in cooling, K.
    push: [f64; 2],
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
            demand: Pi::new(parameters.gains, -1.0, 1.0, hours),
            push: [0.0; 2],
            parameters: parameters.clone(),
        }
    }

    pub(super) fn reset(&mut self) {
        self.demand.reset();
        self.push = [0.0; 2];
    }

    pub(super) fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        let target = self.slots.target.of(observation);
        let demand = self.demand.step(target - observation[self.slots.temperature]);
        let parameters = &self.parameters;
        let (low, high) = self.supply;
        // Far targets leave the supply no room to be pushed.
        let warmest = (high - target - parameters.heating_lift).max(0.0);
        let coldest = (target - parameters.cooling_drop - low).max(0.0);
        let rule = &parameters.trim_respond;
        self.push[0] = rule.step(self.push[0], demand, self.hours, warmest);
        self.push[1] = rule.step(self.push[1], -demand, self.hours, coldest);
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
}
