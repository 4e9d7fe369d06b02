//! Whether a number that ships with the program comes out again.

/// By how much it may differ, relatively: machines round the mathematics of the engine differently.
pub const TOLERANCE: f64 = 1e-6;

/// The largest relative difference between numbers and those that are shipped.
pub fn difference<const N: usize>(ours: [f64; N], shipped: [f64; N]) -> f64 {
    let relative = |(a, b): (f64, f64)| if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) };
    ours.into_iter().zip(shipped).map(relative).fold(0.0, f64::max)
}
