//! The hours with the largest deviations from target.

use serde::Serialize;

use super::recorded::Recorded;
use crate::terminal::table::Table;

/// Hours listed for each run.
const COUNT: usize = 10;
/// Hours of each run in the terminal.
const IN_TERMINAL: usize = 3;
/// Deviation below which an hour is not listed, K.
const SMALL: f64 = 0.005;

/// An hour of one zone.
#[derive(Clone, Debug, Serialize)]
pub struct WorstHour {
    /// Date, as `01-31`.
    pub date: String,
    /// Hour of the day at which it begins, 0 to 23.
    pub hour: usize,
    /// Hours since the beginning of the episode.
    pub index: usize,
    pub zone: String,
    /// Mean deviation from target, K.
    pub deviation_k: f64,
    pub temperature_c: f64,
    pub target_c: f64,
    pub outdoor_c: f64,
}

/// Returns the worst hours of a run, at most one per zone and day, beginning with the largest deviation.
pub fn of(run: &Recorded) -> Vec<WorstHour> {
    let per_hour = run.described.steps_per_hour as usize;
    let constant = run.constant_target();
    let hours = run.steps() / per_hour;
    let mean = |hour: usize, value: &dyn Fn(usize) -> f64| {
        (hour * per_hour..(hour + 1) * per_hour).map(value).sum::<f64>() / per_hour as f64
    };
    let mut worst: Vec<(f64, usize, usize)> = Vec::new();
    for (number, zone) in run.zones.iter().enumerate() {
        let deviations: Vec<f64> =
            (0..hours).map(|hour| mean(hour, &|step| zone.deviation(step, constant))).collect();
        for (day, own) in deviations.chunks(24).enumerate() {
            let largest = own.iter().enumerate().max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
            worst.extend(largest.map(|(hour, deviation)| (*deviation, day * 24 + hour, number)));
        }
    }
    worst.retain(|(deviation, ..)| deviation.abs() >= SMALL);
    worst.sort_by(|(a, a_hour, _), (b, b_hour, _)| b.abs().total_cmp(&a.abs()).then(a_hour.cmp(b_hour)));
    let hour = |(deviation_k, index, number): (f64, usize, usize)| {
        let zone = &run.zones[number];
        WorstHour {
            date: run.period.part((index / 24) as u32, 1).first().to_string(),
            hour: index % 24,
            index,
            zone: zone.name.clone(),
            deviation_k,
            temperature_c: mean(index, &|step| zone.temperature[step]),
            target_c: mean(index, &|step| zone.target_of(step, constant)),
            outdoor_c: mean(index, &|step| run.outdoor[step]),
        }
    };
    worst.into_iter().take(COUNT).map(hour).collect()
}

/// Returns a table of the worst hours of every run.
pub fn table(runs: &[Recorded]) -> String {
    let has_bands = runs[0].described.task_definition.is_operation();
    let mut table = Table::new([
        "worst hours of",
        "date",
        "hour",
        "zone",
        "deviation (K)",
        "zone (°C)",
        if has_bands { "setpoint (°C)" } else { "target (°C)" },
        "outdoor (°C)",
    ]);
    for run in runs {
        for each in of(run).into_iter().take(IN_TERMINAL) {
            table.row([
                run.name.clone(),
                each.date,
                format!("{:02}:00", each.hour),
                each.zone,
                format!("{:+.2}", each.deviation_k),
                format!("{:.1}", each.temperature_c),
                format!("{:.1}", each.target_c),
                format!("{:.1}", each.outdoor_c),
            ]);
        }
    }
    table.text()
}
