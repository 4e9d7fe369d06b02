//! What is kept of an episode.

use b2b_building::Conditioning;
use b2b_env::Spaces;
use b2b_env::{Metrics, Target};
use serde::{Deserialize, Serialize};

use super::bench::Located;
use super::rollout::Rolled;
use crate::baseline::Terms;
use crate::policy::Policy;

/// What became of an episode.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It ran to its end.
    Finished(Box<Finished>),
    /// It did not, and why.
    Lost(String),
}

/// An episode that ran to its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finished {
    /// Its figures.
    pub record: Record,
    /// What a return for any weight is made of.
    pub terms: Terms,
    /// How far zones were from their targets.
    pub deviations: Deviations,
    /// Hour by hour.
    pub hours: Hours,
}

/// The figures of an episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Name of the building.
    pub building: String,
    /// Its type; nothing for a user's own model.
    pub building_type: String,
    /// Climate zone of ASHRAE 169.
    pub climate_zone: String,
    /// Place, or weather file.
    pub place: String,
    /// `train` or `test`; nothing for a building that is not of the dataset.
    pub split: String,
    /// Spelling of the task.
    pub task: String,
    /// SHA-256 of the task.
    pub task_hash: String,
    /// Run period, `MM-DD..MM-DD` or its name.
    pub period: String,
    /// Zone time steps an hour.
    pub steps_per_hour: u32,
    /// Name of the policy.
    pub policy: String,
    /// Its seed.
    pub seed: u64,
    /// Steps.
    pub steps: usize,
    /// Sum of the rewards.
    pub episode_return: f64,
    /// Sum of the temperature penalties, K².
    pub temperature_penalty: f64,
    /// Sum of the energy penalties.
    pub energy_penalty: f64,
    /// Root mean square deviation from target, mean over zones with heating and cooling, K.
    pub rms_deviation: f64,
    /// Mean absolute deviation, K.
    pub mean_abs_deviation: f64,
    /// Hours outside the comfort band, mean over the same zones.
    pub hours_outside_band: f64,
    /// Thermal discomfort beyond the band, mean over the controlled zones, K h.
    pub discomfort: f64,
    /// HVAC electricity, Wh/m².
    pub electricity: f64,
    /// HVAC gas, Wh/m².
    pub gas: f64,
    /// Cost by the task's prices, currency/m².
    pub cost: f64,
    /// Emissions by the task's factors, kg of CO₂/m².
    pub emissions: f64,
    /// Highest electric HVAC power, mean of a step, W/m².
    pub peak_electricity: f64,
    /// Highest gas power, mean of a step, W/m².
    pub peak_gas: f64,
    /// Way of the actuators a day, in times their ranges, mean over them.
    pub daily_travel: f64,
    /// Action values that were out of bounds.
    pub clamped_actions: usize,
    /// SHA-256 of every observation, action and penalty, as `b2b run` has it.
    pub trajectory_hash: String,
}

/// A histogram of deviations from target: of every step and zone with heating and cooling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Deviations {
    /// How many are in each bin of [`Deviations::WIDTH`] from [`Deviations::LOWEST`]; what is beyond is in the
    /// outermost.
    pub counts: Vec<u64>,
}

impl Deviations {
    /// Lower end of the first bin, K.
    pub const LOWEST: f64 = -10.0;
    /// Width of a bin, K.
    pub const WIDTH: f64 = 0.05;
    const BINS: usize = 400;

    /// An empty histogram.
    pub fn empty() -> Self {
        Self { counts: vec![0; Self::BINS] }
    }

    /// Counts a deviation, K.
    pub fn add(&mut self, deviation: f64) {
        let bin = ((deviation - Self::LOWEST) / Self::WIDTH).floor();
        self.counts[bin.clamp(0.0, (Self::BINS - 1) as f64) as usize] += 1;
    }

    /// Middle of a bin, K.
    pub fn middle(bin: usize) -> f64 {
        Self::LOWEST + (bin as f64 + 0.5) * Self::WIDTH
    }
}

/// An episode by the hour, in hundredths: room for a year in a small file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Hours {
    /// Coldest controlled zone, °C/100.
    pub coldest: Vec<i32>,
    /// Mean of the controlled zones.
    pub mean: Vec<i32>,
    /// Warmest controlled zone.
    pub warmest: Vec<i32>,
    /// Mean target.
    pub target: Vec<i32>,
    /// Outdoor air.
    pub outdoor: Vec<i32>,
    /// HVAC power, electricity and gas, W/m²/100.
    pub power: Vec<i32>,
}

/// A controlled zone in an observation.
struct Controlled {
    slot: usize,
    target: Target,
    fully_conditioned: bool,
}

