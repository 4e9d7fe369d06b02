//! Faults of sensors and equipment.
//!
//! Faults depend only on seed, step and location, so equal tasks have equal faults in every episode.

use b2b_base::random::{standard_normal, uniform};
use b2b_building::PreparedBuilding;
use b2b_building::hvac::Quantity;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::limits::within;
use crate::random::stream;

/// Temperature toward which fouling moves the bounds of supply temperatures, °C.
const NEUTRAL: f64 = 20.0;
/// Streams of biases and stuck actuators. The stream of the noise is the step.
const BIASES: u64 = u64::MAX;
const STUCK: u64 = u64::MAX - 1;

/// Faults of sensors and equipment. None by default.
///
/// Rewards and metrics use true temperatures; only observations have sensor errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Faults {
    /// Random seed.
    pub seed: u64,
    /// Standard deviation of the noise of every zone temperature sensor, K: independent from step to step.
    pub noise: f64,
    /// Standard deviation of the bias of the zone temperature sensors, K: constant, drawn for each zone.
    pub bias: f64,
    /// Probability that an actuator is stuck at a value drawn from its range. Not even the ventilation interlock moves
    /// it.
    pub stuck: f64,
    /// Loss of the coils by fouling, 0 to 1: the range of supply air temperatures shrinks by this share toward 20 °C.
    pub fouling: f64,
}

impl Faults {
    /// Returns whether there is no fault.
    pub fn is_none(&self) -> bool {
        Self { seed: 0, ..*self } == Self::default()
    }

    /// The faults, by their words in the text form of a task.
    pub(crate) fn parts(&mut self) -> [(&'static str, &mut f64); 4] {
        let Self { seed: _, noise, bias, stuck, fouling } = self;
        [("noise", noise), ("bias", bias), ("stuck", stuck), ("fouling", fouling)]
    }

    pub(crate) fn check(&self) -> Result<()> {
        within("noise", self.noise, 0.0, 10.0)?;
        within("bias", self.bias, 0.0, 10.0)?;
        within("stuck", self.stuck, 0.0, 1.0)?;
        within("fouling", self.fouling, 0.0, 1.0)
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
}

impl Impairment {
    /// Draws the faults of a building; `None` if there are none.
    pub(crate) fn new(faults: &Faults, building: &PreparedBuilding) -> Option<Self> {
        if faults.is_none() {
            return None;
        }
        let Faults { seed, noise, bias, stuck, fouling } = *faults;
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
        let bounds = bounds.collect();
        Some(Self { seed, noise, biases, bounds })
    }

    /// Limits an action to what the faulty equipment can do.
    pub(crate) fn limit(&self, action: &mut [f64]) {
        for (value, [low, high]) in action.iter_mut().zip(&self.bounds) {
            *value = value.clamp(*low, *high);
        }
    }

    /// Adds the errors of the sensors to the zone temperatures at the end of a step.
    pub(crate) fn disturb(&self, step: usize, temperatures: &mut [f64]) {
        let mut random = (self.noise > 0.0).then(|| stream(self.seed, step as u64));
        for (temperature, bias) in temperatures.iter_mut().zip(&self.biases) {
            *temperature += bias;
            if let Some(random) = &mut random {
                *temperature += self.noise * standard_normal(random);
            }
        }
    }
}
