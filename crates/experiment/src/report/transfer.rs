//! Distributions of scores by building type, like the paper's figure of cross-domain transfer.

use b2b_evaluate::report::{Chart, color, horizontal_line, make_logarithmic, range};
use serde_json::{Value, json};

use super::content::{Content, SCORES};
use super::group::Group;
use crate::definition::Experiment;
use crate::results::Results;

pub(super) fn content(experiment: &Experiment, results: &Results) -> Content {
    let mut rows = Vec::new();
    for policy in experiment.policies(&results.budget) {
        for building_type in &experiment.types {
            let own = results.of(&policy.name).map(|(_, row)| row);
            let own = own.filter(|row| row.info.building_type == building_type.name());
            let Some(group) = Group::of(own) else { continue };
            let [median, resolved, range, beats] = group.cells();
            let share = format!("{:.0}", 100.0 * group.beats() as f64 / group.count() as f64);
            rows.push(vec![
                policy.name.clone(),
                building_type.to_string(),
                median,
                resolved,
                range,
                beats,
                share,
            ]);
        }
    }
    let table = json!({
        "title": "on unseen buildings of the test split",
        "header": ["agent", "type", "median score", "resolved median", "range", "below 1", "share (%)"],
        "rows": rows,
    });
    let charts = experiment.types.iter().map(|each| chart(experiment, results, each.name())).collect();
    Content { tables: vec![table], charts, notes: SCORES.to_owned(), ..Content::default() }
}

fn chart(experiment: &Experiment, results: &Results, building_type: &str) -> Chart {
    let mut data = Vec::new();
    let mut all = vec![1.0];
    for (number, policy) in experiment.policies(&results.budget).iter().enumerate() {
        let own = results.of(&policy.name).filter(|(_, row)| row.info.building_type == building_type);
        let ran: Vec<(String, f64)> = own
            .filter_map(|(done, row)| Some((format!("{}, {}", row.info.building, done.key), row.score()?)))
            .collect();
        let scores: Vec<f64> = ran.iter().map(|(_, score)| *score).collect();
        all.extend(&scores);
        data.push(json!({
            "type": "box", "name": policy.name, "y": scores, "boxpoints": "all", "jitter": 0.5, "pointpos": -1.6,
            "text": ran.iter().map(|(name, _)| name).collect::<Vec<_>>(), "hoveron": "points",
            "hovertemplate": "%{text}: %{y:.3f}<extra></extra>",
            "marker": {"color": color(number), "size": 5}, "showlegend": false,
        }));
    }
    let mut axis = json!({"title": {"text": "score"}, "zeroline": false});
    make_logarithmic(&mut axis, range(&all));
    let layout = json!({"xaxis": {"type": "category"}, "yaxis": axis, "shapes": [horizontal_line(1.0)]});
    let note = "one point per building and seed; box: quartiles and median".to_owned();
    Chart { title: building_type.to_owned(), note, height: 320, wide: false, data: Value::from(data), layout }
}
