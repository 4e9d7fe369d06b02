//! Values of episodes by building.

use std::collections::BTreeMap;

use b2b_evaluate::statistics::median;
use b2b_evaluate::{EpisodeResult, Scored};

use crate::results::Results;

/// Returns a policy's episodes, from training runs with at least this many steps.
pub(super) fn trained<'a>(results: &'a Results, policy: &'a str, steps: u64) -> Vec<&'a EpisodeResult> {
    results.of(policy).filter(|(done, _)| done.steps >= steps).map(|(_, row)| row).collect()
}

/// Returns the values of episodes, by building.
pub(super) fn by_building<'a>(
    rows: &[&'a EpisodeResult],
    value: impl Fn(&'a Scored) -> Option<f64>,
) -> BTreeMap<&'a str, Vec<f64>> {
    let mut buildings: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for row in rows {
        let value = row.scored().and_then(&value);
        buildings.entry(&row.info.building).or_default().extend(value);
    }
    buildings.retain(|_, values| !values.is_empty());
    buildings
}

/// Returns the values of episodes, one list per building.
pub(crate) fn lists<'a>(
    rows: &[&'a EpisodeResult],
    value: impl Fn(&'a Scored) -> Option<f64>,
) -> Vec<Vec<f64>> {
    by_building(rows, value).into_values().collect()
}

/// Returns the natural logarithm of a score, for ratios between scores.
pub(super) fn log_score(scored: &Scored) -> Option<f64> {
    scored.score.map(log)
}

/// Returns the natural logarithm of a resolved score.
pub(super) fn log_resolved(scored: &Scored) -> Option<f64> {
    scored.resolved_score.map(log)
}

fn log(score: f64) -> f64 {
    const SMALLEST: f64 = 1e-6;
    score.max(SMALLEST).ln()
}

/// Returns the median of values of episodes.
pub(super) fn median_of<'a>(
    rows: &[&'a EpisodeResult],
    value: impl Fn(&'a Scored) -> Option<f64>,
) -> Option<f64> {
    let mut values: Vec<f64> = rows.iter().filter_map(|row| value(row.scored()?)).collect();
    values.sort_by(f64::total_cmp);
    (!values.is_empty()).then(|| median(&values))
}
