//! The engine's warm-up under a small fixed controller.

use std::sync::Arc;

use b2b_energyplus::Event;

use super::Env;
use super::engine::Engine;
use crate::Result;
use crate::calendar::Moment;
use crate::reward::ZoneStep;
use crate::warmup;

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
                        let (occupied, target) = self.targets.at(index, moment, engine.occupied(index));
                        let temperature = engine.simulation.read(engine.temperatures[zone.slot]);
                        let penalize_above_target = zone.penalize_above_target;
                        self.zone_steps.push(ZoneStep {
                            temperature,
                            target,
                            occupied,
                            penalize_above_target,
                        });
                    }
                    warmup::act(&spaces.building, &self.zone_steps, &mut self.action);
                    self.ventilate(engine);
                    engine.act(&self.action);
                }
                Some(Event::WarmedUp) => return Ok(()),
                _ => return Err(self.wrong_length()),
            }
        }
    }
}
