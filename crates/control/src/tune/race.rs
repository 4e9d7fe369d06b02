//! Racing: a proposal is evaluated on one building after another, and dropped as soon as it cannot win.

use super::outcome::percentile_75;

/// A proposal is dropped if the geometric mean of its losses exceeds the best set's by this fraction, after one, two,
/// three and more buildings.
const MARGINS: [f64; 4] = [0.10, 0.05, 0.03, 0.02];

/// The best set so far.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Best {
    /// Number of its evaluation.
    pub(super) number: usize,
    /// Relative loss on each building.
    pub(super) losses: Vec<f64>,
}

impl Best {
    /// Returns the score: the 75th percentile of the relative losses.
    pub(super) fn score(&self) -> f64 {
        percentile_75(&self.losses)
    }

    /// Returns whether to drop a proposal with these relative losses on the first buildings: it cannot win even with no
    /// loss on the others, or is clearly worse than the best set on the same buildings.
    pub(super) fn is_beyond(&self, losses: &[f64]) -> bool {
        if losses.is_empty() || losses.len() >= self.losses.len() {
            return false;
        }
        let mut optimistic = losses.to_vec();
        optimistic.resize(self.losses.len(), 0.0);
        let margin = MARGINS[(losses.len() - 1).min(MARGINS.len() - 1)];
        percentile_75(&optimistic) >= self.score() || self.excess(losses) > margin.ln_1p()
    }

    /// Returns the estimated score of a dropped proposal: the best set's score, scaled by the losses on the same
    /// buildings. Never better than the best set.
    pub(super) fn estimate(&self, losses: &[f64]) -> f64 {
        self.score() * self.excess(losses).exp().max(1.0)
    }

    /// Returns the mean logarithm of the losses relative to the best set's.
    fn excess(&self, losses: &[f64]) -> f64 {
        let relative =
            |(loss, best): (&f64, &f64)| (loss.max(f64::MIN_POSITIVE) / best.max(f64::MIN_POSITIVE)).ln();
        losses.iter().zip(&self.losses).map(relative).sum::<f64>() / losses.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn best() -> Best {
        Best { number: 3, losses: vec![0.5, 0.6, 0.7, 0.8, 0.9] }
    }

    #[test]
    fn a_proposal_that_is_better_on_every_building_is_never_dropped() {
        let losses = [0.49, 0.59, 0.69, 0.79, 0.89];
        for done in 0..=5 {
            assert!(!best().is_beyond(&losses[..done]), "{done}");
        }
    }

    #[test]
    fn a_clearly_worse_proposal_is_dropped_after_the_first_building_and_a_slightly_worse_one_later() {
        assert!(best().is_beyond(&[0.56]) && !best().is_beyond(&[0.54]));
        assert!(best().is_beyond(&[0.54, 0.63]) && !best().is_beyond(&[0.52, 0.61]));
        assert!(best().is_beyond(&[0.52, 0.62, 0.72, 0.82]));
    }

    #[test]
    fn a_proposal_that_cannot_win_is_dropped_at_once() {
        // Better than the best set on the first building, but two buildings are above its second worst.
        assert!(best().is_beyond(&[0.1, 0.81, 0.82]));
        assert!(!best().is_beyond(&[0.1, 0.81]));
    }

    #[test]
    fn the_estimate_of_a_dropped_proposal_is_proportional_and_never_better_than_the_best() {
        assert!((best().estimate(&[1.0]) - 1.6).abs() < 1e-12);
        assert_eq!(best().estimate(&[0.1, 0.2]), 0.8);
    }
}
