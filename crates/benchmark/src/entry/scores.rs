//! The scores of a stage: grouped by building, and by stratum for the bootstrap.

use serde::{Deserialize, Serialize};

use crate::evaluation::Row;
use crate::statistics::Cluster;

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
    /// Mean over seeds.
    pub score: f64,
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

    /// Returns the mean over seeds with what it belongs to.
    pub(super) fn score(&self) -> Score {
        let Self { building, task, period, .. } = self;
        Score { building: building.clone(), task: task.clone(), period: period.clone(), score: self.mean() }
    }

    /// Returns by how much the mean of `other` is lower, as the scores of the same building.
    pub(super) fn improvement(&self, other: &Self) -> Self {
        Self {
            building: other.building.clone(),
            building_type: other.building_type.clone(),
            task: other.task.clone(),
            period: other.period.clone(),
            seeds: vec![self.mean() - other.mean()],
        }
    }

    fn stratum(&self) -> StratumKey {
        (self.building_type.clone(), self.task.clone(), self.period.clone())
    }
}

/// Groups the scores of rows by building, task and run period, in the order of the rows.
pub(super) fn by_building(rows: &[Row]) -> Vec<SeedScores> {
    let mut groups: Vec<SeedScores> = Vec::new();
    for row in rows {
        let (info, Some(score)) = (&row.info, row.score()) else { continue };
        // Seeds of a building are adjacent.
        let known = groups.iter_mut().rev().find(|group| {
            group.building == info.building && group.task == info.task && group.period == info.period
        });
        match known {
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
