//! Scores of an agent against the reactive controllers.

use std::sync::{Mutex, PoisonError};

use b2b_agent::Agent;
use b2b_benchmark::{Baseline, Episode, Evaluation, Outcome};
use b2b_building::RunPeriod;
use serde::Serialize;

use crate::error::{Error, Result};

/// Episodes that agents are scored on.
pub(super) struct Judge<'a> {
    evaluation: &'a Evaluation<'a>,
    episodes: Vec<(Episode, Baseline)>,
}

/// What an agent is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measures {
    /// Score against the reactive controllers: below 1 beats them.
    pub score: f64,
    /// Resolved score: see [`b2b_benchmark::resolved_score`].
    pub resolved_score: f64,
    /// Root mean square deviation from target, K.
    pub rms_deviation_k: f64,
    /// HVAC energy over that of the reactive controllers.
    pub energy_ratio: f64,
    /// Actuator travel, full strokes a day: a limit cycle shows here.
    pub travel_per_day: f64,
}

/// The scores of an agent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scores {
    /// Means over its buildings.
    #[serde(flatten)]
    pub mean: Measures,
    /// The same for each building, if there are several.
    #[serde(rename = "by_building", skip_serializing_if = "Vec::is_empty")]
    pub buildings: Vec<BuildingScores>,
}

/// The scores of an agent in one building.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BuildingScores {
    /// The building.
    pub building: String,
    /// Its scores.
    #[serde(flatten)]
    pub measures: Measures,
}

impl<'a> Judge<'a> {
    /// Returns the judge of episodes with what they are scored against.
    pub(super) fn new(evaluation: &'a Evaluation<'a>, episodes: Vec<(Episode, Baseline)>) -> Self {
        Self { evaluation, episodes }
    }

    /// Returns the scores of an agent. It acts without exploration.
    pub(super) fn judge(&self, agent: &Agent) -> Result<Scores> {
        let outcomes: Mutex<Vec<Option<Outcome>>> = Mutex::new(vec![None; self.episodes.len()]);
        let numbered: Vec<_> = self.episodes.iter().map(|(episode, _)| episode).enumerate().collect();
        self.evaluation.run(&numbered, agent, &(), &|number, outcome| {
            outcomes.lock().unwrap_or_else(PoisonError::into_inner)[number] = Some(outcome);
            Ok(())
        })?;
        let outcomes = outcomes.into_inner().unwrap_or_else(PoisonError::into_inner);
        let scored = self.episodes.iter().zip(outcomes).map(|(known, outcome)| scores(known, outcome));
        Ok(Scores::of(scored.collect::<Result<_>>()?))
    }
}

fn scores((episode, baseline): &(Episode, Baseline), outcome: Option<Outcome>) -> Result<BuildingScores> {
    let building = episode.subject.name.to_string();
    let lost = |why: String| Error::Invalid(format!("the evaluation in {building} was lost: {why}"));
    let finished = outcome.ok_or_else(|| lost("it did not run".into()))?.map_err(|why| lost(why.reason))?;
    let metrics = finished.record.metrics;
    let measures = Measures {
        score: baseline.score(metrics.episode_return).unwrap_or(f64::NAN),
        resolved_score: baseline.resolved_score(metrics.episode_return, metrics.steps).unwrap_or(f64::NAN),
        rms_deviation_k: metrics.rms_deviation,
        energy_ratio: if baseline.energy > 0.0 { metrics.energy() / baseline.energy } else { f64::NAN },
        travel_per_day: metrics.daily_travel,
    };
    Ok(BuildingScores { building, measures })
}

impl Measures {
    /// Measures that are not known.
    pub(super) const UNKNOWN: Self = Self {
        score: f64::NAN,
        resolved_score: f64::NAN,
        rms_deviation_k: f64::NAN,
        energy_ratio: f64::NAN,
        travel_per_day: f64::NAN,
    };

    /// Returns the measures by name, as they are in the progress of a run.
    pub(super) fn named(self) -> [(&'static str, f64); 5] {
        [
            ("score", self.score),
            ("resolved_score", self.resolved_score),
            ("rms_deviation_k", self.rms_deviation_k),
            ("energy_ratio", self.energy_ratio),
            ("travel_per_day", self.travel_per_day),
        ]
    }
}

impl Scores {
    fn of(buildings: Vec<BuildingScores>) -> Self {
        let mean = |value: fn(&Measures) -> f64| {
            buildings.iter().map(|each| value(&each.measures)).sum::<f64>() / buildings.len().max(1) as f64
        };
        Self {
            mean: Measures {
                score: mean(|each| each.score),
                resolved_score: mean(|each| each.resolved_score),
                rms_deviation_k: mean(|each| each.rms_deviation_k),
                energy_ratio: mean(|each| each.energy_ratio),
                travel_per_day: mean(|each| each.travel_per_day),
            },
            buildings: if buildings.len() > 1 { buildings } else { Vec::new() },
        }
    }
}

/// Returns `days` days in the middle of a run period.
pub(super) fn window(period: RunPeriod, days: u32) -> RunPeriod {
    period.part(period.days().saturating_sub(days) / 2, days)
}
