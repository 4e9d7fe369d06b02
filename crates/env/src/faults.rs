//! Faults of sensors and equipment.
//!
//! Faults depend only on seed, step and location, and with [`Faults::own`] on the building's name, so equal tasks have
//! equal faults in every episode of a building.

use b2b_base::digest::seed_of;
use b2b_base::random::{standard_normal, uniform};
use b2b_building::hvac::{Actuator, Quantity};
use b2b_building::morphology::Owner;
use b2b_building::{Controls, PreparedBuilding};
use serde::{Deserialize, Serialize};

use crate::limits::within;
use crate::random::stream;
use crate::{Error, Result};

/// Temperature toward which fouling moves the bounds of supply temperatures, °C.
const NEUTRAL: f64 = 20.0;
/// Streams of biases and stuck actuators. The stream of the noise is the step.
const BIASES: u64 = u64::MAX;
const STUCK: u64 = u64::MAX - 1;
/// Stream of a building's own share of fouling.
const FOULING: u64 = u64::MAX - 2;

/// Faults of sensors and equipment. None by default.
///
/// Rewards and metrics use true temperatures; only observations have sensor errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Faults {
    /// Random seed.
    pub seed: u64,
    /// Whether every building has faults of its own: seeded by its name, with a share of fouling from 0 to `fouling`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub own: bool,
    /// Standard deviation of the noise of every zone temperature sensor, K: independent from step to step.
    pub noise: f64,
    /// Standard deviation of the bias of the zone temperature sensors, K: constant, drawn for each zone.
    pub bias: f64,
    /// Probability that an actuator is stuck at a value drawn from its range. Not even the ventilation interlock moves
    /// it.
    pub stuck: f64,
    /// Share of the coils' range lost to fouling, 0 to 1: the range of supply air temperatures shrinks by this share toward 20 °C.
    pub fouling: f64,
}

impl Faults {
    /// Returns whether there is no fault.
    pub fn is_none(&self) -> bool {
        Self { seed: 0, own: false, ..*self } == Self::default()
    }

    /// The faults, by their words in the text form of a task.
    pub(crate) fn parts(&mut self) -> [(&'static str, &mut f64); 4] {
        let Self { seed: _, own: _, noise, bias, stuck, fouling } = self;
        [("noise", noise), ("bias", bias), ("stuck", stuck), ("fouling", fouling)]
    }

    pub(crate) fn check(&self) -> Result<()> {
        within("noise", self.noise, 0.0, 10.0)?;
        within("bias", self.bias, 0.0, 10.0)?;
        within("stuck", self.stuck, 0.0, 1.0)?;
        within("fouling", self.fouling, 0.0, 1.0)?;
        if self.own && self.is_none() {
            return Err(Error::OwnFaults);
        }
        Ok(())
    }

    /// Returns the faults as a building has them.
    fn of(&self, building: &str) -> Self {
        if !self.own {
            return *self;
        }
        let seed = self.seed.wrapping_add(seed_of(Controls::common_name(building)));
        Self { seed, fouling: self.fouling * uniform(&mut stream(seed, FOULING)), ..*self }
    }
}

/// The faults of a building in an episode.
#[derive(Debug)]
pub(crate) struct Impairment {
    seed: u64,
    noise: f64,
    /// Sensor bias of each zone, K.
    biases: Vec<f64>,
    /// Bounds of each actuator; both ends equal where it is stuck.
    bounds: Vec<[f64; 2]>,
    /// Actuators that set a thermostat, with its zone.
    thermostats: Vec<(usize, usize)>,
    /// Errors of the sensors, and what the engine is given, in a step.
    errors: Vec<f64>,
    given: Vec<f64>,
}

impl Impairment {
    /// Draws the faults of a building; `None` if there are none.
    pub(crate) fn new(faults: &Faults, building: &PreparedBuilding) -> Option<Self> {
        if faults.is_none() {
            return None;
        }
        let Faults { seed, own: _, noise, bias, stuck, fouling } = faults.of(&building.name);
        let mut random = stream(seed, BIASES);
        let biases = building.zones.iter().map(|_| bias * standard_normal(&mut random)).collect();
        let mut random = stream(seed, STUCK);
        let toward_neutral = |value: f64| NEUTRAL + (value - NEUTRAL) * (1.0 - fouling);
        let bounds = building.actuators().map(|actuator| {
            let (low, high) = (actuator.low, actuator.high);
            let (is_stuck, at) = (uniform(&mut random) < stuck, uniform(&mut random));
            match actuator.quantity {
                _ if is_stuck => [low + (high - low) * at; 2],
                Quantity::SupplyAirTemperature => [low, high].map(toward_neutral),
                _ => [low, high],
            }
        });
        let bounds: Vec<[f64; 2]> = bounds.collect();
        let thermostat =
            |(index, (owner, actuator)): (usize, (Owner, &Actuator))| match (owner, actuator.quantity) {
                (Owner::Zone(zone), Quantity::HeatingSetpoint | Quantity::CoolingSetpoint) => {
                    Some((index, zone))
                }
                _ => None,
            };
        Some(Self {
            seed,
            noise,
            thermostats: building.owned_actuators().enumerate().filter_map(thermostat).collect(),
            errors: vec![0.0; building.zones.len()],
            given: vec![0.0; bounds.len()],
            biases,
            bounds,
        })
    }

