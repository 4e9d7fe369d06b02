//! Scores of an agent against the reactive controllers.

use std::sync::{Mutex, PoisonError};

use b2b_agent::Agent;
use b2b_benchmark::{Baseline, Baselines, Episode, Evaluation, Outcome, Subject};
use b2b_building::{Date, RunPeriod};
use b2b_dataset::{BuildingName, Catalog};
use b2b_energyplus::install::Quiet;
use serde::Serialize;

use super::config::TrainConfig;
use crate::error::{Error, Result};

/// Episodes that agents are scored on.
pub(super) struct Judge<'a> {
    evaluation: &'a Evaluation<'a>,
    episodes: Vec<(Episode, Baseline)>,
}

/// The scores of an agent: means over its buildings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scores {
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
    /// The same for each building.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub buildings: Vec<BuildingScores>,
}

/// The scores of an agent in one building.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BuildingScores {
    /// The building.
    pub building: String,
    /// As [`Scores::score`].
    pub score: f64,
    /// As [`Scores::resolved_score`].
    pub resolved_score: f64,
    /// As [`Scores::rms_deviation_k`].
    pub rms_deviation_k: f64,
    /// As [`Scores::energy_ratio`].
    pub energy_ratio: f64,
    /// As [`Scores::travel_per_day`].
    pub travel_per_day: f64,
}

impl<'a> Judge<'a> {
    /// Returns the judge of episodes of these buildings over a period. Baselines that are unknown are computed.
    pub(super) fn new(
        config: &TrainConfig,
        buildings: &[BuildingName],
        period: RunPeriod,
        evaluation: &'a Evaluation<'a>,
        baselines: &Baselines,
        catalog: &Catalog,
    ) -> Result<Self> {
        let episode = |name: &BuildingName| {
            let subject = Subject::at_home(name.clone());
            let site = subject.locate(catalog, &mut Quiet)?;
            let (task, steps_per_hour) = (config.task()?, config.steps_per_hour);
            let episode = Episode { subject, task, period, seed: 0, steps_per_hour };
            let baseline = baselines.baseline(evaluation, &episode, &site, &())?;
            Ok((episode, baseline))
        };
        Ok(Self { evaluation, episodes: buildings.iter().map(episode).collect::<Result<_>>()? })
    }

    /// Returns the judge with episodes that are run otherwise.
    pub(super) fn with_evaluation(self, evaluation: &'a Evaluation<'a>) -> Self {
        Self { evaluation, ..self }
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
        Ok(Scores::mean(scored.collect::<Result<_>>()?))
    }
}

fn scores((episode, baseline): &(Episode, Baseline), outcome: Option<Outcome>) -> Result<BuildingScores> {
    let building = episode.subject.name.to_string();
    let lost = |why: String| Error::Invalid(format!("the evaluation in {building} was lost: {why}"));
    let finished = outcome.ok_or_else(|| lost("it did not run".into()))?.map_err(|why| lost(why.reason))?;
    let metrics = finished.record.metrics;
    let energy = metrics.electricity + metrics.gas;
    Ok(BuildingScores {
        score: baseline.score(metrics.episode_return).unwrap_or(f64::NAN),
        resolved_score: baseline.resolved_score(metrics.episode_return, metrics.steps).unwrap_or(f64::NAN),
        rms_deviation_k: metrics.rms_deviation,
        energy_ratio: if baseline.energy > 0.0 { energy / baseline.energy } else { f64::NAN },
        travel_per_day: metrics.daily_travel,
        building,
    })
}

impl Scores {
    fn mean(buildings: Vec<BuildingScores>) -> Self {
        let mean = |value: fn(&BuildingScores) -> f64| {
            buildings.iter().map(value).sum::<f64>() / buildings.len().max(1) as f64
        };
        Self {
            score: mean(|each| each.score),
            resolved_score: mean(|each| each.resolved_score),
            rms_deviation_k: mean(|each| each.rms_deviation_k),
            energy_ratio: mean(|each| each.energy_ratio),
            travel_per_day: mean(|each| each.travel_per_day),
            buildings: if buildings.len() > 1 { buildings } else { Vec::new() },
        }
    }
}

/// Returns `days` days in the middle of a run period.
pub(super) fn window(period: RunPeriod, days: u32) -> RunPeriod {
    let days = days.clamp(1, period.days());
    let first = period.first().day_of_year() + (period.days() - days) / 2;
    let [first, last] = [first, first + days - 1].map(Date::of_day);
    RunPeriod::new(first, last).unwrap_or(period)
}
