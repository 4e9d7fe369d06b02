//! The distribution of the rewards of single steps.

use b2b_env::Trajectory;
use serde::{Deserialize, Serialize};

/// A histogram of the penalties of steps, which are their negative rewards, over logarithmic bins.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepRewards {
    /// Counts: 20 bins per decade from [`StepRewards::LOWEST`]; the outermost bins take everything beyond.
    pub counts: Vec<u32>,
}

impl StepRewards {
    /// Lower end of the first bin.
    pub const LOWEST: f64 = 1e-6;
    /// Bins in a factor of ten.
    const PER_DECADE: f64 = 20.0;
    const BINS: usize = 200;

    /// Returns the histogram of an episode.
    pub(super) fn of(trajectory: &Trajectory) -> Self {
        let mut counts = vec![0; Self::BINS];
        for [temperature, energy] in &trajectory.penalties {
            counts[Self::bin(temperature + energy)] += 1;
        }
        Self { counts }
    }

    fn bin(penalty: f64) -> usize {
        let bin = ((penalty.max(Self::LOWEST) / Self::LOWEST).log10() * Self::PER_DECADE).floor();
        bin.min((Self::BINS - 1) as f64) as usize
    }

    /// Returns the decimal logarithm of the penalty in the middle of a bin.
    pub fn log10_middle(bin: usize) -> f64 {
        Self::LOWEST.log10() + (bin as f64 + 0.5) / Self::PER_DECADE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_is_counted_in_the_bin_of_its_penalty() {
        let penalties = vec![[0.0, 0.0], [0.5, 0.5], [0.97, 0.0], [1e9, 0.0], [1e-9, 0.0]];
        let rewards = StepRewards::of(&Trajectory { penalties, ..Trajectory::default() });
        let at = |penalty: f64| rewards.counts[StepRewards::bin(penalty)];
        assert_eq!((at(0.0), at(1.01), at(0.95), at(1e12)), (2, 1, 1, 1));
        assert_eq!(rewards.counts.iter().sum::<u32>(), 5);
        assert!((StepRewards::log10_middle(StepRewards::bin(1.0001)) - 0.025).abs() < 1e-9);
    }
}
