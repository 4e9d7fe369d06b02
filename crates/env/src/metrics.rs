//! What an episode amounts to.

use serde::{Deserialize, Serialize};

use crate::reward::{JudgedZone, Reward};

/// Deviation of one zone from its target over an episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ZoneMetrics {
    /// Slot of the zone in the observation.
    pub slot: usize,
    /// Whether it has both heating and cooling.
    pub fully_conditioned: bool,
    squares: f64,
    absolutes: f64,
    steps_outside: usize,
}

/// Sums over the steps of an episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Steps done.
    pub steps: usize,
    /// Sum of the rewards.
    pub episode_return: f64,
    /// Sum of the temperature penalties, K².
    pub temperature_penalty: f64,
    /// Sum of the energy penalties.
    pub energy_penalty: f64,
    /// HVAC electricity, Wh/m².
    pub electricity: f64,
    /// HVAC gas, Wh/m².
    pub gas: f64,
    /// Action values that were out of bounds and clamped.
    pub clamped_actions: usize,
    /// The controlled zones, in model order.
    pub zones: Vec<ZoneMetrics>,
    hours_per_step: f64,
}

/// A zone is outside comfort when it is further than this from its target, K.
const COMFORT_BAND: f64 = 1.0;

impl ZoneMetrics {
    /// Root mean square deviation over so many steps, K.
    pub fn rms_deviation(&self, steps: usize) -> f64 {
        (self.squares / steps.max(1) as f64).sqrt()
    }

    /// Mean absolute deviation over so many steps, K.
    pub fn mean_abs_deviation(&self, steps: usize) -> f64 {
        self.absolutes / steps.max(1) as f64
    }
}

impl Metrics {
    pub(crate) fn new(zones: &[JudgedZone], steps_per_hour: u32) -> Self {
        let zones = zones.iter().map(|zone| ZoneMetrics {
            slot: zone.slot,
            fully_conditioned: zone.fully_conditioned,
            ..ZoneMetrics::default()
        });
        Self { zones: zones.collect(), hours_per_step: 1.0 / f64::from(steps_per_hour), ..Self::default() }
    }

    /// Adds what the step just counted was worth. `energy` in Wh/m², electricity and gas.
    pub(crate) fn add(&mut self, reward: Reward, target: f64, observation: &[f64], energy: [f64; 2]) {
        self.episode_return += reward.total();
        self.temperature_penalty += reward.temperature_penalty;
        self.energy_penalty += reward.energy_penalty;
        self.electricity += energy[0];
        self.gas += energy[1];
        for zone in &mut self.zones {
            let deviation = observation[zone.slot] - target;
            zone.squares += deviation * deviation;
            zone.absolutes += deviation.abs();
            zone.steps_outside += usize::from(deviation.abs() > COMFORT_BAND);
        }
    }

    /// Root mean square deviation of a zone, K; both sides of the target count.
    /// Averaged over the zones that have both heating and cooling.
    pub fn rms_deviation(&self) -> f64 {
        self.mean_over_zones(|zone| zone.rms_deviation(self.steps))
    }

    /// Mean absolute deviation, K, averaged over the zones that have both heating and cooling.
    pub fn mean_abs_deviation(&self) -> f64 {
        self.mean_over_zones(|zone| zone.mean_abs_deviation(self.steps))
    }

    /// Hours further than 1 K from target, averaged over the zones that have both heating and cooling.
    pub fn hours_outside_1k(&self) -> f64 {
        self.mean_over_zones(|zone| self.zone_hours_outside_1k(zone))
    }

    /// Hours that a zone was further than 1 K from target.
    pub fn zone_hours_outside_1k(&self, zone: &ZoneMetrics) -> f64 {
        zone.steps_outside as f64 * self.hours_per_step
    }

    fn mean_over_zones(&self, value: impl Fn(&ZoneMetrics) -> f64) -> f64 {
        let zones: Vec<_> = self.zones.iter().filter(|z| z.fully_conditioned).collect();
        zones.iter().map(|z| value(z)).sum::<f64>() / zones.len().max(1) as f64
    }
}
