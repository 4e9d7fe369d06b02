//! The drawings of the report: traces and layouts as plotly takes them.

use serde_json::{Value, json};

use super::{TypeDeviations, Worst};
use crate::evaluation::{Deviations, Record, Row};
use crate::results::Results;
use crate::statistics::quantile;

/// Colours of the types.
pub(super) const PALETTE: [&str; 8] =
    ["#2563eb", "#e4572e", "#0f9d76", "#9333ea", "#d39b00", "#0891b2", "#db2777", "#65800f"];
/// Points that stand for a distribution of steps.
const QUANTILES: usize = 400;
/// Scores are drawn by their logarithm where they differ by more than this factor.
const WIDE: f64 = 20.0;

/// All of them, in order: title, note, height and figure.
pub(super) fn all(results: &Results, deviations: &[TypeDeviations], worst: &[Worst<'_>]) -> Vec<Value> {
    let rows: Vec<&Row> = results.rows.iter().filter(|row| row.lost.is_none()).collect();
    let types = distinct(&rows, |row| row.record.building_type.clone());
    let mut all = vec![
        drawing(
            "Scores by type",
            "a point is an episode; 1 is the reactive controllers",
            360,
            scores(&rows, &types, |row| type_name(&row.record.building_type)),
        ),
        drawing(
            "Scores by climate zone",
            "of ASHRAE 169, from hot to cold",
            360,
            scores(&by_zone(&rows), &types, |row| row.record.climate_zone.clone()),
        ),
        drawing(
            "Deviation from target, step by step",
            "temperature less target of every step and zone with heating and cooling; each building as heavy as the others",
            340,
            step_deviations(deviations, &types),
        ),
        drawing(
            "RMS deviation by building",
            "root mean square over the episode; a point is an episode, the diamond their mean",
            340,
            rms_deviations(&rows, &types),
        ),
        drawing(
            "Energy against comfort",
            "a point is an episode: to the lower left is better",
            400,
            energy_and_comfort(&rows, &types),
        ),
    ];
    all.extend(worst.iter().map(hours));
    all
}

fn drawing(title: &str, note: &str, height: u32, (data, mut layout): (Value, Value)) -> Value {
    layout["height"] = height.into();
    json!({"title": title, "note": note, "data": data, "layout": layout})
}

fn distinct<K: PartialEq>(rows: &[&Row], key: impl Fn(&Row) -> K) -> Vec<K> {
    let mut keys = Vec::new();
    for key in rows.iter().map(|row| key(row)) {
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys
}

fn type_name(name: &str) -> String {
    if name.is_empty() { "own models" } else { name }.to_owned()
}

fn color(types: &[String], name: &str) -> &'static str {
    PALETTE[types.iter().position(|each| each == name).unwrap_or_default() % PALETTE.len()]
}

fn by_zone<'a>(rows: &[&'a Row]) -> Vec<&'a Row> {
    let mut rows = rows.to_vec();
    rows.sort_by(|a, b| a.record.climate_zone.cmp(&b.record.climate_zone));
    rows
}

/// What is read when a point is pointed at.
fn label(row: &Row) -> String {
    let record = &row.record;
    let score = row.score.map_or("no score".to_owned(), |score| format!("score {score:.3}"));
    let (asked, episode_return, rms) = (asked(record), record.episode_return, record.rms_deviation);
    format!("{asked}<br>{score}, return {episode_return:.1}, RMS {rms:.2} K")
}

/// Which episode it is, in two lines.
pub(super) fn asked(record: &Record) -> String {
    let Record { building, place, climate_zone, task, period, seed, .. } = record;
    format!("{building} in {place} ({climate_zone})<br>{task}, {period}, seed {seed}")
}

/// A box over each category, with the episodes beside it in the colours of their types.
fn scores(rows: &[&Row], types: &[String], category: impl Fn(&Row) -> String) -> (Value, Value) {
    let scored: Vec<&Row> =
        rows.iter().copied().filter(|row| row.score.is_some_and(f64::is_finite)).collect();
    let values: Vec<f64> = scored.iter().filter_map(|row| row.score).collect();
    let mut categories: Vec<String> = distinct(&scored, &category);
    let mut data = vec![json!({
        "type": "box", "x": scored.iter().map(|row| category(row)).collect::<Vec<_>>(), "y": values,
        "boxpoints": false, "line": {"color": "#9aa3af", "width": 1.2}, "fillcolor": "rgba(154,163,175,.12)",
        "hoverinfo": "skip", "showlegend": false, "width": 0.6,
    })];
    for name in types {
        let own: Vec<&Row> = scored.iter().copied().filter(|row| row.record.building_type == *name).collect();
        data.push(points(
            &own,
            own.iter().map(|row| category(row).into()).collect(),
            own.iter().map(|row| row.score.into()).collect(),
            &type_name(name),
            color(types, name),
        ));
    }
    // The box would put them in an order of its own.
    categories.dedup();
    let mut layout = json!({
        "xaxis": {"type": "category", "categoryorder": "array", "categoryarray": categories},
        "yaxis": {"title": {"text": "score"}, "zeroline": false},
        "shapes": [line_at(1.0)],
    });
    let (low, high) = extremes(&values);
    if low > 0.0 && high / low > WIDE {
        layout["yaxis"]["type"] = "log".into();
        layout["yaxis"]["dtick"] = "D1".into();
    } else {
        let (low, high) = (low.min(1.0), high.max(1.0));
        // Around the line even where every score is on it.
        let margin = ((high - low) * 0.08).max(0.02);
        layout["yaxis"]["range"] = json!([low - margin, high + margin]);
    }
    (data.into(), layout)
}