impl Finished {
    pub(super) fn new(
        located: &Located,
        policy: &dyn Policy,
        seed: u64,
        spaces: &Spaces,
        metrics: &Metrics,
        rolled: &Rolled,
    ) -> Self {
        let episode = &spaces.episode;
        let record = Record {
            building: spaces.building.name.clone(),
            building_type: located.subject.building_type().to_owned(),
            climate_zone: located.surroundings.climate_zone.clone(),
            place: located.surroundings.place.clone(),
            split: located.subject.split(),
            task: episode.task.to_string(),
            task_hash: episode.task.hash(),
            period: episode.period.to_string(),
            steps_per_hour: episode.steps_per_hour,
            policy: policy.name(),
            seed,
            steps: metrics.steps,
            episode_return: metrics.episode_return,
            temperature_penalty: metrics.temperature_penalty,
            energy_penalty: metrics.energy_penalty,
            rms_deviation: metrics.rms_deviation(),
            mean_abs_deviation: metrics.mean_abs_deviation(),
            hours_outside_band: metrics.hours_outside_band(),
            discomfort: metrics.discomfort(),
            electricity: metrics.electricity,
            gas: metrics.gas,
            cost: metrics.cost,
            emissions: metrics.emissions / 1000.0,
            peak_electricity: metrics.peak_electricity,
            peak_gas: metrics.peak_gas,
            daily_travel: metrics.daily_travel(),
            clamped_actions: metrics.clamped_actions,
            trajectory_hash: rolled.trajectory.hash(),
        };
        let zones = controlled_zones(spaces);
        Self {
            record,
            terms: Terms::of(metrics),
            deviations: deviations(rolled, &zones),
            hours: hours(rolled, &zones, spaces),
        }
    }
}

fn controlled_zones(spaces: &Spaces) -> Vec<Controlled> {
    let zones = spaces.building.zones.iter().enumerate();
    let controlled = zones.filter(|(_, zone)| zone.conditioning != Conditioning::None);
    let zone = |(number, (slot, zone)): (usize, (usize, &b2b_building::Zone))| Controlled {
        slot,
        target: spaces.observation.target(number),
        fully_conditioned: zone.conditioning == Conditioning::HeatingAndCooling,
    };
    controlled.enumerate().map(zone).collect()
}

/// Pairs of what was seen before a step and at its end.
fn steps(rolled: &Rolled) -> impl Iterator<Item = (&[f64], &[f64])> {
    let width = rolled.first_observation.len();
    let ends = rolled.trajectory.observations.chunks_exact(width);
    std::iter::once(rolled.first_observation.as_slice()).chain(ends.clone()).zip(ends)
}

/// Targets are those that were seen before the step, as in the reward.
fn deviations(rolled: &Rolled, zones: &[Controlled]) -> Deviations {
    let mut deviations = Deviations::empty();
    for (before, end) in steps(rolled) {
        for zone in zones.iter().filter(|zone| zone.fully_conditioned) {
            deviations.add(end[zone.slot] - zone.target.of(before));
        }
    }
    deviations
}

fn hours(rolled: &Rolled, zones: &[Controlled], spaces: &Spaces) -> Hours {
    let per_hour = spaces.episode.steps_per_hour as usize;
    let (outdoor, electricity, gas) = (
        spaces.observation.outdoor_temperature(),
        spaces.observation.electricity(),
        spaces.observation.gas(),
    );
    let all: Vec<_> = steps(rolled).collect();
    let mut hours = Hours::default();
    for hour in all.chunks(per_hour) {
        let temperatures = || hour.iter().flat_map(|(_, end)| zones.iter().map(|zone| end[zone.slot]));
        let targets = hour.iter().flat_map(|(before, _)| zones.iter().map(|zone| zone.target.of(before)));
        hours.coldest.push(hundredths(temperatures().fold(f64::INFINITY, f64::min)));
        hours.warmest.push(hundredths(temperatures().fold(f64::NEG_INFINITY, f64::max)));
        hours.mean.push(hundredths(mean(temperatures())));
        hours.target.push(hundredths(mean(targets)));
        hours.outdoor.push(hundredths(mean(hour.iter().map(|(_, end)| end[outdoor]))));
        // Wh/m² of a step, times steps an hour.
        let power = mean(hour.iter().map(|(_, end)| end[electricity] + end[gas])) * per_hour as f64;
        hours.power.push(hundredths(power));
    }
    hours
}

fn hundredths(value: f64) -> i32 {
    (value * 100.0).round() as i32
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| (sum + value, count + 1));
    sum / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deviation_is_counted_where_it_belongs_and_none_is_lost() {
        let mut deviations = Deviations::empty();
        for value in [0.01, 0.04, -0.01, 1e9, -1e9] {
            deviations.add(value);
        }
        let at = |value: f64| ((value - Deviations::LOWEST) / Deviations::WIDTH) as usize;
        assert_eq!((deviations.counts[at(0.01)], deviations.counts[at(-0.01)]), (2, 1));
        assert_eq!((deviations.counts[0], deviations.counts[399]), (1, 1));
        assert!((Deviations::middle(at(0.01)) - 0.025).abs() < 1e-9);
    }
}
