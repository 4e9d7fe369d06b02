//! Charts of resource use against comfort, relative to the baseline where it is known.

use serde_json::{Value, json};

use super::chart::{Chart, color, horizontal_line, make_logarithmic, range, vertical_line};
use super::series::{Series, labels};
use crate::evaluation::{EpisodeInfo, RESOURCE, Scored, resource_heading};
use crate::scores::FREE_DISCOMFORT;

/// An episode in a table.
type Entry<'a> = (&'a EpisodeInfo, &'a Scored);

/// What a chart draws of each episode.
struct Form {
    title: &'static str,
    note: &'static str,
    /// Titles of the axes.
    axes: [&'static str; 2],
    /// Position of an episode; `None` if it is not known.
    point: fn(&Entry<'_>) -> Option<[f64; 2]>,
    /// Position of the baseline, and the dashed line of comfort.
    baseline: Option<([f64; 2], f64)>,
}

const TRACKING: Form = Form {
    title: "Energy vs. comfort",
    note: "one point per episode; lower left is better",
    axes: ["HVAC energy (kWh/m²)", "RMS deviation (K)"],
    point: |(_, scored)| Some([scored.metrics.energy() / 1000.0, scored.metrics.rms_deviation]),
    baseline: None,
};

const TRACKING_RELATIVE: Form = Form {
    title: "Energy vs. comfort, relative to the baseline",
    note: "one point per episode; lower left is better; comfort: root of the temperature penalty, after adding 0.2 K to both",
    axes: ["HVAC energy / baseline", "deviation / baseline"],
    point: |(_, scored)| Some([scored.relative_energy()?, scored.relative_comfort()?]),
    baseline: Some(([1.0, 1.0], 1.0)),
};

const OPERATION: Form = Form {
    title: "Cost vs. comfort",
    note: "one point per episode; lower left is better; discomfort: mean over zones",
    axes: ["cost (per m²)", "discomfort (K·h/day)"],
    point: |(info, scored)| {
        Some([scored.metrics.cost_tot?, scored.metrics.tdis_tot? / scored.days(info.steps_per_hour)])
    },
    baseline: None,
};

const OPERATION_RELATIVE: Form = Form {
    title: "Cost vs. comfort, relative to the baseline",
    note: "one point per episode; lower left is better; discomfort: per zone, beyond the baseline's; dashed: the \
           baseline's cost, and the discomfort that is free",
    axes: [RESOURCE, "excess discomfort (K·h/day)"],
    point: |(info, scored)| {
        let discomfort = scored.metrics.tdis_tot? - scored.baseline_discomfort?;
        Some([scored.relative_resource()?, discomfort / scored.days(info.steps_per_hour)])
    },
    baseline: Some(([1.0, 0.0], FREE_DISCOMFORT)),
};

/// Returns a chart for episodes of tracking and one for episodes of operation, as far as there are any, one point per
/// episode. Without a known baseline, a chart has absolute units.
pub fn trade_offs(series: &[Series<'_>], height: u32, wide: bool) -> Vec<Chart> {
    let chart = |relative: &Form, absolute: &Form, operated: bool| {
        let own: Vec<Series<'_>> = series
            .iter()
            .map(|Series { name, episodes }| {
                let is_own = |(_, scored): &&Entry<'_>| scored.metrics.tdis_tot.is_some() == operated;
                Series { name, episodes: episodes.iter().filter(is_own).copied().collect() }
            })
            .collect();
        let known = |form: &Form| {
            own.iter().flat_map(|series| &series.episodes).any(|row| (form.point)(row).is_some())
        };
        let form = if known(relative) { relative } else { absolute };
        known(form).then(|| draw(&own, form, height, wide))
    };
    [chart(&TRACKING_RELATIVE, &TRACKING, false), chart(&OPERATION_RELATIVE, &OPERATION, true)]
        .into_iter()
        .flatten()
        .collect()
}

fn draw(series: &[Series<'_>], form: &Form, height: u32, wide: bool) -> Chart {
    let mut data = traces(series, form);
    let axes = [0, 1].map(|side| axis(series, form, side));
    let mut layout = json!({"xaxis": axes[0], "yaxis": axes[1]});
    if let Some(([x, y], comfort)) = form.baseline {
        data.push(json!({
            "type": "scatter", "mode": "markers", "x": [x], "y": [y], "name": "baseline",
            "hovertemplate": "baseline<extra></extra>",
            "marker": {"symbol": "diamond", "size": 12, "color": "#b45309", "line": {"width": 1.5, "color": "#fff"}},
        }));
        layout["shapes"] = json!([horizontal_line(comfort), vertical_line(x)]);
    }
    Chart { title: form.title.into(), note: form.note.into(), height, wide, data: data.into(), layout }
}

/// Returns the axis of one side of the points, around the baseline if it is drawn.
fn axis(series: &[Series<'_>], form: &Form, side: usize) -> Value {
    let tasks = series.iter().flat_map(|series| &series.episodes).map(|(info, _)| &info.task[..]);
    let title = match form.axes[side] {
        RESOURCE => resource_heading(tasks),
        title => title.to_owned(),
    };
    let mut axis = json!({"title": {"text": title}, "zeroline": false});
    let Some((baseline, comfort)) = form.baseline else {
        axis["rangemode"] = "tozero".into();
        return axis;
    };
    let points = series.iter().flat_map(|series| &series.episodes).filter_map(form.point);
    let mut values: Vec<f64> = points.map(|point| point[side]).filter(|value| value.is_finite()).collect();
    values.push(baseline[side]);
    if side == 1 {
        values.push(comfort);
    }
    let (low, high) = range(&values);
    if !make_logarithmic(&mut axis, (low, high)) {
        // Leaves room around the baseline even if every episode is on it.
        let margin = ((high - low) * 0.08).max(0.02);
        axis["range"] = json!([low - margin, high + margin]);
    }
    axis
}

fn traces(series: &[Series<'_>], form: &Form) -> Vec<Value> {
    let trace = |(number, Series { name, episodes }): (usize, &Series<'_>)| {
        let known: Vec<(Entry<'_>, [f64; 2])> =
            episodes.iter().filter_map(|row| Some((*row, (form.point)(row)?))).collect();
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
    use crate::{BuiltIn, EpisodePlan, Subject};
    use b2b_env::{EpisodeMetrics, Term};

    fn episode() -> EpisodeInfo {
        let episode = EpisodePlan {
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
            let series = [Series { name: "a", episodes: vec![(&info, scored)] }];
            let [chart] = &trade_offs(&series, 300, true)[..] else { panic!("one chart") };
            chart.clone()
        };
        let chart = drawn(&known);
        assert_eq!((&chart.data[0]["x"], &chart.data[0]["y"]), (&json!([1.0]), &json!([1.0])));
        assert_eq!(chart.data[1]["name"], "baseline");
        assert_eq!(chart.layout["shapes"].as_array().unwrap().len(), 2);
        assert_eq!(chart.layout["yaxis"]["range"], json!([0.98, 1.02]), "no cliff of rounding errors");
        let chart = drawn(&unknown);
        assert_eq!(chart.data.as_array().unwrap().len(), 1);
        assert_eq!(chart.layout["xaxis"]["title"]["text"], "HVAC energy (kWh/m²)");
    }

    #[test]
    fn operation_is_drawn_by_cost_and_discomfort_and_beside_tracking() {
        let metrics = |tdis_tot| EpisodeMetrics { steps: 576, tdis_tot, ..EpisodeMetrics::default() };
        let operated = Scored {
            metrics: metrics(Some(5.0)),
            resource: Some(3.0),
            baseline_resource: Some(4.0),
            baseline_discomfort: Some(2.0),
            ..Scored::default()
        };
        let tracked = Scored { metrics: metrics(None), ..Scored::default() };
        let info = EpisodeInfo { task: "operate+tou".into(), ..episode() };
        let episodes = vec![(&info, &operated), (&info, &tracked)];
        let charts = trade_offs(&[Series { name: "a", episodes }], 300, true);
        assert_eq!(
            charts.iter().map(|chart| chart.title.as_str()).collect::<Vec<_>>(),
            [TRACKING.title, OPERATION_RELATIVE.title]
        );
        assert_eq!(
            (&charts[1].data[0]["x"], &charts[1].data[0]["y"]),
            (&json!([0.75]), &json!([1.5])),
            "3 K·h in 2 days"
        );
        assert_eq!((&charts[1].data[1]["x"], &charts[1].data[1]["y"]), (&json!([1.0]), &json!([0.0])));
        assert_eq!(charts[1].layout["xaxis"]["title"]["text"], "cost / baseline");
    }
}
