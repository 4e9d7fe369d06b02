//! Response to the setpoints of thermostats: whether they move the temperature of their zones.

use b2b_building::hvac::zone_equipment::zone_equipment;
use b2b_building::hvac::{Actuator, Quantity};
use b2b_building::morphology::Owner;

use super::bench::Bench;
use super::heat::{AT_SETPOINT, RISE, SOME_HEAT};
use super::hold::{setpoint_hold, setpoints};
use super::reading::Reading;
use super::report::{Condition, Level, Limit, Row, Verdict};
use crate::{Error, Result};

/// Steps before the first hold, from midnight: 8 hours.
const STEPS_BEFORE: usize = 96;
/// Steps of a hold: two hours.
const STEPS: usize = 24;
/// Tests, each between two holds that call for nothing.
const TESTED: [(Quantity, Level); 2] =
    [(Quantity::HeatingSetpoint, Level::High), (Quantity::CoolingSetpoint, Level::Low)];

/// The state of the zones of all setpoints in a hold: temperature at its end (°C), and mean heat delivered or removed
/// (W). Equipment may cycle, so that a single step says little.
type State = Vec<(f64, f64)>;

/// A zone between two holds that call for nothing.
#[derive(Clone, Copy)]
struct Free {
    /// Setpoint that calls for nothing, °C.
    command: f64,
    /// Mean temperature before and after, °C.
    temperature: f64,
    /// Mean heat delivered or removed before and after, W.
    heat: f64,
    /// Whether equipment heats or cools its surfaces: that heat is not measured.
    radiates: bool,
}

