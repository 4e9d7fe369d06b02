//! The leaderboard: results beside each other, problem by problem, in one file that needs no network.

use std::io::Write;

use serde_json::{Value, json};

use super::drawing::{PALETTE, asked, line_at};
use super::{interval, write_page};
use crate::entry::{Measures, RunResult};
use crate::evaluation::Row;
use crate::problem::Stage;

/// A result with its rows by stage.
type Entry = (RunResult, Vec<(Stage, Vec<Row>)>);

/// Scores are drawn by their logarithm where they differ by more than this factor.
const WIDE: f64 = 20.0;

/// Writes the page.
///
/// # Errors
/// What the file says.
pub fn write(file: &mut impl Write, results: &[Entry]) -> std::io::Result<()> {
    let mut boards: Vec<Vec<&Entry>> = Vec::new();
    for entry in results {
        let hash = &entry.0.problem_hash;
        match boards.iter_mut().find(|board| board[0].0.problem_hash == *hash) {
            Some(board) => board.push(entry),
            None => boards.push(vec![entry]),
        }
    }
    let key = |board: &[&Entry]| {
        let result = &board[0].0;
        (
            result.problem_changes.as_ref().is_none_or(|changes| !changes.is_empty()),
            result.problem.name.clone(),
        )
    };
    boards.sort_by_cached_key(|board| key(board));
    for board in &mut boards {
        let score = |entry: &Entry| entry.0.measures.test.interquartile_mean.value;
        board.sort_by(|a, b| score(a).total_cmp(&score(b)).then_with(|| a.0.name.cmp(&b.0.name)));
    }
    let data = json!({
        "title": "Leaderboard",
        "tiles": [["problems", boards.len().to_string()], ["results", results.len().to_string()]],
        "tables": [], "lost": [], "drawings": [],
        "sections": boards.iter().map(|board| section(board)).collect::<Vec<_>>(),
        "footer": footer(results),
    });
    write_page(file, &data)
}

fn section(board: &[&Entry]) -> Value {
    let result = &board[0].0;
    let problem = &result.problem;
    let changed = match result.problem_changes.as_deref() {
        Some([]) => String::new(),
        Some(changes) => format!(" · changed: {}", changes.join(", ")),
        None => " · a problem of somebody's own".to_owned(),
    };
    let windows: Vec<_> = problem.protocol.windows.iter().map(ToString::to_string).collect();
    let mut tables = vec![scores(board)];
    tables.extend(strata(board));
    tables.extend(adaptation(board));
    let mut drawings = vec![returns(board), profiles(board), by_type(board), deviations(board)];
    drawings.extend(curves(board));
    json!({
        "title": format!("{}, version {}{changed}", problem.name, problem.version),
        "note": format!("{}. {} Tested on {}; {}; attributes {}; {}.", capital(&problem.family.to_string()), problem.question,
            problem.test.buildings, windows.join(", "), problem.protocol.attributes, &result.problem_hash[..12]),
        "tables": tables, "drawings": drawings,
    })
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().collect::<String>() + letters.as_str())
}

fn table(title: &str, header: &[&str], rows: Vec<Value>) -> Value {
    json!({"title": title, "header": header, "rows": rows})
}

fn scores(board: &[&Entry]) -> Value {
    let row = |(rank, (result, _)): (usize, &&Entry)| {
        let Measures { test, generalisation_gap, .. } = &result.measures;
        let steps = result.training_steps.map_or("–".to_owned(), |steps| steps.to_string());
        json!([
            format!("{}. {}", rank + 1, result.name),
            interval(test.interquartile_mean),
            interval(test.median),
            interval(test.mean),
            format!("{:.0} %", 100.0 * test.beats_baseline.value),
            generalisation_gap.map_or("–".to_owned(), interval),
            test.episodes.to_string(),
            steps,
            result.description.clone().unwrap_or_default(),
        ])
    };
    let header = [
        "entry",
        "interquartile mean",
        "median",
        "mean",
        "beat 1",
        "generalisation gap",
        "scores",
        "trained for, steps",
        "",
    ];
    table(
        "lower is better, 1 is the reactive controllers",
        &header,
        board.iter().enumerate().map(row).collect(),
    )
}

