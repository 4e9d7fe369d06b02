//! Scores by type, task and period, compared with the paper's table.

use std::collections::BTreeMap;

use b2b_evaluate::report::{Chart, color, horizontal_line, make_logarithmic, range};
use b2b_evaluate::statistics::{aggregate, is_below_baseline};
use b2b_evaluate::{EpisodeResult, Scored};
use serde_json::{Value, json};

use super::content::{Content, SCORES};
use super::group::Group;
use crate::absolute::{
    comfort_share, deviation, energy, median_text, range_text, reactive_deviation, reactive_energy,
};
use crate::definition::{Experiment, Policy};
use crate::paper;
use crate::results::{Ran, Results, samples};

pub(super) fn content(experiment: &Experiment, results: &Results) -> Content {
    let policies = experiment.policies(&results.budget);
    let mut won: Vec<[usize; 2]> = vec![[0, 0]; policies.len()];
    let mut rows = Vec::new();
    for building_type in &experiment.types {
        for task in &experiment.tasks {
            for period in &experiment.periods {
                let place = [building_type.name(), &task[..], &period[..]];
                rows.push(cells(results, &policies, place, &mut won));
            }
        }
    }
    let tile = |(policy, [won, of]): (&Policy<'_>, [usize; 2])| {
        (format!("rows whose median is below 1, {}", policy.name), format!("{won} of {of}"))
    };
    let title = "median, lowest and highest score over the buildings, how many of them are below 1, and medians of RMS \
                 deviation (K) and HVAC energy of the run period (kWh/m²), also of the reactive controllers in the same episodes; \
                 published: in the paper";
    let table = json!({"title": title, "header": header(&policies), "rows": rows});
    Content {
        tiles: policies.iter().zip(won).map(tile).collect(),
        tables: vec![
            by_task(experiment, results, &policies),
            table,
            by_building(experiment, results, &policies),
        ],
        charts: experiment.tasks.iter().map(|task| chart(results, &policies, task)).collect(),
        notes: SCORES.to_owned(),
    }
}