impl Bench<'_> {
    /// Raises the heating setpoints and lowers the cooling setpoints of thermostats, and evaluates the zone
    /// temperatures. If the engine ends the run, every setpoint that is not tested fails with its message.
    pub(super) fn thermostats(&mut self) -> Result<Vec<Row>> {
        let mut rows = Vec::new();
        match self.test_thermostats(&mut rows) {
            Err(Error::Engine(error)) => {
                let message = error.to_string();
                self.untested(&mut rows, &message);
                Ok(rows)
            }
            tested => tested.map(|()| rows),
        }
    }

    fn test_thermostats(&mut self, rows: &mut Vec<Row>) -> Result<()> {
        let thermostats = self.setpoint_slots();
        self.settle(&thermostats, STEPS_BEFORE)?;
        let mut before = self.settle(&thermostats, STEPS)?;
        for (quantity, level) in TESTED {
            let tested = self.hold_setpoints(&thermostats, quantity, level)?;
            let after = self.settle(&thermostats, STEPS)?;
            for (number, row) in tested {
                let (index, slot) = thermostats[number];
                let zone = &self.building.zones[slot].name;
                let free = self.free(index, zone, [before[number], after[number]]);
                let verdict = match judge(&row, free) {
                    Verdict::Fails if self.building.notes.is_mostly_off(zone, self.month) => {
                        Verdict::AtCapacity(Limit::SwitchedOff)
                    }
                    other => other,
                };
                rows.push(Row { verdict, ..row });
            }
            before = after;
        }
        Ok(())
    }

    /// Returns a zone between holds that call for nothing: the mean of both.
    fn free(&self, index: usize, zone: &str, [before, after]: [(f64, f64); 2]) -> Free {
        let equipment = zone_equipment(self.building.model(), zone).unwrap_or_default();
        Free {
            command: setpoint_hold(self.building, None).action[index],
            temperature: 0.5 * (before.0 + after.0),
            heat: 0.5 * (before.1 + after.1),
            radiates: equipment.iter().any(|item| heats_surfaces(&item.class)),
        }
    }

    /// Adds a row that fails for every setpoint without one.
    fn untested(&self, rows: &mut Vec<Row>, message: &str) {
        let actuators: Vec<&Actuator> = self.building.actuators().collect();
        for (quantity, level) in TESTED {
            for (index, _) in self.setpoint_slots() {
                let row = Reading::new(actuators[index], self.season, Condition::Free, level).row;
                let is_tested = rows.iter().any(|tested| tested.actuator == row.actuator);
                if row.quantity == quantity && !is_tested {
                    rows.push(Row {
                        lowest: f64::NAN,
                        mean: f64::NAN,
                        highest: f64::NAN,
                        error: f64::NAN,
                        verdict: Verdict::Fails,
                        message: Some(message.to_owned()),
                        ..row
                    });
                }
            }
        }
    }

    /// Returns the index of each setpoint with the slot of its zone's temperature.
    fn setpoint_slots(&self) -> Vec<(usize, usize)> {
        let thermostats = setpoints(self.building);
        let owners: Vec<Owner> = self.building.owned_actuators().map(|(owner, _)| owner).collect();
        let slot = |&index: &usize| match owners[index] {
            Owner::Zone(zone) => Some((index, zone)),
            _ => None,
        };
        thermostats.iter().filter_map(slot).collect()
    }

    /// Runs some steps in which nothing is called for.
    fn settle(&mut self, thermostats: &[(usize, usize)], steps: usize) -> Result<State> {
        let hold = setpoint_hold(self.building, None);
        let mut state = vec![(0.0, 0.0); thermostats.len()];
        for _ in 0..steps {
            self.env.step(&hold.action)?;
            for ((temperature, heat), &(index, slot)) in state.iter_mut().zip(thermostats) {
                *temperature = self.env.observation()[slot];
                *heat += self.env.heat(index).unwrap_or(0.0) / steps as f64;
            }
        }
        Ok(state)
    }

    /// Holds the setpoints of one quantity at a level. Returns a row for each, with its number among the setpoints.
    fn hold_setpoints(
        &mut self,
        thermostats: &[(usize, usize)],
        quantity: Quantity,
        level: Level,
    ) -> Result<Vec<(usize, Row)>> {
        let hold = setpoint_hold(self.building, Some((quantity, level)));
        let actuators: Vec<_> = self.building.actuators().collect();
        let tested: Vec<(usize, usize, usize)> = thermostats
            .iter()
            .enumerate()
            .filter(|(_, (index, _))| actuators[*index].quantity == quantity)
            .map(|(number, &(index, slot))| (number, index, slot))
            .collect();
        let reading = |&(_, index, _): &(usize, usize, usize)| {
            Reading::new(actuators[index], self.season, Condition::Free, level)
        };
        let mut readings: Vec<Reading> = tested.iter().map(reading).collect();
        let mut heats = vec![0.0; tested.len()];
        for _ in 0..STEPS {
            self.env.step(&hold.action)?;
            for ((&(_, index, slot), reading), heat) in tested.iter().zip(&mut readings).zip(&mut heats) {
                reading.add(actuators[index], self.env.observation()[slot]);
                *heat += self.env.heat(index).unwrap_or(0.0) / STEPS as f64;
            }
        }
        let ended = |((&(number, ..), reading), heat): ((&(usize, usize, usize), Reading), f64)| {
            let error = (reading.last - reading.row.command).abs();
            (number, Row { mean: reading.last, heat: Some(heat), error, ..reading.row })
        };
        Ok(tested.iter().zip(readings).zip(heats).map(ended).collect())
    }
}

/// Returns whether equipment heats or cools the surfaces of a zone, beside its air or instead of it.
fn heats_surfaces(class: &str) -> bool {
    let class = class.to_lowercase();
    class.contains("radiant") || class.contains("slab")
}

/// A setpoint must bring more heat to its zone than when nothing calls for it, and move it toward the setpoint or hold
/// it there, unless the zone is beyond it anyway, or at it. A zone that never comes near its setpoint while it gets
/// more heat, or is short of heat also when nothing is called for, has equipment at capacity.
fn judge(row: &Row, free: Free) -> Verdict {
    let (sign, [short, idle]) = match row.quantity {
        Quantity::CoolingSetpoint => (-1.0, [Limit::Cooler, Limit::CoolZone]),
        _ => (1.0, [Limit::Heater, Limit::WarmZone]),
    };
    let (moved, missing) = (sign * (row.mean - free.temperature), sign * (row.command - row.mean));
    let works = row.heat.unwrap_or(0.0) > free.heat + SOME_HEAT;
    let is_short = sign * (free.command - free.temperature) > AT_SETPOINT && free.heat > SOME_HEAT;
    if moved > RISE && (works || free.radiates) {
        return if missing <= AT_SETPOINT { Verdict::Follows } else { Verdict::AtCapacity(short) };
    }
    match works {
        true if missing.abs() <= AT_SETPOINT => Verdict::Follows,
        true => Verdict::AtCapacity(short),
        false if missing <= AT_SETPOINT => Verdict::AtCapacity(idle),
        false if is_short => Verdict::AtCapacity(short),
        false => Verdict::Fails,
    }
}

