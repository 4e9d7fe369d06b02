//! The charts of the leaderboard.

use serde_json::{Value, json};

use super::Ranked;
use crate::entry::{Measures, Stages, rows_of};
use crate::problem::Stage;
use b2b_evaluate::report::{
    Chart, Series, color, has_several_tasks, horizontal_line, label_logarithmic, labels, make_logarithmic,
    range, rms_deviations, step_rewards,
};
use b2b_evaluate::statistics::Interval;
use b2b_evaluate::{EpisodeInfo, Scored};

/// Lowest score of a logarithmic profile, and the highest score of the profiles in results.
const PROFILE_START: f64 = 0.1;
const PROFILE_END: f64 = 3.0;
/// Highest score drawn to scale. Axes end here, so that one entry far above does not flatten the others.
const HIGHEST: f64 = 20.0;

/// Returns all charts of a problem's entries, in order.
pub(super) fn all(board: &[&Ranked]) -> Vec<Value> {
    let charts = [
        returns(board),
        profiles(board),
        by_type(board),
        step_rewards(&series(board)),
        rms_deviations(&series(board)),
    ];
    charts.into_iter().chain(adaptation(board)).chain(by_episode(board)).map(Chart::json).collect()
}

fn chart(title: &str, note: &str, data: Vec<Value>, layout: Value) -> Chart {
    Chart { title: title.into(), note: note.into(), height: 340, wide: false, data: data.into(), layout }
}

/// Draws a bar per entry, as in the paper's figure of returns.
fn returns(board: &[&Ranked]) -> Chart {
    let bar = |(number, (result, _)): (usize, &&Ranked)| {
        let median = result.measures.test.scores.median;
        match median.value <= HIGHEST {
            true => json!({
                "type": "bar", "x": [result.name], "y": [median.value], "width": 0.55, "marker": {"color": color(number)},
                "error_y": {"type": "data", "symmetric": false, "array": [median.high - median.value],
                            "arrayminus": [median.value - median.low], "thickness": 1.4, "color": "#6b7280"},
                "hovertemplate": "%{x}: %{y:.3f}<extra></extra>", "showlegend": false,
            }),
            false => beyond(&result.name, median.value, color(number)),
        }
    };
    let values: Vec<f64> = board.iter().map(|(result, _)| result.measures.test.scores.median.value).collect();
    let mut layout = json!({
        "xaxis": {"type": "category"}, "yaxis": {"title": {"text": "score, median"}, "zeroline": false},
        "shapes": [horizontal_line(1.0)],
    });
    let logarithmic = scale_y(&mut layout, &values);
    let mut traces: Vec<Value> = board.iter().enumerate().map(bar).collect();
    if logarithmic {
        // A logarithmic axis has no zero for bars to start from.
        for trace in traces.iter_mut().filter(|trace| trace["type"] == "bar") {
            trace["type"] = "scatter".into();
            trace["mode"] = "markers".into();
            trace["marker"]["size"] = 11.into();
        }
    }
    let note = "dashed: the baseline; error bars: 95 % intervals; triangles: beyond the axis";
    chart("Median score", note, traces, layout)
}

/// Scales the vertical axis: logarithmic for widely spread values, else from 0; returns whether it is logarithmic. The
/// baseline's 1 is in the range.
fn scale_y(layout: &mut Value, values: &[f64]) -> bool {
    let (low, high) = range(values);
    let (low, end) = (low.min(1.0), high.clamp(1.0, HIGHEST));
    let logarithmic = make_logarithmic(&mut layout["yaxis"], (low, end));
    if !logarithmic {
        layout["yaxis"]["rangemode"] = "tozero".into();
    }
    if high > HIGHEST {
        layout["yaxis"]["range"] = match logarithmic {
            true => json!([(0.9 * low).log10(), (1.1 * HIGHEST).log10()]),
            false => json!([0, 1.1 * HIGHEST]),
        };
    }
    logarithmic
}

/// Returns a triangle at the end of the axis for an entry beyond it, with its score.
fn beyond(name: &str, score: f64, color: &str) -> Value {
    json!({
        "type": "scatter", "mode": "markers+text", "x": [name], "y": [HIGHEST], "showlegend": false,
        "text": [format!("{score:.0}")], "textposition": "bottom center",
        "marker": {"symbol": "triangle-up", "size": 13, "color": color},
        "hovertemplate": format!("%{{x}}: {score:.0}<extra></extra>"),
    })
}

