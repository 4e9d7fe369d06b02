//! A central air loop: dampers cool, reheat heats, and the supply temperature follows the warmest zones.

use b2b_building::hvac;
use serde::{Deserialize, Serialize};

use super::ZoneSlots;
use super::pi::{Gains, Pi};
use super::trim_respond::{Request, TrimRespond};

/// Parameters of the controller of a central air loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AirLoopParameters {
    /// Damper opening per K of error.
    pub gains: Gains,
    /// Change of a zone's target within a step that makes its loop start anew, K; 0.1 to 50.
    pub restart_jump: f64,
    /// Least opening of a damper; 0.01 to 1.
    pub least_opening: f64,
    /// Warmest supply temperature, °C; 10 to 30.
    pub warmest_supply: f64,
    /// Coldest supply temperature, °C; 5 to 20, and no warmer than the warmest.
    pub coldest_supply: f64,
    /// How the supply temperature is pushed from warmest to coldest by the requests of all zones for cooling.
    pub trim_respond: TrimRespond,
    /// Least outdoor air, as a share of the supply; 0 to 1.
    pub least_outdoor_air: f64,
    /// How much the fan warms the air, K: the mixer aims that much under the supply temperature; 0 to 5.
    pub fan_rise: f64,
    /// Reheat starts this far under target, K: without it reheat holds the target exactly, the dampers' loops see
    /// no error, and a zone may be cooled and reheated for ever; 0 to 2.
    pub deadband: f64,
    /// Opening added per K under target, 1/K: heating needs air to carry it; 0 to 10.
    pub heating_opening: f64,
}

impl Default for AirLoopParameters {
    fn default() -> Self {
        Self {
            gains: Gains { proportional: 0.6, integral: 2.4 },
            restart_jump: 0.5,
            least_opening: 0.1,
            warmest_supply: 18.0,
            coldest_supply: 10.0,
            trim_respond: TrimRespond {
                respond: 6.0,
                most_requests: 3.0,
                trim: 4.0,
                threshold: 0.7,
                release: 0.1,
                ignored: 0.0,
            },
            least_outdoor_air: 0.15,
            fan_rise: 1.5,
            deadband: 0.05,
            heating_opening: 0.5,
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct AirLoop {
    parameters: AirLoopParameters,
    /// Slot of the outdoor temperature.
    outdoor: usize,
    hours: f64,
    fan_flow: f64,
    terminals: Vec<Terminal>,
    push: f64,
}

#[derive(Clone, Debug)]
struct Terminal {
    slots: ZoneSlots,
    design_flow: f64,
    /// Opening up to which more air brings more heat.
    heating_opening: f64,
    cooling: Pi,
    request: Request,
}

impl AirLoop {
    pub(super) fn new(
        air_loop: &hvac::AirLoop,
        slots: impl Fn(&str) -> ZoneSlots,
        outdoor: usize,
        hours: f64,
        parameters: &AirLoopParameters,
    ) -> Self {
        let terminals = air_loop.terminals.iter().map(|terminal| Terminal {
            slots: slots(&terminal.zone),
            design_flow: terminal.design_flow,
            heating_opening: terminal.heating_opening,
            cooling: Pi::new(parameters.gains, [0.0, 1.0], hours, parameters.restart_jump),
            request: Request::default(),
        });
        Self {
            parameters: parameters.clone(),
            outdoor,
            hours,
            fan_flow: air_loop.fan_flow,
            terminals: terminals.collect(),
            push: 0.0,
        }
    }

    /// Number of actuators.
    pub(super) fn width(&self) -> usize {
        2 + 2 * self.terminals.len()
    }

    pub(super) fn reset(&mut self) {
        self.push = 0.0;
        for terminal in &mut self.terminals {
            terminal.cooling.reset();
            terminal.request = Request::default();
        }
    }

    pub(super) fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        let (central, boxes) = action.split_at_mut(2);
        let mut flow = 0.0;
        let mut heat = 0.0;
        let mut requests = 0.0;
        let rule = &self.parameters.trim_respond;
        for (terminal, action) in self.terminals.iter_mut().zip(boxes.chunks_exact_mut(2)) {
            let (temperature, target) =
                (observation[terminal.slots.temperature], terminal.slots.target.of(observation));
            let error = temperature - target;
            let demand = terminal.cooling.step(error, target);
            requests += terminal.request.count(rule, demand, error);
            let least = self.parameters.least_opening;
            let heating = (self.parameters.heating_opening * -error).clamp(0.0, terminal.heating_opening);
            action[0] = least + (1.0 - least) * demand.max(heating);
            action[1] = target - self.parameters.deadband;
            flow += action[0] * terminal.design_flow;
            heat += action[0] * terminal.design_flow * temperature;
        }
        let range = self.parameters.warmest_supply - self.parameters.coldest_supply;
        self.push = rule.step(self.push, requests, self.hours, range);
        central[0] = self.parameters.warmest_supply - self.push;
        central[1] = self.outdoor_air(flow.min(self.fan_flow), heat / flow, observation, central[0]);
    }

    /// Outdoor air flow, kg/s: as much as mixes with return air (°C) to the supply temperature where outdoor
    /// air helps, and the least elsewhere.
    fn outdoor_air(&self, flow: f64, return_air: f64, observation: &[f64], supply: f64) -> f64 {
        let outdoor = observation[self.outdoor];
        let mixed = supply - self.parameters.fan_rise;
        let share = match () {
            () if outdoor >= return_air => 0.0,
            () if outdoor >= mixed => 1.0,
            () => (return_air - mixed) / (return_air - outdoor),
        };
        flow * share.clamp(self.parameters.least_outdoor_air, 1.0)
    }
}
