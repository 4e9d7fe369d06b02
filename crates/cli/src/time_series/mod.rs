//! Time series on pages: their encoding and the script that draws them.
//!
//! A series has at most [`MAX_POINTS`] points, each the mean of a span of steps, and the minimum and maximum of each
//! day. Values are quantized to 16 bits between the minimum and maximum of the whole series. That keeps a year of the
//! largest building below 2 MB.

use b2b_building::RunPeriod;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Serialize;
use serde_json::Value;

/// Maximum number of points of a series: the hours of a leap year.
const MAX_POINTS: usize = 8784;
const SCRIPT: &str = concat!(include_str!("time_series.js"), include_str!("steps.js"));
/// Number of parts into which [`Steps`] resolve a unit: a price to a hundredth of a cent.
const STEPS_PER_UNIT: f64 = 1e4;
const STYLE: &str = include_str!("time_series.css");

/// The time axis of an episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct TimeAxis {
    /// Year, month and day of the month of the first day, in a year with the same days of the week.
    pub first_day: [u32; 3],
    pub steps_per_hour: u32,
    /// Steps per point, a divisor of the steps of a day.
    pub span: usize,
    /// Number of points.
    pub points: usize,
}

/// One time series.
#[derive(Clone, Debug, Serialize)]
pub struct Series {
    pub name: String,
    /// Index of the color.
    color: usize,
    /// Whether the line is dashed.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    dashed: bool,
    low: f64,
    high: f64,
    /// Means of the spans: base64 of little-endian 16-bit numbers, 0 for `low` and 65535 for `high`.
    mean: String,
    /// Minima and maxima of the days.
    days: [String; 2],
}

/// A time series of values that stay the same for many steps: setpoints, prices and states.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Steps {
    pub name: String,
    /// Index of the color; the color of bands without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<usize>,
    /// Whether the line is dashed.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub dashed: bool,
    /// Names of the states 1, 2, …; empty for a quantity.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    pub states: &'static [&'static str],
    /// Points at which the value changes, and the new value.
    pub changes: Vec<(usize, f64)>,
}

impl Series {
    /// Returns the series under another name.
    pub fn named(self, name: String) -> Self {
        Self { name, ..self }
    }

    /// Returns the series with a dashed line.
    pub fn dashed(self) -> Self {
        Self { dashed: true, ..self }
    }
}

impl TimeAxis {
    /// Returns the axis of an episode with this many steps.
    pub fn new(period: RunPeriod, steps_per_hour: u32, steps: usize) -> Self {
        let needed = steps.div_ceil(MAX_POINTS).max(1);
        let day = 24 * steps_per_hour as usize;
        let span = (needed..=day).find(|span| day.is_multiple_of(*span)).unwrap_or(day);
        Self { first_day: period.first_day(), steps_per_hour, span, points: steps.div_ceil(span) }
    }

    /// Returns a series of one value per step.
    pub fn series(self, name: String, color: usize, values: &[f64]) -> Series {
        let (low, high) = (minimum(values), maximum(values));
        let day = 24 * self.steps_per_hour as usize;
        let mean = |span: &[f64]| span.iter().sum::<f64>() / span.len() as f64;
        let days = |of: fn(&[f64]) -> f64| encode(values.chunks(day).map(of), low, high);
        Series {
            name,
            color,
            dashed: false,
            low,
            high,
            mean: encode(values.chunks(self.span).map(mean), low, high),
            days: [days(minimum), days(maximum)],
        }
    }

    /// Returns the steps of one value per step: each point has the first value of its span.
    pub fn steps(self, name: String, values: impl Iterator<Item = f64>) -> Steps {
        let mut changes: Vec<(usize, f64)> = Vec::new();
        for (point, value) in values.step_by(self.span).enumerate() {
            let value = (value * STEPS_PER_UNIT).round() / STEPS_PER_UNIT;
            if changes.last().is_none_or(|(_, last)| *last != value) {
                changes.push((point, value));
            }
        }
        Steps { name, color: None, dashed: false, states: &[], changes }
    }

    /// Returns a sentence about the time that a point covers.
    pub fn resolution(self) -> String {
        match self.span {
            1 => "Each point is one step.".to_owned(),
            span => {
                format!("Each point is the mean of {} minutes.", span * 60 / self.steps_per_hour as usize)
            }
        }
    }
}

/// Returns a template with its data and with the script and style for time series.
pub fn fill(template: &str, data: &Value) -> String {
    b2b_page::fill(&template.replace("{{TIME_SERIES}}", SCRIPT).replace("{{TIME_SERIES_STYLE}}", STYLE), data)
}

fn minimum(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn maximum(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// Returns base64 of 16-bit numbers, 0 for `low` and 65535 for `high`.
fn encode(values: impl Iterator<Item = f64>, low: f64, high: f64) -> String {
    let range = if high > low { high - low } else { 1.0 };
    let bytes: Vec<u8> = values
        .flat_map(|value| (((value - low) / range * f64::from(u16::MAX)).round() as u16).to_le_bytes())
        .collect();
    BASE64_STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_quantized_between_minimum_and_maximum() {
        let bytes = BASE64_STANDARD.decode(encode([1.0, 2.0, 3.0].into_iter(), 1.0, 3.0)).unwrap();
        assert_eq!(bytes, [0, 0, 0, 128, 255, 255]);
    }

    #[test]
    fn steps_are_the_points_at_which_a_value_changes() {
        let axis = TimeAxis { first_day: [2017, 1, 1], steps_per_hour: 12, span: 2, points: 4 };
        let steps = axis.steps("price".into(), [0.1, 0.1, 0.1, 0.3, 0.2, 0.2, 0.2, 0.1].into_iter());
        assert_eq!(steps.changes, [(0, 0.1), (2, 0.2)]);
    }

    #[test]
    fn a_point_covers_a_divisor_of_a_day() {
        for (steps_per_hour, days, span) in
            [(12, 14, 1), (12, 90, 3), (12, 200, 8), (12, 365, 12), (60, 365, 60)]
        {
            let axis =
                TimeAxis::new(RunPeriod::FULL_YEAR, steps_per_hour, days * 24 * steps_per_hour as usize);
            assert_eq!(axis.span, span);
            assert!(axis.points <= MAX_POINTS);
        }
    }

    #[test]
    fn ticks_are_in_the_year_of_the_axis() {
        assert!(!SCRIPT.contains("2017"));
    }

    #[test]
    fn the_script_needs_no_network() {
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(!SCRIPT.contains(word) && !STYLE.contains(word), "{word}");
        }
    }
}