/// Returns the note, with the number of values beyond the end of the axis if there are any.
fn and_beyond(note: &str, values: &[f64]) -> String {
    match values.iter().filter(|value| **value > HIGHEST).count() {
        0 => note.to_owned(),
        count => format!("{note}; {count} above {HIGHEST} not drawn"),
    }
}

/// Draws the share of buildings at or below a score, with its interval.
fn profiles(board: &[&Ranked]) -> Chart {
    let mut data = Vec::new();
    for (number, (result, _)) in board.iter().enumerate() {
        let profile = &result.measures.profile;
        let scores: Vec<f64> = profile.iter().map(|point| point.score).collect();
        let of = |value: fn(&Interval) -> f64| {
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
        let scores = result.measures.scores.iter().map(|each| each.score).collect();
        data.extend(profile_beyond(scores, color(number)));
    }
    let scores = board.iter().flat_map(|(result, _)| &result.measures.scores).map(|each| each.score);
    let highest = scores.fold(PROFILE_END, f64::max);
    let mut axis = json!({"title": {"text": "score τ"}, "zeroline": false, "range": [0, PROFILE_END]});
    let end = highest.min(HIGHEST);
    if highest > PROFILE_END {
        label_logarithmic(&mut axis, (PROFILE_START, end));
        axis["range"] = json!([PROFILE_START.log10(), (1.1 * end).log10()]);
    }
    let layout = json!({
        "xaxis": axis,
        "yaxis": {"title": {"text": "share of scores ≤ τ"}, "range": [-0.02, 1.02], "tickformat": ".0%", "zeroline": false},
        "shapes": [{"type": "line", "yref": "paper", "y0": 0, "y1": 1, "x0": 1, "x1": 1,
                    "line": {"dash": "dash", "width": 1.3, "color": "#b45309"}}],
    });
    let note = if highest > PROFILE_END {
        "upper left is better; bands: 95 % intervals; dotted: beyond a score of 3, without them"
    } else {
        "upper left is better; bands: 95 % intervals"
    };
    chart("Performance profile", note, data, layout)
}

/// Continues the profile of an entry to its highest score.
fn profile_beyond(mut scores: Vec<f64>, color: &str) -> Option<Value> {
    scores.sort_by(f64::total_cmp);
    let share = |count: usize| count as f64 / scores.len() as f64;
    let within = scores.partition_point(|score| *score <= PROFILE_END);
    if within == scores.len() {
        return None;
    }
    let (mut x, mut y) = (vec![PROFILE_END], vec![share(within)]);
    for (number, score) in scores.iter().enumerate().skip(within) {
        x.push(*score);
        y.push(share(number + 1));
    }
    Some(json!({
        "type": "scatter", "x": x, "y": y, "mode": "lines", "showlegend": false,
        "line": {"color": color, "width": 2, "shape": "hv", "dash": "dot"},
        "hovertemplate": "%{y:.0%} score %{x:.2f} or less<extra></extra>",
    }))
}

/// Returns the rows of the test stage; none of a result's rows is lost.
fn test_rows(stages: &Stages) -> Vec<(&EpisodeInfo, &Scored)> {
    let rows = rows_of(stages, Stage::Test).unwrap_or_default().iter();
    rows.filter_map(|row| Some((&row.info, row.scored()?))).collect()
}

/// Returns the entries with the episodes of the test stage.
fn series<'a>(board: &[&'a Ranked]) -> Vec<Series<'a>> {
    board.iter().map(|(result, stages)| Series { name: &result.name, episodes: test_rows(stages) }).collect()
}

/// Draws boxes with the episodes' scores by building type.
fn by_type(board: &[&Ranked]) -> Chart {
    let mut values = Vec::new();
    let mut data = Vec::new();
    let episodes = board.iter().flat_map(|(_, stages)| test_rows(stages)).map(|(info, _)| info);
    let several_tasks = has_several_tasks(episodes);
    for (number, (result, stages)) in board.iter().enumerate() {
        let rows = test_rows(stages);
        let scores: Vec<f64> = rows.iter().filter_map(|(_, scored)| scored.score).collect();
        let category = |info: &EpisodeInfo| match several_tasks {
            true => format!("{}<br>{}", info.building_type, info.task),
            false => info.building_type.clone(),
        };
        data.push(json!({
            "type": "box", "x": rows.iter().map(|(info, _)| category(info)).collect::<Vec<_>>(), "y": scores,
            "name": result.name, "boxpoints": "all", "jitter": 0.5, "pointpos": 0,
            "marker": {"size": 4.5, "opacity": 0.65, "color": color(number)}, "line": {"width": 1.2},
            "fillcolor": format!("{}1a", color(number)), "text": labels(&rows),
            "hoveron": "points", "hovertemplate": "%{text}<extra></extra>",
        }));
        values.extend(scores);
    }
    let mut layout = json!({
        "xaxis": {"type": "category"}, "yaxis": {"title": {"text": "score"}, "zeroline": false},
        "boxmode": "group", "shapes": [horizontal_line(1.0)],
    });
    scale_y(&mut layout, &values);
    let title = if several_tasks { "Scores by building type and task" } else { "Scores by building type" };
    let note = and_beyond("one point per episode; dashed: the baseline", &values);
    chart(title, &note, data, layout)
}

