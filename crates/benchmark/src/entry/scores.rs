//! The scores of a stage by building.

use serde::{Deserialize, Serialize};

use b2b_evaluate::any_number;
use b2b_evaluate::statistics::{Aggregate, Sample, aggregate, mean};
use b2b_evaluate::{EpisodeInfo, EpisodeResult, relative_energy};

use crate::problem::Stage;

/// The score of a building under a task in a run period.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// The building.
    pub building: String,
    /// The task.
    pub task: String,
    /// The run period.
    pub period: String,
    /// Score as in the paper, mean over seeds.
    #[serde(with = "any_number")]
    pub score: f64,
    /// Resolved score, mean over seeds.
    #[serde(with = "any_number")]
    pub resolved_score: f64,
    /// RMS deviation from target, mean over seeds, K.
    pub rms_deviation_k: f64,
    /// HVAC energy relative to the baseline; `None` if the baseline's is 0.
    pub relative_energy: Option<f64>,
}

/// Performance over a set of episodes. In JSON, the fields of the paper's score stand next to the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Performance {
    /// Scores as in the paper.
    #[serde(flatten)]
    pub scores: Aggregate,
    /// Resolved scores.
    pub resolved: Aggregate,
    /// RMS deviation from target, mean over episodes, K.
    pub rms_deviation_k: f64,
    /// HVAC energy relative to the baseline; `None` if the baseline's is 0.
    pub relative_energy: Option<f64>,
}

impl Performance {
    /// Returns the performance in some rows of a stage; `None` if none has a score.
    pub(super) fn of<'a>(
        stage: Stage,
        rows: impl IntoIterator<Item = &'a EpisodeResult> + Clone,
    ) -> Option<Self> {
        let sample = |row: &'a EpisodeResult, score: f64| {
            let sample = Sample::of(&row.info, score);
            // Specialists act in one building each.
            if stage == Stage::UpperBound { Sample { agent: sample.building, ..sample } } else { sample }
        };
        let aggregated = |score: fn(&EpisodeResult) -> Option<f64>| {
            let samples = rows.clone().into_iter().filter_map(|row| Some(sample(row, score(row)?)));
            aggregate(&samples.collect::<Vec<_>>())
        };
        Some(Self {
            scores: aggregated(EpisodeResult::score)?,
            resolved: aggregated(EpisodeResult::resolved_score)?,
            rms_deviation_k: mean_deviation(rows.clone()),
            relative_energy: relative_energy(rows),
        })
    }
}

/// Returns the mean over the rows that were not lost, K.
pub(super) fn mean_deviation<'a>(rows: impl IntoIterator<Item = &'a EpisodeResult>) -> f64 {
    let metrics = rows.into_iter().filter_map(EpisodeResult::metrics);
    let values: Vec<f64> = metrics.map(|metrics| metrics.rms_deviation).collect();
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The scores of a building under a task in a run period, with their seeds.
pub(super) struct SeedScores<'a> {
    /// The first seed's episode.
    info: &'a EpisodeInfo,
    seeds: Vec<(u64, f64)>,
}

impl<'a> SeedScores<'a> {
    /// Returns the mean over seeds.
    pub(super) fn mean(&self) -> f64 {
        mean(&self.seeds.iter().map(|(_, score)| *score).collect::<Vec<_>>())
    }

    /// Returns whether an episode has the same building, task and run period.
    fn has(&self, info: &EpisodeInfo) -> bool {
        let EpisodeInfo { building, task, period, .. } = self.info;
        [building, task, period] == [&info.building, &info.task, &info.period]
    }

    /// Returns the scores after a change.
    fn map(&self, change: impl Fn(f64) -> f64) -> Self {
        let seeds = self.seeds.iter().map(|(seed, score)| (*seed, change(*score))).collect();
        Self { info: self.info, seeds }
    }

    /// Returns the mean of a group of the same building, task and run period minus each score; `None` without such a
    /// group.
    pub(super) fn improvement(&self, from: &[SeedScores<'_>]) -> Option<Self> {
        let from = from.iter().find(|other| other.has(self.info))?.mean();
        Some(self.map(|score| from - score))
    }
}

/// Groups the scores of rows by building, task and run period, in the order of the rows.
pub(super) fn by_building<'a>(
    rows: impl IntoIterator<Item = &'a EpisodeResult>,
    score: impl Fn(&EpisodeResult) -> Option<f64>,
) -> Vec<SeedScores<'a>> {
    let mut groups: Vec<SeedScores<'a>> = Vec::new();
    for row in rows {
        let (info, Some(score)) = (&row.info, score(row)) else { continue };
        // Seeds of a building are adjacent.
        match groups.iter_mut().rev().find(|group| group.has(info)) {
            Some(group) => group.seeds.push((info.seed, score)),
            None => groups.push(SeedScores { info, seeds: vec![(info.seed, score)] }),
        }
    }
    groups
}

/// Returns the scores of rows on the scale where random actions have 0 and the baseline has 1: the decrease of the
/// penalty from random actions, divided by the baseline's decrease. Scores and resolved scores give the same. Leaves
/// out buildings that were not run under random actions, or where random actions are at least as good as the baseline.
pub(super) fn from_random<'a>(rows: &'a [EpisodeResult], random: &[EpisodeResult]) -> Vec<SeedScores<'a>> {
    let random = by_building(random, EpisodeResult::score);
    let scaled = |group: SeedScores<'a>| {
        let highest = random.iter().find(|other| other.has(group.info))?.mean();
        (highest > 1.0).then(|| group.map(|score| (highest - score) / (highest - 1.0)))
    };
    by_building(rows, EpisodeResult::score).into_iter().filter_map(scaled).collect()
}

/// Returns the scores of every building, means over seeds.
pub(super) fn building_scores(rows: &[EpisodeResult]) -> Vec<Score> {
    let resolved = by_building(rows, EpisodeResult::resolved_score);
    let score = |group: &SeedScores<'_>| {
        let own: Vec<&EpisodeResult> = rows.iter().filter(|row| group.has(&row.info)).collect();
        let EpisodeInfo { building, task, period, .. } = group.info.clone();
        Some(Score {
            building,
            task,
            period,
            score: group.mean(),
            resolved_score: resolved.iter().find(|other| other.has(group.info))?.mean(),
            rms_deviation_k: mean_deviation(own.iter().copied()),
            relative_energy: relative_energy(own.iter().copied()),
        })
    };
    by_building(rows, EpisodeResult::score).iter().filter_map(score).collect()
}

/// Returns the scores as they are drawn.
pub(super) fn samples<'a>(groups: &[SeedScores<'a>]) -> Vec<Sample<'a>> {
    let samples = groups.iter().flat_map(|SeedScores { info, seeds }| {
        seeds.iter().map(|(seed, score)| Sample { seed: *seed, ..Sample::of(info, *score) })
    });
    samples.collect()
}
