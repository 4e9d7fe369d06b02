//! The engine's warm-up under a small fixed controller, which each system defines
//! ([`System::warm_up`](b2b_building::hvac::System::warm_up)).
//!
//! It is part of the definition of an environment: every episode starts near its target, the same for every agent.
//! With idle systems, zones drift to 30 °C and the warm-up of EnergyPlus does not converge.

use std::sync::Arc;

use b2b_building::PreparedBuilding;
use b2b_building::hvac::ZoneState;
use b2b_energyplus::Event;

use super::Env;
use super::engine::Engine;
use super::observe::zone_step;
use crate::Result;
use crate::reward::ZoneStep;
use crate::setpoints::calendar::Moment;

impl Env {
    /// Repeats the first day until the engine reports convergence.
    ///
    /// No actuator is set before the first step, because a terminal takes its minimum flow from its flow schedule at
    /// the start of the run, which is 0 in the prepared model.
    pub(super) fn warm_up(&mut self, engine: &mut Engine) -> Result<()> {
        let spaces = Arc::clone(&self.spaces);
        let first_day = self.moment().day_of_year;
        loop {
            match engine.simulation.advance()? {
                Some(Event::WarmupStep) => {
                    let hour = engine.simulation.clock().hour_of_day % 24.0;
                    let moment = Moment { day_of_year: first_day, hour };
                    self.zone_steps.clear();
                    for (index, zone) in self.zones.iter().enumerate() {
                        let asked = self.targets.at(index, moment, engine.occupied(index));
                        let temperature = engine.simulation.read(engine.temperatures[zone.slot]);
                        self.zone_steps.push(zone_step(temperature, asked, zone));
                    }
                    act(&spaces.building, &self.zone_steps, &mut self.action);
                    self.ventilate(engine);
                    engine.act(&self.action);
                }
                Some(Event::WarmedUp) => return Ok(()),
                _ => return Err(self.wrong_length()),
            }
        }
    }
}

/// Writes the action of the warm-up controller, given the controlled zones in model order.
fn act(building: &PreparedBuilding, zones: &[ZoneStep], action: &mut [f64]) {
    for (system, layout) in building.laid_out_systems() {
        let state = |zone: usize| {
            let ZoneStep { temperature, target, .. } = zones[layout.zones[zone].controlled];
            ZoneState { temperature, target }
        };
        system.warm_up(&state, &mut action[layout.actions.clone()]);
    }
}