    /// Returns what the engine is given for an action after a number of steps. Its thermostats know the true
    /// temperature, so that their setpoints are lowered by the errors of the sensors, which these compare with the
    /// setpoints of the action.
    pub(crate) fn given(&mut self, step: usize, action: &[f64]) -> &[f64] {
        let mut errors = std::mem::take(&mut self.errors);
        errors.fill(0.0);
        self.disturb(step, &mut errors);
        self.given.copy_from_slice(action);
        for (actuator, zone) in &self.thermostats {
            self.given[*actuator] -= errors[*zone];
        }
        self.errors = errors;
        &self.given
    }

    /// Limits an action to what the faulty equipment can do.
    pub(crate) fn limit(&self, action: &mut [f64]) {
        for (value, [low, high]) in action.iter_mut().zip(&self.bounds) {
            *value = value.clamp(*low, *high);
        }
    }

    /// Returns whether an actuator is stuck.
    pub(crate) fn is_stuck(&self, actuator: usize) -> bool {
        let [low, high] = self.bounds[actuator];
        low == high
    }

    /// Adds the errors of the sensors to the zone temperatures at the end of a step.
    pub(crate) fn disturb(&self, step: usize, temperatures: &mut [f64]) {
        self.add(step, temperatures, 1.0);
    }

    /// Removes the errors of the sensors from the zone temperatures at the end of a step.
    pub(crate) fn correct(&self, step: usize, temperatures: &mut [f64]) {
        self.add(step, temperatures, -1.0);
    }

    fn add(&self, step: usize, temperatures: &mut [f64], sign: f64) {
        let mut random = (self.noise > 0.0).then(|| stream(self.seed, step as u64));
        for (temperature, bias) in temperatures.iter_mut().zip(&self.biases) {
            *temperature += sign * bias;
            if let Some(random) = &mut random {
                *temperature += sign * (self.noise * standard_normal(random));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_faults_depend_on_name_and_seed_and_lose_at_most_the_given_share() {
        let faults = Faults { own: true, bias: 0.5, fouling: 0.4, ..Faults::default() };
        let names: Vec<String> = (0..100).map(|number| format!("OfficeSmall-{number:04}")).collect();
        let own: Vec<Faults> = names.iter().map(|name| faults.of(name)).collect();
        for (number, one) in own.iter().enumerate() {
            assert_eq!(faults.of(&names[number]), *one);
            assert!(own[..number].iter().all(|other| (other.seed, other.fouling) != (one.seed, one.fouling)));
            assert!((0.0..0.4).contains(&one.fouling) && one.bias == 0.5);
        }
        let mean = own.iter().map(|each| each.fouling).sum::<f64>() / 100.0;
        assert!((0.17..0.23).contains(&mean), "{mean}");
        assert_ne!(Faults { seed: 1, ..faults }.of(&names[0]), own[0]);
        assert_eq!(Faults { own: false, ..faults }.of(&names[0]), Faults { own: false, ..faults });
    }

    #[test]
    fn tasks_without_own_faults_are_written_as_before() {
        let text = |faults: Faults| serde_json::to_string(&faults).unwrap();
        let faults = Faults { bias: 0.5, ..Faults::default() };
        assert_eq!(text(faults), r#"{"seed":0,"noise":0.0,"bias":0.5,"stuck":0.0,"fouling":0.0}"#);
        assert!(text(Faults { own: true, ..faults }).starts_with(r#"{"seed":0,"own":true,"#));
    }
}
