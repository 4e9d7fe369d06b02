//! The result of an episode.

pub(crate) mod deviations;
pub(crate) mod hours;
pub(crate) mod table;

use std::fmt;

use b2b_env::{EpisodeMetrics, Inputs, Resource};
use serde::{Deserialize, Serialize};

use super::finished::{EpisodeRecord, Finished, Lost};
use super::info::EpisodeInfo;
use super::resource::is_same_resource;
use super::step_rewards::StepRewards;
use crate::scores::{Baseline, RESOLUTION, Scores, excess_discomfort};

/// The result of an episode: a row of a results table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeResult {
    /// The episode.
    pub info: EpisodeInfo,
    /// Its metrics, with its score where its baseline is known, or why it was lost.
    pub outcome: Result<Scored, Lost>,
}

/// The metrics of an episode, with its score where its baseline is known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scored {
    /// The metrics.
    pub metrics: EpisodeMetrics,
    /// Distribution of the rewards of single steps.
    pub step_rewards: StepRewards,
    /// Its model and weather.
    pub inputs: Inputs,
    /// SHA-256 of the observation, action and penalties of every step.
    pub trajectory_hash: String,
    /// Return of the baseline in the same episode, if known: the reactive controllers, or the guideline controller in a
    /// operation task.
    pub baseline_return: Option<f64>,
    /// HVAC energy of the baseline in the same episode, Wh/m², if known.
    pub baseline_energy: Option<f64>,
    /// Amount of the task's resource over the episode, in the unit of the resource; `None` in older results.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resource: Option<f64>,
    /// Amount of the resource in the baseline, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline_resource: Option<f64>,
    /// Discomfort of the baseline in an operation task, K·h per zone, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline_discomfort: Option<f64>,
    /// Return relative to the reactive controllers, as in the paper: see [`normalized_score`](crate::normalized_score).
    /// In an operation task: see [`score_at_comfort`](crate::score_at_comfort).
    pub score: Option<f64>,
    /// See [`resolved_score`](crate::resolved_score); in an operation task the same as `score`.
    pub resolved_score: Option<f64>,
}

impl EpisodeResult {
    /// Returns the result of an episode of a task with this resource, without a score.
    pub(crate) fn unscored(finished: Finished, resource: Resource) -> Self {
        let Finished { record, terms, step_rewards, .. } = finished;
        let EpisodeRecord { info, metrics, inputs, trajectory_hash } = record;
        let resource = terms.used(resource);
        let scored = Scored { metrics, step_rewards, inputs, trajectory_hash, resource, ..Scored::default() };
        Self { info, outcome: Ok(scored) }
    }

    /// Scores the episode against its baseline, unless it was lost.
    pub(crate) fn score_against(&mut self, baseline: Baseline) {
        let Ok(scored) = &mut self.outcome else { return };
        let Scores { score, resolved } =
            baseline.scores(&scored.metrics, scored.resource, self.info.steps_per_hour);
        scored.baseline_return = Some(baseline.episode_return);
        scored.baseline_energy = Some(baseline.energy);
        scored.baseline_resource = baseline.resource;
        scored.baseline_discomfort = baseline.discomfort;
        (scored.score, scored.resolved_score) = (score, resolved);
    }

    /// Returns the metrics with the score, unless the episode was lost.
    pub fn scored(&self) -> Option<&Scored> {
        self.outcome.as_ref().ok()
    }

    /// Returns the score, if the episode was not lost and has one.
    pub fn score(&self) -> Option<f64> {
        self.scored()?.score
    }

    /// Returns the resolved score, if the episode was not lost and has one.
    pub fn resolved_score(&self) -> Option<f64> {
        self.scored()?.resolved_score
    }

    /// Returns the metrics, unless the episode was lost.
    pub fn metrics(&self) -> Option<&EpisodeMetrics> {
        Some(&self.scored()?.metrics)
    }
}

/// The episode and, if it was lost, the reason.
impl fmt::Display for EpisodeResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.outcome {
            Ok(_) => self.info.fmt(f),
            Err(lost) => write!(f, "{}: {lost}", self.info),
        }
    }
}

impl Scored {
    /// Returns the baseline, if known.
    pub fn baseline(&self) -> Option<Baseline> {
        Some(Baseline {
            episode_return: self.baseline_return?,
            energy: self.baseline_energy?,
            resource: self.baseline_resource,
            discomfort: self.baseline_discomfort,
        })
    }

    /// Returns whether discomfort in an operation task exceeds the baseline's by more than the free allowance; `None`
    /// in a task with targets, or if the baseline's is unknown.
    pub fn is_uncomfortable(&self, steps_per_hour: u32) -> Option<bool> {
        let days = self.days(steps_per_hour);
        Some(excess_discomfort(self.metrics.tdis_tot?, self.baseline_discomfort?, days) > 0.0)
    }

    /// Returns the length of the episode, days.
    pub fn days(&self, steps_per_hour: u32) -> f64 {
        self.metrics.steps as f64 / (24.0 * f64::from(steps_per_hour))
    }