#[cfg(test)]
mod tests {
    use b2b_building::hvac::{Actuator, EngineVariable};

    use super::super::report::Season;
    use super::*;

    /// A zone that gets nothing.
    fn free(temperature: f64) -> Free {
        Free { command: 10.0, temperature, heat: 0.0, radiates: false }
    }

    fn row(quantity: Quantity, command: f64, mean: f64, heat: f64) -> Row {
        let effect = EngineVariable::new("", "");
        let actuator = Actuator::of_schedule(String::new(), String::new(), quantity, [10.0, 30.0], effect);
        let row = Reading::new(&actuator, Season::Winter, Condition::Free, Level::High).row;
        Row { command, mean, heat: Some(heat), ..row }
    }

    #[test]
    fn a_row_without_a_tolerance_is_read_back_from_json() {
        let row = row(Quantity::CoolingSetpoint, 15.0, 22.0, 0.0);
        let text = serde_json::to_string(&Row { lowest: 20.0, highest: 23.0, ..row.clone() }).unwrap();
        let read: Row = serde_json::from_str(&text).unwrap();
        assert_eq!((read.tolerance, read.command), (f64::INFINITY, 15.0));
    }

    #[test]
    fn a_setpoint_moves_its_zone_or_its_equipment_is_at_capacity() {
        let heating = |mean, heat| judge(&row(Quantity::HeatingSetpoint, 30.0, mean, heat), free(20.0));
        assert_eq!(heating(29.9, 500.0), Verdict::Follows);
        assert_eq!(heating(25.0, 500.0), Verdict::AtCapacity(Limit::Heater));
        assert_eq!(heating(20.0, 500.0), Verdict::AtCapacity(Limit::Heater));
        assert_eq!(heating(31.0, 0.0), Verdict::AtCapacity(Limit::WarmZone), "the sun heats it");
        assert_eq!(heating(25.0, 0.0), Verdict::Fails, "the sun heats it");
        let at_setpoint = judge(&row(Quantity::HeatingSetpoint, 30.0, 30.0 - 1e-9, 0.0), free(31.0));
        assert_eq!(at_setpoint, Verdict::AtCapacity(Limit::WarmZone), "it is there without heat");
        assert_eq!(heating(20.0, 0.0), Verdict::Fails, "nothing happens below the setpoint");
        let cooling = |before, mean, cold| {
            judge(&row(Quantity::CoolingSetpoint, 15.0, mean, cold), Free { command: 35.0, ..free(before) })
        };
        assert_eq!(cooling(22.0, 15.1, 500.0), Verdict::Follows);
        assert_eq!(cooling(22.0, 19.0, 500.0), Verdict::AtCapacity(Limit::Cooler));
        assert_eq!(cooling(14.0, 14.0, 0.0), Verdict::AtCapacity(Limit::CoolZone));
        assert_eq!(cooling(22.0, 22.0, 0.0), Verdict::Fails);
    }

    #[test]
    fn equipment_that_ignores_its_setpoint_fails_however_much_it_heats() {
        let constant = |temperature| Free { heat: 500.0, ..free(temperature) };
        let heating = |mean, heat, free| judge(&row(Quantity::HeatingSetpoint, 30.0, mean, heat), free);
        assert_eq!(heating(20.0, 500.0, constant(20.0)), Verdict::Fails);
        assert_eq!(heating(20.4, 500.5, constant(20.0)), Verdict::Fails, "it drifts");
        assert_eq!(heating(20.4, 510.0, constant(20.0)), Verdict::AtCapacity(Limit::Heater));
        let cold = "its heater is at its limit at 10 °C, too";
        assert_eq!(heating(5.0, 500.0, constant(5.0)), Verdict::AtCapacity(Limit::Heater), "{cold}");
        let radiant = Free { radiates: true, ..free(20.0) };
        assert_eq!(heating(20.4, 0.0, radiant), Verdict::AtCapacity(Limit::Heater), "its floor is warm");
        assert_eq!(heating(20.0, 0.0, radiant), Verdict::Fails);
    }
}
