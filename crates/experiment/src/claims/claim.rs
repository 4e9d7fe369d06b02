//! A claim with a bound, and how it is judged.

use std::fmt;

use b2b_evaluate::statistics::score_text;

use super::interval::Measured;

/// How claims are judged: the subtitle of their table.
pub const RULE: &str = "a claim holds if the whole 95 % interval (bootstrap over buildings and seeds; for two to four \
                        buildings, the range of all values; one does not decide) is on the claimed side of its bound \
                        and beyond the margin, does not hold if it is on the other side and beyond the margin, and \
                        otherwise cannot be told; trainings with fewer steps than the paper's do not count";

/// A claim of the paper, judged.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// What the paper says, with its numbers.
    pub claim: String,
    /// Whether it holds here.
    pub verdict: Verdict,
    /// The quantity with its interval, and the bound.
    pub measured: String,
    /// Why it was judged this way.
    pub reason: String,
}

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It does.
    Holds,
    /// It does not.
    Fails,
    /// The results do not decide.
    Unknown,
    /// There are no results at the paper's budget.
    NoResults,
}

/// A claim that a quantity is on one side of a bound.
#[derive(Clone, Debug)]
pub(super) struct Claim {
    pub(super) text: String,
    /// Name and unit of the quantity.
    pub(super) quantity: &'static str,
    pub(super) side: Side,
    pub(super) bound: f64,
    pub(super) margin: f64,
    /// What may differ from the paper, shown for a claim that does not hold or cannot be judged.
    pub(super) caveat: &'static str,
}

/// The side of a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Below,
    Above,
}

impl Claim {
    /// Judges the claim by the quantity, with a remark on its origin.
    pub(super) fn judge(&self, measured: Option<Measured>, remark: &str) -> Judged {
        let Self { text, quantity, side, bound, margin, caveat } = self;
        let word = if *side == Side::Below { "below" } else { "above" };
        let margin = if *margin > 0.0 { format!(" by {margin}") } else { String::new() };
        let question = format!("{word} {bound}{margin}?");
        let Some(measured) = measured else {
            let (measured, reason) = (format!("{quantity}, {question}"), String::new());
            return Judged { claim: text.clone(), verdict: Verdict::NoResults, measured, reason };
        };
        let verdict = self.verdict(&measured);
        let kind = if measured.is_range { "range" } else { "interval" };
        let plural = if measured.buildings == 1 { "" } else { "s" };
        let mut reasons = vec![format!("{kind} of {} building{plural}", measured.buildings)];
        reasons.extend([remark].into_iter().filter(|remark| !remark.is_empty()).map(str::to_owned));
        if verdict != Verdict::Holds {
            reasons.push((*caveat).to_owned());
        }
        Judged {
            claim: text.clone(),
            verdict,
            measured: format!("{quantity} {}, {question}", measured.interval),
            reason: reasons.join("; "),
        }
    }

    pub(super) fn verdict(&self, measured: &Measured) -> Verdict {
        let Self { side, bound, margin, .. } = self;
        let (low, high) = (measured.interval.low, measured.interval.high);
        // A range without width has no values that differ.
        let decides = !measured.is_range || measured.buildings > 1 && low < high;
        let (is_below, is_above) = (decides && high < bound - margin, decides && low > bound + margin);
        match (side, is_below, is_above) {
            (Side::Below, true, _) | (Side::Above, _, true) => Verdict::Holds,
            (Side::Below, _, true) | (Side::Above, true, _) => Verdict::Fails,
            _ => Verdict::Unknown,
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Holds => "holds",
            Self::Fails => "does not hold",
            Self::Unknown => "cannot be told",
            Self::NoResults => "no results yet",
        })
    }
}

/// Returns the median RMS deviations of agents and of the reactive controllers as text.
pub(super) fn deviations_text(agent: Option<f64>, reactive: Option<f64>) -> String {
    let (Some(agent), Some(reactive)) = (agent, reactive) else { return String::new() };
    format!(
        "median RMS deviation {} K, of the reactive controllers {} K",
        score_text(agent),
        score_text(reactive)
    )
}

#[cfg(test)]
mod tests {
    use b2b_evaluate::statistics::median;

    use super::super::interval::measured;
    use super::super::interval::tests::buildings;
    use super::*;

    fn claim(side: Side) -> Claim {
        Claim {
            text: "x".into(),
            quantity: "score",
            side,
            bound: 1.0,
            margin: 0.05,
            caveat: "other buildings",
        }
    }

    #[test]
    fn a_claim_is_judged_by_its_whole_interval_and_the_margin() {
        let of = |side, values: &[f64]| {
            let values = values.iter().map(|value| vec![*value]).collect::<Vec<_>>();
            claim(side).judge(measured(&buildings(&values), median), "").verdict
        };
        assert_eq!(of(Side::Below, &[0.5, 0.6, 0.7, 0.8]), Verdict::Holds);
        assert_eq!(of(Side::Above, &[0.5, 0.6, 0.7, 0.8]), Verdict::Fails);
        assert_eq!(of(Side::Below, &[0.96, 0.97, 0.98]), Verdict::Unknown, "within the margin");
        assert_eq!(of(Side::Below, &[0.5, 0.6, 1.4, 1.5]), Verdict::Unknown);
        assert_eq!(of(Side::Below, &[1.2, 1.3]), Verdict::Fails, "the range of two buildings");
        assert_eq!(of(Side::Below, &[0.5]), Verdict::Unknown, "one value");
        assert_eq!(of(Side::Below, &[]), Verdict::NoResults);
    }

    #[test]
    fn the_caveat_is_for_claims_that_do_not_hold() {
        let of =
            |values: &[Vec<f64>]| claim(Side::Below).judge(measured(&buildings(values), median), "so").reason;
        assert_eq!(of(&[vec![0.5], vec![0.6]]), "range of 2 buildings; so");
        assert_eq!(of(&[vec![1.5], vec![1.6]]), "range of 2 buildings; so; other buildings");
        assert_eq!(of(&[vec![0.5, 0.6]]), "range of 1 building; so; other buildings");
    }
}
