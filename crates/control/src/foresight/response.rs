//! The slope of each day's objective, estimated from mirrored pairs.

use crate::search::least_squares::{dot, solve};

/// Regularization of the slope that all days share: variance of a pair's error over the variance of slopes.
const SHARED: f64 = 0.01;
/// The same for a day's difference from it.
const OWN: f64 = 0.03;

/// Half of the difference between the two points of a mirrored pair, and of their objectives.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    pub(super) difference: Vec<f64>,
    pub(super) gain: f64,
}

/// Returns the slope of each day from its pairs: ridge regressions, of all days together and then of each day's
/// residuals. Days are alike, so that a few pairs determine many slopes.
pub(super) fn slopes(days: &[Vec<Pair>]) -> Vec<Vec<f64>> {
    let all: Vec<&Pair> = days.iter().flatten().collect();
    let width = all.first().map_or(0, |pair| pair.difference.len());
    let shared = ridge(&all, &vec![0.0; width], SHARED);
    days.iter().map(|pairs| ridge(&pairs.iter().collect::<Vec<_>>(), &shared, OWN)).collect()
}

/// Returns the slope nearest to a prior that explains the pairs.
fn ridge(pairs: &[&Pair], prior: &[f64], regularization: f64) -> Vec<f64> {
    let width = prior.len();
    let mut matrix = vec![0.0; width * width];
    (0..width).for_each(|index| matrix[index * width + index] = regularization);
    let mut right = vec![0.0; width];
    for Pair { difference, gain } in pairs {
        let residual = gain - dot(difference, prior);
        for (row, &factor) in difference.iter().enumerate() {
            right[row] += factor * residual;
            let entries = &mut matrix[row * width..(row + 1) * width];
            entries.iter_mut().zip(difference).for_each(|(entry, value)| *entry += factor * value);
        }
    }
    solve(&mut matrix, &mut right);
    prior.iter().zip(right).map(|(prior, own)| prior + own).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_share_a_slope_that_none_of_them_shows_alone() {
        let slope = [0.3, -0.2, 0.0, 0.1];
        // Each day moves along one axis only.
        let day = |axis: usize| {
            let mut difference = vec![0.0; 4];
            difference[axis] = 1.0;
            vec![Pair { gain: dot(&slope, &difference), difference }]
        };
        for found in slopes(&[day(0), day(1), day(2), day(3)]) {
            found
                .iter()
                .zip(slope)
                .for_each(|(found, slope)| assert!((found - slope).abs() < 0.01, "{found}"));
        }
    }

    #[test]
    fn an_unusual_day_gets_its_own_slope() {
        let pairs = |slope: f64| vec![Pair { difference: vec![1.0], gain: slope }];
        let found = slopes(&[pairs(0.1), pairs(0.1), pairs(-0.5)]);
        assert!(found[0][0] > 0.08 && found[2][0] < -0.45, "{found:?}");
    }
}
