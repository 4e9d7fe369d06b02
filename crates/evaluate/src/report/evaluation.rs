//! `report.html` of an evaluation.

use std::io::Write;

use serde_json::{Value, json};

use super::deviation_chart::StepDeviations;
use super::evaluation_charts;
use super::hourly_chart;
use crate::evaluation::{Finished, Row};
use crate::operation::{OperationMeans, OperationTable};
use crate::results::Results;
use crate::scores::RESOLUTION;
use crate::statistics::{Aggregate, score_text};
use crate::summary::{Group, Summary, Window, type_label};

/// Number of episodes with an hourly chart.
const WORST: usize = 4;

/// Writes the page. `read` returns the record of an episode by its number.
///
/// # Errors
/// The errors of the file.
pub fn write(
    file: &mut impl Write,
    results: &Results,
    summary: &Summary,
    read: &dyn Fn(usize) -> Option<Finished>,
) -> std::io::Result<()> {
    let mut charts = evaluation_charts::all(results, &deviations(results, read));
    charts.extend(
        worst(results).into_iter().filter_map(|(number, row)| {
            Some(hourly_chart::worst(&row.info, row.score(), &read(number)?.hours))
        }),
    );
    let data = json!({
        "title": format!("{} on {} episodes", summary.policy, summary.episodes),
        "tiles": tiles(summary),
        "tables": tables(summary),
        "lost": summary.lost.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "drawings": charts,
        "footer": footer(summary),
    });
    b2b_page::write_page(file, &data)
}

/// Returns the episodes with the highest scores; without scores, those with the largest deviations.
fn worst(results: &Results) -> Vec<(usize, &Row)> {
    let rows = results.rows.iter().enumerate();
    let mut ran: Vec<_> = rows.filter_map(|(number, row)| Some((number, row, row.metrics()?))).collect();
    ran.sort_by(|(_, a, a_metrics), (_, b, b_metrics)| {
        let (a_score, b_score) = (a.score().unwrap_or(0.0), b.score().unwrap_or(0.0));
        let by_deviation = || b_metrics.rms_deviation.total_cmp(&a_metrics.rms_deviation);
        b_score.total_cmp(&a_score).then_with(by_deviation)
    });
    ran.into_iter().take(WORST).map(|(number, row, _)| (number, row)).collect()
}

fn deviations(results: &Results, read: &dyn Fn(usize) -> Option<Finished>) -> Vec<StepDeviations> {
    let mut types: Vec<StepDeviations> = Vec::new();
    for (number, row) in results.rows.iter().enumerate() {
        let Some(Finished { deviations, .. }) = read(number) else { continue };
        let name = type_label(&row.info.building_type);
        let index = types.iter().position(|each| each.category == name).unwrap_or_else(|| {
            types.push(StepDeviations::empty(name.into(), name.into(), types.len()));
            types.len() - 1
        });
        types[index].add(&deviations);
    }
    types.retain(|each| !each.is_empty());
    types
}

/// Returns pairs of a label and a value.
fn tiles(summary: &Summary) -> Value {
    let mut tiles = operation_tiles(summary);
    for window in summary.windows.iter().filter(|window| !window.is_operation()) {
        let Window { task, period, all, .. } = window;
        let which = if summary.windows.len() > 1 { format!(" · {task}, {period}") } else { String::new() };
        if let Some(scores) = &all.resolved_scores {
            let score = scores.interquartile_mean.to_string();
            tiles.push(json!([format!("resolved score, interquartile mean{which}"), score]));
        }
        if let Some(scores) = &all.scores {
            let score = scores.interquartile_mean.to_string();
            tiles.push(json!([format!("score, interquartile mean{which}"), score]));
            let share = scores.beats_baseline_text();
            tiles.push(json!([format!("beats baseline (%){which}"), share]));
        }
        let deviation = format!("{:.2} K", all.rms_deviation_k);
        tiles.push(json!([format!("RMS deviation, mean{which}"), deviation]));
        let energy = format!("{:.1} kWh/m²", all.energy_wh_m2 / 1000.0);
        tiles.push(json!([format!("HVAC energy, mean{which}"), energy]));
        if let Some(ratio) = all.relative_energy {
            tiles.push(json!([format!("energy / baseline{which}"), format!("{ratio:.2}")]));
        }
    }
    tiles.into()
}

