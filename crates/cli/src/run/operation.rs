//! The part of a run's page for tasks with comfort bands: zones in their bands, modes and prices.

use b2b_env::{DecisionLog, ElectricityPrice, ObservationSpace, Spaces, Target, Trajectory};
use serde::Serialize;

use crate::time_series::{Steps, TimeAxis};

/// The name of the state of an occupied zone.
const PRESENCE: &[&str] = &["present"];

/// The data drawn by the page.
#[derive(Serialize)]
pub struct Operation {
    /// The controlled zones, in the order of the panel of temperatures.
    zones: Vec<ZoneView>,
    /// States of the controller's systems, such as their modes.
    states: Vec<Steps>,
    /// Price of electricity.
    price: Steps,
    /// Unit of the price.
    price_unit: String,
    /// Currency of all costs; empty if it is unknown.
    currency: String,
}

/// The band of a controlled zone, and the controller's setpoints.
#[derive(Serialize)]
struct ZoneView {
    comfort: Comfort,
    /// Setpoints that the controller holds at the moment.
    in_use: Vec<Steps>,
}

/// The comfort band of a zone, and when people are present.
#[derive(Serialize)]
pub struct Comfort {
    heating: Steps,
    /// `None` without cooling.
    cooling: Option<Steps>,
    presence: Steps,
}

impl Comfort {
    /// Returns the band of the setpoints (°C) and the occupancy of each step.
    pub fn of(axis: TimeAxis, heating: &[f64], cooling: Option<&[f64]>, occupancy: &[f64]) -> Self {
        let steps = |name: &str, values: &[f64]| axis.steps(name.to_owned(), values.iter().copied());
        let present: Vec<f64> = occupancy.iter().map(|people| f64::from(*people > 0.0)).collect();
        Self {
            heating: steps("heating setpoint", heating),
            cooling: cooling.map(|cooling| steps("cooling setpoint", cooling)),
            presence: Steps { states: PRESENCE, ..steps("people present", &present) },
        }
    }
}

impl Operation {
    /// Returns this part for an episode; `None` in a task without bands.
    ///
    /// # Errors
    /// The errors of [`ElectricityPrice::of`].
    pub fn of(
        spaces: &Spaces,
        trajectory: &Trajectory,
        decisions: &DecisionLog,
        axis: TimeAxis,
    ) -> b2b_env::Result<Option<Self>> {
        if !spaces.episode.task.is_operation() {
            return Ok(None);
        }
        let price = ElectricityPrice::of(&spaces.episode)?;
        let currency = price.currency.unwrap_or_default();
        let unit = if currency.is_empty() { "1" } else { &currency };
        let view = View { space: &spaces.observation, trajectory, decisions, axis };
        let zones = spaces.controlled_zones().enumerate();
        let zones =
            zones.map(|(controlled, index)| view.zone(controlled, index, &spaces.building.zones[index].name));
        let steps = axis.steps("electricity".into(), price.steps.into_iter());
        Ok(Some(Self {
            zones: zones.collect(),
            states: view.states().collect(),
            price: Steps { color: Some(0), ..steps },
            price_unit: format!("{unit}/kWh"),
            currency,
        }))
    }
}

struct View<'a> {
    space: &'a ObservationSpace,
    trajectory: &'a Trajectory,
    decisions: &'a DecisionLog,
    axis: TimeAxis,
}

impl View<'_> {
    /// Returns the view of a zone, given its indices among the controlled and among all zones.
    fn zone(&self, controlled: usize, index: usize, name: &str) -> ZoneView {
        let (heating, cooling) = match self.space.target(controlled) {
            Target::Between([heating, cooling]) => (self.asked(heating), Some(self.asked(cooling))),
            Target::Slot(heating) => (self.asked(heating), None),
            Target::Always(heating) => (vec![heating; self.trajectory.len()], None),
        };
        let occupancy = self.space.occupancy(controlled).map(|slot| self.asked(slot)).unwrap_or_default();
        let comfort = Comfort::of(self.axis, &heating, cooling.as_deref(), &occupancy);
        ZoneView { comfort, in_use: self.in_use(index, name).collect() }
    }

    /// Returns the setpoint or the occupancy of each step, from a slot of the observation.
    fn asked(&self, slot: usize) -> Vec<f64> {
        asked(self.trajectory.observed(slot).collect())
    }

    /// Returns the temperatures that the controller decided on for a zone.
    fn in_use<'b>(&'b self, index: usize, zone: &'b str) -> impl Iterator<Item = Steps> + 'b {
        let slots = self.decisions.slots().iter().enumerate();
        let own = slots.filter(move |(_, slot)| slot.zone.as_deref() == Some(zone) && slot.unit == "°C");
        own.filter(|(k, _)| self.decisions.values(*k).all(f64::is_finite)).map(move |(k, slot)| {
            let name = slot.name.strip_prefix(zone).unwrap_or(&slot.name).trim().to_owned();
            let steps = self.axis.steps(name, self.decisions.values(k));
            Steps { color: Some(index), dashed: true, ..steps }
        })
    }

    fn states(&self) -> impl Iterator<Item = Steps> {
        let slots = self.decisions.slots().iter().enumerate();
        slots.filter(|(_, slot)| !slot.states.is_empty()).map(|(k, slot)| {
            let name = slot.name.trim_end_matches(" mode").to_owned();
            Steps { states: slot.states, ..self.axis.steps(name, self.decisions.values(k)) }
        })
    }
}

/// Shifts the setpoints in observations to the following step, to which they apply. The first step's setpoint is not
/// recorded, so the second step's is used.
pub fn asked(mut observed: Vec<f64>) -> Vec<f64> {
    observed.rotate_right(1);
    if let [first, second, ..] = &mut observed[..] {
        *first = *second;
    }
    observed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_setpoints_of_a_step_are_in_the_observation_before_it() {
        assert_eq!(asked(vec![21.0, 22.0, 23.0]), [21.0, 21.0, 22.0]);
    }
}
