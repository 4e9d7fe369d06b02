//! Scores of an agent against the baseline.

use std::cell::OnceCell;
use std::sync::{Mutex, PoisonError};

use b2b_agent::Agent;
use b2b_control::tune::travel_limit;
use b2b_env::EpisodeMetrics;
use b2b_evaluate::{Baseline, BuiltIn, EpisodePlan, Evaluation, Outcome, Policy};
use serde::Serialize;

use crate::error::{Error, Result};

/// Episodes that agents are scored on.
pub(super) struct Judge<'a> {
    evaluation: &'a Evaluation<'a>,
    episodes: Vec<(EpisodePlan, Baseline)>,
    /// Actuator travel above which actuators hunt, full strokes/day, of each episode; empty before the first agent.
    travel_limits: OnceCell<Vec<f64>>,
}

/// The measures by which an agent is judged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measures {
    /// Score; the baseline's is 1, and lower is better.
    pub score: f64,
    /// Resolved score: see [`b2b_evaluate::resolved_score`].
    pub resolved_score: f64,
    /// Root mean square deviation from target, K.
    pub rms_deviation_k: f64,
    /// HVAC energy divided by the baseline's.
    pub energy_ratio: f64,
    /// Actuator travel, full strokes/day.
    pub travel_per_day: f64,
    /// Actuator travel divided by its limit: 5 strokes/day, or the baseline's travel if higher. Above 1, actuators
    /// hunt. The worst building counts, not the mean.
    pub relative_travel: f64,
    /// Share of zone-steps in sustained oscillation: see [`b2b_env::Metrics::oscillating_share`].
    pub oscillating_share: f64,
    /// In an operation task, use of its resource divided by the baseline's.
    pub cost_ratio: f64,
    /// In an operation task, discomfort, K·h per zone and day.
    pub discomfort: f64,
    /// In an operation task, the baseline's discomfort, K·h per zone and day.
    pub baseline_discomfort: f64,
}

/// The criteria by which the best agent of a run is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rating {
    /// Score: infinite if there is no agent yet.
    pub(super) score: f64,
    /// Actuator travel divided by its limit.
    pub(super) relative_travel: f64,
}

/// The scores of an agent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AgentScores {
    /// Means over its buildings.
    #[serde(flatten)]
    pub mean: Measures,
    /// The same for each building, written if there are several.
    #[serde(rename = "by_building", skip_serializing_if = "is_alone")]
    pub buildings: Vec<BuildingScores>,
}

fn is_alone(buildings: &[BuildingScores]) -> bool {
    buildings.len() < 2
}

/// The scores of an agent in one building.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BuildingScores {
    /// The building.
    pub building: String,
    /// The task.
    pub task: String,
    /// The run period.
    pub period: String,
    /// Its scores.
    #[serde(flatten)]
    pub measures: Measures,
}

impl<'a> Judge<'a> {
    /// Returns a judge of these episodes with their baselines.
    pub(super) fn new(evaluation: &'a Evaluation<'a>, episodes: Vec<(EpisodePlan, Baseline)>) -> Self {
        Self { evaluation, episodes, travel_limits: OnceCell::new() }
    }

    /// Returns the scores of an agent. It acts without exploration.
    pub(super) fn judge(&self, agent: &Agent) -> Result<AgentScores> {
        let limits = self.travel_limits()?;
        let metrics = self.run(&self.numbered().collect::<Vec<_>>(), agent)?;
        let judged = self.episodes.iter().zip(limits).zip(&metrics);
        let scores = judged.map(|(((episode, baseline), limit), metrics)| BuildingScores {
            building: episode.subject.label(),
            task: episode.task.to_string(),
            period: episode.period.to_string(),
            measures: Measures::of(metrics, episode, baseline, *limit),
        });
        Ok(AgentScores::of(scores.collect()))
    }

    /// Returns the limits of actuator travel. Runs the baselines once, because stored baselines do not include travel.
    fn travel_limits(&self) -> Result<&[f64]> {
        if let Some(limits) = self.travel_limits.get() {
            return Ok(limits);
        }
        let mut limits = vec![f64::NAN; self.episodes.len()];
        for policy in BuiltIn::baselines() {
            let is_own = |(_, episode): &(usize, &EpisodePlan)| BuiltIn::baseline_of(&episode.task) == policy;
            let own: Vec<_> = self.numbered().filter(is_own).collect();
            for ((number, _), metrics) in own.iter().zip(self.run(&own, &policy)?) {
                limits[*number] = travel_limit(metrics.daily_travel);
            }
        }
        Ok(self.travel_limits.get_or_init(|| limits))
    }

    fn numbered(&self) -> impl Iterator<Item = (usize, &EpisodePlan)> {
        self.episodes.iter().map(|(episode, _)| episode).enumerate()
    }

    /// Returns the metrics of a policy in some of the episodes.
    fn run(&self, episodes: &[(usize, &EpisodePlan)], policy: &dyn Policy) -> Result<Vec<EpisodeMetrics>> {
        let outcomes: Mutex<Vec<Option<Outcome>>> = Mutex::new(vec![None; self.episodes.len()]);
        self.evaluation.run(episodes, policy, &(), &|number, outcome| {
            outcomes.lock().unwrap_or_else(PoisonError::into_inner)[number] = Some(outcome);
            Ok(())
        })?;
        let mut outcomes = outcomes.into_inner().unwrap_or_else(PoisonError::into_inner);
        let of = |(number, episode): &(usize, &EpisodePlan)| {
            let lost = |why: String| {
                Error::Invalid(format!("the evaluation in {} was lost: {why}", episode.subject.label()))
            };
            let finished = outcomes[*number].take().ok_or_else(|| lost("it did not run".into()))?;
            Ok(finished.map_err(|why| lost(why.reason))?.record.metrics)
        };
        episodes.iter().map(of).collect()
    }
}

