//! Comfort and energy by energy weight.

use b2b_env::{Resource, Task};
use b2b_evaluate::EpisodeResult;
use b2b_evaluate::report::{Chart, StepDeviations, color, step_deviations};
use serde_json::{Value, json};

use super::content::{Content, SCORES};
use crate::definition::{Experiment, REACTIVE};
use crate::results::Results;

/// Sizes of points at the slider's weight, and of all others, px.
const MARKED: u32 = 16;
const UNMARKED: u32 = 7;
/// RMS deviation beyond which drawing a controller would shrink all others to a point, K.
const FAR: f64 = 1.0;

/// Means over buildings under one task.
struct Point {
    weight: f64,
    deviation: f64,
    /// kWh/m².
    energy: f64,
    relative_energy: f64,
}

/// The points of a controller, by weight.
struct Curve {
    name: String,
    color: &'static str,
    points: Vec<Point>,
}

pub(super) fn content(experiment: &Experiment, results: &Results) -> Content {
    let (mut rows, mut charts) = (Vec::new(), Vec::new());
    let controllers = controllers(experiment, results);
    let mut all_setpoints: Vec<&str> = Vec::new();
    for setpoints in experiment.tasks.iter().map(|task| setpoints(task)) {
        if !all_setpoints.contains(&setpoints) {
            all_setpoints.push(setpoints);
        }
    }
    for building_type in &experiment.types {
        for setpoints in &all_setpoints {
            let curve = |(number, name): (usize, &'_ String)| Curve {
                name: name.clone(),
                color: color(number),
                points: points(experiment, results, name, building_type.name(), setpoints),
            };
            let curves: Vec<Curve> = controllers.iter().enumerate().map(curve).collect();
            for weight in weights(&curves) {
                let cells = curves.iter().map(|curve| cell(&curve.points, weight));
                let place = [building_type.to_string(), (*setpoints).to_owned(), weight.to_string()];
                rows.push(place.into_iter().chain(cells).collect::<Vec<_>>());
            }
            charts.push(front(format!("{building_type}: {setpoints} targets"), curves));
            charts.extend(distributions(experiment, results, building_type.name(), setpoints));
        }
    }
    let place = ["type", "targets", "weight of energy"];
    let table = json!({
        "name": "Comfort and energy",
        "title": "RMS deviation (K) · HVAC energy (kWh/m²) · energy / baseline; means over buildings and seeds",
        "header": place.into_iter().map(str::to_owned).chain(controllers.clone()).collect::<Vec<_>>(),
        "rows": rows,
    });
    Content { tables: vec![table], charts, notes: SCORES.to_owned(), ..Content::default() }
}

/// Returns the weights of curves in increasing order.
fn weights(curves: &[Curve]) -> Vec<f64> {
    let mut weights: Vec<f64> =
        curves.iter().flat_map(|curve| &curve.points).map(|point| point.weight).collect();
    weights.sort_by(f64::total_cmp);
    weights.dedup();
    weights
}

/// Returns the table cell for the point at a weight.
fn cell(points: &[Point], weight: f64) -> String {
    points.iter().find(|point| point.weight == weight).map_or_else(String::new, |point| {
        let Point { deviation, energy, relative_energy, .. } = point;
        // Spaces that do not break.
        format!("{deviation:.2}\u{a0}·\u{a0}{energy:.2}\u{a0}·\u{a0}{relative_energy:.2}")
    })
}

/// Draws comfort against energy, with a slider that marks the points of a weight. Controllers far from all targets are
/// left out.
fn front(title: String, curves: Vec<Curve>) -> Chart {
    let drawn = curves.into_iter().filter(|curve| !curve.points.is_empty());
    let (far, curves): (Vec<_>, Vec<_>) =
        drawn.partition(|curve| curve.points.iter().all(|point| point.deviation > FAR));
    let weights = weights(&curves);
    let step = |weight: &f64| {
        json!({"label": weight.to_string(), "method": "update",
               "args": [{"marker.size": sizes(&curves, *weight)}, {"annotations": caption(&curves, *weight)}]})
    };
    let steps: Vec<Value> = weights.iter().map(step).collect();
    let first = weights.first().copied().unwrap_or_default();
    let data: Vec<Value> =
        curves.iter().zip(sizes(&curves, first)).map(|(curve, sizes)| trace(curve, &sizes)).collect();
    let mut note = "means over buildings; the number is the weight of energy. The reactive controllers have one set of parameters \
                    for weight 0 and one for all others"
        .to_owned();
    if !far.is_empty() {
        let names: Vec<&str> = far.iter().map(|curve| &curve.name[..]).collect();
        note += &format!(". Not drawn, because it is more than {FAR} K off target: {}", names.join(", "));
    }
    Chart {
        title,
        note,
        height: 430,
        wide: false,
        data: data.into(),
        layout: json!({
            "xaxis": {"title": {"text": "HVAC energy (kWh/m²)"}, "zeroline": false},
            "yaxis": {"title": {"text": "RMS deviation (K)"}, "rangemode": "tozero", "zeroline": false},
            "annotations": caption(&curves, first),
            "sliders": [{"steps": steps, "active": 0, "pad": {"t": 50}, "currentvalue": {"prefix": "weight of energy: "}}],
        }),
    }
}

