//! Specialists and generalists on test buildings, like the paper's figures of dynamics adaptation.

use std::collections::BTreeMap;

use b2b_evaluate::report::{Chart, Series, color, horizontal_line, make_logarithmic, range, rms_deviations};
use b2b_evaluate::statistics::{mean, median, score_text};
use b2b_evaluate::{EpisodeInfo, EpisodeResult, Scored};
use serde_json::json;

use super::content::{Content, SCORES};
use super::group::Group;
use crate::absolute::{deviation, energy, figure_text, median_text, reactive_deviation, reactive_energy};
use crate::definition::{Experiment, Policy, Training};
use crate::results::Results;

/// The scores of a policy on the test buildings.
struct Tested<'a> {
    name: &'a str,
    group: Group,
    rows: Vec<&'a EpisodeResult>,
    trainings: usize,
    median: f64,
    error: Option<f64>,
}

pub(super) fn content(experiment: &Experiment, results: &Results) -> Content {
    let policies = experiment.policies(&results.budget);
    let tested: Vec<Tested<'_>> = policies.iter().filter_map(|policy| Tested::of(results, policy)).collect();
    let title = "on test buildings; ± standard error: over seeds, or by bootstrap over buildings for specialists; medians of RMS \
                 deviation and of the HVAC energy of the run period";
    let table = json!({
        "title": title,
        "header": ["agent", "trainings", "episodes", "median score", "resolved median", "range", "below 1",
                   "RMS deviation (K)", "mean", "reactive: RMS deviation (K)", "HVAC energy (kWh/m²)",
                   "reactive: HVAC energy (kWh/m²)"],
        "rows": tested.iter().map(Tested::cells).collect::<Vec<_>>(),
    });
    let series: Vec<Series<'_>> = tested.iter().map(Tested::series).collect();
    let mut notes = SCORES.to_owned();
    if !experiment.paper.starts_with("not in") {
        notes += " The paper's figure is a picture only: its text has no numbers to show here.";
    }
    Content {
        tables: vec![table],
        charts: vec![medians(&tested), rms_deviations(&series)],
        notes,
        ..Content::default()
    }
}

impl<'a> Tested<'a> {
    /// Returns `None` without a score.
    fn of(results: &'a Results, policy: &'a Policy<'a>) -> Option<Self> {
        let rows: Vec<&EpisodeResult> = results.of(&policy.name).map(|(_, row)| row).collect();
        let group = Group::of(rows.iter().copied())?;
        let mut of_jobs = Vec::new();
        let mut by_building: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for (_, rows) in results.trainings(&policy.name) {
            let Some(median) = Group::of(rows.iter()).map(|group| group.median()) else { continue };
            of_jobs.push(median);
            by_building.entry(&rows[0].info.building).or_default().push(median);
        }
        // A generalist's median is the mean of its seeds' medians; specialists have one building each.
        let (median, error) = match policy.agent.trains {
            Training::Building => {
                (group.median(), bootstrap_error(&Vec::from_iter(by_building.into_values())))
            }
            _ => (mean(&of_jobs), standard_error(&of_jobs)),
        };
        Some(Self { name: &policy.name, group, rows, trainings: of_jobs.len(), median, error })
    }

    fn cells(&self) -> Vec<String> {
        let deviations: Vec<f64> =
            self.rows.iter().filter_map(|row| Some(row.metrics()?.rms_deviation)).collect();
        let error = self.error.map_or(String::new(), |error| format!(" ± {}", score_text(error)));
        let [_, resolved, range, beats] = self.group.cells();
        vec![
            self.name.to_owned(),
            self.trainings.to_string(),
            self.group.count().to_string(),
            score_text(self.median) + &error,
            resolved,
            range,
            beats,
            median_text(&self.rows, deviation),
            figure_text(mean(&deviations)),
            median_text(&self.rows, reactive_deviation),
            median_text(&self.rows, energy),
            median_text(&self.rows, reactive_energy),
        ]
    }

    fn series(&self) -> Series<'a> {
        let ran = |row: &&'a EpisodeResult| -> Option<(&'a EpisodeInfo, &'a Scored)> {
            Some((&row.info, row.scored()?))
        };
        Series { name: self.name, episodes: self.rows.iter().filter_map(ran).collect() }
    }
}

/// Draws the median scores.
fn medians(tested: &[Tested<'_>]) -> Chart {
    let medians: Vec<f64> = tested.iter().map(|each| each.median).collect();
    let mut layout = json!({"xaxis": {"type": "category"}, "yaxis": {"title": {"text": "median score"}, "rangemode": "tozero"},
                            "shapes": [horizontal_line(1.0)], "showlegend": false});
    let (low, high) = range(&medians);
    // A logarithmic axis has no zero for bars to start from.
    let (kind, size) = match make_logarithmic(&mut layout["yaxis"], (low.min(1.0), high.max(1.0))) {
        true => ("scatter", 11),
        false => ("bar", 0),
    };
    Chart {
        title: "Median score on the test buildings".into(),
        note: "dashed line: the reactive controllers; below is better".into(),
        height: 340,
        wide: false,
        data: json!([{
            "type": kind, "mode": "markers", "x": tested.iter().map(|each| each.name).collect::<Vec<_>>(), "y": medians,
            "marker": {"color": (0..tested.len()).map(color).collect::<Vec<_>>(), "size": size}, "width": 0.6,
            "error_y": {"type": "data", "array": tested.iter().map(|each| each.error).collect::<Vec<_>>()},
            "hovertemplate": "%{x}: %{y:.3f}<extra></extra>",
        }]),
        layout,
    }
}

/// Returns the standard error of a mean; `None` for a single value.
fn standard_error(values: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let mean = mean(values);
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64;
    Some((variance / values.len() as f64).sqrt())
}

/// Returns the standard deviation of the median when the buildings are resampled, each with all of its values; `None`
/// for a single building.
fn bootstrap_error(buildings: &[Vec<f64>]) -> Option<f64> {
    use rand::{RngExt, SeedableRng};
    const DRAWS: usize = 2000;
    if buildings.len() < 2 {
        return None;
    }
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(0);
    let medians: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let drawn = buildings.iter().map(|_| &buildings[random.random_range(0..buildings.len())]);
            let mut drawn: Vec<f64> = drawn.flatten().copied().collect();
            drawn.sort_by(f64::total_cmp);
            median(&drawn)
        })
        .collect();
    Some(standard_error(&medians)? * (DRAWS as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_follow_their_definitions() {
        assert!((standard_error(&[1.0, 2.0, 3.0]).unwrap() - 1.0 / 3.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!((standard_error(&[1.0]), bootstrap_error(&[vec![1.0, 2.0]])), (None, None));
        // The median of a large normal sample has a standard error of 1.253 σ / √n.
        let values: Vec<Vec<f64>> = (0..100).map(|index| vec![f64::from(index % 10)]).collect();
        let error = bootstrap_error(&values).unwrap();
        assert!(error > 0.1 && error < 1.0, "{error}");
        // Four equal values per building count no more than one.
        let repeated: Vec<Vec<f64>> = values.iter().map(|values| values.repeat(4)).collect();
        assert_eq!(bootstrap_error(&repeated), Some(error));
    }
}