fn points(rows: &[&Row], x: Vec<Value>, y: Vec<Value>, name: &str, color: &str) -> Value {
    json!({
        "type": "scatter", "mode": "markers", "x": x, "y": y, "name": name,
        "text": rows.iter().map(|row| label(row)).collect::<Vec<_>>(), "hovertemplate": "%{text}<extra></extra>",
        "marker": {"size": 7, "color": color, "opacity": 0.8, "line": {"width": 0}},
    })
}

/// A dashed line across.
pub(super) fn line_at(value: f64) -> Value {
    json!({"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": value, "y1": value,
           "line": {"dash": "dash", "width": 1.3, "color": "#b45309"}})
}

fn extremes(values: &[f64]) -> (f64, f64) {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    (low, values.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

/// Violins over evenly spaced quantiles of the steps.
fn step_deviations(deviations: &[TypeDeviations], types: &[String]) -> (Value, Value) {
    let mut far: f64 = 0.5;
    let mut data = Vec::new();
    for each in deviations {
        let values = quantiles(&each.shares);
        // What is drawn is where 99 of 100 steps are.
        far = far.max(-quantile(&values, 0.005)).max(quantile(&values, 0.995));
        let name = type_name(&each.name);
        data.push(json!({
            "type": "violin", "y": values, "x0": name, "name": name, "points": false, "hoverinfo": "y+name",
            "line": {"color": color(types, &each.name), "width": 1.2}, "spanmode": "hard", "width": 0.85,
            "meanline": {"visible": true}, "box": {"visible": true, "width": 0.12},
        }));
    }
    let layout = json!({
        "yaxis": {"title": {"text": "temperature less target, K"}, "range": [-1.1 * far, 1.1 * far], "zeroline": false},
        "xaxis": {"type": "category"}, "shapes": [line_at(0.0)], "showlegend": false,
    });
    (data.into(), layout)
}

/// Values at evenly spaced shares of a histogram.
fn quantiles(shares: &[f64]) -> Vec<f64> {
    let total: f64 = shares.iter().sum();
    let (mut bin, mut sum) = (0, shares.first().copied().unwrap_or_default());
    let mut value = |index: usize| {
        let wanted = (index as f64 + 0.5) / QUANTILES as f64 * total;
        while sum < wanted && bin + 1 < shares.len() {
            bin += 1;
            sum += shares[bin];
        }
        // In proportion within the bin.
        let within = if shares[bin] > 0.0 { 1.0 - (sum - wanted) / shares[bin] } else { 0.5 };
        Deviations::middle(bin) + (within.clamp(0.0, 1.0) - 0.5) * Deviations::WIDTH
    };
    (0..QUANTILES).map(&mut value).collect()
}

/// As in the paper's figure: violins with the episodes beside them, and their mean as a diamond.
fn rms_deviations(rows: &[&Row], types: &[String]) -> (Value, Value) {
    let mut data = Vec::new();
    for name in types {
        let own: Vec<&Row> = rows.iter().copied().filter(|row| row.record.building_type == *name).collect();
        let values: Vec<f64> = own.iter().map(|row| row.record.rms_deviation).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let shown = type_name(name);
        data.push(json!({
            "type": "violin", "y": values, "x0": shown, "name": shown, "points": "all", "jitter": 0.4, "pointpos": 0,
            "text": own.iter().map(|row| label(row)).collect::<Vec<_>>(), "hoveron": "points",
            "hovertemplate": "%{text}<extra></extra>", "line": {"color": color(types, name), "width": 1.2},
            "marker": {"size": 5, "opacity": 0.8}, "spanmode": "hard", "width": 0.85,
        }));
        data.push(json!({
            "type": "scatter", "mode": "markers", "x": [shown], "y": [mean], "hovertemplate": "mean %{y:.2f} K<extra></extra>",
            "marker": {"symbol": "diamond", "size": 11, "color": color(types, name), "line": {"width": 1.5, "color": "#fff"}},
        }));
    }
    let layout = json!({
        "yaxis": {"title": {"text": "RMS deviation, K"}, "rangemode": "tozero", "zeroline": false},
        "xaxis": {"type": "category"}, "showlegend": false,
    });
    (data.into(), layout)
}

fn energy_and_comfort(rows: &[&Row], types: &[String]) -> (Value, Value) {
    let mut data = Vec::new();
    for name in types {
        let own: Vec<&Row> = rows.iter().copied().filter(|row| row.record.building_type == *name).collect();
        let energy = |row: &&Row| ((row.record.electricity + row.record.gas) / 1000.0).into();
        data.push(points(
            &own,
            own.iter().map(energy).collect(),
            own.iter().map(|row| row.record.rms_deviation.into()).collect(),
            &type_name(name),
            color(types, name),
        ));
    }
    let layout = json!({
        "xaxis": {"title": {"text": "HVAC energy, kWh/m²"}, "rangemode": "tozero", "zeroline": false},
        "yaxis": {"title": {"text": "RMS deviation, K"}, "rangemode": "tozero", "zeroline": false},
    });
    (data.into(), layout)
}

/// An episode hour by hour: its zones above, outdoors and power below.
fn hours(worst: &Worst<'_>) -> Value {
    let record = &worst.row.record;
    let hundredths =
        |values: &[i32]| values.iter().map(|value| f64::from(*value) / 100.0).collect::<Vec<_>>();
    let first =
        record.period.parse::<b2b_building::RunPeriod>().map_or(1, |period| period.first().day_of_year());
    // Milliseconds of the calendar year of every episode, 2017.
    let start = 1_483_228_800_000_i64 + i64::from(first - 1) * 86_400_000;
    let times: Vec<i64> = (0..worst.hours.mean.len() as i64).map(|hour| start + hour * 3_600_000).collect();
    let line = |name: &str, values: &[i32], axis: &str, line: Value| {
        json!({"type": "scatter", "mode": "lines", "x": times, "y": hundredths(values), "name": name, "yaxis": axis,
               "line": line, "hovertemplate": "%{y:.2f}"})
    };
    let mut warmest =
        line("coldest to warmest zone", &worst.hours.warmest, "y", json!({"width": 0, "color": "#2563eb"}));
    warmest["fill"] = "tonexty".into();
    warmest["fillcolor"] = "rgba(37,99,235,.22)".into();
    let mut coldest =
        line("coldest zone", &worst.hours.coldest, "y", json!({"width": 0, "color": "#2563eb"}));
    coldest["showlegend"] = false.into();
    let data = json!([
        coldest,
        warmest,
        line("mean of the zones", &worst.hours.mean, "y", json!({"width": 1.2, "color": "#2563eb"})),
        line(
            "target, mean",
            &worst.hours.target,
            "y",
            json!({"width": 1.2, "color": "#b45309", "dash": "dash"})
        ),
        line("outdoor air", &worst.hours.outdoor, "y2", json!({"width": 1, "color": "#0891b2"})),
        line("HVAC power", &worst.hours.power, "y3", json!({"width": 1, "color": "#e4572e"})),
    ]);
    let layout = json!({
        "xaxis": {"type": "date", "anchor": "y3", "hoverformat": "%a %e %b %H:00"},
        "yaxis": {"domain": [0.5, 1], "title": {"text": "zones, °C"}},
        "yaxis2": {"domain": [0.26, 0.44], "title": {"text": "outdoors, °C"}, "zeroline": false},
        "yaxis3": {"domain": [0, 0.2], "title": {"text": "W/m²"}, "rangemode": "tozero"},
        "hovermode": "x unified",
    });
    let score = worst.row.score.map_or("no score".to_owned(), |score| format!("score {score:.2}"));
    let title = format!("Worst: {} in {}", record.building, record.place);
    let note = format!(
        "{score}, {}, task {}, seed {}; hourly, drag to zoom in",
        record.period, record.task, record.seed
    );
    drawing(&title, &note, 460, (data, layout))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_a_histogram_are_where_its_steps_are() {
        let mut deviations = Deviations::empty();
        for step in 0..1000 {
            deviations.add(-1.0 + f64::from(step) / 500.0);
        }
        let shares: Vec<f64> = deviations.counts.iter().map(|count| *count as f64).collect();
        let values = quantiles(&shares);
        assert_eq!(values.len(), QUANTILES);
        assert!(values.is_sorted());
        for (share, expected) in [(0.0, -1.0), (0.25, -0.5), (0.5, 0.0), (1.0, 1.0)] {
            assert!((quantile(&values, share) - expected).abs() < 0.02, "{share}");
        }
    }
}
