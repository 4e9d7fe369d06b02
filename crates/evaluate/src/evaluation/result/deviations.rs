//! The distribution of deviations from target.

use serde::{Deserialize, Serialize};

use crate::evaluation::recording::{ControlledZone, Recording};

/// A histogram of deviations from target or band over every step and zone with both heating and cooling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Deviations {
    /// Counts in bins of [`Deviations::WIDTH`] from [`Deviations::LOWEST`]; the outermost bins take everything beyond.
    pub counts: Vec<u64>,
}

impl Deviations {
    /// Lower end of the first bin, K.
    pub const LOWEST: f64 = -10.0;
    /// Width of a bin, K.
    pub const WIDTH: f64 = 0.05;
    const BINS: usize = 400;

    /// Returns an empty histogram.
    pub fn empty() -> Self {
        Self { counts: vec![0; Self::BINS] }
    }

    /// Returns the histogram of an episode. Deviations are from the targets observed before a step, as in the reward.
    pub(in crate::evaluation) fn of(recording: &Recording, zones: &[ControlledZone]) -> Self {
        let mut deviations = Self::empty();
        for (before, end) in recording.steps() {
            for zone in zones.iter().filter(|zone| zone.fully_conditioned) {
                deviations.add(zone.deviation(before, end));
            }
        }
        deviations
    }

    /// Counts a deviation, K.
    pub fn add(&mut self, deviation: f64) {
        let bin = ((deviation - Self::LOWEST) / Self::WIDTH).floor();
        self.counts[bin.clamp(0.0, (Self::BINS - 1) as f64) as usize] += 1;
    }

    /// Returns the middle of a bin, K.
    pub fn middle(bin: usize) -> f64 {
        Self::LOWEST + (bin as f64 + 0.5) * Self::WIDTH
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_deviation_is_counted_in_its_bin() {
        let mut deviations = Deviations::empty();
        for value in [0.01, 0.04, -0.01, 1e9, -1e9] {
            deviations.add(value);
        }
        let at = |value: f64| ((value - Deviations::LOWEST) / Deviations::WIDTH) as usize;
        assert_eq!((deviations.counts[at(0.01)], deviations.counts[at(-0.01)]), (2, 1));
        assert_eq!((deviations.counts[0], deviations.counts[399]), (1, 1));
        assert!((Deviations::middle(at(0.01)) - 0.025).abs() < 1e-9);
    }
}
