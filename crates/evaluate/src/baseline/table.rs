//! The table of shipped baselines as CSV.

use std::fmt::Write;

use super::key::Key;
use crate::return_terms::ReturnTerms;

const HEADER: &str = "building,task,objective,period,steps_per_hour,generator,engine,controller,revision,\
                      temperature_penalty,energy_wh_m2,cost_m2,emissions_g_m2,peak_w_m2";

/// Writes the table; numbers are in the shortest form that reads back the same.
pub fn text(rows: &[(Key, ReturnTerms)]) -> String {
    let mut text = format!("{HEADER}\n");
    for (key, terms) in rows {
        let Key {
            building,
            task,
            objective,
            period,
            steps_per_hour,
            generator,
            engine,
            controller,
            revision,
        } = key;
        let ReturnTerms { temperature_penalty, energy, cost, emissions, peak } = terms;
        write!(
            text,
            "{building},{task},{objective},{period},{steps_per_hour},{generator},{engine},{controller},{revision},"
        )
        .and_then(|()| writeln!(text, "{temperature_penalty},{energy},{cost},{emissions},{peak}"))
        .expect("writing to a string never fails");
    }
    text
}

/// Reads the table; `None` for any other text.
pub fn read(text: &str) -> Option<Vec<(Key, ReturnTerms)>> {
    let mut lines = text.lines();
    if lines.next() != Some(HEADER) {
        return None;
    }
    lines.map(row).collect()
}

fn row(line: &str) -> Option<(Key, ReturnTerms)> {
    let cells: Vec<&str> = line.split(',').collect();
    let (key, numbers) = cells.split_at_checked(9)?;
    let [building, task, objective, period, steps_per_hour, generator, engine, controller, revision] = *key
    else {
        return None;
    };
    let numbers: Vec<f64> = numbers.iter().map(|cell| cell.parse().ok()).collect::<Option<_>>()?;
    let [temperature_penalty, energy, cost, emissions, peak] = numbers[..] else { return None };
    let key = Key {
        building: building.into(),
        task: task.into(),
        objective: objective.parse().ok()?,
        period: period.into(),
        steps_per_hour: steps_per_hour.parse().ok()?,
        generator: generator.into(),
        engine: engine.into(),
        controller: controller.into(),
        revision: revision.parse().ok()?,
    };
    Some((key, ReturnTerms { temperature_penalty, energy, cost, emissions, peak }))
}
