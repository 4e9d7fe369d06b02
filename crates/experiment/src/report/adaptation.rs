//! Specialists and generalists on test buildings, like the paper's figures of dynamics adaptation.

use b2b_evaluate::report::{Chart, Series, color, horizontal_line, make_logarithmic, range, rms_deviations};
use b2b_evaluate::statistics::{Interval, aggregate, mean};
use b2b_evaluate::{EpisodeInfo, EpisodeResult, Scored};
use serde_json::json;

use super::content::{Content, SCORES};
use super::group::Group;
use crate::absolute::{deviation, energy, figure_text, median_text, reactive_deviation, reactive_energy};
use crate::definition::Experiment;
use crate::results::{Ran, Results, samples};

/// The scores of a policy on the test buildings.
struct Tested<'a> {
    name: &'a str,
    group: Group,
    rows: Vec<&'a EpisodeResult>,
    trainings: usize,
    median: Interval,
}

pub(super) fn content(experiment: &Experiment, results: &Results) -> Content {
    let policies = experiment.policies(&results.budget);
    let tested: Vec<Tested<'_>> =
        policies.iter().filter_map(|policy| Tested::of(results, &policy.name)).collect();
    let title = "on test buildings; median score with its 95 % interval (a bootstrap over buildings and seeds); medians of RMS \
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
    fn of(results: &'a Results, name: &'a str) -> Option<Self> {
        let ran: Vec<Ran<'_>> = results.of(name).collect();
        let median = aggregate(&samples(&ran, |scored| scored.score))?.median;
        let rows: Vec<&EpisodeResult> = ran.into_iter().map(|(_, row)| row).collect();
        let group = Group::of(rows.iter().copied())?;
        Some(Self { name, group, rows, trainings: results.trainings(name).count(), median })
    }

    fn cells(&self) -> Vec<String> {
        let deviations: Vec<f64> =
            self.rows.iter().filter_map(|row| Some(row.metrics()?.rms_deviation)).collect();
        let [_, resolved, range, beats] = self.group.cells();
        vec![
            self.name.to_owned(),
            self.trainings.to_string(),
            self.group.count().to_string(),
            self.median.to_string(),
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
    let of = |value: fn(Interval) -> f64| tested.iter().map(|each| value(each.median)).collect::<Vec<_>>();
    let medians = of(|median| median.value);
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
            "error_y": {"type": "data", "symmetric": false, "array": of(|median| median.high - median.value),
                        "arrayminus": of(|median| median.value - median.low)},
            "hovertemplate": "%{x}: %{y:.3f}<extra></extra>",
        }]),
        layout,
    }
}
