//! Statistics of measurements, and the action under which they are taken.

use b2b_env::ActionSpace;

/// The median.
pub fn median(values: Vec<f64>) -> f64 {
    percentile(values, 50)
}

/// The value that `percent` % of the values are below.
pub fn percentile(mut values: Vec<f64>, percent: usize) -> f64 {
    values.sort_by(f64::total_cmp);
    values[(values.len() * percent / 100).min(values.len() - 1)]
}

/// The middle of every actuator's range.
pub fn middle(space: &ActionSpace) -> Vec<f64> {
    space.low().iter().zip(space.high()).map(|(low, high)| (low + high) / 2.0).collect()
}
