//! The leading metrics of operation: cost, energy, discomfort and peak of every run, compared with the first.

use b2b_env::{Display, EpisodeMetrics};
use serde_json::{Value, json};

use super::recorded::Recorded;
use crate::terminal::table::Table;

/// Columns of the leading metrics, and whether they are compared as ratios, which does not suit discomfort near 0.
const LEAD: [(&str, bool); 4] =
    [("cost_tot", true), ("ener_tot", true), ("tdis_tot", false), ("pele_tot", true)];

/// A leading metric of all runs.
struct Lead {
    label: String,
    decimals: usize,
    /// Value of each run, and its difference from the first as text.
    cells: Vec<(Option<f64>, String)>,
}

/// Returns the leading metrics; none for tasks without bands.
fn leading(runs: &[Recorded]) -> Vec<Lead> {
    if !runs[0].described.task_definition.is_operation() {
        return Vec::new();
    }
    let columns = LEAD.iter().filter_map(|(name, by_ratio)| {
        let column = EpisodeMetrics::columns().find(|column| column.name == *name)?;
        Some((column.name, column.display?, *by_ratio))
    });
    columns.map(|(name, display, by_ratio)| Lead::of(runs, name, display, by_ratio)).collect()
}

/// Returns whether a metric leads in a comparison of runs.
pub fn leads(runs: &[Recorded], column: &str) -> bool {
    runs[0].described.task_definition.is_operation() && LEAD.iter().any(|(name, _)| *name == column)
}

impl Lead {
    fn of(runs: &[Recorded], name: &str, display: Display, by_ratio: bool) -> Self {
        let values: Vec<_> = runs.iter().map(|run| Some(run.metric(name)? * display.scale)).collect();
        let first = values[0];
        let cell = |(number, value): (usize, &Option<f64>)| match (number, first, value) {
            (0, ..) | (_, None, _) | (_, _, None) => (*value, String::new()),
            (_, Some(first), Some(value)) => {
                (Some(*value), difference(*value, first, by_ratio, display.decimals))
            }
        };
        let currency = runs[0].described.currency.as_deref().unwrap_or("currency");
        Self {
            label: display.label.replace("currency", currency),
            decimals: display.decimals,
            cells: values.iter().enumerate().map(cell).collect(),
        }
    }
}

/// Returns the difference of a value from the first, as a percentage or in its unit.
fn difference(value: f64, first: f64, by_ratio: bool, decimals: usize) -> String {
    match by_ratio {
        true if first > 0.0 => format!("{:+.1} %", 100.0 * (value / first - 1.0)),
        true => String::new(),
        false => format!("{:+.decimals$}", value - first),
    }
}

/// Returns the table for the terminal, a row per run, followed by an empty line. Empty for tasks without bands.
pub fn table(runs: &[Recorded]) -> String {
    let leading = leading(runs);
    if leading.is_empty() {
        return String::new();
    }
    let mut header = vec!["run".to_owned()];
    header.extend(leading.iter().flat_map(|lead| [lead.label.clone(), "difference".to_owned()]));
    let mut table = Table::with_header(header);
    for (number, run) in runs.iter().enumerate() {
        let mut cells = vec![run.name.clone()];
        for Lead { decimals, cells: values, .. } in &leading {
            let (value, difference) = &values[number];
            cells.extend([value.map_or("–".to_owned(), |v| format!("{v:.decimals$}")), difference.clone()]);
        }
        table.push(cells);
    }
    format!("{}\n\n", table.text())
}

/// Returns the leading metrics for the page.
pub fn json(runs: &[Recorded]) -> Value {
    let lead = |Lead { label, decimals, cells }: Lead| {
        let (values, differences): (Vec<_>, Vec<_>) = cells.into_iter().unzip();
        json!({"label": label, "decimals": decimals, "values": values, "differences": differences})
    };
    leading(runs).into_iter().map(lead).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_differ_in_percent_and_discomfort_in_its_unit() {
        assert_eq!(difference(0.24, 0.30, true, 3), "-20.0 %");
        assert_eq!(difference(2.5, 0.0, false, 1), "+2.5");
        assert_eq!(difference(2.5, 0.0, true, 1), "");
        let names: Vec<_> = EpisodeMetrics::columns().filter(|each| each.display.is_some()).collect();
        assert!(LEAD.iter().all(|(name, _)| names.iter().any(|each| each.name == *name)));
    }
}
