//! The charts of an evaluation's report.

use b2b_env::EpisodeMetrics;
use serde_json::{Value, json};

use super::chart::{
    Chart, color, distribution, has_several_tasks, horizontal_line, hover_name, make_logarithmic,
    mean_diamond, range,
};
use super::deviation_chart::{StepDeviations, step_deviations};
use super::series::Series;
use super::trade_off::trade_offs;
use crate::evaluation::{EpisodeInfo, EpisodeResult};
use crate::results::Results;
use crate::summary::type_label;

/// An episode that was not lost.
#[derive(Clone, Copy)]
struct EpisodeRun<'a> {
    info: &'a EpisodeInfo,
    metrics: &'a EpisodeMetrics,
    score: Option<f64>,
}

impl<'a> EpisodeRun<'a> {
    fn of(row: &'a EpisodeResult) -> Option<Self> {
        let scored = row.scored()?;
        Some(Self { info: &row.info, metrics: &scored.metrics, score: scored.score })
    }
}

/// Returns all charts in order.
pub(super) fn all(results: &Results, deviations: &[StepDeviations]) -> Vec<Value> {
    let rows: Vec<EpisodeRun<'_>> = results.rows.iter().filter_map(EpisodeRun::of).collect();
    let types = distinct(&rows, |row| row.info.building_type.clone());
    let charts = [
        scores_by_type(&rows, &types),
        scores_by_zone(&rows, &types),
        step_deviations("Deviations of all steps".into(), deviations),
        rms_deviations(&rows, &types),
    ];
    charts.into_iter().chain(by_type(results, &types)).map(Chart::json).collect()
}

fn distinct<K: PartialEq>(rows: &[EpisodeRun<'_>], key: impl Fn(&EpisodeRun<'_>) -> K) -> Vec<K> {
    let mut keys = Vec::new();
    for key in rows.iter().map(key) {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys
}

fn type_color(types: &[String], name: &str) -> &'static str {
    color(types.iter().position(|each| each == name).unwrap_or_default())
}

fn of_type<'a>(rows: &[EpisodeRun<'a>], building_type: &str) -> Vec<EpisodeRun<'a>> {
    rows.iter().filter(|row| row.info.building_type == building_type).copied().collect()
}

/// Returns the hover label of an episode.
fn label(row: &EpisodeRun<'_>) -> String {
    let score = row.score.map_or("no score".to_owned(), |score| format!("score {score:.3}"));
    let EpisodeMetrics { episode_return, rms_deviation, .. } = row.metrics;
    format!(
        "{}<br>{score}, return {episode_return:.1}, RMS deviation {rms_deviation:.2} K",
        hover_name(row.info)
    )
}

