//! The response check of a building in one season.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::{Actuator, Quantity};

use super::heat::{heated_zones, judge_heat};
use super::hold::{Hold, heat_hold};
use super::reading::Reading;
use super::report::{Level, Limit, Row, Season, Verdict};
use crate::Result;
use crate::env::Env;

/// Steps of a hold; the first lets the system settle.
const HOLD_STEPS: usize = 9;
/// Steps added to probe a miss at the end of a hold.
const PROBE_STEPS: usize = 2;
/// Steps of a heating setpoint hold.
const HEAT_STEPS: usize = 24;

/// A building under test in one season.
pub(super) struct Bench<'a> {
    pub(super) env: Env,
    pub(super) building: &'a PreparedBuilding,
    pub(super) season: Season,
    /// Month of its days, from 0.
    pub(super) month: usize,
    pub(super) readings: Vec<Reading>,
}

impl Bench<'_> {
    /// Holds the commands and records the responses. A supply air temperature that misses its command, but not because
    /// of a limit, is tested again with the other actuators at constant commands, because coils that share a plant
    /// affect each other while all are probed.
    pub(super) fn hold(&mut self, hold: &Hold) -> Result<()> {
        let mut readings = self.respond(hold, &hold.tested)?;
        if hold.tested.len() > 1 {
            for (reading, tested) in readings.iter_mut().zip(&hold.tested) {
                if reading.row.quantity == Quantity::SupplyAirTemperature && reading.judge() == Verdict::Fails
                {
                    *reading = self.respond(hold, std::slice::from_ref(tested))?.remove(0);
                }
            }
        }
        self.readings.append(&mut readings);
        Ok(())
    }

    /// Returns the responses of the tested actuators to the commands of a hold.
    fn respond(&mut self, hold: &Hold, tested: &[(usize, Level)]) -> Result<Vec<Reading>> {
        let actuators: Vec<_> = self.building.actuators().collect();
        let reading =
            |(i, level): &(usize, Level)| Reading::new(actuators[*i], self.season, hold.condition, *level);
        let mut readings: Vec<_> = tested.iter().map(reading).collect();
        let mut action = hold.action.clone();
        for step in 0..HOLD_STEPS + PROBE_STEPS {
            if step >= HOLD_STEPS && readings.iter().all(Reading::is_settled) {
                break;
            }
            for ((i, _), reading) in tested.iter().zip(&readings) {
                action[*i] = reading.nearer.unwrap_or(reading.row.command);
            }
            self.env.step(&action)?;
            for ((i, _), reading) in tested.iter().zip(&mut readings) {
                if (1..HOLD_STEPS).contains(&step) || !reading.is_settled() {
                    reading.see(actuators[*i], self.effect(*i, actuators[*i]));
                }
            }
        }
        for ((i, _), reading) in tested.iter().zip(&mut readings) {
            reading.limit = reading.coil_limit().or(self.flow_limit(*i, reading));
        }
        Ok(readings)
    }

    /// Returns the controlled quantity of an actuator, in the unit of its command.
    fn effect(&self, i: usize, actuator: &Actuator) -> f64 {
        self.env.effect(i).unwrap_or(f64::NAN) / actuator.effect_scale
    }

    /// Returns the limit of its system's shared flow that an actuator has reached, if any.
    fn flow_limit(&self, i: usize, reading: &Reading) -> Option<Limit> {
        let (system, layout) =
            self.building.laid_out_systems().find(|(_, layout)| layout.actions.contains(&i))?;
        let shared = system.shared_flow()?;
        let effect = |index: usize| self.env.effect(index).unwrap_or(f64::NAN);
        let actuators = layout.actions.clone().zip(system.actuators());
        let dampers = actuators.filter(|(_, actuator)| actuator.quantity == Quantity::DamperOpening);
        let supplied: f64 = dampers.map(|(index, _)| effect(index)).sum();
        let command = reading.row.command;
        match reading.row.quantity {
            Quantity::DamperOpening => {
                damper_limit(command, reading.last, supplied, shared.fan).then_some(Limit::Fan)
            }
            Quantity::OutdoorAirFlow => outdoor_limit(command, effect(i), supplied, shared.exhaust),
            _ => None,
        }
    }

    /// Raises and lowers the heating setpoints, and evaluates heat and zone temperature.
    pub(super) fn heat(&mut self) -> Result<Vec<Row>> {
        const LEVELS: [Level; 5] = [Level::Low, Level::Middle, Level::Low, Level::High, Level::Low];
        let zones = heated_zones(self.building);
        let actuators: Vec<_> = self.building.actuators().collect();
        let mut rows: Vec<Vec<Row>> = Vec::new();
        for level in LEVELS {
            let hold = heat_hold(self.building, level);
            let read =
                |&(i, _): &(usize, usize)| Reading::new(actuators[i], self.season, hold.condition, level);
            let mut readings: Vec<_> = zones.iter().map(read).collect();
            for _ in 0..HEAT_STEPS {
                let step = self.env.step(&hold.action)?;
                for (&(i, slot), reading) in zones.iter().zip(&mut readings) {
                    reading.add(actuators[i], step.observation[slot]);
                }
            }
            let ended = |(&(i, _), reading): (&(usize, usize), Reading)| {
                let heat = self.env.heat(i);
                Row {
                    mean: reading.last,
                    heat,
                    error: (reading.last - reading.row.command).abs(),
                    ..reading.row
                }
            };
            rows.push(zones.iter().zip(readings).map(ended).collect());
        }
        Ok((0..zones.len())
            .flat_map(|zone| judge_heat([0, 1, 2, 3, 4].map(|hold| &rows[hold][zone])))
            .collect())
    }
}

fn reaches(flow: f64, limit: f64, tolerance: f64) -> bool {
    (flow / limit - 1.0).abs() <= tolerance
}

/// Returns whether a damper gets less than its command because the fan is at its design flow.
fn damper_limit(command: f64, flow: f64, supplied: f64, fan_flow: f64) -> bool {
    flow < command && reaches(supplied, fan_flow, 0.01)
}

/// Returns the limit that prevents the outdoor air of a loop from following its command: the supply flow if more was
/// commanded, exhaust fans if less.
fn outdoor_limit(command: f64, outdoor: f64, supplied: f64, exhaust_flow: f64) -> Option<Limit> {
    let is_all = outdoor < command && reaches(outdoor, supplied, 0.02);
    let makes_up = outdoor > command && outdoor <= 1.02 * exhaust_flow;
    is_all.then_some(Limit::SupplyFlow).or(makes_up.then_some(Limit::Exhaust))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flow_limit_excuses_only_commands_beyond_it() {
        assert!(damper_limit(0.5, 0.4, 1.0, 1.0));
        assert!(!damper_limit(0.3, 0.4, 1.0, 1.0), "less was commanded");
        assert!(!damper_limit(0.5, 0.4, 0.8, 1.0), "the fan has flow left");
        assert_eq!(outdoor_limit(0.9, 0.7, 0.7, 0.0), Some(Limit::SupplyFlow));
        assert_eq!(outdoor_limit(0.5, 0.7, 0.7, 0.0), None, "less was commanded");
        assert_eq!(outdoor_limit(0.5, 0.7, 0.7, 0.7), Some(Limit::Exhaust));
        assert_eq!(outdoor_limit(0.9, 0.7, 1.0, 0.7), None, "more was commanded");
    }
}
