//! What counts in tasks with comfort bands: cost, energy, discomfort and peak, a row for each period.

use b2b_env::EpisodeMetrics;
use serde::Serialize;

use crate::evaluation::Row;
use crate::statistics::Aggregate;
use crate::summary::{Group, Summary, Window};

/// Means over the episodes of a group in tasks with bands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OperationMeans {
    /// Cost of HVAC energy, currency/m².
    pub cost_tot: f64,
    /// HVAC energy, kWh/m².
    pub ener_tot: f64,
    /// Thermal discomfort, K h per zone.
    pub tdis_tot: f64,
    /// Peak electric demand, kW/m².
    pub pele_tot: f64,
    /// Share of the occupied zone-hours outside the band.
    pub occupied_outside_share: f64,
}

/// A table of text cells.
#[derive(Clone, Debug, PartialEq)]
pub struct OperationTable {
    /// Names of the columns, with units.
    pub header: Vec<&'static str>,
    /// A row for each period, task and building type.
    pub rows: Vec<Vec<String>>,
}

impl OperationMeans {
    /// Returns the means over episodes; `None` unless all of them are of tasks with bands.
    pub fn of<'a>(metrics: impl Iterator<Item = &'a EpisodeMetrics>) -> Option<Self> {
        let metrics: Vec<_> = metrics.collect();
        if metrics.is_empty() || metrics.iter().any(|each| each.tdis_tot.is_none()) {
            return None;
        }
        let mean = |value: fn(&EpisodeMetrics) -> Option<f64>| {
            metrics.iter().map(|each| value(each).unwrap_or(0.0)).sum::<f64>() / metrics.len() as f64
        };
        Some(Self {
            cost_tot: mean(|each| each.cost_tot),
            ener_tot: mean(|each| each.ener_tot),
            tdis_tot: mean(|each| each.tdis_tot),
            pele_tot: mean(|each| each.pele_tot),
            occupied_outside_share: mean(|each| Some(each.occupied_too_cold? + each.occupied_too_warm?)),
        })
    }

    /// Returns the means of rows that were not lost.
    pub(crate) fn of_rows<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Option<Self> {
        Self::of(rows.into_iter().filter_map(Row::metrics))
    }

    /// Returns the cells of discomfort (K·h per zone), occupied hours outside (%) and peak (W/m²).
    pub(crate) fn comfort_cells(&self) -> [String; 3] {
        [
            format!("{:.1}", self.tdis_tot),
            format!("{:.1}", 100.0 * self.occupied_outside_share),
            format!("{:.1}", 1000.0 * self.pele_tot),
        ]
    }
}

impl OperationTable {
    /// Columns of [`OperationMeans::comfort_cells`].
    pub(crate) const COMFORT: [&'static str; 3] =
        ["discomfort (K·h per zone)", "occupied hours outside (%)", "peak demand, 15 min (W/m²)"];

    /// Returns the table of the windows with bands, a row for each and, with several building types, for each of these; `None`
    /// if there are none. Ratios are to the baseline.
    pub fn of(summary: &Summary) -> Option<Self> {
        let windows = summary.windows.iter().filter(|window| window.is_operation());
        let rows: Vec<_> = windows.flat_map(rows).collect();
        let [discomfort, outside, peak] = Self::COMFORT;
        let header = vec![
            "period",
            "task",
            "type",
            "cost (per m²)",
            "cost / baseline",
            "HVAC energy (kWh/m²)",
            "energy / baseline",
            discomfort,
            outside,
            peak,
            "score",
        ];
        (!rows.is_empty()).then_some(Self { header, rows })
    }
}

impl Window {
    /// Returns whether the task has comfort bands.
    pub fn is_operation(&self) -> bool {
        self.all.operation.is_some()
    }
}

fn rows(window: &Window) -> Vec<Vec<String>> {
    let several = window.types.len() > 1;
    let groups = window.types.iter().chain(several.then_some(&window.all));
    let row = |group: &Group| {
        let means = group.operation?;
        let ratio = |ratio: Option<f64>| ratio.map_or("–".to_owned(), |ratio| format!("{ratio:.2}"));
        let score = |scores: &Aggregate| scores.interquartile_mean.to_string();
        let mut cells = vec![
            window.period.clone(),
            window.task.clone(),
            group.name.clone(),
            format!("{:.3}", means.cost_tot),
            ratio(group.relative_resource),
            format!("{:.2}", means.ener_tot),
            ratio(group.relative_energy),
        ];
        cells.extend(means.comfort_cells());
        cells.push(group.scores.as_ref().map_or("–".to_owned(), score));
        Some(cells)
    };
    groups.filter_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn episode(cost: f64, discomfort: f64) -> EpisodeMetrics {
        EpisodeMetrics { cost_tot: Some(cost), tdis_tot: Some(discomfort), ..EpisodeMetrics::default() }
    }

    #[test]
    fn means_are_of_tasks_with_bands_alone() {
        let means = OperationMeans::of([episode(0.2, 1.0), episode(0.4, 2.0)].iter()).unwrap();
        assert!((means.cost_tot - 0.3).abs() < 1e-12 && means.tdis_tot == 1.5);
        let mixed = [episode(0.2, 1.0), EpisodeMetrics::default()];
        assert_eq!(OperationMeans::of(mixed.iter()), None);
        assert_eq!(OperationMeans::of([].iter()), None);
    }
}
