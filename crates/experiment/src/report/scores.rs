//! Scores by type, task and period, beside the paper's table.

use std::collections::BTreeMap;

use b2b_evaluate::report::{Chart, color, horizontal_line, make_logarithmic, range};
use b2b_evaluate::statistics::{Cluster, aggregate_clusters, beats_baseline, median};
use b2b_evaluate::{Row, Scored};
use serde_json::{Value, json};

use super::group::Group;
use super::{Content, SCORES};
use crate::definition::Experiment;
use crate::paper;
use crate::results::Results;

pub(super) fn content(experiment: &Experiment, results: &Results) -> Content {
    let (mut rows, mut tiles) = (Vec::new(), Vec::new());
    let mut won: Vec<[usize; 2]> = vec![[0, 0]; experiment.agents.len()];
    for building_type in &experiment.types {
        for task in &experiment.tasks {
            for period in &experiment.periods {
                let mut cells = vec![building_type.to_string(), task.clone(), period.clone()];
                cells.extend(paper_cells(building_type.name(), task, period));
                for (agent, won) in experiment.agents.iter().zip(&mut won) {
                    let own = results.of(&agent.name).map(|(_, row)| row).filter(|row| {
                        let info = &row.info;
                        info.building_type == building_type.name()
                            && info.task == *task
                            && info.period == *period
                    });
                    match Group::of(own) {
                        Some(group) => {
                            cells.extend(group.cells());
                            *won = [won[0] + usize::from(beats_baseline(group.median())), won[1] + 1];
                        }
                        None => cells.extend(["–"; 4].map(str::to_owned)),
                    }
                }
                rows.push(cells);
            }
        }
    }
    for (agent, [won, of]) in experiment.agents.iter().zip(won) {
        tiles.push((
            format!("rows whose median beats the baseline, {}", agent.name),
            format!("{won} of {of}"),
        ));
    }
    let mut header: Vec<String> =
        ["type", "task", "period", "published: median", "published: range", "published: beats"]
            .map(str::to_owned)
            .into();
    for agent in &experiment.agents {
        let name = &agent.name;
        header.extend(
            ["median", "resolved median", "range", "beats"].map(|column| format!("{name}: {column}")),
        );
    }
    let title = "median, lowest and highest score over the buildings, and how many agents beat the reactive controllers; \
                 published: in the paper";
    let tables = vec![by_task(experiment, results), json!({"title": title, "header": header, "rows": rows})];
    let charts = experiment.tasks.iter().map(|task| chart(experiment, results, task)).collect();
    Content { tiles, tables, charts, notes: SCORES.to_owned() }
}

/// Returns a table of the interquartile means by task and agent, each building and period counted once.
fn by_task(experiment: &Experiment, results: &Results) -> Value {
    let mut rows = Vec::new();
    for task in &experiment.tasks {
        for agent in &experiment.agents {
            let own: Vec<&Row> =
                results.of(&agent.name).map(|(_, row)| row).filter(|row| row.info.task == *task).collect();
            let aggregate = |score| aggregate_clusters(&strata(&own, score), 0);
            let (Some(scores), Some(resolved)) = (aggregate(Row::score), aggregate(Row::resolved_score))
            else {
                continue;
            };
            let [share, deviation, energy] =
                [comfort_share, deviation, Scored::relative_energy].map(|value| median_of(&own, value));
            rows.push(vec![
                task.clone(),
                agent.name.clone(),
                own.len().to_string(),
                scores.interquartile_mean.to_string(),
                resolved.interquartile_mean.to_string(),
                scores.beats_baseline_text(),
                share,
                deviation,
                energy,
            ]);
        }
    }
    json!({
        "title": "interquartile means by task with 95 % intervals (a bootstrap over buildings and periods within each type, and seeds), and medians",
        "header": ["task", "agent", "episodes", "score", "resolved score", "beats baseline (%)",
                   "comfort in baseline's penalty", "RMS deviation (K)", "energy / baseline"],
        "rows": rows,
    })
}