fn labels(rows: &[EpisodeRun<'_>]) -> Vec<String> {
    rows.iter().map(label).collect()
}

fn scores_by_type(rows: &[EpisodeRun<'_>], types: &[String]) -> Chart {
    let several_tasks = has_several_tasks(rows.iter().map(|row| row.info));
    let (data, layout) = scores(rows, types, |row| match type_label(&row.info.building_type) {
        label if several_tasks => format!("{label}<br>{}", row.info.task),
        label => label.to_owned(),
    });
    Chart {
        title: format!("Scores by building type{}", if several_tasks { " and task" } else { "" }),
        note: "one point per episode; dashed: the baseline".into(),
        height: 360,
        wide: false,
        data,
        layout,
    }
}

fn scores_by_zone(rows: &[EpisodeRun<'_>], types: &[String]) -> Chart {
    let mut rows = rows.to_vec();
    rows.sort_by(|a, b| a.info.climate_zone.cmp(&b.info.climate_zone));
    let (mut data, layout) = scores(&rows, types, |row| row.info.climate_zone.clone());
    // A box over several tasks would show differences between tasks.
    if let (true, Value::Array(traces)) = (has_several_tasks(rows.iter().map(|row| row.info)), &mut data) {
        traces.retain(|trace| trace["type"] != "box");
    }
    Chart {
        title: "Scores by climate zone".into(),
        note: "ASHRAE 169 climate zones, from hot to cold; dashed: the baseline".into(),
        height: 360,
        wide: false,
        data,
        layout,
    }
}

/// Draws a box per category, with its episodes in the colors of their types.
fn scores(
    rows: &[EpisodeRun<'_>],
    types: &[String],
    category: impl Fn(&EpisodeRun<'_>) -> String,
) -> (Value, Value) {
    let scored: Vec<EpisodeRun<'_>> =
        rows.iter().copied().filter(|row| row.score.is_some_and(f64::is_finite)).collect();
    let values: Vec<f64> = scored.iter().filter_map(|row| row.score).collect();
    let mut data = vec![json!({
        "type": "box", "x": scored.iter().map(&category).collect::<Vec<_>>(), "y": values,
        "boxpoints": false, "line": {"color": "#9aa3af", "width": 1.2}, "fillcolor": "rgba(154,163,175,.12)",
        "hoverinfo": "skip", "showlegend": false, "width": 0.6,
    })];
    for name in types {
        let own = of_type(&scored, name);
        let x = own.iter().map(|row| category(row).into()).collect();
        let y = own.iter().map(|row| row.score.into()).collect();
        data.push(points(&own, x, y, type_label(name), type_color(types, name)));
    }
    let mut layout = json!({
        // Otherwise plotly would order the categories by their boxes.
        "xaxis": {"type": "category", "categoryorder": "array", "categoryarray": distinct(&scored, &category)},
        "yaxis": {"title": {"text": "score"}, "zeroline": false},
        "shapes": [horizontal_line(1.0)],
    });
    let (low, high) = range(&values);
    let (low, high) = (low.min(1.0), high.max(1.0));
    if !make_logarithmic(&mut layout["yaxis"], (low, high)) {
        // Leaves room around the line even if every score is on it.
        let margin = ((high - low) * 0.08).max(0.02);
        layout["yaxis"]["range"] = json!([low - margin, high + margin]);
    }
    (data.into(), layout)
}

fn points(rows: &[EpisodeRun<'_>], x: Vec<Value>, y: Vec<Value>, name: &str, color: &str) -> Value {
    json!({
        "type": "scatter", "mode": "markers", "x": x, "y": y, "name": name,
        "text": labels(rows), "hovertemplate": "%{text}<extra></extra>",
        "marker": {"size": 7, "color": color, "opacity": 0.8, "line": {"width": 0}},
    })
}

/// Draws violins with their episodes and means, as in the paper's figure.
fn rms_deviations(rows: &[EpisodeRun<'_>], types: &[String]) -> Chart {
    let mut data = Vec::new();
    for name in types {
        let own = of_type(rows, name);
        let values: Vec<f64> = own.iter().map(|row| row.metrics.rms_deviation).collect();
        let (label, color) = (type_label(name), type_color(types, name));
        data.push(distribution(label, &values, &labels(&own), color));
        data.push(mean_diamond(label, &values, color));
    }
    let layout = json!({
        "yaxis": {"title": {"text": "RMS deviation (K)"}, "rangemode": "tozero", "zeroline": false},
        "xaxis": {"type": "category"}, "showlegend": false,
    });
    Chart {
        title: "RMS deviation by building type".into(),
        note: "one point per episode; diamond: mean".into(),
        height: 340,
        wide: false,
        data: data.into(),
        layout,
    }
}

/// Draws resource use against comfort, with a series for each type.
fn by_type(results: &Results, types: &[String]) -> Vec<Chart> {
    let episodes = |name: &String| {
        let own = results.rows.iter().filter(|row| row.info.building_type == *name);
        own.filter_map(|row| Some((&row.info, row.scored()?))).collect()
    };
    let series: Vec<_> =
        types.iter().map(|name| Series { name: type_label(name), episodes: episodes(name) }).collect();
    trade_offs(&series, 400, true)
}