    /// Returns HVAC energy relative to the baseline; `None` if the baseline's is unknown or 0.
    pub fn relative_energy(&self) -> Option<f64> {
        let baseline = self.baseline_energy.filter(|energy| *energy > 0.0)?;
        Some(self.metrics.energy() / baseline)
    }

    /// Returns the baseline's energy penalty, which follows from the amounts of the resource; `None` if these are
    /// unknown. Older results have none, and penalize energy.
    pub fn energy_penalty_of_baseline(&self) -> Option<f64> {
        let (own, baseline) = match self.resource {
            Some(own) => (own, self.baseline_resource),
            None => (self.metrics.energy(), self.baseline_energy),
        };
        match self.metrics.energy_penalty {
            0.0 => Some(0.0),
            penalty => (own != 0.0).then_some(penalty * baseline? / own),
        }
    }

    /// Returns the root of the temperature penalty relative to the baseline's, after adding a deviation of
    /// [`RESOLUTION`] to both; `None` if that is unknown.
    pub fn relative_comfort(&self) -> Option<f64> {
        let EpisodeMetrics { temperature_penalty, steps, .. } = self.metrics;
        let floor = steps as f64 * RESOLUTION * RESOLUTION;
        let baseline = (-self.baseline_return? - self.energy_penalty_of_baseline()?).max(0.0);
        (floor > 0.0).then(|| ((temperature_penalty + floor) / (baseline + floor)).sqrt())
    }

    /// Returns the task's resource (energy, cost, emissions or peak demand) relative to the baseline; `None` if either
    /// is unknown, or if the baseline's is not above 0, as may happen with negative prices.
    pub fn relative_resource(&self) -> Option<f64> {
        let baseline = self.baseline_resource.filter(|amount| *amount > 0.0)?;
        Some(self.resource? / baseline)
    }
}

/// Returns total HVAC energy divided by the baseline's total, over the rows with a known baseline; `None` if that total
/// is 0. A ratio of sums gives almost no weight to an episode that uses almost no energy.
pub fn relative_energy<'a>(rows: impl IntoIterator<Item = &'a EpisodeResult>) -> Option<f64> {
    ratio_of_sums(rows, |scored| Some([scored.metrics.energy(), scored.baseline_energy?]))
}

/// Returns the total of the tasks' resource divided by the baseline's total, over the rows in which both are known;
/// `None` if the baseline's total is not above 0, or if the tasks have different resources.
pub fn relative_resource<'a>(
    rows: impl IntoIterator<Item = &'a EpisodeResult, IntoIter: Clone>,
) -> Option<f64> {
    let rows = rows.into_iter();
    is_same_resource(rows.clone().map(|row| &row.info.task[..])).then_some(())?;
    ratio_of_sums(rows, |scored| Some([scored.resource?, scored.baseline_resource?]))
}

fn ratio_of_sums<'a>(
    rows: impl IntoIterator<Item = &'a EpisodeResult>,
    amounts: impl Fn(&Scored) -> Option<[f64; 2]>,
) -> Option<f64> {
    let (mut sum, mut baseline) = (0.0, 0.0);
    let scored = rows.into_iter().filter_map(|row| row.scored());
    for [amount, of_baseline] in scored.filter_map(amounts) {
        sum += amount;
        baseline += of_baseline;
    }
    (baseline > 0.0).then(|| sum / baseline)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_resource_is_relative_to_a_baseline_that_is_known_and_above_zero() {
        let scored = |amounts: [Option<f64>; 2]| {
            let [resource, baseline_resource] = amounts;
            Scored { resource, baseline_resource, ..Scored::default() }
        };
        for (amounts, expected) in [
            ([Some(1.0), Some(4.0)], Some(0.25)),
            ([Some(1.0), Some(-4.0)], None),
            ([Some(1.0), None], None),
            ([None, Some(4.0)], None),
        ] {
            assert_eq!(scored(amounts).relative_resource(), expected, "{amounts:?}");
        }
    }

    #[test]
    fn comfort_is_relative_to_the_baseline_without_its_energy_penalty() {
        let metrics = |temperature_penalty, energy_penalty| EpisodeMetrics {
            steps: 100,
            temperature_penalty,
            energy_penalty,
            ..EpisodeMetrics::default()
        };
        // 100 steps of 0.2 K add 4 to both.
        let comfort =
            Scored { metrics: metrics(60.0, 0.0), baseline_return: Some(-12.0), ..Scored::default() };
        assert_eq!(comfort.relative_comfort(), Some(2.0));
        let energy = Scored {
            metrics: metrics(60.0, 5.0),
            baseline_return: Some(-22.0),
            resource: Some(1.0),
            baseline_resource: Some(2.0),
            ..Scored::default()
        };
        assert_eq!(energy.relative_comfort(), Some(2.0));
        assert_eq!(Scored { baseline_resource: None, ..energy.clone() }.relative_comfort(), None);
        assert_eq!(Scored { baseline_return: None, ..comfort }.relative_comfort(), None);
    }
}