fn strata(board: &[&Entry]) -> Option<Value> {
    let rows: Vec<_> = board
        .iter()
        .flat_map(|(result, _)| result.measures.strata.iter().map(move |stratum| (result, stratum)))
        .map(|(result, stratum)| {
            json!([
                result.name,
                stratum.building_type,
                stratum.task,
                stratum.period,
                interval(stratum.scores.interquartile_mean),
                format!("{:.0} %", 100.0 * stratum.scores.beats_baseline.value),
            ])
        })
        .collect();
    let header = ["entry", "type", "task", "days", "interquartile mean", "beat 1"];
    (!rows.is_empty()).then(|| table("by type and task", &header, rows))
}

fn adaptation(board: &[&Entry]) -> Option<Value> {
    let mut rows = Vec::new();
    for (result, _) in board {
        let Some(adaptation) = &result.measures.adaptation else { continue };
        let steps = adaptation.median_steps_to_baseline;
        let last = adaptation.curve.last();
        rows.push(json!([
            result.name,
            interval(adaptation.jump_start),
            steps.map_or("never".to_owned(), |steps| format!("{steps:.0}")),
            format!("{:.0} %", 100.0 * adaptation.reach_baseline),
            last.map_or(String::new(), |point| point.steps.to_string()),
            last.map_or(String::new(), |point| interval(point.scores.interquartile_mean)),
        ]));
    }
    let header = [
        "entry",
        "jump-start",
        "steps to baseline, median",
        "reach it",
        "last test after",
        "interquartile mean then",
    ];
    (!rows.is_empty()).then(|| table("adaptation", &header, rows))
}

fn drawing(title: &str, note: &str, data: Vec<Value>, mut layout: Value) -> Value {
    layout["height"] = 340.into();
    json!({"title": title, "note": note, "data": data, "layout": layout})
}

fn color(number: usize) -> &'static str {
    PALETTE[number % PALETTE.len()]
}

/// As in the paper's figure of returns: a bar for each entry, and the baseline's dashed line at 1.
fn returns(board: &[&Entry]) -> Value {
    let bar = |(number, (result, _)): (usize, &&Entry)| {
        let median = result.measures.test.median;
        json!({
            "type": "bar", "x": [result.name], "y": [median.value], "width": 0.55, "marker": {"color": color(number)},
            "error_y": {"type": "data", "symmetric": false, "array": [median.high - median.value],
                        "arrayminus": [median.value - median.low], "thickness": 1.4, "color": "#6b7280"},
            "hovertemplate": "%{x}: %{y:.3f}<extra></extra>", "showlegend": false,
        })
    };
    let values: Vec<f64> = board.iter().map(|(result, _)| result.measures.test.median.value).collect();
    let mut layout = json!({
        "xaxis": {"type": "category"}, "yaxis": {"title": {"text": "normalised return"}, "zeroline": false},
        "shapes": [line_at(1.0)],
    });
    scale(&mut layout, &values, &["yaxis"], 1.0);
    drawing(
        "Normalised return, median",
        "dashed: the reactive controllers; bars of 95 %",
        board.iter().enumerate().map(bar).collect(),
        layout,
    )
}

/// A logarithm where values are far from each other, and everything from 0 where they are not.
fn scale(layout: &mut Value, values: &[f64], axes: &[&str], always: f64) {
    let low = values.iter().copied().fold(always, f64::min);
    let high = values.iter().copied().fold(always, f64::max);
    for axis in axes {
        if low > 0.0 && high / low > WIDE {
            layout[axis]["type"] = "log".into();
            layout[axis]["dtick"] = 1.into();
        } else {
            layout[axis]["rangemode"] = "tozero".into();
        }
    }
}

