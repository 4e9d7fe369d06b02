//! The paper's claims about the rewards of the reactive controllers.

use b2b_evaluate::statistics::median;
use b2b_evaluate::{Scored, StepRewards};

use super::claim::{Claim, Judged, Side, Verdict};
use super::interval::measured;
use super::select::trained;
use crate::definition::REACTIVE;
use crate::results::{Results, samples};

pub(super) fn judge(results: &Results) -> Vec<Judged> {
    let all = trained(results, REACTIVE, 0);
    let claim = Claim {
        text: "The modes of the reactive controllers' per-step rewards are around 0".into(),
        quantity: "median penalty of a step (K²)",
        side: Side::Below,
        bound: 0.25,
        margin: 0.05,
        caveat: "buildings and the tuning of the controllers are not the paper's",
    };
    let is_told = !all.is_empty();
    let tail = Judged {
        claim: "The tails of these distributions come from one set of parameters for all buildings of a type and climate".into(),
        verdict: if is_told { Verdict::Unknown } else { Verdict::NoResults },
        measured: "–".into(),
        reason: "no run tunes the parameters for each building, here or in the paper".into(),
    };
    vec![
        claim.judge(
            measured(&samples(&all, median_penalty), median),
            "half of the steps are within 0.5 K of 0 at 0.25 K²",
        ),
        tail,
    ]
}

/// Returns the median penalty of the steps of an episode.
fn median_penalty(scored: &Scored) -> Option<f64> {
    let counts = &scored.step_rewards.counts;
    let half = counts.iter().map(|count| u64::from(*count)).sum::<u64>().div_ceil(2);
    let mut sum = 0;
    let bin = counts.iter().position(|count| {
        sum += u64::from(*count);
        sum >= half
    });
    bin.filter(|_| half > 0).map(|bin| 10_f64.powf(StepRewards::log10_middle(bin)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_penalty_is_in_the_middle_of_the_counts() {
        let scored = |counts: Vec<u32>| Scored { step_rewards: StepRewards { counts }, ..Scored::default() };
        let middle = 10_f64.powf(StepRewards::log10_middle(2));
        assert_eq!(median_penalty(&scored(vec![1, 1, 5, 0])), Some(middle));
        assert_eq!(median_penalty(&scored(vec![0, 0])), None);
    }
}