/// Returns the sizes of the points of each curve when a weight is marked.
fn sizes(curves: &[Curve], weight: f64) -> Vec<Vec<u32>> {
    let size = |point: &Point| if point.weight == weight { MARKED } else { UNMARKED };
    curves.iter().map(|curve| curve.points.iter().map(size).collect()).collect()
}

/// Returns the annotation with the points of a weight.
fn caption(curves: &[Curve], weight: f64) -> Value {
    let line = |Curve { name, points, .. }: &Curve| {
        let point = points.iter().find(|point| point.weight == weight)?;
        Some(format!("{name}: {:.2} kWh/m², {:.2} K", point.energy, point.deviation))
    };
    let text = curves.iter().filter_map(line).collect::<Vec<_>>().join("<br>");
    json!([{"text": text, "xref": "paper", "yref": "paper", "x": 1, "y": 0.02, "xanchor": "right", "yanchor": "bottom",
            "align": "right", "showarrow": false}])
}

fn trace(Curve { name, color, points }: &Curve, sizes: &[u32]) -> Value {
    json!({
        "type": "scatter", "mode": "lines+markers+text", "name": name, "cliponaxis": false,
        "x": points.iter().map(|point| point.energy).collect::<Vec<_>>(),
        "y": points.iter().map(|point| point.deviation).collect::<Vec<_>>(),
        "text": points.iter().map(|point| point.weight.to_string()).collect::<Vec<_>>(),
        "textposition": "top center", "line": {"color": color, "width": 1.2}, "marker": {"size": sizes},
        "hovertemplate": "weight %{text}: %{x:.2f} kWh/m², %{y:.2f} K<extra></extra>",
    })
}

/// Draws the deviations from target of all steps by weight, like the paper's figure of temperatures; `None` without
/// kept episodes.
fn distributions(
    experiment: &Experiment,
    results: &Results,
    building_type: &str,
    wanted: &str,
) -> Option<Chart> {
    let mut all = Vec::new();
    for task in experiment.tasks.iter().filter(|task| setpoints(task) == wanted) {
        for (number, name) in controllers(experiment, results).iter().enumerate() {
            let is_own =
                |row: &EpisodeResult| row.info.building_type == building_type && row.info.task == *task;
            let Some(weight) = weight(task) else { continue };
            let mut own = StepDeviations::empty(format!("w_E = {weight}"), name.clone(), number);
            results.deviations(name, is_own).for_each(|episode| own.add(episode));
            all.push(own);
        }
    }
    all.retain(|each| !each.is_empty());
    let title = format!("{building_type}: deviation from {wanted} targets");
    (!all.is_empty()).then(|| step_deviations(title, &all))
}

/// Returns the names of the policies, with the reactive controllers first if their episodes are kept.
fn controllers(experiment: &Experiment, results: &Results) -> Vec<String> {
    let reactive = experiment.reactive.then(|| REACTIVE.to_owned());
    let policies = experiment.policies(&results.budget).into_iter().map(|policy| policy.name);
    reactive.into_iter().chain(policies).collect()
}

/// Returns the weight of energy in a task; `None` if it penalizes another resource.
fn weight(task: &str) -> Option<f64> {
    let task: Task = task.parse().ok()?;
    (task.resource == Resource::ENERGY).then_some(task.energy_weight)
}

fn setpoints(task: &str) -> &str {
    task.split('+').next().unwrap_or(task)
}

/// Returns the means of a controller, by weight.
fn points(
    experiment: &Experiment,
    results: &Results,
    name: &str,
    building_type: &str,
    wanted: &str,
) -> Vec<Point> {
    let tasks = experiment.tasks.iter().filter(|task| setpoints(task) == wanted);
    let point = |task: &String| {
        let own = results
            .of(name)
            .filter(|(_, row)| row.info.building_type == building_type && row.info.task == *task);
        let values: Vec<[f64; 3]> = own
            .filter_map(|(_, row)| {
                let scored = row.scored()?;
                let energy = scored.metrics.energy() / 1000.0;
                Some([scored.metrics.rms_deviation, energy, scored.relative_energy()?])
            })
            .collect();
        let mean = |of: usize| values.iter().map(|value| value[of]).sum::<f64>() / values.len() as f64;
        let weight = weight(task)?;
        (!values.is_empty()).then(|| Point {
            weight,
            deviation: mean(0),
            energy: mean(1),
            relative_energy: mean(2),
        })
    };
    tasks.filter_map(point).collect()
}
