//! The page of a comparison, in one file that needs no network.

use std::io::Write;

use anyhow::Result;
use serde_json::{Value, json};

use super::difference::relevant;
use super::lead;
use super::recorded::{BandRecord, Recorded};
use super::worst_hours;
use crate::run::operation::Comfort;
use crate::time_series::{Series, TimeAxis, fill};

const PAGE: &str = include_str!("compare.html");

/// Writes the page.
pub fn write(file: &mut impl Write, runs: &[Recorded]) -> Result<()> {
    let first = &runs[0];
    let axis = TimeAxis::new(first.period, first.described.steps_per_hour, first.steps());
    let series = |number: usize, values: &[f64]| axis.series(runs[number].name.clone(), number, values);
    let of_zone = |zone: usize| -> Vec<Series> {
        (0..runs.len()).map(|run| series(run, &runs[run].zones[zone].temperature)).collect()
    };
    let zones = first.zones.iter().enumerate().map(|(number, zone)| {
        json!({
            "name": zone.name,
            "runs": of_zone(number),
            "target": zone.target.as_ref().map(|target| axis.series("target".into(), 0, target)),
            "comfort": zone.band.as_ref().map(|BandRecord { heating, cooling, occupancy }| {
                Comfort::of(axis, heating, cooling.as_deref(), occupancy)
            }),
            "values": runs.iter().map(|run| run.zones[number].deviation_metric).collect::<Vec<_>>(),
        })
    });
    let per_hour = f64::from(first.described.steps_per_hour);
    let power = |of: &dyn Fn(&Recorded, usize) -> f64| -> Vec<Series> {
        let values =
            |run: &Recorded| (0..run.steps()).map(|step| of(run, step) * per_hour).collect::<Vec<_>>();
        runs.iter().enumerate().map(|(number, run)| series(number, &values(run))).collect()
    };
    let fuels = [
        ("electricity and gas", power(&|run, step| run.energy[0][step] + run.energy[1][step])),
        ("electricity", power(&|run, step| run.energy[0][step])),
        ("gas", power(&|run, step| run.energy[1][step])),
    ];
    let uses = |fuel: usize| runs.iter().any(|run| run.energy[fuel].iter().any(|value| *value > 0.0));
    // With one fuel, the total is the same.
    let fuels = if uses(0) && uses(1) { &fuels[..] } else { &fuels[if uses(0) { 1..2 } else { 2..3 }] };
    let data = json!({
        "title": first.title(runs.len()),
        "axis": axis,
        "resolution": axis.resolution(),
        "target": first.constant_target(),
        "lead": lead::json(runs),
        "band": first.described.task_definition.comfort_band,
        "faulty_sensors": first.has_faulty_sensors(),
        "runs": runs.iter().map(|run| json!({"name": run.name, "folder": run.folder})).collect::<Vec<_>>(),
        "metrics": metrics(runs),
        "zones": zones.collect::<Vec<_>>(),
        "power": fuels.iter().map(|(name, runs)| json!({"name": name, "runs": runs})).collect::<Vec<Value>>(),
        "outdoor": axis.series("outdoor air".into(), runs.len(), &first.outdoor),
        "worst": runs.iter().map(worst_hours::of).collect::<Vec<_>>(),
    });
    Ok(file.write_all(fill(PAGE, &data).as_bytes())?)
}

/// Returns the relevant metrics with the values of all runs.
fn metrics(runs: &[Recorded]) -> Vec<Value> {
    let rows = relevant(runs).map(|(metric, values)| {
        json!({
            "label": metric.label(runs),
            "decimals": metric.display.decimals,
            "higher_is_better": metric.display.higher_is_better,
            "values": values,
        })
    });
    rows.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_needs_no_network() {
        for mark in ["{{DATA}}", "{{LOOK}}", "{{PAGE}}", "{{TIME_SERIES}}", "{{TIME_SERIES_STYLE}}"] {
            assert_eq!(PAGE.matches(mark).count(), 1);
        }
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(!PAGE.contains(word), "{word}");
        }
    }
}