impl Measures {
    /// Measures that are not known.
    pub(super) const UNKNOWN: Self = Self {
        score: f64::NAN,
        resolved_score: f64::NAN,
        rms_deviation_k: f64::NAN,
        energy_ratio: f64::NAN,
        travel_per_day: f64::NAN,
        relative_travel: f64::NAN,
        oscillating_share: f64::NAN,
        cost_ratio: f64::NAN,
        discomfort: f64::NAN,
        baseline_discomfort: f64::NAN,
    };

    fn of(metrics: &EpisodeMetrics, episode: &EpisodePlan, baseline: &Baseline, travel_limit: f64) -> Self {
        let used = metrics.used(episode.task.resource);
        let scores = baseline.scores(metrics, used, episode.steps_per_hour);
        let days = metrics.steps as f64 / (24.0 * f64::from(episode.steps_per_hour));
        let ratio = |own: Option<f64>, base: Option<f64>| match (own, base) {
            (Some(own), Some(base)) if baseline.discomfort.is_some() => own / base,
            _ => f64::NAN,
        };
        Self {
            score: scores.score.unwrap_or(f64::NAN),
            resolved_score: scores.resolved.unwrap_or(f64::NAN),
            rms_deviation_k: metrics.rms_deviation,
            energy_ratio: if baseline.energy > 0.0 { metrics.energy() / baseline.energy } else { f64::NAN },
            travel_per_day: metrics.daily_travel,
            relative_travel: metrics.daily_travel / travel_limit,
            oscillating_share: metrics.oscillating_share,
            cost_ratio: ratio(used, baseline.resource),
            discomfort: metrics.tdis_tot.map_or(f64::NAN, |total| total / days),
            baseline_discomfort: baseline.discomfort.map_or(f64::NAN, |total| total / days),
        }
    }

    /// Returns the criteria by which the best agent is chosen.
    pub(super) fn rating(&self) -> Rating {
        Rating { score: self.score, relative_travel: self.relative_travel }
    }

    /// Returns the measures by name, as they are in the progress of a run.
    pub(super) fn named(self) -> [(&'static str, f64); 10] {
        [
            ("score", self.score),
            ("resolved_score", self.resolved_score),
            ("rms_deviation_k", self.rms_deviation_k),
            ("energy_ratio", self.energy_ratio),
            ("travel_per_day", self.travel_per_day),
            ("relative_travel", self.relative_travel),
            ("oscillating_share", self.oscillating_share),
            ("cost_ratio", self.cost_ratio),
            ("discomfort", self.discomfort),
            ("baseline_discomfort", self.baseline_discomfort),
        ]
    }
}

impl Default for Rating {
    /// Returns the rating that any agent with a score is better than.
    fn default() -> Self {
        Self { score: f64::INFINITY, relative_travel: f64::INFINITY }
    }
}

impl Rating {
    /// Returns whether actuator travel is within its limit in every building.
    pub(super) fn is_within_travel_limit(self) -> bool {
        self.relative_travel <= 1.0
    }

    /// Returns whether an agent is better than another. An agent within the travel limit is better than one whose
    /// actuators hunt; otherwise, the one with the lower score is better. An agent without a score is never better.
    pub(super) fn is_better_than(self, other: Self) -> bool {
        match (self.is_within_travel_limit(), other.is_within_travel_limit()) {
            (true, false) => self.score.is_finite(),
            (false, true) => false,
            _ => self.score < other.score,
        }
    }
}

impl AgentScores {
    fn of(buildings: Vec<BuildingScores>) -> Self {
        let mean = |value: fn(&Measures) -> f64| {
            buildings.iter().map(|each| value(&each.measures)).sum::<f64>() / buildings.len().max(1) as f64
        };
        let relative_travel = buildings.iter().map(|each| each.measures.relative_travel).fold(0.0, f64::max);
        Self {
            mean: Measures {
                score: mean(|each| each.score),
                resolved_score: mean(|each| each.resolved_score),
                rms_deviation_k: mean(|each| each.rms_deviation_k),
                energy_ratio: mean(|each| each.energy_ratio),
                travel_per_day: mean(|each| each.travel_per_day),
                relative_travel,
                oscillating_share: mean(|each| each.oscillating_share),
                cost_ratio: mean(|each| each.cost_ratio),
                discomfort: mean(|each| each.discomfort),
                baseline_discomfort: mean(|each| each.baseline_discomfort),
            },
            buildings,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_agent_whose_actuators_hunt_is_the_best_only_while_there_is_no_other() {
        let rating = |score, relative_travel| Rating { score, relative_travel };
        let hunting = rating(0.8, 9.6);
        assert!(hunting.is_better_than(Rating::default()));
        assert!(rating(0.7, 20.0).is_better_than(hunting));
        let steady = rating(0.95, 1.0);
        assert!(steady.is_better_than(hunting) && !hunting.is_better_than(steady));
        assert!(rating(0.94, 0.2).is_better_than(steady) && !rating(0.96, 0.0).is_better_than(steady));
        let unknown = rating(f64::NAN, 0.0);
        assert!(!unknown.is_better_than(hunting) && !unknown.is_better_than(Rating::default()));
    }
}
