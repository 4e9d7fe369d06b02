//! `report.html` of an evaluation.

use std::io::Write;

use serde_json::{Value, json};

use super::deviation_chart::StepDeviations;
use super::evaluation_charts;
use super::hourly_chart;
use crate::evaluation::{Finished, Row};
use crate::results::Results;
use crate::scores::{DISCOMFORT_COST, FREE_DISCOMFORT, RESOLUTION};
use crate::statistics::{Aggregate, score_text};
use crate::summary::{Group, OperationComfort, Summary, Window, type_label};

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
        "tables": summary.windows.iter().map(table).collect::<Vec<_>>(),
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
    let mut tiles = Vec::new();
    for Window { task, period, all, .. } in &summary.windows {
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

fn table(window: &Window) -> Value {
    if window.all.comfort.is_some() { operation_table(window) } else { tracking_table(window) }
}

/// Returns the table of a task of operation: cost at comfort first.
fn operation_table(window: &Window) -> Value {
    let row = |group: &Group| {
        let of = |text: fn(&Aggregate) -> String| group.scores.as_ref().map_or("–".to_owned(), text);
        let ratio = |ratio: Option<f64>| ratio.map_or("–".to_owned(), |ratio| format!("{ratio:.2}"));
        let comfort = group.comfort.as_ref();
        json!([
            group.name,
            group.episodes().to_string(),
            of(|scores| scores.interquartile_mean.to_string()),
            of(|scores| scores.median.to_string()),
            of(Aggregate::beats_baseline_text),
            ratio(group.relative_resource),
            ratio(group.relative_energy),
            ratio(comfort.map(|comfort| comfort.discomfort_k_h)),
            ratio(comfort.and_then(|comfort| comfort.baseline_discomfort_k_h)),
            comfort.map_or_else(String::new, OperationComfort::mark),
            format!("{:.2}", group.energy_wh_m2 / 1000.0),
            format!("{:.1}", group.daily_travel),
        ])
    };
    let groups = window.types.iter().chain((window.types.len() > 1).then_some(&window.all));
    json!({
        "title": format!("{}, task {}; lower is better, 1 is the baseline", window.period, window.task),
        "header": ["building type", "episodes", "score at comfort, interquartile mean", "score, median", "beats baseline (%)",
                   "cost / baseline", "energy / baseline", "discomfort (K·h per zone)", "baseline's discomfort",
                   "episodes beyond the free discomfort", "HVAC energy (kWh/m²)", "actuator travel (strokes/day)"],
        "rows": groups.map(row).collect::<Vec<_>>(),
    })
}

fn tracking_table(window: &Window) -> Value {
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
         an air temperature sensor, to both. Score at comfort, in tasks of operation: cost divided by that of the guideline \
         controller (the baseline), plus {DISCOMFORT_COST} days of the latter for every K·h per zone of discomfort beyond its own \
         and {FREE_DISCOMFORT} K·h per day. In brackets: 95 % bootstrap confidence intervals over episodes, stratified by building type. {}.",
        summary.versions
    )
}
