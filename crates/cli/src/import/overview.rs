//! The text and JSON report on several models.

use anyhow::Result;
use b2b_building::hvac::KINDS;
use serde_json::{Value, json};

use super::report::{Group, Report, groups};
use super::trial::Trial;
use crate::terminal::table::Table;

/// RMS deviation of the worst zone from which a note names the zone, K.
const LARGE_DEVIATION: f64 = 1.0;

/// Returns the names of the columns, including a count of systems for each kind.
fn columns() -> Vec<String> {
    let kinds = KINDS.iter().map(|kind| kind.plural());
    let first = ["model", "zones", "controlled"].into_iter();
    let last = ["actuators", "not controlled", "RMS (K)", "worst zone (K)", "severe"];
    first.chain(kinds).chain(last).map(str::to_owned).collect()
}

/// The report on one of several models, or the error if it cannot be imported.
pub struct Imported {
    pub name: String,
    pub report: Result<Report, String>,
}

impl Imported {
    /// Returns whether the model was imported and, if simulated, had no severe messages.
    pub fn passed(&self) -> bool {
        let quiet = |report: &Report| report.trial.as_ref().is_none_or(|trial| trial.severes == 0);
        self.report.as_ref().is_ok_and(quiet)
    }

    /// Returns the report, or the error, as JSON.
    pub fn json(&self) -> Result<Value> {
        Ok(match &self.report {
            Ok(report) => serde_json::to_value(report)?,
            Err(error) => json!({"model": self.name, "error": error}),
        })
    }
}

/// Returns a table with a row per model, then notes.
pub fn text(imported: &[Imported]) -> String {
    let mut table = Table::with_header(columns());
    let mut notes = String::new();
    for each in imported {
        match &each.report {
            Ok(report) => {
                table.push(row(&each.name, report));
                notes += &note(&each.name, report);
            }
            Err(error) => {
                let mut cells = vec!["–".to_owned(); columns().len()];
                cells[0].clone_from(&each.name);
                table.push(cells);
                let error = error.replace('\n', "\n  ");
                notes += &format!("\n  {}: {error}", each.name);
            }
        }
    }
    let usable = imported.iter().filter(|each| each.report.is_ok()).count();
    format!("{}\n\n{usable} of {} models can be used as environments{notes}", table.text(), imported.len())
}

fn row(name: &str, report: &Report) -> Vec<String> {
    let of_trial = |value: fn(&Trial) -> String| report.trial.as_ref().map_or_else(|| "–".to_owned(), value);
    let mut cells =
        vec![name.to_owned(), report.zones.len().to_string(), report.controlled_zones().to_string()];
    cells.extend(KINDS.iter().map(|kind| report.count(*kind).to_string()));
    cells.extend([
        report.actuators().to_string(),
        report.not_controlled.len().to_string(),
        of_trial(|trial| if trial.cools { format!("{:.2}", trial.rms_deviation_k) } else { "–".to_owned() }),
        of_trial(|trial| format!("{:.2}", trial.worst_zone_rms_k)),
        of_trial(|trial| trial.severes.to_string()),
    ]);
    cells
}

/// Returns the components of a model that are not controlled, with the reason, and notes on problems in its trial.
fn note(name: &str, report: &Report) -> String {
    let line = |group: &Group<'_>| format!("{} × {}: {}", group.members.len(), group.class, group.reason);
    let mut lines: Vec<String> = groups(&report.not_controlled).iter().map(line).collect();
    let follows = groups(&report.follows_setpoints);
    lines.extend(follows.iter().map(|group| format!("through setpoints: {}", line(group))));
    if let Some(trial) = &report.trial {
        lines.extend(trial.severe_message.iter().map(|message| message.replace('\n', " ")));
        if !trial.never_near_target.is_empty() {
            lines.push(format!("never near target: {}", trial.never_near_target.join(", ")));
        }
        if trial.worst_zone_rms_k >= LARGE_DEVIATION {
            lines.push(format!("worst zone: {}", trial.worst_zone));
        }
    }
    if lines.is_empty() { String::new() } else { format!("\n  {name}\n    {}", lines.join("\n    ")) }
}
