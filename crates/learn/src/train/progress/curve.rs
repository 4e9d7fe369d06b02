//! The learning curve of a run as a page: the result first, then the course of training.

use std::path::Path;

use b2b_base::aside::write_whole;
use b2b_page::fill;
use serde_json::{Value, json};

use super::table::read_column;
use crate::error::{Result, at};
use crate::train::config::TrainConfig;
use crate::train::environments::days;
use crate::train::summary::RunSummary;

/// Name of the page.
pub const PAGE: &str = "curve.html";
const TEMPLATE: &str = include_str!("curve.html");

/// A panel of the page.
struct Panel {
    /// Column of the progress.
    column: &'static str,
    title: &'static str,
    /// Value of the baseline.
    baseline: Option<f64>,
    /// Values that the axis always includes, so that small differences look small.
    shown: [f64; 2],
}

const fn panel(column: &'static str, title: &'static str, baseline: Option<f64>, shown: [f64; 2]) -> Panel {
    Panel { column, title, baseline, shown }
}

const PANELS: [Panel; 12] = [
    panel("score", "Score (lower is better; the baseline scores 1)", Some(1.0), [0.5, 1.5]),
    panel("resolved_score", "Resolved score", Some(1.0), [0.5, 1.5]),
    panel("rms_deviation_k", "RMS deviation (K)", None, [0.0, 0.5]),
    panel("energy_ratio", "HVAC energy over baseline", Some(1.0), [0.5, 1.5]),
    panel("cost_ratio", "Cost, or the task's other resource, over baseline", Some(1.0), [0.8, 1.1]),
    panel("discomfort", "Discomfort (K·h per zone and day)", None, [0.0, 0.5]),
    panel("training_penalty", "Mean penalty in training, with exploration", None, [0.0, 0.0]),
    panel("travel_per_day", "Actuator travel (strokes/day)", None, [0.0, 1.0]),
    panel(
        "relative_travel",
        "Actuator travel over its limit (above 1 actuators hunt)",
        Some(1.0),
        [0.0, 1.0],
    ),
    panel("oscillating_share", "Zone-steps in sustained oscillation (share)", None, [0.0, 0.1]),
    panel("explained_variance", "Explained variance of the critic", None, [0.0, 1.0]),
    panel("steps_per_s", "Environment steps per second", None, [0.0, 0.0]),
];

impl Panel {
    /// Returns the ends of the axis for some values, with a margin.
    fn range(&self, values: &[f64]) -> [f64; 2] {
        let finite = || values.iter().copied().filter(|value| value.is_finite());
        let (low, high) = (finite().fold(self.shown[0], f64::min), finite().fold(self.shown[1], f64::max));
        let margin = 0.04 * (high - low).max(f64::MIN_POSITIVE);
        // An axis from 0 has no margin below.
        [if low == 0.0 { 0.0 } else { low - margin }, high + margin]
    }

    /// Returns the panel with its values; `None` if the table has none.
    fn drawn(&self, folder: &Path) -> Option<Value> {
        let rows = read_column(folder, self.column).ok().filter(|rows| !rows.is_empty())?;
        let (steps, values): (Vec<u64>, Vec<f64>) = rows.into_iter().unzip();
        Some(json!({
            "title": self.title, "steps": steps, "values": values, "baseline": self.baseline,
            "range": self.range(&values),
        }))
    }
}

/// Returns the tiles of the result, as pairs of a label and a value; for an unfinished run, of its last evaluation.
fn tiles(folder: &Path, summary: Option<&RunSummary>) -> Vec<[String; 2]> {
    let tile = |name: &str, value: String| [name.to_owned(), value];
    if let Some(scores) = summary.and_then(|summary| summary.scores.as_ref()) {
        return vec![
            tile("resolved score, whole run period", format!("{:.3}", scores.mean.resolved_score)),
            tile("score, whole run period", format!("{:.3}", scores.mean.score)),
            tile("RMS deviation, whole run period", format!("{:.2} K", scores.mean.rms_deviation_k)),
            tile("HVAC energy / baseline", format!("{:.2}", scores.mean.energy_ratio)),
        ];
    }
    let last = |name: &str| read_column(folder, name).ok().and_then(|rows| rows.last().copied());
    let of = |(label, column, unit): &(&str, &str, &str)| {
        let (steps, value) = last(column)?;
        Some(tile(&format!("{label}, last evaluation ({steps} steps)"), format!("{value:.3}{unit}")))
    };
    [
        ("resolved score", "resolved_score", ""),
        ("score", "score", ""),
        ("RMS deviation", "rms_deviation_k", " K"),
    ]
    .iter()
    .filter_map(of)
    .collect()
}

/// The line below the title: period, seed, and the days of evaluations.
fn note(config: &TrainConfig) -> Result<String> {
    let evaluated = match config.evaluation.every {
        0 => "not evaluated during training".to_owned(),
        _ => {
            let also = if days::are_held_out(config)? { "" } else { ", which training uses as well" };
            let evaluated =
                config.training_set.periods()?.into_iter().map(|each| days::evaluated(config, each));
            let evaluated: Vec<String> = evaluated.map(|days| days.to_string()).collect();
            format!("evaluated on {}{also}", evaluated.join(", "))
        }
    };
    Ok(format!("{}, seed {}; {evaluated}", config.training_set.period, config.budget.seed))
}

/// Writes the page of a run's folder from its table, and from its result if it has finished.
pub(crate) fn write(folder: &Path, config: &TrainConfig, summary: Option<&RunSummary>) -> Result<()> {
    let data = json!({
        "title": format!("{} on {}", config.training_set.task, config.training_set.buildings_text()),
        "note": note(config)?,
        "tiles": tiles(folder, summary),
        "panels": PANELS.iter().filter_map(|panel| panel.drawn(folder)).collect::<Vec<Value>>(),
    });
    let path = folder.join(PAGE);
    write_whole(&path, fill(TEMPLATE, &data).as_bytes()).map_err(at(&path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_differences_look_small_and_large_ones_fit() {
        let named = |name: &str| PANELS.iter().find(|panel| panel.column == name).unwrap();
        let [low, high] = named("explained_variance").range(&[0.997, 1.0]);
        assert!(low == 0.0 && (1.0..1.1).contains(&high), "{low} to {high}");
        let [low, high] = named("score").range(&[0.98, 0.97]);
        assert!(low < 0.5 && high > 1.5, "{low} to {high}");
        let [low, high] = named("score").range(&[30.0, f64::INFINITY, 0.2]);
        assert!(low < 0.2 && (30.0..40.0).contains(&high), "{low} to {high}");
    }

    #[test]
    fn the_result_is_before_the_curves() {
        let result = TEMPLATE.find("class=\"tiles\"").unwrap();
        assert!(result < TEMPLATE.find("id=\"panels\"").unwrap());
        let folder = tempfile::tempdir().unwrap();
        let table = "steps,score,resolved_score,rms_deviation_k\n10,2.5,1.5,0.8\n20,0.75,0.875,0.25\n";
        std::fs::write(folder.path().join(crate::train::progress::TABLE), table).unwrap();
        let tiles = tiles(folder.path(), None);
        assert_eq!(tiles[0], ["resolved score, last evaluation (20 steps)", "0.875"]);
        assert_eq!(tiles[2][1], "0.250 K");
    }
}
