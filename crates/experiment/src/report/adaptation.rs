//! Specialists and generalists on test buildings, as the paper's figures of dynamics adaptation.

use std::collections::BTreeMap;

use b2b_evaluate::report::{Chart, Series, color, horizontal_line, make_logarithmic, range, rms_deviations};
use b2b_evaluate::statistics::{mean, median, score_text};
use b2b_evaluate::{EpisodeInfo, Scored};
use serde_json::json;

use super::group::Group;
use super::{Content, SCORES};
use crate::definition::{Experiment, Training};
use crate::results::Results;

pub(super) fn content(experiment: &Experiment, results: &Results) -> Content {
    let mut rows = Vec::new();
    let (mut names, mut medians, mut errors, mut colors) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut series = Vec::new();
    for (number, agent) in experiment.agents.iter().enumerate() {
        let own = || results.of(&agent.name);
        let Some(group) = Group::of(own().map(|(_, row)| row)) else { continue };
        let mut of_jobs = Vec::new();
        let mut by_building: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for done in results.done.iter().filter(|done| done.agent == agent.name) {
            let Some(median) = Group::of(done.rows.iter()).map(|group| group.median()) else { continue };
            of_jobs.push(median);
            by_building.entry(&done.rows[0].info.building).or_default().push(median);
        }
        // A generalist's median is the mean over the medians of its seeds; specialists have one building each.
        let (value, error) = match agent.trains {
            Training::Building => {
                (group.median(), bootstrap_error(&Vec::from_iter(by_building.into_values())))
            }
            _ => (mean(&of_jobs), standard_error(&of_jobs)),
        };
        let deviation = own().filter_map(|(_, row)| Some(row.metrics()?.rms_deviation)).collect::<Vec<_>>();
        let [_, resolved, range, beats] = group.cells();
        rows.push(vec![
            agent.name.clone(),
            of_jobs.len().to_string(),
            group.count().to_string(),
            score_text(value) + &error.map_or(String::new(), |error| format!(" ± {}", score_text(error))),
            resolved,
            range,
            beats,
            format!("{:.2}", mean(&deviation)),
        ]);
        names.push(agent.name.clone());
        medians.push(value);
        errors.push(error);
        colors.push(color(number));
        let episodes: Vec<(&EpisodeInfo, &Scored)> =
            own().filter_map(|(_, row)| Some((&row.info, row.outcome.as_ref().ok()?))).collect();
        series.push(Series { name: &agent.name, episodes });
    }
    let mut layout = json!({"xaxis": {"type": "category"}, "yaxis": {"title": {"text": "median score"}, "rangemode": "tozero"},
                            "shapes": [horizontal_line(1.0)], "showlegend": false});
    let (low, high) = range(&medians);
    // A logarithmic axis has no zero for the foot of a bar.
    let (kind, size) = match make_logarithmic(&mut layout["yaxis"], (low.min(1.0), high.max(1.0))) {
        true => ("scatter", 11),
        false => ("bar", 0),
    };
    let chart = Chart {
        title: "Median score on the test buildings".into(),
        note: "dashed line: the reactive controllers; below beats them".into(),
        height: 340,
        wide: false,
        data: json!([{"type": kind, "mode": "markers", "x": names, "y": medians, "marker": {"color": colors, "size": size},
                      "width": 0.6, "error_y": {"type": "data", "array": errors},
                      "hovertemplate": "%{x}: %{y:.3f}<extra></extra>"}]),
        layout,
    };
    let table = json!({
        "title": "on test buildings; ± standard error: over seeds, or by bootstrap over buildings for specialists",
        "header": ["agent", "trainings", "episodes", "median score", "resolved median", "range", "beats baseline",
                   "RMS deviation (K)"],
        "rows": rows,
    });
    Content {
        tables: vec![table],
        charts: vec![chart, rms_deviations(&series)],
        notes: SCORES.to_owned(),
        ..Content::default()
    }
}

/// Returns the standard error of a mean; `None` of a single value.
fn standard_error(values: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let mean = mean(values);
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64;
    Some((variance / values.len() as f64).sqrt())
}

/// Returns the standard deviation of the median when the buildings are resampled, each with all of its values; `None` of a single
/// building.
fn bootstrap_error(buildings: &[Vec<f64>]) -> Option<f64> {
    use rand::{RngExt, SeedableRng};
    const DRAWS: usize = 2000;
    if buildings.len() < 2 {
        return None;
    }
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(0);
    let medians: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let drawn = buildings.iter().map(|_| &buildings[random.random_range(0..buildings.len())]);
            let mut drawn: Vec<f64> = drawn.flatten().copied().collect();
            drawn.sort_by(f64::total_cmp);
            median(&drawn)
        })
        .collect();
    Some(standard_error(&medians)? * (DRAWS as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_follow_their_definitions() {
        assert!((standard_error(&[1.0, 2.0, 3.0]).unwrap() - 1.0 / 3.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!((standard_error(&[1.0]), bootstrap_error(&[vec![1.0, 2.0]])), (None, None));
        // The median of a large normal sample has a standard error of 1.253 σ / √n.
        let values: Vec<Vec<f64>> = (0..100).map(|index| vec![f64::from(index % 10)]).collect();
        let error = bootstrap_error(&values).unwrap();
        assert!(error > 0.1 && error < 1.0, "{error}");
        // Four equal values of each building are no more than one.
        let repeated: Vec<Vec<f64>> = values.iter().map(|values| values.repeat(4)).collect();
        assert_eq!(bootstrap_error(&repeated), Some(error));
    }
}
