//! Control of a central air loop: dampers cool, reheat heats, trim-and-respond resets the supply air temperature, and
//! an economizer mixes outdoor air.

use b2b_building::hvac;
use serde::{Deserialize, Serialize};

use super::pi::{Gains, Pi};
use super::trim_respond::{Request, TrimRespond};
use super::zone::ZoneSlots;

/// Parameters of the controller of a central air loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AirLoopParameters {
    /// Gains from temperature error to damper opening.
    pub gains: Gains,
    /// Change of a zone's target within a step that resets the integral term of its loop, K; 0.1 to 50.
    pub restart_jump: f64,
    /// Minimum damper opening; 0 to 1.
    pub min_opening: f64,
    /// Maximum supply air temperature, °C; 10 to 30.
    pub max_supply_temperature: f64,
    /// Minimum supply air temperature, °C; 5 to 20, and at most the maximum.
    pub min_supply_temperature: f64,
    /// Reset of the supply air temperature from maximum toward minimum by the cooling requests of the zones.
    pub trim_respond: TrimRespond,
    /// Minimum outdoor air fraction of the supply air; 0 to 1.
    pub min_outdoor_air: f64,
    /// Temperature rise across the fan, K, by which the mixed air is kept below the supply air; 0 to 5.
    pub fan_rise: f64,
    /// Distance of the reheat setpoint below target, K; 0 to 2. At 0, reheat holds the target exactly, the damper loops
    /// see no error, and a zone may be cooled and reheated at once indefinitely.
    pub deadband: f64,
    /// Damper opening in heating per K below target, as a share of the range from minimum to open, because the reheat
    /// coil needs air flow, 1/K. The larger of this and the cooling demand counts; 0 to 10.
    pub heating_gain: f64,
}

impl Default for AirLoopParameters {
    fn default() -> Self {
        Self {
            gains: Gains { proportional: 0.6, integral: 2.4 },
            restart_jump: 0.5,
            min_opening: 0.1,
            max_supply_temperature: 18.0,
            min_supply_temperature: 10.0,
            trim_respond: TrimRespond {
                respond: 6.0,
                max_requests: 3.0,
                trim: 4.0,
                threshold: 0.7,
                hysteresis: 0.1,
                ignored_requests: 0.0,
            },
            min_outdoor_air: 0.15,
            fan_rise: 1.5,
            deadband: 0.05,
            heating_gain: 0.5,
        }
    }
}

/// The controller of a central air loop.
#[derive(Clone, Debug)]
pub(super) struct AirLoop {
    parameters: AirLoopParameters,
    /// Slot of the outdoor temperature.
    outdoor: usize,
    hours: f64,
    fan_flow: f64,
    terminals: Vec<Terminal>,
    /// Reset of the supply air temperature below its maximum, K.
    reset: f64,
}

/// The controller of a terminal.
#[derive(Clone, Debug)]
struct Terminal {
    slots: ZoneSlots,
    /// Number of the actuator of its damper.
    damper: usize,
    /// Number of the actuator of its reheat setpoint.
    coil: Option<usize>,
    design_flow: f64,
    /// Largest useful opening in heating.
    heating_opening: f64,
    cooling: Pi,
    request: Request,
    /// Its last reheat setpoint, °C.
    reheat: f64,
    /// Amount by which the setpoint in use exceeds it, K.
    raised: f64,
}

impl AirLoop {
    pub(super) fn new(
        air_loop: &hvac::AirLoop,
        zones: impl Iterator<Item = ZoneSlots>,
        outdoor: usize,
        hours: f64,
        parameters: &AirLoopParameters,
    ) -> Self {
        let terminals = air_loop.terminals.iter().zip(air_loop.of_terminals()).zip(zones);
        let terminals = terminals.map(|((terminal, (damper, coil)), slots)| Terminal {
            slots,
            damper,
            coil,
            design_flow: terminal.design_flow,
            heating_opening: terminal.heating_opening,
            cooling: Pi::new(parameters.gains, [0.0, 1.0], hours, parameters.restart_jump),
            request: Request::default(),
            reheat: 0.0,
            raised: 0.0,
        });
        Self {
            parameters: parameters.clone(),
            outdoor,
            hours,
            fan_flow: air_loop.fan_flow,
            terminals: terminals.collect(),
            reset: 0.0,
        }
    }

    pub(super) fn reset(&mut self) {
        self.reset = 0.0;
        for terminal in &mut self.terminals {
            terminal.cooling.reset();
            terminal.request = Request::default();
            terminal.raised = 0.0;
        }
    }

    /// Records the action that was used instead of the last one.
    pub(super) fn follow(&mut self, used: &[f64]) {
        for terminal in &mut self.terminals {
            terminal.raised = terminal.coil.map_or(0.0, |coil| (used[coil] - terminal.reheat).max(0.0));
        }
    }

    pub(super) fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        let mut flow = 0.0;
        let mut heat = 0.0;
        let mut requests = 0.0;
        let rule = &self.parameters.trim_respond;
        for terminal in &mut self.terminals {
            let (temperature, target) =
                (observation[terminal.slots.temperature], terminal.slots.target.of(observation));
            let error = temperature - target;
            // The cooling setpoint stays a deadband above the reheat setpoint.
            let excess = error - terminal.raised;
            let demand = terminal.cooling.step(excess, target);
            requests += terminal.request.count(rule, demand, excess);
            let min_opening = self.parameters.min_opening;
            let heating = (self.parameters.heating_gain * -error).clamp(0.0, terminal.heating_opening);
            let opening = min_opening + (1.0 - min_opening) * demand.max(heating);
            action[terminal.damper] = opening;
            terminal.reheat = target - self.parameters.deadband;
            if let Some(coil) = terminal.coil {
                action[coil] = terminal.reheat;
            }
            flow += opening * terminal.design_flow;
            heat += opening * terminal.design_flow * temperature;
        }
        let range = self.parameters.max_supply_temperature - self.parameters.min_supply_temperature;
        self.reset = rule.step(self.reset, requests, self.hours, range);
        let supply = self.parameters.max_supply_temperature - self.reset;
        action[hvac::AirLoop::SUPPLY_TEMPERATURE] = supply;
        // With all dampers closed, no air is mixed.
        let return_air = if flow > 0.0 { heat / flow } else { supply };
        action[hvac::AirLoop::OUTDOOR_AIR] =
            self.outdoor_air(flow.min(self.fan_flow), return_air, observation, supply);
    }

    /// Returns the outdoor air flow of the economizer, kg/s: the flow that mixes with return air (°C) to the supply air
    /// temperature if outdoor air is colder than return air, otherwise the minimum.
    fn outdoor_air(&self, flow: f64, return_air: f64, observation: &[f64], supply: f64) -> f64 {
        let outdoor = observation[self.outdoor];
        let mixed = supply - self.parameters.fan_rise;
        let share = if outdoor >= return_air {
            0.0
        } else if outdoor >= mixed {
            1.0
        } else {
            (return_air - mixed) / (return_air - outdoor)
        };
        flow * share.clamp(self.parameters.min_outdoor_air, 1.0)
    }
}
