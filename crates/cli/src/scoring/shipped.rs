//! Comparison of recomputed numbers with the shipped ones.

/// Largest tolerated relative difference: math libraries round differently on different machines.
pub const TOLERANCE: f64 = 1e-6;

/// Returns the largest relative difference between numbers and the shipped ones; infinite if one is NaN.
pub fn difference(ours: impl IntoIterator<Item = f64>, shipped: impl IntoIterator<Item = f64>) -> f64 {
    let relative = |(a, b): (f64, f64)| if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) };
    let known = |difference: f64| if difference.is_nan() { f64::INFINITY } else { difference };
    ours.into_iter().zip(shipped).map(relative).map(known).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::difference;

    #[test]
    fn nan_differs_from_every_number() {
        assert_eq!(difference([1.0, 0.0], [1.0, 0.0]), 0.0);
        assert_eq!(difference([1.0, 4.0], [1.0, -2.0]), 1.5);
        assert_eq!(difference([f64::NAN, 1.0], [2.0, 1.0]), f64::INFINITY);
    }
}