/// Returns the scores by type, for each building and period one per seed.
fn strata(rows: &[&Row], score: fn(&Row) -> Option<f64>) -> Vec<Vec<Cluster>> {
    let mut strata: BTreeMap<&str, BTreeMap<(&str, &str), Cluster>> = BTreeMap::new();
    for row in rows {
        let info = &row.info;
        let clusters = strata.entry(&info.building_type).or_default();
        clusters.entry((&info.building, &info.period)).or_default().extend(score(row));
    }
    let scored = |clusters: BTreeMap<_, Cluster>| {
        clusters.into_values().filter(|cluster| !cluster.is_empty()).collect()
    };
    strata.into_values().map(scored).collect()
}

/// Returns the share of comfort in the penalty of the reactive controllers. Without it, an agent gains by energy alone.
fn comfort_share(scored: &Scored) -> Option<f64> {
    let of_energy = match scored.metrics.energy_penalty {
        0.0 => 0.0,
        penalty => scored.baseline_energy? * penalty / scored.metrics.energy(),
    };
    Some(1.0 + of_energy / scored.baseline_return?)
}

fn deviation(scored: &Scored) -> Option<f64> {
    Some(scored.metrics.rms_deviation)
}

fn median_of(rows: &[&Row], value: fn(&Scored) -> Option<f64>) -> String {
    let mut values: Vec<f64> = rows.iter().filter_map(|row| value(row.outcome.as_ref().ok()?)).collect();
    values.sort_by(f64::total_cmp);
    if values.is_empty() { "–".to_owned() } else { format!("{:.2}", median(&values)) }
}

fn paper_cells(building_type: &str, task: &str, period: &str) -> [String; 3] {
    match paper::score(building_type, task, period) {
        Some(row) => [
            format!("{:.2}", row.median),
            format!("{:.2} to {:.2}", row.min, row.max),
            format!("{}/8", row.beats),
        ],
        None => ["–"; 3].map(str::to_owned),
    }
}

/// Draws the scores of a task, a point per episode.
fn chart(experiment: &Experiment, results: &Results, task: &str) -> Chart {
    let mut data = Vec::new();
    let mut all = vec![1.0];
    for (number, agent) in experiment.agents.iter().enumerate() {
        let own = || results.of(&agent.name).map(|(_, row)| row).filter(|row| row.info.task == task);
        let ran: Vec<_> = own().filter_map(|row| Some((&row.info, row.score()?))).collect();
        let scores: Vec<f64> = ran.iter().map(|(_, score)| *score).collect();
        all.extend(&scores);
        let text = ran.iter().map(|(info, _)| format!("{}, {}", info.building, info.period));
        let symbols =
            ran.iter().map(|(info, _)| if info.period == "summer" { "circle-open" } else { "circle" });
        data.push(json!({
            "type": "box", "name": agent.name, "boxpoints": "all", "jitter": 0.5, "pointpos": 0,
            "fillcolor": "rgba(0,0,0,0)", "line": {"color": "rgba(0,0,0,0)"},
            "x": ran.iter().map(|(info, _)| info.building_type.as_str()).collect::<Vec<_>>(), "y": scores,
            "text": text.collect::<Vec<_>>(), "hovertemplate": "%{text}: %{y:.3f}<extra></extra>",
            "marker": {"color": color(number), "size": 7, "opacity": 0.8, "symbol": symbols.collect::<Vec<_>>()},
        }));
    }
    let mut axis = json!({"title": {"text": "score"}, "zeroline": false});
    make_logarithmic(&mut axis, range(&all));
    let layout = json!({"boxmode": "group", "xaxis": {"type": "category"}, "yaxis": axis,
                        "shapes": [horizontal_line(1.0)]});
    let note = "one point per building and period; below the line beats the reactive controllers".to_owned();
    Chart {
        title: format!("Scores: {task}"),
        note,
        height: 340,
        wide: false,
        data: Value::from(data),
        layout,
    }
}
