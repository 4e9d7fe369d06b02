//! Times of a step by type, compared with the paper's table.

use b2b_building::BuildingType;
use b2b_evaluate::report::{Chart, color};
use serde_json::{Value, json};

use super::content::Content;
use crate::paper;
use crate::results::Results;

pub(super) fn content(results: &Results) -> Content {
    let measured: Vec<&Value> =
        results.done.iter().filter_map(|done| done.measured.as_array()).flatten().collect();
    let (mut rows, mut names, mut ours, mut theirs, mut engine) = (vec![], vec![], vec![], vec![], vec![]);
    for entry in measured {
        let name = entry["type"].as_str().unwrap_or_default().to_owned();
        let Ok(building_type) = name.parse::<BuildingType>() else { continue };
        rows.push(cells(entry, building_type));
        names.push(name);
        ours.push(number(entry, "env_ms"));
        engine.push(number(entry, "engine_ms"));
        theirs.push(paper::step_time(building_type)[0]);
    }
    let bar = |(number, (name, values)): (usize, (&str, &Vec<f64>))| {
        json!({"type": "bar", "name": name, "x": names, "y": values, "marker": {"color": color(number)},
               "hovertemplate": "%{x}: %{y:.3f} ms<extra></extra>"})
    };
    let data = [("environment", &ours), ("bare engine", &engine), ("paper", &theirs)]
        .into_iter()
        .enumerate()
        .map(bar);
    let chart = Chart {
        title: "Step time".into(),
        note: "CPU time; environment and bare engine: median day, paper: mean".into(),
        height: 340,
        wide: true,
        data: Value::from(data.collect::<Vec<_>>()),
        layout: json!({"barmode": "group", "xaxis": {"type": "category"}, "yaxis": {"title": {"text": "ms"}}}),
    };
    let table = json!({
        "name": "Step time",
        "title": "ms; mean ± standard deviation over 10,000 steps, and the medians over days on which environment and bare engine alternate",
        "header": ["type", "paper, mean", "here, mean", "here, median", "engine, median", "ratio"],
        "rows": rows,
    });
    Content {
        tables: vec![table],
        charts: vec![chart],
        notes: "Here: CPU time of a whole step of the environment, with the engine; the paper used a different machine."
            .to_owned(),
        ..Content::default()
    }
}

fn cells(entry: &Value, building_type: BuildingType) -> Vec<String> {
    let [mean, deviation] = paper::step_time(building_type);
    vec![
        building_type.to_string(),
        format!("{mean:.3} ± {deviation:.3}"),
        format!("{:.3} ± {:.3}", number(entry, "env_mean_ms"), number(entry, "env_deviation_ms")),
        format!("{:.3}", number(entry, "env_ms")),
        format!("{:.3}", number(entry, "engine_ms")),
        format!("{:.3}", number(entry, "env_to_engine")),
    ]
}

fn number(entry: &Value, name: &str) -> f64 {
    entry[name].as_f64().unwrap_or(f64::NAN)
}
