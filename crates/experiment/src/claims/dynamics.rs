//! The paper's claims about dynamics adaptation.

use b2b_evaluate::statistics::{median, quantile, score_text};

use super::claim::{Claim, Judged, Side, deviations_text};
use super::interval::{Measured, by_seed, difference, measured};
use super::select::{log_score, median_of, trained};
use crate::absolute::{deviation, reactive_deviation};
use crate::results::{Ran, Results, samples};

const STEPS: u64 = 4_000_000;
const AGENTS: [&str; 3] = ["specialist", "parameterized", "generalist"];
const CAVEAT: &str = "houses, their attributes and the scaling of observations are not the paper's";

pub(super) fn judge(results: &Results) -> Vec<Judged> {
    let [specialist, parameterized, generalist] = AGENTS.map(|agent| trained(results, agent, STEPS));
    let mut judged = vec![
        below(
            "Specialists score lower than the parameterized agent, with a substantial gap",
            &specialist,
            &parameterized,
        ),
        below(
            "Specialists score lower than the generalist, with a substantial gap",
            &specialist,
            &generalist,
        ),
        below("The parameterized agent scores lower than the generalist", &parameterized, &generalist),
        around_target(&[&specialist, &parameterized, &generalist]),
    ];
    judged.push(tail(
        "The generalist has a long tail: transfer failed in a few houses",
        Side::Above,
        &generalist,
    ));
    judged.push(tail("The parameterized agent has a long tail, too", Side::Above, &parameterized));
    judged.push(tail("Specialists are consistent throughout the test set", Side::Below, &specialist));
    judged
}

/// Judges whether an agent scores lower than another in the houses both are tested in.
fn below(text: &str, agent: &[Ran<'_>], other: &[Ran<'_>]) -> Judged {
    let claim = Claim {
        text: text.into(),
        quantity: "median ratio of scores in the same house",
        side: Side::Below,
        bound: 1.0,
        margin: 0.05,
        caveat: CAVEAT,
    };
    let difference = difference(&samples(agent, log_score), &samples(other, log_score), median);
    let remark = match (median_of(agent, deviation), median_of(other, deviation)) {
        (Some(own), Some(other)) => {
            format!("median RMS deviations {} and {} K", score_text(own), score_text(other))
        }
        _ => String::new(),
    };
    claim.judge(difference.map(Measured::exp), &remark)
}

/// Judges whether all agents keep the temperature near the target, by the worst agent.
fn around_target(agents: &[&[Ran<'_>]]) -> Judged {
    let claim = Claim {
        text: "All agents control the temperature around the target".into(),
        quantity: "highest of the three median RMS deviations (K)",
        side: Side::Below,
        bound: 1.0,
        margin: 0.1,
        caveat: CAVEAT,
    };
    let all: Vec<(Measured, &[Ran<'_>])> = agents
        .iter()
        .filter_map(|rows| Some((measured(&samples(rows, deviation), median)?, *rows)))
        .collect();
    if all.len() < agents.len() {
        return claim.judge(None, "");
    }
    let worst = all.into_iter().max_by(|a, b| a.0.interval.value.total_cmp(&b.0.interval.value));
    let Some((measured, rows)) = worst else { return claim.judge(None, "") };
    let remark = deviations_text(median_of(rows, deviation), median_of(rows, reactive_deviation));
    claim.judge(Some(measured), &remark)
}

/// Judges the tail of the RMS deviations over houses.
fn tail(text: &str, side: Side, rows: &[Ran<'_>]) -> Judged {
    let claim = Claim {
        text: text.into(),
        quantity: "95th percentile of RMS deviations over their median, by seed",
        side,
        bound: 2.0,
        margin: 0.1,
        caveat: CAVEAT,
    };
    let spread = by_seed(&samples(rows, deviation), |sorted| quantile(sorted, 0.95) / median(sorted));
    // A few buildings have no tail, and the range of their deviations is not one of ratios.
    claim.judge(spread.filter(|measured| !measured.is_range), "")
}
