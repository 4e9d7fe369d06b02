//! The table of shipped baselines as CSV.

use std::fmt::Write;

use b2b_env::{RESOURCES, Resource};

use super::key::Key;
use crate::return_terms::ReturnTerms;

const KEY: &str = "building,task,objective,period,steps_per_hour,generator,engine,controller,revision";
/// Number of columns of [`KEY`].
const KEYS: usize = 9;
const TEMPERATURE: &str = "temperature_penalty";

/// Writes the table; numbers are in the shortest form that reads back the same. A resource that is unknown in every row has no
/// column, and else empty cells.
pub fn text(rows: &[(Key, ReturnTerms)]) -> String {
    let known = |resource: &Resource| rows.iter().any(|(_, terms)| terms.used(*resource).is_some());
    let resources: Vec<Resource> = Resource::ALL.into_iter().filter(known).collect();
    let columns: String = resources.iter().map(|each| format!(",{}", each.penalty().column)).collect();
    let mut text = format!("{KEY},{TEMPERATURE}{columns}\n");
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
        let cell = |resource: &Resource| terms.used(*resource).map_or(String::new(), |sum| sum.to_string());
        let sums: String = resources.iter().map(|resource| format!(",{}", cell(resource))).collect();
        write!(
            text,
            "{building},{task},{objective},{period},{steps_per_hour},{generator},{engine},{controller},{revision},"
        )
        .and_then(|()| writeln!(text, "{}{sums}", terms.temperature_penalty))
        .expect("writing to a string never fails");
    }
    text
}

/// Reads the table; `None` for any other text.
pub fn read(text: &str) -> Option<Vec<(Key, ReturnTerms)>> {
    let mut lines = text.lines();
    let columns = lines.next()?.strip_prefix(KEY)?.strip_prefix(',')?.strip_prefix(TEMPERATURE)?;
    let of_column = |column| Resource::ALL.iter().position(|each| each.penalty().column == column);
    let places: Vec<usize> = columns.split(',').skip(1).map(of_column).collect::<Option<_>>()?;
    lines.map(|line| row(line, &places)).collect()
}

/// Reads a line with the resources at `places`.
fn row(line: &str, places: &[usize]) -> Option<(Key, ReturnTerms)> {
    let cells: Vec<&str> = line.split(',').collect();
    let (key, numbers) = cells.split_at_checked(KEYS)?;
    let [building, task, objective, period, steps_per_hour, generator, engine, controller, revision] = *key
    else {
        return None;
    };
    let (temperature, sums) = numbers.split_first()?;
    let mut terms = ReturnTerms { temperature_penalty: temperature.parse().ok()?, used: [None; RESOURCES] };
    if sums.len() != places.len() {
        return None;
    }
    for (place, cell) in places.iter().zip(sums).filter(|(_, cell)| !cell.is_empty()) {
        terms.used[*place] = Some(cell.parse().ok()?);
    }
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
    Some((key, terms))
}
