//! Response to the setpoints of thermostats: whether they move the temperature of their zones.

use b2b_building::hvac::Quantity;
use b2b_building::morphology::Owner;

use super::bench::Bench;
use super::heat::{AT_SETPOINT, RISE, SOME_HEAT};
use super::hold::{setpoint_hold, setpoints};
use super::reading::Reading;
use super::report::{Condition, Level, Limit, Row, Verdict};
use crate::Result;

/// Steps before the first hold, from midnight: 8 hours.
const STEPS_BEFORE: usize = 96;
/// Steps of a hold: two hours.
const STEPS: usize = 24;
/// What is tested between holds that call for nothing.
const TESTED: [(Quantity, Level); 2] =
    [(Quantity::HeatingSetpoint, Level::High), (Quantity::CoolingSetpoint, Level::Low)];

/// The state of the zones of all setpoints at the end of a hold: temperature (°C), and heat delivered or removed (W).
type State = Vec<(f64, f64)>;

impl Bench<'_> {
    /// Raises the heating setpoints and lowers the cooling setpoints of thermostats, and evaluates the zone temperatures.
    pub(super) fn thermostats(&mut self) -> Result<Vec<Row>> {
        let thermostats = self.setpoint_slots();
        self.settle(&thermostats, STEPS_BEFORE)?;
        let mut before = self.settle(&thermostats, STEPS)?;
        let mut rows = Vec::new();
        for (quantity, level) in TESTED {
            let tested = self.hold_setpoints(&thermostats, quantity, level)?;
            let after = self.settle(&thermostats, STEPS)?;
            for (number, row) in tested {
                let free = 0.5 * (before[number].0 + after[number].0);
                let zone = &self.building.zones[thermostats[number].1].name;
                let verdict = match judge(&row, free) {
                    Verdict::Fails if self.building.notes.is_mostly_off(zone) => {
                        Verdict::AtCapacity(Limit::SwitchedOff)
                    }
                    other => other,
                };
                rows.push(Row { verdict, ..row });
            }
            before = after;
        }
        Ok(rows)
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
        let mut temperatures = vec![0.0; thermostats.len()];
        for _ in 0..steps {
            let step = self.env.step(&hold.action)?;
            for (temperature, (_, slot)) in temperatures.iter_mut().zip(thermostats) {
                *temperature = step.observation[*slot];
            }
        }
        let heat = |&(index, _): &(usize, usize)| self.env.heat(index).unwrap_or(0.0);
        Ok(temperatures.into_iter().zip(thermostats.iter().map(heat)).collect())
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
        for _ in 0..STEPS {
            let step = self.env.step(&hold.action)?;
            for (&(_, index, slot), reading) in tested.iter().zip(&mut readings) {
                reading.add(actuators[index], step.observation[slot]);
            }
        }
        let ended = |(&(number, index, _), reading): (&(usize, usize, usize), Reading)| {
            let error = (reading.last - reading.row.command).abs();
            (number, Row { mean: reading.last, heat: self.env.heat(index), error, ..reading.row })
        };
        Ok(tested.iter().zip(readings).map(ended).collect())
    }
}

/// A setpoint must move its zone towards it, relative to the temperature without any call, unless the zone is beyond it
/// anyway, or at it, and gets nothing. A zone that never comes near its setpoint while it moves has equipment at capacity.
fn judge(row: &Row, free: f64) -> Verdict {
    let (sign, [short, idle]) = match row.quantity {
        Quantity::CoolingSetpoint => (-1.0, [Limit::Cooler, Limit::CoolZone]),
        _ => (1.0, [Limit::Heater, Limit::WarmZone]),
    };
    let (moved, missing) = (sign * (row.mean - free), sign * (row.command - row.mean));
    let works = row.heat.unwrap_or(0.0) > SOME_HEAT;
    if moved > RISE {
        return if missing <= AT_SETPOINT { Verdict::Follows } else { Verdict::AtCapacity(short) };
    }
    match works {
        true if missing.abs() <= AT_SETPOINT => Verdict::Follows,
        true => Verdict::AtCapacity(short),
        false if missing <= AT_SETPOINT => Verdict::AtCapacity(idle),
        false => Verdict::Fails,
    }
}

#[cfg(test)]
mod tests {
    use b2b_building::hvac::{Actuator, EngineVariable};

    use super::super::report::Season;
    use super::*;

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
        let heating = |mean, heat| judge(&row(Quantity::HeatingSetpoint, 30.0, mean, heat), 20.0);
        assert_eq!(heating(29.9, 500.0), Verdict::Follows);
        assert_eq!(heating(25.0, 500.0), Verdict::AtCapacity(Limit::Heater));
        assert_eq!(heating(20.0, 500.0), Verdict::AtCapacity(Limit::Heater));
        assert_eq!(heating(31.0, 0.0), Verdict::Follows, "it was 20 °C without the setpoint");
        let at_setpoint = judge(&row(Quantity::HeatingSetpoint, 30.0, 30.0 - 1e-9, 0.0), 31.0);
        assert_eq!(at_setpoint, Verdict::AtCapacity(Limit::WarmZone), "it is there without heat");
        assert_eq!(heating(20.0, 0.0), Verdict::Fails, "nothing happens below the setpoint");
        let cooling = |free, mean, cold| judge(&row(Quantity::CoolingSetpoint, 15.0, mean, cold), free);
        assert_eq!(cooling(22.0, 15.1, 500.0), Verdict::Follows);
        assert_eq!(cooling(22.0, 19.0, 500.0), Verdict::AtCapacity(Limit::Cooler));
        assert_eq!(cooling(14.0, 14.0, 0.0), Verdict::AtCapacity(Limit::CoolZone));
        assert_eq!(cooling(22.0, 22.0, 0.0), Verdict::Fails);
    }
}
