//! Scales of the operation rewards: the guideline controller's cost by class, and the matching weight of discomfort.

use std::collections::BTreeMap;

use b2b_building::Class;
use b2b_dataset::{BuildingName, Control};
use b2b_env::{CostScale, OPERATION_WEIGHT};
use serde::Serialize;

use crate::evaluation::EpisodeResult;

/// Approximate share of discomfort intended in the guideline controller's penalty.
const DISCOMFORT_SHARE: f64 = 0.1;

/// Episodes under one controller in buildings of the dataset.
#[derive(Clone, Copy, Debug)]
pub struct Operation<'a> {
    /// Name of the controller.
    pub policy: &'a str,
    /// The episodes.
    pub rows: &'a [EpisodeResult],
}

/// The weight that makes discomfort a tenth of a controller's penalty, and the numbers it is computed from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Balance {
    /// Building type; `all` for all types, each of which counts the same.
    pub building_type: String,
    /// Discomfort, mean over the episodes, K·h per zone and day.
    pub discomfort_per_day: f64,
    /// Share of discomfort in the penalty under the shipped weight.
    pub share: f64,
    /// The weight under which the share is a tenth.
    pub balanced_weight: f64,
}

/// The ranks of a controller under the weights in [`WEIGHTS`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ranked {
    /// Name of the controller.
    pub policy: String,
    /// Mean cost penalty of a step, in units of the class's mean cost per step.
    pub cost: f64,
    /// Discomfort, K·h per zone and day.
    pub discomfort_per_day: f64,
    /// Mean penalty of a step under each weight.
    pub penalties: [f64; WEIGHTS.len()],
    /// Rank under each weight, from 1.
    pub ranks: [usize; WEIGHTS.len()],
    /// Mean score at comfort; `None` if an episode has none.
    pub score: Option<f64>,
}

/// Weights of discomfort for ranking controllers, relative to the shipped weight.
pub const WEIGHTS: [f64; 3] = [0.25, 1.0, 4.0];

/// An episode in the units of the reward.
struct OperationEpisode {
    class: Class,
    building: String,
    /// Currency/m².
    cost: f64,
    /// K·h per zone.
    discomfort: f64,
    hours: f64,
    score: Option<f64>,
}

/// Returns the mean cost of an hour in each class that has episodes, in the order of the classes.
pub fn cost_scales(rows: &[EpisodeResult]) -> Vec<CostScale> {
    let mut classes: BTreeMap<Class, Vec<OperationEpisode>> = BTreeMap::new();
    for episode in rows.iter().filter_map(OperationEpisode::of) {
        classes.entry(episode.class).or_default().push(episode);
    }
    let scale = |(class, episodes): (Class, Vec<OperationEpisode>)| {
        let mut buildings: Vec<String> = episodes.iter().map(|episode| episode.building.clone()).collect();
        buildings.dedup();
        let cost: f64 = episodes.iter().map(|episode| episode.cost).sum();
        let hours: f64 = episodes.iter().map(|episode| episode.hours).sum();
        CostScale { class, cost_scale: cost / hours, buildings }
    };
    classes.into_iter().map(scale).collect()
}

