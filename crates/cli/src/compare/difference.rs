//! The metrics of the runs, and their differences from the first.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::recorded::Recorded;
use super::worst_hours;
use crate::table::Table;

/// A metric in the comparison.
pub struct Metric {
    /// Name with its unit.
    pub label: &'static str,
    /// Column of the episode metrics.
    column: &'static str,
    /// Factor from the unit of the column.
    scale: f64,
    pub decimals: usize,
    /// Whether higher is better; `None` if neither.
    pub higher_is_better: Option<bool>,
}

const fn metric(
    label: &'static str,
    column: &'static str,
    (scale, decimals): (f64, usize),
    higher_is_better: Option<bool>,
) -> Metric {
    Metric { label, column, scale, decimals, higher_is_better }
}

/// The metrics in order.
pub const METRICS: [Metric; 15] = [
    metric("return", "return", (1.0, 1), Some(true)),
    metric("RMS deviation (K)", "rms_deviation_k", (1.0, 2), Some(false)),
    metric(
        "RMS deviation below target, zones without cooling (K)",
        "rms_heating_only_k",
        (1.0, 2),
        Some(false),
    ),
    metric("mean absolute deviation (K)", "mean_abs_deviation_k", (1.0, 2), Some(false)),
    metric("outside comfort band (h)", "hours_outside_band", (1.0, 1), Some(false)),
    metric("discomfort outside the band (K·h)", "discomfort_k_h", (1.0, 1), Some(false)),
    metric("HVAC electricity (kWh/m²)", "electricity_wh_m2", (1e-3, 2), Some(false)),
    metric("HVAC gas (kWh/m²)", "gas_wh_m2", (1e-3, 2), Some(false)),
    metric("cost at the task's prices (per m²)", "cost_m2", (1.0, 2), Some(false)),
    metric("emissions (kg CO₂/m²)", "emissions_kg_m2", (1.0, 2), Some(false)),
    metric("peak electric demand (W/m²)", "peak_electricity_w_m2", (1.0, 1), Some(false)),
    metric("peak gas demand (W/m²)", "peak_gas_w_m2", (1.0, 1), Some(false)),
    metric("actuator travel (strokes/day)", "daily_travel", (1.0, 1), Some(false)),
    metric("sustained oscillation (% of zone-steps)", "oscillating_share", (100.0, 1), Some(false)),
    metric("outdoor air per person (L/s)", "outdoor_air_l_s_person", (1.0, 1), None),
];

impl Metric {
    /// Returns the value of each run, in the unit of the label.
    pub fn values(&self, runs: &[Recorded]) -> Vec<Option<f64>> {
        runs.iter().map(|run| run.metric(self.column).map(|value| value * self.scale + 0.0)).collect()
    }

    fn text(&self, value: Option<f64>) -> String {
        value.map_or("–".to_owned(), |value| without_sign_of_zero(format!("{value:.*}", self.decimals)))
    }

    fn difference_text(&self, difference: Option<f64>) -> String {
        let signed = |difference| without_sign_of_zero(format!("{difference:+.*}", self.decimals));
        difference.map_or("–".to_owned(), signed)
    }
}

/// Returns the metrics of which not all values are zero or missing, with their values.
pub fn relevant(runs: &[Recorded]) -> impl Iterator<Item = (&'static Metric, Vec<Option<f64>>)> {
    let with_values = |metric: &'static Metric| (metric, metric.values(runs));
    METRICS.iter().map(with_values).filter(|(_, values)| values.iter().any(|v| v.is_some_and(|v| v != 0.0)))
}

/// Returns the table: a row per metric; a column per run, with its difference from the first.
pub fn table(runs: &[Recorded]) -> String {
    let mut header = vec!["metric".to_owned(), runs[0].name.clone()];
    header.extend(runs[1..].iter().flat_map(|run| [run.name.clone(), "difference".to_owned()]));
    let mut table = Table::with_header(header);
    for (metric, values) in relevant(runs) {
        let mut cells = vec![metric.label.to_owned(), metric.text(values[0])];
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
        for Metric { column, .. } in &METRICS {
            let value = run.metric(column);
            metrics.insert((*column).to_owned(), json!(value));
            difference.insert((*column).to_owned(), json!(subtract(value, runs[0].metric(column))));
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
    use b2b_env::EpisodeMetrics;

    #[test]
    fn every_metric_is_a_column_of_the_episode_metrics() {
        for metric in &METRICS {
            assert!(EpisodeMetrics::COLUMNS.iter().any(|c| c.name == metric.column), "{}", metric.column);
        }
    }

    #[test]
    fn differences_have_a_sign_unless_they_round_to_zero() {
        let text = |value: f64| METRICS[1].difference_text(Some(value));
        assert_eq!([0.5, -0.5, 0.001, -0.001].map(text), ["+0.50", "-0.50", "0.00", "0.00"]);
        assert_eq!(METRICS[1].difference_text(None), "–");
    }
}
