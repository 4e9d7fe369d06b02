//! Shift and stretch of the hours of a month.

use std::ops::Range;

pub(super) const DAYS: [usize; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
/// Hours of a common year.
pub(super) const HOURS: usize = 8760;
/// Iterations that bring a month to its target where there is no closed form.
pub(super) const PASSES: usize = 30;

/// The hours of each month.
pub(super) fn months() -> impl Iterator<Item = Range<usize>> {
    DAYS.iter().scan(0, |start, days| {
        let hours = *start..*start + 24 * days;
        *start = hours.end;
        Some(hours)
    })
}

/// Daily means.
fn daily_means(hours: &[f64]) -> Vec<f64> {
    hours.chunks(24).map(mean).collect()
}

/// The slow component of a year: daily means at noon, linearly interpolated, so that stretching causes no jump at
/// midnight.
pub(super) fn trend(hours: &[f64]) -> Vec<f64> {
    let means = daily_means(hours);
    let at = |hour: usize| {
        // The middle of the hour, in days after the first noon.
        let days = ((hour as f64 + 0.5) / 24.0 - 0.5).clamp(0.0, (means.len() - 1) as f64);
        let day = (days as usize).min(means.len() - 2);
        means[day] + (days - day as f64) * (means[day + 1] - means[day])
    };
    (0..hours.len()).map(at).collect()
}

/// Standard deviation of the daily means.
pub(super) fn spread(hours: &[f64]) -> f64 {
    let days = daily_means(hours);
    let mean = mean(&days);
    let squares: f64 = days.iter().map(|day| (day - mean) * (day - mean)).sum();
    (squares / (days.len() - 1) as f64).sqrt()
}

/// Mean daily range.
pub(super) fn range(hours: &[f64]) -> f64 {
    let range = |day: &[f64]| {
        let (low, high) =
            day.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    };
    hours.chunks(24).map(range).sum::<f64>() / (hours.len() / 24) as f64
}

/// Target statistics of a month.
pub(super) struct Target {
    pub(super) mean: f64,
    /// Standard deviation of the daily means.
    pub(super) spread: f64,
    /// Mean daily range.
    pub(super) range: f64,
}

impl Target {
    /// Returns the hours with their trend and their deviation from it stretched, then shifted to the mean.
    pub(super) fn reached_by(&self, hours: &[f64], trend: &[f64]) -> Vec<f64> {
        let (mut slow, mut fast) = (1.0, 1.0);
        let mut stretched = hours.to_vec();
        for _ in 0..PASSES {
            slow *= self.spread / spread(&stretched);
            fast *= self.range / range(&stretched);
            let pairs = hours.iter().zip(trend);
            stretched = pairs.map(|(hour, trend)| slow * trend + fast * (hour - trend)).collect();
        }
        let shift = self.mean - mean(&stretched);
        stretched.iter().map(|hour| hour + shift).collect()
    }
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Limits dew points to the dry bulbs and shifts them to the mean `target`.
pub(super) fn held_under(mut dew_points: Vec<f64>, dry_bulbs: &[f64], target: f64) -> Vec<f64> {
    let mut shift = 0.0;
    let clamped = |shift: f64| dew_points.iter().zip(dry_bulbs).map(move |(d, t)| (d + shift).min(*t));
    for _ in 0..PASSES {
        shift += target - clamped(shift).sum::<f64>() / dry_bulbs.len() as f64;
    }
    let held: Vec<f64> = clamped(shift).collect();
    dew_points.copy_from_slice(&held);
    dew_points
}

pub(super) fn scaled(values: &[f64], to: f64) -> Vec<f64> {
    let ratio = to / mean(values);
    values.iter().map(|value| value * ratio).collect()
}