/// Returns the weights that make discomfort a tenth of the penalty of the controller whose costs are the scales, for
/// each type and for all.
pub fn balances(rows: &[EpisodeResult]) -> Vec<Balance> {
    let mut types: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for row in rows {
        let Some(episode) = OperationEpisode::of(row) else { continue };
        types.entry(&row.info.building_type).or_default().push(episode.discomfort / episode.hours);
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let means: Vec<(&str, f64)> = types.iter().map(|(name, values)| (*name, mean(values))).collect();
    let all = mean(&means.iter().map(|(_, mean)| *mean).collect::<Vec<_>>());
    means.into_iter().chain([("all", all)]).map(|(name, mean)| Balance::of(name, mean)).collect()
}

/// Ranks controllers by their mean penalty under each weight. A cost equal to its class's `scales` counts as 1.
pub fn rank(operations: &[Operation<'_>], scales: &[CostScale]) -> Vec<Ranked> {
    let mut ranked: Vec<Ranked> = operations.iter().map(|each| Ranked::of(each, scales)).collect();
    for weight in 0..WEIGHTS.len() {
        let penalties: Vec<f64> = ranked.iter().map(|each| each.penalties[weight]).collect();
        for each in &mut ranked {
            let own = each.penalties[weight];
            each.ranks[weight] = 1 + penalties.iter().filter(|penalty| **penalty < own).count();
        }
    }
    ranked
}

impl Balance {
    /// Returns the balance for a mean discomfort, K.
    fn of(building_type: &str, mean: f64) -> Self {
        let penalty = OPERATION_WEIGHT * mean;
        Self {
            building_type: building_type.to_owned(),
            discomfort_per_day: 24.0 * mean,
            share: penalty / (1.0 + penalty),
            balanced_weight: DISCOMFORT_SHARE / (1.0 - DISCOMFORT_SHARE) / mean,
        }
    }
}

impl Ranked {
    fn of(operation: &Operation<'_>, scales: &[CostScale]) -> Self {
        let episodes: Vec<OperationEpisode> =
            operation.rows.iter().filter_map(OperationEpisode::of).collect();
        let mean = |value: &dyn Fn(&OperationEpisode) -> f64| {
            episodes.iter().map(value).sum::<f64>() / episodes.len() as f64
        };
        let scale_of = |class: Class| {
            scales.iter().find(|scale| scale.class == class).map_or(f64::NAN, |scale| scale.cost_scale)
        };
        let cost = mean(&|episode| episode.cost / (episode.hours * scale_of(episode.class)));
        let discomfort = mean(&|episode| episode.discomfort / episode.hours);
        let scores: Option<Vec<f64>> = episodes.iter().map(|episode| episode.score).collect();
        Self {
            policy: operation.policy.to_owned(),
            cost,
            discomfort_per_day: 24.0 * discomfort,
            penalties: WEIGHTS.map(|weight| cost + weight * OPERATION_WEIGHT * discomfort),
            ranks: [0; WEIGHTS.len()],
            score: scores.map(|scores| scores.iter().sum::<f64>() / scores.len() as f64),
        }
    }
}

impl OperationEpisode {
    /// Returns `None` for a lost episode, a building outside the dataset, or a task with targets.
    fn of(row: &EpisodeResult) -> Option<Self> {
        let (name, _) = Control::split_name(&row.info.building);
        let Ok(BuildingName::Id(id)) = name.parse() else { return None };
        let metrics = row.metrics()?;
        Some(Self {
            class: b2b_dataset::row(id).building.class(),
            building: row.info.building.clone(),
            cost: metrics.cost_tot?,
            discomfort: metrics.tdis_tot?,
            hours: metrics.steps as f64 / f64::from(row.info.steps_per_hour),
            score: row.score(),
        })
    }
}

#[cfg(test)]
mod tests {
    use b2b_env::EpisodeMetrics;

    use super::*;
    use crate::evaluation::{EpisodeInfo, EpisodePlan, Scored};
    use crate::{BuiltIn, Subject};

    /// Two weeks of a building at a cost per m² and a discomfort in K·h per zone.
    fn row(building: &str, cost: f64, discomfort: f64) -> EpisodeResult {
        let episode = EpisodePlan {
            subject: Subject::at_home(building.parse().unwrap()),
            task: "operate".parse().unwrap(),
            period: "peak-heating".parse().unwrap(),
            seed: 0,
            steps_per_hour: 12,
        };
        let metrics = EpisodeMetrics {
            steps: 14 * 288,
            cost_tot: Some(cost),
            tdis_tot: Some(discomfort),
            ..EpisodeMetrics::default()
        };
        let scored = Scored { metrics, score: Some(cost), ..Scored::default() };
        EpisodeResult { info: EpisodeInfo::of(&episode, &BuiltIn::guideline36()), outcome: Ok(scored) }
    }

    #[test]
    fn the_scale_of_a_class_is_its_mean_cost_of_an_hour() {
        let rows = [row("SingleFamilyHouse-1", 0.336, 0.0), row("SingleFamilyHouse-2", 0.672, 0.0)];
        let scales = cost_scales(&rows);
        assert_eq!(scales.len(), 1);
        assert!((scales[0].cost_scale - 1.5e-3).abs() < 1e-12);
        assert_eq!(scales[0].buildings, ["SingleFamilyHouse-0001", "SingleFamilyHouse-0002"]);
    }

    #[test]
    fn under_the_balanced_weight_discomfort_is_a_tenth_of_the_penalty() {
        let balance = &balances(&[row("SingleFamilyHouse-1", 0.336, 3.36)])[1];
        let penalty = balance.balanced_weight * 0.01;
        assert!((penalty / (1.0 + penalty) - 0.1).abs() < 1e-12);
        assert!((balance.discomfort_per_day - 0.24).abs() < 1e-12);
    }

    #[test]
    fn a_larger_weight_ranks_a_cold_building_lower() {
        let [cheap, warm] =
            [[row("SingleFamilyHouse-1", 0.0, 10.0)], [row("SingleFamilyHouse-1", 0.336, 0.0)]];
        let operations =
            [Operation { policy: "cold", rows: &cheap }, Operation { policy: "warm", rows: &warm }];
        let ranked = rank(&operations, &cost_scales(&warm));
        // Half of 10 days of cost, in two weeks.
        assert!((ranked[0].penalties[1] - 5.0 / 14.0).abs() < 1e-12);
        assert_eq!((ranked[0].ranks, ranked[1].ranks), ([1, 1, 2], [2, 2, 1]));
    }
}
