//! The metrics of the runs, and their differences from the first.

use std::path::Path;

use b2b_env::{Display, EpisodeMetrics};
use serde_json::{Map, Value, json};

use super::lead;
use super::recorded::Recorded;
use super::worst_hours;
use crate::terminal::table::Table;

/// A metric in the comparison.
pub struct Metric {
    /// Column of the episode metrics.
    column: &'static str,
    /// How it is shown.
    pub display: Display,
}

/// Returns the metrics in order.
fn metrics() -> impl Iterator<Item = Metric> {
    EpisodeMetrics::columns()
        .filter_map(|column| Some(Metric { column: column.name, display: column.display? }))
}

impl Metric {
    /// Returns the value of each run, in the unit of the label.
    pub fn values(&self, runs: &[Recorded]) -> Vec<Option<f64>> {
        let scale = self.display.scale;
        runs.iter().map(|run| run.metric(self.column).map(|value| value * scale + 0.0)).collect()
    }

    /// Returns the label. In operation, `thermal discomfort` counts from the edge of the band, and these two from
    /// `comfort_band` beyond it.
    pub fn label(&self, runs: &[Recorded]) -> String {
        let task = &runs[0].described.task_definition;
        let outside = |unit| format!("more than {} K outside ({unit})", task.comfort_band);
        match self.column {
            "discomfort_k_h" if task.is_operation() => outside("K·h"),
            "hours_outside_band" if task.is_operation() => outside("h"),
            _ => self.display.label.to_owned(),
        }
    }

    fn text(&self, value: Option<f64>) -> String {
        let decimals = self.display.decimals;
        value.map_or("–".to_owned(), |value| without_sign_of_zero(format!("{value:.decimals$}")))
    }

    fn difference_text(&self, difference: Option<f64>) -> String {
        let decimals = self.display.decimals;
        let signed = |difference| without_sign_of_zero(format!("{difference:+.decimals$}"));
        difference.map_or("–".to_owned(), signed)
    }
}

/// Returns the metrics that are not zero or missing in all runs, with their values, except the leading ones.
pub fn relevant(runs: &[Recorded]) -> impl Iterator<Item = (Metric, Vec<Option<f64>>)> {
    let with_values = |metric: Metric| {
        let values = metric.values(runs);
        (metric, values)
    };
    let follows = |metric: &Metric| !lead::leads(runs, metric.column);
    metrics()
        .filter(follows)
        .map(with_values)
        .filter(|(_, values)| values.iter().any(|v| v.is_some_and(|v| v != 0.0)))
}

/// Returns the table: a row per metric; a column per run, with its difference from the first.
pub fn table(runs: &[Recorded]) -> String {
    let mut header = vec!["metric".to_owned(), runs[0].name.clone()];
    header.extend(runs[1..].iter().flat_map(|run| [run.name.clone(), "difference".to_owned()]));
    let mut table = Table::with_header(header);
    for (metric, values) in relevant(runs) {
        let mut cells = vec![metric.label(runs), metric.text(values[0])];
        for value in &values[1..] {
            cells.extend([metric.text(*value), metric.difference_text(subtract(*value, values[0]))]);
        }
        table.push(cells);
    }
    table.text()
}

/// Returns the object that `--json` prints.
pub fn json(runs: &[Recorded], page: &Path) -> Value {
    let described = &runs[0].described;
    let run = |run: &Recorded| {
        let (mut metrics, mut difference) = (Map::new(), Map::new());
        for Metric { column, .. } in self::metrics() {
            let value = run.metric(column);
            metrics.insert(column.to_owned(), json!(value));
            difference.insert(column.to_owned(), json!(subtract(value, runs[0].metric(column))));
        }
        json!({
            "name": run.name,
            "folder": run.folder,
            "controller": run.described.controller,
            "metrics": metrics,
            "difference": difference,
            "worst_hours": worst_hours::of(run),
        })
    };
    json!({
        "building": described.building,
        "place": described.place,
        "period": described.period,
        "task": described.task,
        "steps_per_hour": described.steps_per_hour,
        "steps": runs[0].steps(),
        "runs": runs.iter().map(run).collect::<Vec<_>>(),
        "page": page,
    })
}

fn subtract(value: Option<f64>, reference: Option<f64>) -> Option<f64> {
    Some(value? - reference?)
}

fn without_sign_of_zero(text: String) -> String {
    let digits = text.trim_start_matches(['-', '+']);
    if digits.chars().all(|c| matches!(c, '0' | '.')) { digits.to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_have_a_sign_unless_they_round_to_zero() {
        let metric = metrics().find(|metric| metric.column == "rms_deviation_k").unwrap();
        let text = |value: f64| metric.difference_text(Some(value));
        assert_eq!([0.5, -0.5, 0.001, -0.001].map(text), ["+0.50", "-0.50", "0.00", "0.00"]);
        assert_eq!(metric.difference_text(None), "–");
    }
}