/// Share of buildings at or below a score, with its interval.
fn profiles(board: &[&Entry]) -> Value {
    let mut data = Vec::new();
    for (number, (result, _)) in board.iter().enumerate() {
        let profile = &result.measures.profile;
        let scores: Vec<f64> = profile.iter().map(|point| point.score).collect();
        let of = |value: fn(&crate::statistics::Interval) -> f64| {
            profile.iter().map(|point| value(&point.share)).collect::<Vec<f64>>()
        };
        let there_and_back: Vec<f64> = scores.iter().chain(scores.iter().rev()).copied().collect();
        let around: Vec<f64> =
            of(|share| share.high).into_iter().chain(of(|share| share.low).into_iter().rev()).collect();
        data.push(json!({
            "type": "scatter", "x": there_and_back, "y": around, "mode": "lines", "fill": "toself",
            "fillcolor": format!("{}2b", color(number)), "line": {"width": 0}, "hoverinfo": "skip", "showlegend": false,
        }));
        data.push(json!({
            "type": "scatter", "x": scores, "y": of(|share| share.value), "mode": "lines", "name": result.name,
            "line": {"color": color(number), "width": 2, "shape": "hv"},
            "hovertemplate": "%{y:.0%} score %{x:.2f} or less<extra></extra>",
        }));
    }
    let layout = json!({
        "xaxis": {"title": {"text": "score τ"}, "zeroline": false, "range": [0, 3]},
        "yaxis": {"title": {"text": "share of scores ≤ τ"}, "range": [-0.02, 1.02], "tickformat": ".0%", "zeroline": false},
        "shapes": [{"type": "line", "yref": "paper", "y0": 0, "y1": 1, "x0": 1, "x1": 1,
                    "line": {"dash": "dash", "width": 1.3, "color": "#b45309"}}],
    });
    drawing("Performance profile", "further up and to the left is better; bands of 95 %", data, layout)
}

fn test_rows(stages: &[(Stage, Vec<Row>)]) -> impl Iterator<Item = &Row> {
    stages.iter().filter(|(stage, _)| *stage == Stage::Test).flat_map(|(_, rows)| rows)
}

/// What is read when a point is pointed at.
fn label(row: &Row) -> String {
    let (score, rms) = (row.score.unwrap_or(f64::NAN), row.record.rms_deviation);
    format!("{}<br>score {score:.3}, RMS {rms:.2} K", asked(&row.record))
}

/// Scores as points around a box, for each type.
fn by_type(board: &[&Entry]) -> Value {
    let mut values = Vec::new();
    let mut data = Vec::new();
    for (number, (result, stages)) in board.iter().enumerate() {
        let rows: Vec<&Row> = test_rows(stages).collect();
        let scores: Vec<f64> = rows.iter().filter_map(|row| row.score).collect();
        data.push(json!({
            "type": "box", "x": rows.iter().map(|row| &row.record.building_type).collect::<Vec<_>>(), "y": scores,
            "name": result.name, "boxpoints": "all", "jitter": 0.5, "pointpos": 0,
            "marker": {"size": 4.5, "opacity": 0.65, "color": color(number)}, "line": {"width": 1.2},
            "fillcolor": format!("{}1a", color(number)), "text": rows.iter().map(|row| label(row)).collect::<Vec<_>>(),
            "hoveron": "points", "hovertemplate": "%{text}<extra></extra>",
        }));
        values.extend(scores);
    }
    let mut layout = json!({
        "xaxis": {"type": "category"}, "yaxis": {"title": {"text": "score"}, "zeroline": false},
        "boxmode": "group", "shapes": [line_at(1.0)],
    });
    scale(&mut layout, &values, &["yaxis"], 1.0);
    drawing("Scores by type", "a point is an episode; dashed: the reactive controllers", data, layout)
}

