//! The chart of energy against comfort, relative to the reactive controllers if they are known.

use serde_json::{Value, json};

use super::chart::{Chart, color, horizontal_line, make_logarithmic, range, vertical_line};
use super::series::{Series, labels};
use crate::evaluation::{EpisodeInfo, Scored};

/// Returns the chart of HVAC energy against comfort, one point per episode, relative to the reactive controllers at (1,
/// 1); without them, it shows energy and RMS deviation in units.
pub fn energy_and_comfort(series: &[Series<'_>], height: u32, wide: bool) -> Chart {
    let relative = |scored: &Scored| Some([scored.relative_energy()?, scored.relative_comfort()?]);
    let all = || series.iter().flat_map(|series| series.episodes.iter().map(|(_, scored)| *scored));
    match all().any(|scored| relative(scored).is_some()) {
        true => to_baseline(series, &relative, height, wide),
        false => {
            let absolute =
                |scored: &Scored| Some([scored.metrics.energy() / 1000.0, scored.metrics.rms_deviation]);
            let axis =
                |title: &str| json!({"title": {"text": title}, "rangemode": "tozero", "zeroline": false});
            Chart {
                title: "Energy vs. comfort".into(),
                note: "one point per episode; lower left is better".into(),
                height,
                wide,
                data: traces(series, &absolute).into(),
                layout: json!({"xaxis": axis("HVAC energy (kWh/m²)"), "yaxis": axis("RMS deviation (K)")}),
            }
        }
    }
}

type Point<'a> = &'a dyn Fn(&Scored) -> Option<[f64; 2]>;

fn to_baseline(series: &[Series<'_>], point: Point<'_>, height: u32, wide: bool) -> Chart {
    let all = series.iter().flat_map(|series| series.episodes.iter().map(|(_, scored)| *scored));
    let points: Vec<[f64; 2]> = all.filter_map(point).collect();
    let axis = |title: &str, side: usize| {
        let values: Vec<f64> = points.iter().map(|point| point[side]).collect();
        let (low, high) = range(&values);
        let mut axis = json!({"title": {"text": title}, "zeroline": false});
        make_logarithmic(&mut axis, (low.min(1.0), high.max(1.0)));
        axis
    };
    let mut data = traces(series, point);
    data.push(json!({
        "type": "scatter", "mode": "markers", "x": [1], "y": [1], "name": "reactive controllers",
        "hovertemplate": "reactive controllers<extra></extra>",
        "marker": {"symbol": "diamond", "size": 12, "color": "#b45309", "line": {"width": 1.5, "color": "#fff"}},
    }));
    Chart {
        title: "Energy vs. comfort, relative to the reactive controllers".into(),
        note: "one point per episode; lower left is better; comfort: root of the temperature penalty, after adding \
               0.2 K to both"
            .into(),
        height,
        wide,
        data: data.into(),
        layout: json!({
            "xaxis": axis("HVAC energy / baseline", 0), "yaxis": axis("deviation / baseline", 1),
            "shapes": [horizontal_line(1.0), vertical_line(1.0)],
        }),
    }
}

fn traces(series: &[Series<'_>], point: Point<'_>) -> Vec<Value> {
    let trace = |(number, Series { name, episodes }): (usize, &Series<'_>)| {
        let known: Vec<((&EpisodeInfo, &Scored), [f64; 2])> =
            episodes.iter().filter_map(|(info, scored)| Some(((*info, *scored), point(scored)?))).collect();
        let [x, y] = [0, 1].map(|side| known.iter().map(|(_, point)| point[side]).collect::<Vec<_>>());
        json!({
            "type": "scatter", "mode": "markers", "name": name, "x": x, "y": y,
            "text": labels(&known.iter().map(|(row, _)| *row).collect::<Vec<_>>()),
            "hovertemplate": "%{text}<br>%{x:.2f}, %{y:.2f}<extra></extra>",
            "marker": {"size": 7, "color": color(number), "opacity": 0.8, "line": {"width": 0}},
        })
    };
    series.iter().enumerate().map(trace).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BuiltIn, Episode, Subject};
    use b2b_env::{EpisodeMetrics, Term};

    fn episode() -> EpisodeInfo {
        let episode = Episode {
            subject: Subject::at_home("OfficeSmall-1".parse().unwrap()),
            task: "constant".parse().unwrap(),
            period: "01-01..01-02".parse().unwrap(),
            seed: 0,
            steps_per_hour: 12,
        };
        EpisodeInfo::of(&episode, &BuiltIn::random())
    }

    #[test]
    fn the_baseline_is_drawn_at_one_and_one_where_it_is_known() {
        let mut metrics =
            EpisodeMetrics { steps: 100, temperature_penalty: 21.0, ..EpisodeMetrics::default() };
        metrics.terms.set(Term::Electricity, 500.0);
        metrics.terms.set(Term::Gas, 0.0);
        let unknown = Scored { metrics, ..Scored::default() };
        let known = Scored {
            baseline_return: Some(-21.0),
            baseline_energy: Some(unknown.metrics.energy()),
            ..unknown.clone()
        };
        let info = episode();
        let drawn = |scored: &Scored| {
            energy_and_comfort(&[Series { name: "a", episodes: vec![(&info, scored)] }], 300, true)
        };
        let chart = drawn(&known);
        assert_eq!((&chart.data[0]["x"], &chart.data[0]["y"]), (&json!([1.0]), &json!([1.0])));
        assert_eq!(chart.data[1]["name"], "reactive controllers");
        assert_eq!(chart.layout["shapes"].as_array().unwrap().len(), 2);
        let chart = drawn(&unknown);
        assert_eq!(chart.data.as_array().unwrap().len(), 1);
        assert_eq!(chart.layout["xaxis"]["title"]["text"], "HVAC energy (kWh/m²)");
    }
}