/// Draws scores over the training steps on the test environments.
fn adaptation(board: &[&Ranked]) -> Option<Chart> {
    let points = |measures: &Measures| {
        let curve = &measures.adaptation.as_ref()?.curve;
        Some(curve.iter().map(|point| (point.steps, point.scores.interquartile_mean)).collect())
    };
    let note = "scores after training on each test environment; dashed: the baseline";
    curves(board, points, ["Adaptation", note, "training steps on the test environment", "score"])
}

/// Draws scores over the days in a test building, in which a policy keeps its memory.
fn by_episode(board: &[&Ranked]) -> Option<Chart> {
    let points = |measures: &Measures| {
        let points = measures.by_episode.as_ref()?.points.iter();
        let means =
            points.map(|point| (point.days_before.into(), point.performance.resolved.interquartile_mean));
        Some(means.collect())
    };
    let note = "episodes after days in the building; weights do not change; dashed: the baseline";
    curves(board, points, ["Memory", note, "days in the building", "resolved score"])
}

/// Draws a curve for every entry that has points. The texts are title, note, and labels of both axes.
fn curves(
    board: &[&Ranked],
    points: impl Fn(&Measures) -> Option<Vec<(u64, Interval)>>,
    [title, note, x, y]: [&str; 4],
) -> Option<Chart> {
    let mut data = Vec::new();
    let mut values = Vec::new();
    for (number, (result, _)) in board.iter().enumerate() {
        let Some(points) = points(&result.measures) else { continue };
        let of =
            |value: fn(&Interval) -> f64| points.iter().map(|(_, mean)| value(mean)).collect::<Vec<f64>>();
        let above: Vec<f64> = of(|each| each.high - each.value);
        let below: Vec<f64> = of(|each| each.value - each.low);
        values.extend(of(|each| each.value));
        data.push(json!({
            "type": "scatter", "mode": "lines+markers", "name": result.name,
            "x": points.iter().map(|(x, _)| *x).collect::<Vec<_>>(), "y": of(|each| each.value),
            "error_y": {"type": "data", "symmetric": false, "array": above, "arrayminus": below, "thickness": 1.2},
            "line": {"color": color(number), "width": 2}, "marker": {"size": 7},
        }));
    }
    if data.is_empty() {
        return None;
    }
    let mut layout = json!({
        "xaxis": {"title": {"text": x}, "zeroline": false},
        "yaxis": {"title": {"text": format!("{y}, interquartile mean")}, "zeroline": false},
        "shapes": [horizontal_line(1.0)],
    });
    scale_y(&mut layout, &values);
    Some(chart(title, &and_beyond(note, &values), data, layout))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_at_50_000_does_not_flatten_the_others() {
        let mut layout = json!({"yaxis": {}});
        assert!(scale_y(&mut layout, &[0.9, 1.1, 50_000.0]));
        let [low, high] = [0, 1].map(|end| layout["yaxis"]["range"][end].as_f64().unwrap());
        assert!(10_f64.powf(high) < 25.0, "the axis ends at {high}");
        let part = ((1.1_f64).log10() - (0.9_f64).log10()) / (high - low);
        assert!(part > 0.05, "0.9 and 1.1 are {part} of the axis apart");
        let triangle = beyond("far", 50_000.0, "#000");
        assert_eq!((&triangle["y"][0], &triangle["text"][0]), (&json!(HIGHEST), &json!("50000")));
        assert_eq!(and_beyond("points", &[1.0, 50_000.0]), "points; 1 above 20 not drawn");
    }

    #[test]
    fn a_profile_continues_to_the_highest_score() {
        let beyond = profile_beyond(vec![20.0, 0.5, 4.0, 1.0], "#000").unwrap();
        assert_eq!(beyond["x"], json!([3.0, 4.0, 20.0]));
        assert_eq!(beyond["y"], json!([0.5, 0.75, 1.0]));
        assert_eq!(profile_beyond(vec![0.5, 3.0], "#000"), None);
    }
}
