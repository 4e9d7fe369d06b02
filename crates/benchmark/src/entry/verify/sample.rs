//! The random sample of episodes that a verification runs again.

use std::num::NonZeroUsize;

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// A random sample of episodes to run again.
///
/// The author of a forged result must not know the sample: its seed comes from the operating system unless a
/// verification is repeated.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Number of episodes, or of sequences of a policy that keeps its memory; by default enough to include a forged
    /// episode with probability [`Sample::PROBABILITY`] if [`Sample::FORGED`] of all episodes are forged.
    pub episodes: Option<NonZeroUsize>,
    /// Seed of the sample.
    pub seed: u64,
}

impl Sample {
    /// Share of forged episodes assumed for the default number.
    pub const FORGED: f64 = 0.1;
    /// Probability with which the default number finds one of them.
    pub const PROBABILITY: f64 = 0.95;

    /// Draws from the numbers below `total`, in ascending order.
    pub(super) fn draw(&self, total: usize) -> Vec<usize> {
        let size = self.episodes.map_or_else(|| enough(total), NonZeroUsize::get);
        let mut numbers: Vec<usize> = (0..total).collect();
        numbers.shuffle(&mut ChaCha8Rng::seed_from_u64(self.seed));
        numbers.truncate(size);
        numbers.sort_unstable();
        numbers
    }

    /// Describes the chance that a sample of this size finds a forged episode.
    pub(super) fn power(&self, size: usize, total: usize) -> String {
        let forged = forged(total);
        let percent = 100.0 * found(size, forged, total);
        format!(
            "chosen with seed {}: if {forged} of the {total} were forged, {percent:.1} % of such samples find one",
            self.seed
        )
    }
}

/// Returns the number of forged episodes that a sample should find.
fn forged(total: usize) -> usize {
    ((total as f64 * Sample::FORGED).ceil() as usize).max(1)
}

/// Returns the smallest size of a sample that finds one of the forged episodes.
fn enough(total: usize) -> usize {
    let is_enough = |size: &usize| found(*size, forged(total), total) >= Sample::PROBABILITY;
    (1..=total).find(is_enough).unwrap_or(total)
}

/// Returns the probability that a sample without replacement contains at least one of the forged episodes: 1 minus the
/// hypergeometric probability of none.
fn found(size: usize, forged: usize, total: usize) -> f64 {
    if size + forged > total {
        return 1.0;
    }
    let missed = (0..size).map(|drawn| (total - forged - drawn) as f64 / (total - drawn) as f64);
    1.0 - missed.product::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_probability_is_hypergeometric() {
        assert_eq!(found(1, 1, 10), 1.0 - 0.9);
        assert!((found(2, 3, 10) - (1.0 - 7.0 * 6.0 / 90.0)).abs() < 1e-12);
        assert_eq!(found(8, 3, 10), 1.0);
        assert_eq!([1, 5, 10, 300].map(enough), [1, 5, 10, 28]);
    }

    #[test]
    fn the_default_sample_finds_a_tenth_of_forged_episodes_as_often_as_stated() {
        let total = 120;
        let finds = |seed: u64| {
            let drawn = Sample { episodes: None, seed }.draw(total);
            drawn.iter().any(|number| *number < forged(total))
        };
        let share = (0..2000).filter(|seed| finds(*seed)).count() as f64 / 2000.0;
        assert!((0.94..0.98).contains(&share), "{share}");
    }

    #[test]
    fn a_sample_has_its_size_and_no_number_twice() {
        let sample = Sample { episodes: NonZeroUsize::new(7), seed: 3 };
        let drawn = sample.draw(20);
        assert_eq!(drawn.len(), 7);
        assert!(drawn.windows(2).all(|pair| pair[0] < pair[1]) && drawn[6] < 20);
        assert_eq!(sample.draw(5), [0, 1, 2, 3, 4]);
        assert!(sample.power(7, 20).contains("seed 3"));
    }
}