/// Returns the tiles of all windows with bands together: means over them.
fn operation_tiles(summary: &Summary) -> Vec<Value> {
    let windows = summary.windows.iter().filter(|window| window.is_operation());
    let groups: Vec<&Group> = windows.map(|window| &window.all).collect();
    let mean = |value: &dyn Fn(&Group) -> Option<f64>| {
        let values: Vec<f64> = groups.iter().filter_map(|group| value(group)).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let of = |value: fn(&OperationMeans) -> f64| mean(&|group| group.operation.as_ref().map(value));
    let tiles = [
        ("cost / baseline", mean(&|group| group.relative_resource).map(|ratio| format!("{ratio:.2}"))),
        ("energy / baseline", mean(&|group| group.relative_energy).map(|ratio| format!("{ratio:.2}"))),
        ("discomfort per zone, mean", of(|means| means.tdis_tot).map(|value| format!("{value:.1} K·h"))),
        (
            "peak electric demand, 15 min, mean",
            of(|means| 1000.0 * means.pele_tot).map(|value| format!("{value:.1} W/m²")),
        ),
    ];
    tiles.into_iter().filter_map(|(label, value)| Some(json!([label, value?]))).collect()
}

/// Returns the table of the windows with bands, and one for each other.
fn tables(summary: &Summary) -> Vec<Value> {
    let operation = OperationTable::of(summary).map(|OperationTable { header, rows }| {
        json!({
            "name": "Operation",
            "title": "means over episodes; lower is better, 1 is the baseline",
            "header": header,
            "rows": rows,
        })
    });
    let windows = summary.windows.iter().filter(|window| !window.is_operation());
    operation.into_iter().chain(windows.map(table)).collect()
}

fn table(window: &Window) -> Value {
    let row = |group: &Group| {
        let cell = |scores: &Option<Aggregate>, text: fn(&Aggregate) -> String| {
            scores.as_ref().map_or("–".to_owned(), text)
        };
        let of = |text: fn(&Aggregate) -> String| cell(&group.scores, text);
        json!([
            group.name,
            group.episodes().to_string(),
            cell(&group.resolved_scores, |scores| scores.interquartile_mean.to_string()),
            of(|scores| scores.interquartile_mean.to_string()),
            of(|scores| scores.median.to_string()),
            of(|scores| scores.mean.to_string()),
            of(|scores| score_text(scores.min)),
            of(|scores| score_text(scores.max)),
            of(Aggregate::beats_baseline_text),
            format!("{:.2}", group.rms_deviation_k),
            group.relative_energy.map_or("–".to_owned(), |ratio| format!("{ratio:.2}")),
            group.relative_resource.map_or("–".to_owned(), |ratio| format!("{ratio:.2}")),
            format!("{:.2}", group.energy_wh_m2 / 1000.0),
            format!("{:.1}", group.daily_travel),
        ])
    };
    let groups = window.types.iter().chain((window.types.len() > 1).then_some(&window.all));
    json!({
        "title": format!("{}, task {}; lower is better, 1 is the baseline", window.period, window.task),
        "header": ["building type", "episodes", "resolved score, interquartile mean", "score, interquartile mean",
                   "score, median", "score, mean", "score, min", "score, max", "beats baseline (%)",
                   "RMS deviation (K)", "energy / baseline", "task's resource / baseline", "HVAC energy (kWh/m²)", "actuator travel (strokes/day)"],
        "rows": groups.map(row).collect::<Vec<_>>(),
    })
}

fn footer(summary: &Summary) -> String {
    format!(
        "Score: the return divided by that of the reactive controllers (the baseline) for the same building, task and days, as \
         in the paper; lower is better. Resolved score: the same after adding {RESOLUTION} K of RMS deviation, the accuracy of \
         an air temperature sensor, to both. In brackets: 95 % bootstrap confidence intervals over episodes, stratified by building type. {}.",
        summary.versions
    )
}