/// As in the paper's figure: violins, and their mean as a diamond.
fn deviations(board: &[&Entry]) -> Value {
    let mut data = Vec::new();
    for (number, (result, stages)) in board.iter().enumerate() {
        let rows: Vec<&Row> = test_rows(stages).collect();
        let values: Vec<f64> = rows.iter().map(|row| row.record.rms_deviation).collect();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        data.push(json!({
            "type": "violin", "y": values, "x0": result.name, "name": result.name, "points": "all", "jitter": 0.4,
            "pointpos": 0, "marker": {"size": 4, "opacity": 0.65}, "line": {"color": color(number), "width": 1.2},
            "text": rows.iter().map(|row| label(row)).collect::<Vec<_>>(), "hoveron": "points",
            "hovertemplate": "%{text}<extra></extra>", "spanmode": "hard", "width": 0.85, "showlegend": false,
        }));
        data.push(json!({
            "type": "scatter", "mode": "markers", "x": [result.name], "y": [mean], "showlegend": false,
            "hovertemplate": "mean %{y:.2f} K<extra></extra>",
            "marker": {"symbol": "diamond", "size": 11, "color": color(number), "line": {"width": 1.5, "color": "#fff"}},
        }));
    }
    let layout = json!({
        "xaxis": {"type": "category"},
        "yaxis": {"title": {"text": "RMS deviation, K"}, "rangemode": "tozero", "zeroline": false},
    });
    drawing("RMS deviation from target", "a point is an episode, the diamond their mean", data, layout)
}

/// Scores over the steps of training on the test environments.
fn curves(board: &[&Entry]) -> Option<Value> {
    let mut data = Vec::new();
    let mut values = Vec::new();
    for (number, (result, _)) in board.iter().enumerate() {
        let Some(adaptation) = &result.measures.adaptation else { continue };
        let of = |value: fn(&crate::statistics::Interval) -> f64| {
            let means = adaptation.curve.iter().map(|point| &point.scores.interquartile_mean);
            means.map(value).collect::<Vec<f64>>()
        };
        let above: Vec<f64> = of(|each| each.high - each.value);
        let below: Vec<f64> = of(|each| each.value - each.low);
        values.extend(of(|each| each.value));
        data.push(json!({
            "type": "scatter", "mode": "lines+markers", "name": result.name,
            "x": adaptation.curve.iter().map(|point| point.steps).collect::<Vec<_>>(), "y": of(|each| each.value),
            "error_y": {"type": "data", "symmetric": false, "array": above, "arrayminus": below, "thickness": 1.2},
            "line": {"color": color(number), "width": 2}, "marker": {"size": 7},
        }));
    }
    if data.is_empty() {
        return None;
    }
    let mut layout = json!({
        "xaxis": {"title": {"text": "steps on the test environment"}, "zeroline": false},
        "yaxis": {"title": {"text": "score, interquartile mean"}, "zeroline": false}, "shapes": [line_at(1.0)],
    });
    scale(&mut layout, &values, &["yaxis"], 1.0);
    Some(drawing("Adaptation", "scores after training on each test environment", data, layout))
}

fn footer(results: &[Entry]) -> String {
    let mut versions: Vec<String> = Vec::new();
    for (result, _) in results {
        let of = &result.versions;
        let line = format!(
            "building2building {}, dataset {}, EnergyPlus {}, controllers {}",
            of.package, of.generator, of.engine, of.controllers
        );
        if !versions.contains(&line) {
            versions.push(line);
        }
    }
    let several = if versions.len() > 1 { "Results of different versions cannot be compared: " } else { "" };
    format!(
        "A score is that of a building under a task: the mean over seeds of the return over that of the tuned reactive controllers \
         for the same days. In brackets: 95 % intervals of a bootstrap over buildings, stratified by type and task. A \
         generalisation gap is the interquartile mean on test less that on training buildings. {several}{}.",
        versions.join("; ")
    )
}
