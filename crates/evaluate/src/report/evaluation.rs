//! `report.html` of an evaluation.

use std::io::Write;

use b2b_env::Term;
use serde_json::{Value, json};

use super::deviation_chart::StepDeviations;
use super::evaluation_charts;
use super::hourly_chart;
use crate::evaluation::{EpisodeResult, Finished, RESOURCE, resource_heading};
use crate::results::Results;
use crate::scores::{DISCOMFORT_COST, FREE_DISCOMFORT, RESOLUTION};
use crate::statistics::{Aggregate, ratio_text, score_text};
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
        worst(results)
            .into_iter()
            .filter_map(|(number, row)| hourly_chart::worst(&row.info, row.score(), &read(number)?.hours)),
    );
    let data = json!({
        "title": format!("{} on {} episodes", summary.policy, summary.episodes),
        "tiles": tiles(summary),
        "tables": [table(&summary.windows)],
        "lost": summary.lost.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "drawings": charts,
        "footer": footer(summary),
    });
    b2b_page::write_page(file, &data)
}

/// Returns the episodes with the highest scores; without scores, the largest deviations.
fn worst(results: &Results) -> Vec<(usize, &EpisodeResult)> {
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

/// Returns pairs of a label and a value; none for several tasks or run periods, which are rows of the table.
fn tiles(summary: &Summary) -> Value {
    let [Window { all, task, .. }] = &summary.windows[..] else { return json!([]) };
    if let Some(comfort) = &all.comfort {
        return operation_tiles(all, comfort, task);
    }
    let mut tiles = Vec::new();
    if let Some(scores) = &all.resolved_scores {
        tiles.push(json!(["resolved score, interquartile mean", scores.interquartile_mean.to_string()]));
    }
    if let Some(scores) = &all.scores {
        tiles.push(json!(["score, interquartile mean", scores.interquartile_mean.to_string()]));
        tiles.push(json!(["below 1 (%)", scores.beats_baseline_text()]));
    }
    tiles.push(json!(["RMS deviation, mean", format!("{:.2} K", all.rms_deviation_k)]));
    tiles.push(json!(["HVAC energy, mean", format!("{:.1} kWh/m²", all.energy_wh_m2 / 1000.0)]));
    if let Some(ratio) = all.relative_energy {
        tiles.push(json!([ENERGY, format!("{ratio:.2}")]));
    }
    tiles.into()
}

/// Returns the tiles of an operation task: its resource, cost, energy, discomfort and peak.
fn operation_tiles(all: &Group, comfort: &OperationComfort, task: &str) -> Value {
    let mut tiles = Vec::new();
    if let Some(scores) = &all.scores {
        tiles.push(json!(["score at comfort, interquartile mean", scores.interquartile_mean.to_string()]));
    }
    let ratios =
        [(resource_heading([task]), all.relative_resource), (ENERGY.to_owned(), all.relative_energy)];
    for (label, ratio) in ratios {
        tiles.extend(ratio.map(|ratio| json!([label, format!("{ratio:.2}")])));
    }
    tiles.push(json!(["cost per m², mean", format!("{:.3}", comfort.cost_tot)]));
    tiles.push(json!(["HVAC energy, mean", format!("{:.2} kWh/m²", all.energy_wh_m2 / 1000.0)]));
    tiles.push(json!(["discomfort per zone, mean", format!("{:.1} K·h", comfort.discomfort_k_h)]));
    let peak = format!("{:.1} W/m²", 1000.0 * comfort.pele_tot);
    tiles.push(json!(["peak electric demand, mean", peak]));
    tiles.into()
}

/// The heading of energy relative to the baseline.
const ENERGY: &str = "energy / baseline";

/// The columns of a group of episodes.
const COLUMNS: [&str; 20] = [
    "building type",
    "buildings",
    "resolved score, interquartile mean",
    "score, interquartile mean",
    "score, median",
    "score, mean",
    "score, min",
    "score, max",
    "below 1 (%)",
    "RMS deviation (K)",
    "occupied hours too cold (%)",
    "occupied hours too warm (%)",
    ENERGY,
    RESOURCE,
    "HVAC energy (kWh/m²)",
    "heating (kWh/m²)",
    "cooling (kWh/m²)",
    "fans (kWh/m²)",
    "pumps and others (kWh/m²)",
    "actuator travel (strokes/day)",
];

/// The columns of a group of episodes of operation: score at comfort first.
const OPERATION_COLUMNS: [&str; 17] = [
    "building type",
    "buildings",
    "score at comfort, interquartile mean",
    "score, median",
    "below 1 (%)",
    "cost (per m²)",
    RESOURCE,
    ENERGY,
    "discomfort (K·h per zone)",
    "baseline's discomfort",
    "peak demand (W/m²)",
    "episodes beyond the free discomfort",
    "HVAC energy (kWh/m²)",
    "heating (kWh/m²)",
    "cooling (kWh/m²)",
    "fans (kWh/m²)",
    "actuator travel (strokes/day)",
];

/// Returns one table, with a row for each task, run period and building type.
fn table(windows: &[Window]) -> Value {
    const LOWER: &str = "lower is better, 1 is the baseline";
    let several = windows.len() > 1;
    let title = match windows {
        [Window { task, period, .. }] => format!("{period}, task {task}; {LOWER}"),
        _ => LOWER.to_owned(),
    };
    let operation = windows.iter().all(|window| window.all.comfort.is_some());
    let resource = resource_heading(windows.iter().map(|window| &window.task[..]));
    let named =
        |heading: &&'static str| if *heading == RESOURCE { resource.clone() } else { (*heading).to_owned() };
    let columns: Vec<String> = match operation {
        true => OPERATION_COLUMNS.iter().map(named).collect(),
        false => COLUMNS.map(str::to_owned).into(),
    };
    let cells = |group| if operation { operation_cells(group).to_vec() } else { cells(group).to_vec() };
    let which = if several { &["task", "run period"][..] } else { &[] };
    let rows = windows.iter().flat_map(|window| {
        let groups = window.types.iter().chain((window.types.len() > 1).then_some(&window.all));
        let which = if several { vec![window.task.clone(), window.period.clone()] } else { Vec::new() };
        groups.map(move |group| which.iter().cloned().chain(cells(group)).collect::<Vec<_>>())
    });
    json!({
        "title": title,
        "header": which.iter().map(|name| (*name).to_owned()).chain(columns).collect::<Vec<_>>(),
        "rows": rows.collect::<Vec<_>>(),
    })
}

/// Returns the cells of a group of episodes in the order of [`OPERATION_COLUMNS`].
fn operation_cells(group: &Group) -> [String; OPERATION_COLUMNS.len()] {
    let of = |text: fn(&Aggregate) -> String| group.scores.as_ref().map_or("–".to_owned(), text);
    let number = |number: Option<f64>| number.map_or("–".to_owned(), |number| format!("{number:.2}"));
    let [heating, cooling, fans] = end_uses(group);
    let comfort = group.comfort.as_ref();
    [
        group.name.clone(),
        group.buildings().to_string(),
        of(|scores| scores.interquartile_mean.to_string()),
        of(|scores| scores.median.to_string()),
        of(Aggregate::beats_baseline_text),
        comfort.map_or("–".to_owned(), |comfort| format!("{:.3}", comfort.cost_tot)),
        number(group.relative_resource),
        number(group.relative_energy),
        number(comfort.map(|comfort| comfort.discomfort_k_h)),
        number(comfort.and_then(|comfort| comfort.baseline_discomfort_k_h)),
        comfort.map_or("–".to_owned(), |comfort| format!("{:.1}", 1000.0 * comfort.pele_tot)),
        comfort.map_or_else(String::new, OperationComfort::mark),
        format!("{:.2}", group.energy_wh_m2 / 1000.0),
        number(heating),
        number(cooling),
        number(fans),
        format!("{:.1}", group.daily_travel),
    ]
}

/// Returns heating, cooling and fans, kWh/m².
fn end_uses(group: &Group) -> [Option<f64>; 3] {
    [Term::Heating, Term::Cooling, Term::Fans]
        .map(|term| group.end_uses.get(term.entry().column.as_ref()?.name).map(|energy| energy / 1000.0))
}

/// Returns the cells of a group of episodes in the order of [`COLUMNS`].
fn cells(group: &Group) -> [String; COLUMNS.len()] {
    let cell = |scores: &Option<Aggregate>, text: fn(&Aggregate) -> String| {
        scores.as_ref().map_or("–".to_owned(), text)
    };
    let of = |text: fn(&Aggregate) -> String| cell(&group.scores, text);
    let percent =
        |share: Option<f64>| share.map_or("–".to_owned(), |share| format!("{:.1}", 100.0 * share));
    let [heating, cooling, fans] = end_uses(group);
    let known = group.end_uses.values().map(|energy| energy / 1000.0).sum::<f64>();
    let others =
        heating.zip(cooling).zip(fans).map(|((heating, cooling), fans)| known - heating - cooling - fans);
    [
        group.name.clone(),
        group.buildings().to_string(),
        cell(&group.resolved_scores, |scores| scores.interquartile_mean.to_string()),
        of(|scores| scores.interquartile_mean.to_string()),
        of(|scores| scores.median.to_string()),
        of(|scores| scores.mean.to_string()),
        of(|scores| score_text(scores.min)),
        of(|scores| score_text(scores.max)),
        of(Aggregate::beats_baseline_text),
        format!("{:.2}", group.rms_deviation_k),
        percent(group.occupied_too_cold_share),
        percent(group.occupied_too_warm_share),
        ratio_text(group.relative_energy),
        ratio_text(group.relative_resource),
        format!("{:.2}", group.energy_wh_m2 / 1000.0),
        ratio_text(heating),
        ratio_text(cooling),
        ratio_text(fans),
        ratio_text(others.map(|energy| energy.max(0.0))),
        format!("{:.1}", group.daily_travel),
    ]
}

fn footer(summary: &Summary) -> String {
    format!(
        "Score: the return divided by the reactive controllers' return (the baseline) for the same building, task and days, as \
         in the paper; lower is better. Resolved score: the same after adding {RESOLUTION} K of RMS deviation, the accuracy of \
         an air temperature sensor, to both. Score at comfort, in tasks of operation: cost, or the \
         task's other resource, divided by the guideline controller's (the baseline), plus {DISCOMFORT_COST} days of that for every K·h per zone of discomfort beyond its own \
         and {FREE_DISCOMFORT} K·h per day. In brackets: 95 % bootstrap confidence intervals over buildings within each type, and over seeds. {}.",
        summary.versions
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_tasks_and_run_periods_are_rows_of_one_table_and_no_tiles() {
        let group = |name: &str| Group {
            name: name.into(),
            scores: None,
            resolved_scores: None,
            rms_deviation_k: 0.5,
            occupied_too_cold_share: Some(0.125),
            occupied_too_warm_share: None,
            energy_wh_m2: 1000.0,
            end_uses: [
                ("cooling_wh_m2", 0.0),
                ("fans_wh_m2", 250.0),
                ("heating_wh_m2", 700.0),
                ("pumps_wh_m2", 50.0),
            ]
            .into(),
            relative_energy: None,
            relative_resource: Some(0.5),
            daily_travel: 2.0,
            comfort: None,
        };
        let window = |task: &str, period: &str| Window {
            task: task.into(),
            period: period.into(),
            types: vec![group("offices"), group("houses")],
            all: group("all"),
        };
        let summary = |windows| Summary {
            versions: b2b_control::Versions::current(),
            policy: "p".into(),
            episodes: 4,
            lost: Vec::new(),
            windows,
        };
        let several = summary(vec![window("constant", "winter"), window("occupancy", "summer")]);
        assert_eq!(tiles(&several), json!([]));
        let table_of_several = table(&several.windows);
        let rows = table_of_several["rows"].as_array().unwrap();
        assert_eq!(rows.len(), 6, "three of each");
        assert_eq!(rows[3].as_array().unwrap()[..3], ["occupancy", "summer", "offices"]);
        assert!(rows.iter().all(|row| row.as_array().unwrap().len() == COLUMNS.len() + 2));
        let cell = |name: &str| &rows[3][2 + COLUMNS.iter().position(|column| *column == name).unwrap()];
        assert_eq!(
            (cell("occupied hours too cold (%)"), cell("occupied hours too warm (%)")),
            (&json!("12.5"), &json!("–"))
        );
        assert_eq!(
            (cell("heating (kWh/m²)"), cell("pumps and others (kWh/m²)")),
            (&json!("0.70"), &json!("0.05"))
        );

        let one = summary(vec![window("constant", "winter")]);
        assert_eq!(tiles(&one).as_array().unwrap().len(), 2);
        assert_eq!(table(&one.windows)["header"][0], "building type");
    }
}
