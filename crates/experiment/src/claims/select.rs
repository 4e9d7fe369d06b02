//! Values of episodes.

use b2b_evaluate::Scored;
use b2b_evaluate::statistics::median;

use crate::results::{Ran, Results};

/// Returns a policy's episodes, from training runs with at least this many steps.
pub(super) fn trained<'a>(results: &'a Results, policy: &'a str, steps: u64) -> Vec<Ran<'a>> {
    results.of(policy).filter(|(done, _)| done.steps >= steps).collect()
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
pub(super) fn median_of<'a>(rows: &[Ran<'a>], value: impl Fn(&'a Scored) -> Option<f64>) -> Option<f64> {
    let mut values: Vec<f64> = rows.iter().filter_map(|(_, row)| value(row.scored()?)).collect();
    values.sort_by(f64::total_cmp);
    (!values.is_empty()).then(|| median(&values))
}
