//! The hourly chart of one episode.

use b2b_base::calendar::Calendar;
use b2b_building::RunPeriod;
use serde_json::{Value, json};

use super::chart::Chart;
use crate::evaluation::{EpisodeInfo, Hours};

const HOUR_MS: i64 = 3_600_000;

/// Returns the chart of one of the worst episodes: zones, outdoor air and HVAC power. `None` if its dates are unknown:
/// files of earlier versions do not have those of two weeks chosen from the weather.
pub(super) fn worst(info: &EpisodeInfo, score: Option<f64>, hours: &Hours) -> Option<Value> {
    let score = score.map_or("no score".to_owned(), |score| format!("score {score:.2}"));
    let EpisodeInfo { building, place, period, task, seed, .. } = info;
    let first_day = hours.first_day.or_else(|| Some(period.parse::<RunPeriod>().ok()?.first_day()))?;
    let chart = Chart {
        title: format!("Worst episodes: {building} in {place}"),
        note: format!("{score}, {period}, task {task}, seed {seed}; hourly means, drag to zoom"),
        height: 460,
        wide: true,
        data: traces(&times(first_day, hours.mean.len()), hours),
        layout: json!({
            "xaxis": {"type": "date", "anchor": "y3", "hoverformat": "%a %e %b %H:00",
                      "tickformatstops": [{"dtickrange": [null, 86_399_999], "value": "%H:%M\n%e %b"},
                                          {"dtickrange": [86_400_000, null], "value": "%e %b"}]},
            "yaxis": {"domain": [0.5, 1], "title": {"text": "zones (°C)"}},
            "yaxis2": {"domain": [0.26, 0.44], "title": {"text": "outdoors (°C)"}, "zeroline": false},
            "yaxis3": {"domain": [0, 0.2], "title": {"text": "W/m²"}, "rangemode": "tozero"},
            "hovermode": "x unified",
        }),
    };
    Some(chart.json())
}

/// Returns the start of each hour from a first day on, in milliseconds of Unix time. The chart does not show the year.
fn times([year, month, day]: [u32; 3], hours: usize) -> Vec<i64> {
    let before: u32 = (1970..year).map(|year| Calendar::of_year(year).days()).sum();
    let first = before + Calendar::of_year(year).day([month, day]).map_or(0, |day| day - 1);
    let start = i64::from(first) * 24 * HOUR_MS;
    (0..hours as i64).map(|hour| start + hour * HOUR_MS).collect()
}

fn traces(times: &[i64], hours: &Hours) -> Value {
    const ZONES: &str = "#2563eb";
    let line = |name: &str, hundredths: &[i32], axis: &str, line: Value| {
        let values: Vec<f64> = hundredths.iter().map(|value| f64::from(*value) / 100.0).collect();
        json!({"type": "scatter", "mode": "lines", "x": times, "y": values, "name": name, "yaxis": axis, "line": line,
               "hovertemplate": "%{y:.2f}"})
    };
    let invisible = || json!({"width": 0, "color": ZONES});
    let mut coldest = line("coldest zone", &hours.coldest, "y", invisible());
    coldest["showlegend"] = false.into();
    let mut warmest = line("coldest to warmest zone", &hours.warmest, "y", invisible());
    warmest["fill"] = "tonexty".into();
    warmest["fillcolor"] = "rgba(37,99,235,.22)".into();
    let dashed = |name: &str, values: &[i32]| {
        line(name, values, "y", json!({"width": 1.2, "color": "#b45309", "dash": "dash"}))
    };
    let mut traces = vec![
        coldest,
        warmest,
        line("mean of zones", &hours.mean, "y", json!({"width": 1.2, "color": ZONES})),
    ];
    match hours.cooling.is_empty() {
        true => traces.push(dashed("mean target", &hours.target)),
        false => traces.extend([
            dashed("mean heating setpoint", &hours.target),
            dashed("mean cooling setpoint", &hours.cooling),
        ]),
    }
    traces.push(line("outdoor air", &hours.outdoor, "y2", json!({"width": 1, "color": "#0891b2"})));
    traces.push(line("HVAC power", &hours.power, "y3", json!({"width": 1, "color": "#e4572e"})));
    traces.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hours_have_the_day_of_the_week_and_the_date_of_the_episode() {
        assert_eq!(times([2017, 1, 1], 2), [1_483_228_800_000, 1_483_232_400_000]);
        let leap_day = times([2020, 2, 29], 25);
        assert_eq!((leap_day[0], leap_day[24]), (1_582_934_400_000, 1_583_020_800_000), "then 1 March");
    }
}
