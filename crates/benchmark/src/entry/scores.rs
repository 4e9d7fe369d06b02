//! The scores of a stage: grouped by building, and by stratum for the bootstrap.

use serde::{Deserialize, Serialize};

use b2b_evaluate::any_number;
use b2b_evaluate::statistics::{Aggregate, Cluster, aggregate_clusters};
use b2b_evaluate::{EpisodeResult, relative_energy};

/// Seed of the bootstrap.
pub(super) const SEED: u64 = 0;

/// Building type, task and run period.
pub(super) type StratumKey = (String, String, String);

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
    /// Returns the performance in some rows; `None` if none has a score.
    pub(super) fn of<'a>(rows: impl IntoIterator<Item = &'a EpisodeResult> + Clone) -> Option<Self> {
        let aggregate = |score: fn(&EpisodeResult) -> Option<f64>| {
            aggregate_clusters(&clusters(&by_building(rows.clone(), score)), SEED)
        };
        Some(Self {
            scores: aggregate(EpisodeResult::score)?,
            resolved: aggregate(EpisodeResult::resolved_score)?,
            rms_deviation_k: mean_deviation(rows.clone()),
            relative_energy: relative_energy(rows),
        })
    }
}

/// Returns the mean over the rows that were not lost, K.
fn mean_deviation<'a>(rows: impl IntoIterator<Item = &'a EpisodeResult>) -> f64 {
    let metrics = rows.into_iter().filter_map(EpisodeResult::metrics);
    let values: Vec<f64> = metrics.map(|metrics| metrics.rms_deviation).collect();
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The scores of a building under a task in a run period, one per seed.
pub(super) struct SeedScores {
    building: String,
    building_type: String,
    task: String,
    period: String,
    seeds: Cluster,
}

impl SeedScores {
    /// Returns the mean over seeds.
    pub(super) fn mean(&self) -> f64 {
        self.seeds.iter().sum::<f64>() / self.seeds.len() as f64
    }

    /// Returns whether a row has the same building, task and run period.
    fn has(&self, row: &EpisodeResult) -> bool {
        self.building == row.info.building && self.task == row.info.task && self.period == row.info.period
    }

    /// Returns whether other scores have the same building, task and run period.
    fn is_of(&self, other: &Self) -> bool {
        self.building == other.building && self.task == other.task && self.period == other.period
    }

    /// Returns the mean minus each score of `other`, as scores of the same building.
    pub(super) fn improvement(&self, other: &Self) -> Self {
        Self {
            building: other.building.clone(),
            building_type: other.building_type.clone(),
            task: other.task.clone(),
            period: other.period.clone(),
            seeds: other.seeds.iter().map(|score| self.mean() - score).collect(),
        }
    }

    fn stratum(&self) -> StratumKey {
        (self.building_type.clone(), self.task.clone(), self.period.clone())
    }
}

/// Groups the scores of rows by building, task and run period, in the order of the rows.
pub(super) fn by_building<'a>(
    rows: impl IntoIterator<Item = &'a EpisodeResult>,
    score: impl Fn(&EpisodeResult) -> Option<f64>,
) -> Vec<SeedScores> {
    let mut groups: Vec<SeedScores> = Vec::new();
    for row in rows {
        let (info, Some(score)) = (&row.info, score(row)) else { continue };
        // Seeds of a building are adjacent.
        match groups.iter_mut().rev().find(|group| group.has(row)) {
            Some(group) => group.seeds.push(score),
            None => groups.push(SeedScores {
                building: info.building.clone(),
                building_type: info.building_type.clone(),
                task: info.task.clone(),
                period: info.period.clone(),
                seeds: vec![score],
            }),
        }
    }
    groups
}

/// Returns the scores of rows on the scale where random actions have 0 and the baseline has 1: the decrease of the
/// penalty from random actions, divided by the baseline's decrease. Scores and resolved scores give the same. Leaves
/// out buildings that were not run under random actions, or where random actions are at least as good as the baseline.
pub(super) fn from_random(rows: &[EpisodeResult], random: &[EpisodeResult]) -> Vec<SeedScores> {
    let random = by_building(random, EpisodeResult::score);
    let scaled = |group: SeedScores| {
        let highest = random.iter().find(|other| other.is_of(&group))?.mean();
        let scale = |score: &f64| (highest - score) / (highest - 1.0);
        let seeds = group.seeds.iter().map(scale).collect();
        (highest > 1.0).then_some(SeedScores { seeds, ..group })
    };
    by_building(rows, EpisodeResult::score).into_iter().filter_map(scaled).collect()
}

/// Returns the scores of every building, means over seeds.
pub(super) fn building_scores(rows: &[EpisodeResult]) -> Vec<Score> {
    let resolved = by_building(rows, EpisodeResult::resolved_score);
    let score = |group: &SeedScores| {
        let own: Vec<&EpisodeResult> = rows.iter().filter(|row| group.has(row)).collect();
        let same = |other: &&SeedScores| own.first().is_some_and(|row| other.has(row));
        Some(Score {
            building: group.building.clone(),
            task: group.task.clone(),
            period: group.period.clone(),
            score: group.mean(),
            resolved_score: resolved.iter().find(same)?.mean(),
            rms_deviation_k: mean_deviation(own.iter().copied()),
            relative_energy: relative_energy(own.iter().copied()),
        })
    };
    by_building(rows, EpisodeResult::score).iter().filter_map(score).collect()
}

/// Returns whether a row belongs to a stratum.
pub(super) fn is_in(row: &EpisodeResult, (building_type, task, period): &StratumKey) -> bool {
    row.info.building_type == *building_type && row.info.task == *task && row.info.period == *period
}

/// Groups scores by stratum, in order of first appearance.
pub(super) fn strata(groups: &[SeedScores]) -> Vec<(StratumKey, Vec<Cluster>)> {
    let mut strata: Vec<(StratumKey, Vec<Cluster>)> = Vec::new();
    for group in groups {
        let key = group.stratum();
        match strata.iter_mut().find(|(known, _)| *known == key) {
            Some((_, clusters)) => clusters.push(group.seeds.clone()),
            None => strata.push((key, vec![group.seeds.clone()])),
        }
    }
    strata
}

/// Returns the clusters of each stratum.
pub(super) fn clusters(groups: &[SeedScores]) -> Vec<Vec<Cluster>> {
    strata(groups).into_iter().map(|(_, clusters)| clusters).collect()
}
