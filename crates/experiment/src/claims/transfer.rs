//! The paper's claims about one policy for four building types.

use b2b_evaluate::statistics::{is_below_baseline, mean, median};

use super::claim::{Claim, Judged, Side, deviations_text};
use super::interval::measured;
use super::select::{median_of, trained};
use crate::absolute::{deviation, reactive_deviation};
use crate::results::{Results, samples};

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
        "median RMS deviation (K)",
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
    let remark = deviations_text(median_of(&all, deviation), median_of(&all, reactive_deviation));
    let won = |scored: &b2b_evaluate::Scored| Some(f64::from(is_below_baseline(scored.score?)));
    vec![
        adapts.judge(measured(&samples(&all, deviation), median), &remark),
        beats.judge(measured(&samples(&all, won), mean), ""),
    ]
}
