//! The learning curve of a run as a page.

use std::path::Path;

use b2b_base::aside::write_whole;
use b2b_page::fill;
use serde_json::{Value, json};

use super::table::read_column;
use crate::error::{Result, at};
use crate::train::config::TrainConfig;
use crate::train::environments::days;

/// Name of the page.
pub const PAGE: &str = "curve.html";
const TEMPLATE: &str = include_str!("curve.html");

/// Panels of the page: columns of the progress, titles, and the value of the baseline.
const PANELS: [(&str, &str, Option<f64>); 10] = [
    ("score", "Score (below 1 beats the reactive controllers)", Some(1.0)),
    ("resolved_score", "Resolved score", Some(1.0)),
    ("rms_deviation_k", "RMS deviation (K)", None),
    ("energy_ratio", "HVAC energy over baseline", Some(1.0)),
    ("training_penalty", "Mean penalty in training, with exploration", None),
    ("travel_per_day", "Actuator travel (strokes/day)", None),
    ("relative_travel", "Actuator travel over its limit (above 1 actuators hunt)", Some(1.0)),
    ("oscillating_share", "Zone-steps in sustained oscillation (share)", None),
    ("explained_variance", "Explained variance of the critic", None),
    ("steps_per_s", "Environment steps per second", None),
];

/// The line below the title: period, seed, and the days of evaluations.
fn note(config: &TrainConfig) -> Result<String> {
    let evaluated = match config.evaluation.every {
        0 => "not evaluated during training".to_owned(),
        _ => {
            let also = if days::are_held_out(config)? { "" } else { ", which training uses as well" };
            format!("evaluated on {}{also}", days::evaluated(config)?)
        }
    };
    Ok(format!("{}, seed {}; {evaluated}", config.training_set.period, config.budget.seed))
}

/// Writes the page of a run's folder from its table.
pub(crate) fn write(folder: &Path, config: &TrainConfig) -> Result<()> {
    let panels = PANELS.iter().filter_map(|(name, title, baseline)| {
        let rows = read_column(folder, name).ok().filter(|rows| !rows.is_empty())?;
        let (steps, values): (Vec<u64>, Vec<f64>) = rows.into_iter().unzip();
        Some(json!({"title": title, "steps": steps, "values": values, "baseline": baseline}))
    });
    let data = json!({
        "title": format!("{} on {}", config.training_set.task, config.training_set.buildings_text()),
        "note": note(config)?,
        "panels": panels.collect::<Vec<Value>>(),
    });
    let path = folder.join(PAGE);
    write_whole(&path, fill(TEMPLATE, &data).as_bytes()).map_err(at(&path))
}