fn header(policies: &[Policy<'_>]) -> Vec<String> {
    let mut header: Vec<String> = [
        "type",
        "task",
        "period",
        "published: median",
        "published: range",
        "published: below 1",
        "reactive: deviation (K)",
        "reactive: energy (kWh/m²)",
    ]
    .map(str::to_owned)
    .into();
    let columns = ["median", "resolved median", "range", "below 1", "deviation (K)", "energy (kWh/m²)"];
    for Policy { name, .. } in policies {
        header.extend(columns.map(|column| format!("{name}: {column}")));
    }
    header
}

/// Returns the cells of a type, task and period, and counts, among policies with scores, the ones whose median beats
/// the baseline.
fn cells(
    results: &Results,
    policies: &[Policy<'_>],
    place: [&str; 3],
    won: &mut [[usize; 2]],
) -> Vec<String> {
    let [building_type, task, period] = place;
    let of = |policy: &Policy<'_>| -> Vec<&EpisodeResult> {
        let is_own = |row: &&EpisodeResult| {
            let info = &row.info;
            info.building_type == building_type && info.task == task && info.period == period
        };
        results.of(&policy.name).map(|(_, row)| row).filter(is_own).collect()
    };
    let mut cells = place.map(str::to_owned).to_vec();
    cells.extend(paper_cells(building_type, task, period));
    // Every policy is compared with the same episodes of the reactive controllers.
    let all = policies.iter().map(of).find(|rows| !rows.is_empty()).unwrap_or_default();
    cells.extend([reactive_deviation, reactive_energy].map(|figure| median_text(&all, figure)));
    for (policy, won) in policies.iter().zip(won) {
        let own = of(policy);
        match Group::of(own.iter().copied()) {
            Some(group) => {
                cells.extend(group.cells());
                *won = [won[0] + usize::from(is_below_baseline(group.median())), won[1] + 1];
            }
            None => cells.extend(["–"; 4].map(str::to_owned)),
        }
        cells.extend([deviation, energy].map(|figure| median_text(&own, figure)));
    }
    cells
}

/// Returns a table of the interquartile means by task and agent, each building and period counted once.
fn by_task(experiment: &Experiment, results: &Results, policies: &[Policy<'_>]) -> Value {
    let mut rows = Vec::new();
    for task in &experiment.tasks {
        for policy in policies {
            let own: Vec<Ran<'_>> =
                results.of(&policy.name).filter(|(_, row)| row.info.task == *task).collect();
            let aggregated = |score: fn(&Scored) -> Option<f64>| aggregate(&samples(&own, score));
            let (Some(scores), Some(resolved)) =
                (aggregated(|scored| scored.score), aggregated(|scored| scored.resolved_score))
            else {
                continue;
            };
            let own: Vec<&EpisodeResult> = own.into_iter().map(|(_, row)| row).collect();
            let [share, deviation, energy, relative] =
                [comfort_share, deviation, energy, Scored::relative_energy]
                    .map(|figure| median_text(&own, figure));
            rows.push(vec![
                task.clone(),
                policy.name.clone(),
                own.len().to_string(),
                scores.interquartile_mean.to_string(),
                resolved.interquartile_mean.to_string(),
                scores.beats_baseline_text(),
                share,
                deviation,
                energy,
                relative,
            ]);
        }
    }
    json!({
        "title": "interquartile means by task with 95 % intervals (a bootstrap over buildings within each type, and seeds), and medians",
        "header": ["task", "agent", "episodes", "score", "resolved score", "below 1 (%)",
                   "comfort in baseline's penalty", "RMS deviation (K)", "HVAC energy (kWh/m²)", "energy / baseline"],
        "rows": rows,
    })
}

/// Returns a table of the RMS deviations by building, task and period.
fn by_building(experiment: &Experiment, results: &Results, policies: &[Policy<'_>]) -> Value {
    let mut places: BTreeMap<(usize, &str, &str), Vec<Vec<&EpisodeResult>>> = BTreeMap::new();
    for (number, policy) in policies.iter().enumerate() {
        for (_, row) in results.of(&policy.name) {
            let info = &row.info;
            let Some(task) = experiment.tasks.iter().position(|task| *task == info.task) else { continue };
            let place = (task, &info.building[..], &info.period[..]);
            places.entry(place).or_insert_with(|| vec![Vec::new(); policies.len()])[number].push(row);
        }
    }
    let rows = places.into_iter().map(|((task, building, period), by_policy)| {
        let all: Vec<&EpisodeResult> = by_policy.iter().flatten().copied().collect();
        let mut cells = [building, &experiment.tasks[task], period].map(str::to_owned).to_vec();
        cells.push(median_text(&all, reactive_deviation));
        cells.extend(by_policy.iter().map(|own| range_text(own, deviation)));
        cells
    });
    let mut header = ["building", "task", "period", "reactive"].map(str::to_owned).to_vec();
    header.extend(policies.iter().map(|policy| policy.name.to_string()));
    json!({
        "title": "RMS deviation (K) by building: the median over seeds (lowest to highest)",
        "header": header,
        "rows": rows.collect::<Vec<_>>(),
    })
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
fn chart(results: &Results, policies: &[Policy<'_>], task: &str) -> Chart {
    let mut data = Vec::new();
    let mut all = vec![1.0];
    for (number, policy) in policies.iter().enumerate() {
        let own = || results.of(&policy.name).map(|(_, row)| row).filter(|row| row.info.task == task);
        let ran: Vec<_> = own().filter_map(|row| Some((&row.info, row.score()?))).collect();
        let scores: Vec<f64> = ran.iter().map(|(_, score)| *score).collect();
        all.extend(&scores);
        let text = ran.iter().map(|(info, _)| format!("{}, {}", info.building, info.period));
        let symbols =
            ran.iter().map(|(info, _)| if info.period == "summer" { "circle-open" } else { "circle" });
        data.push(json!({
            "type": "box", "name": policy.name, "boxpoints": "all", "jitter": 0.5, "pointpos": 0,
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
    let note = "one point per building and period; below the line is better than the reactive controllers"
        .to_owned();
    Chart {
        title: format!("Scores: {task}"),
        note,
        height: 340,
        wide: false,
        data: Value::from(data),
        layout,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::folder::Folder;

    #[test]
    fn every_building_has_the_deviations_of_all_agents_and_seeds() {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../results/residual"));
        let (folder, experiment, budget) = Folder::open(path).unwrap();
        let results = Results::read(&folder, &experiment, &budget).unwrap();
        let table = by_building(&experiment, &results, &experiment.policies(&budget));
        let rows: Vec<Vec<&str>> = table["rows"]
            .as_array()
            .unwrap()
            .iter()
            .map(|row| row.as_array().unwrap().iter().filter_map(Value::as_str).collect())
            .collect();
        assert_eq!(rows.len(), 5 * 12 * 2, "tasks, buildings and periods");
        let [building, task, period, reactive, own] = rows[0][..] else { panic!("{:?}", rows[0]) };
        assert_eq!([task, period], ["constant", "summer"]);
        let mut of_building: Vec<f64> = results
            .of("residual")
            .filter(|(_, row)| {
                [&row.info.building, &row.info.task, &row.info.period] == [building, task, period]
            })
            .filter_map(|(_, row)| deviation(row.scored()?))
            .collect();
        of_building.sort_by(f64::total_cmp);
        let [low, middle, high] = of_building[..] else { panic!("three seeds") };
        assert_eq!(own, format!("{middle:.3} ({low:.3} to {high:.3})"));
        assert!(reactive.parse::<f64>().unwrap() > middle);
    }
}
