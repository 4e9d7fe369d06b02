//! The paper's claims about one policy for four building types.

use std::collections::{BTreeMap, BTreeSet};

use b2b_evaluate::statistics::{is_below_baseline, mean, median};

use super::claim::{Claim, Judged, Side, deviations_text};
use super::interval::measured;
use super::select::{median_of, trained};
use crate::absolute::{deviation, reactive_deviation};
use crate::results::{Ran, Results, samples};

/// Name of the agent with the paper's setting.
const AGENT: &str = "amorpheus";
const STEPS: u64 = 1_000_000;
const CAVEAT: &str = "buildings, baseline and the scaling of observations are not the paper's, and its learner is not published";

pub(super) fn judge(results: &Results) -> Vec<Judged> {
    let all = trained(results, AGENT, STEPS);
    let claim = |text: &str, quantity, side, bound, margin| Claim {
        text: text.into(),
        quantity,
        side,
        bound,
        margin,
        caveat: CAVEAT,
    };
    let adapts = claim(
        "One policy adapts to unseen buildings of four types",
        "median RMS deviation of the worst type (K)",
        Side::Below,
        1.0,
        0.1,
    );
    let beats = claim(
        "It even outperforms the reactive controllers in some of them",
        "share of buildings and seeds with a score below 1",
        Side::Above,
        0.01,
        0.0,
    );
    let trainings = all.iter().map(|(job, _)| &job.key).collect::<BTreeSet<_>>().len();
    let mut types: BTreeMap<&str, Vec<Ran<'_>>> = BTreeMap::new();
    for &(job, row) in &all {
        types.entry(&row.info.building_type).or_default().push((job, row));
    }
    let by_type =
        types.iter().filter_map(|(name, rows)| Some((measured(&samples(rows, deviation), median)?, *name)));
    let worst = by_type.max_by(|a, b| a.0.interval.value.total_cmp(&b.0.interval.value));
    let remark = worst.as_ref().map_or(String::new(), |(_, name)| {
        let all = deviations_text(median_of(&all, deviation), median_of(&all, reactive_deviation));
        format!("{name}; of all types, {all}; {trainings} trainings")
    });
    let won = |scored: &b2b_evaluate::Scored| Some(f64::from(is_below_baseline(scored.score?)));
    vec![
        adapts.judge(worst.map(|(measured, _)| measured), &remark),
        beats.judge(measured(&samples(&all, won), mean), ""),
    ]
}
