//! The table of shipped baselines as CSV.

use std::fmt::Write;

use b2b_env::{RESOURCES, Resource};

use super::key::Key;
use crate::return_terms::{DISCOMFORT, ReturnTerms};

const KEY: &str = "building,task,objective,period,steps_per_hour,generator,engine,controller,revision";
/// Number of columns of [`KEY`].
const KEYS: usize = 9;
const TEMPERATURE: &str = "temperature_penalty";

/// Writes the table, with numbers in the shortest form that reads back the same. A resource has no column if it is
/// unknown in every row, and empty cells where it is unknown in some. The same holds for discomfort, the last column.
pub fn text(rows: &[(Key, ReturnTerms)]) -> String {
    let known = |resource: &Resource| rows.iter().any(|(_, terms)| terms.used(*resource).is_some());
    let resources: Vec<Resource> = Resource::ALL.into_iter().filter(known).collect();
    let mut columns: String = resources.iter().map(|each| format!(",{}", each.penalty().column)).collect();
    let has_discomfort = rows.iter().any(|(_, terms)| terms.discomfort.is_some());
    if has_discomfort {
        columns += &format!(",{DISCOMFORT}");
    }
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
        let cell = |sum: Option<f64>| sum.map_or(String::new(), |sum| sum.to_string());
        let sums = resources.iter().map(|resource| terms.used(*resource));
        let sums = sums.chain(has_discomfort.then_some(terms.discomfort));
        let sums: String = sums.map(|sum| format!(",{}", cell(sum))).collect();
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
    let of_column = |column| match Resource::ALL.iter().position(|each| each.penalty().column == column) {
        Some(place) => Some(Sum::Resource(place)),
        None => (column == DISCOMFORT).then_some(Sum::Discomfort),
    };
    let places: Vec<Sum> = columns.split(',').skip(1).map(of_column).collect::<Option<_>>()?;
    lines.map(|line| row(line, &places)).collect()
}

/// The sum in a column.
#[derive(Clone, Copy)]
enum Sum {
    /// Of the resource with this index.
    Resource(usize),
    Discomfort,
}

/// Reads a line with the sums at `places`.
fn row(line: &str, places: &[Sum]) -> Option<(Key, ReturnTerms)> {
    let cells: Vec<&str> = line.split(',').collect();
    let (key, numbers) = cells.split_at_checked(KEYS)?;
    let [building, task, objective, period, steps_per_hour, generator, engine, controller, revision] = *key
    else {
        return None;
    };
    let (temperature, sums) = numbers.split_first()?;
    let temperature_penalty = temperature.parse().ok()?;
    let mut terms = ReturnTerms { temperature_penalty, used: [None; RESOURCES], discomfort: None };
    if sums.len() != places.len() {
        return None;
    }
    for (place, cell) in places.iter().zip(sums).filter(|(_, cell)| !cell.is_empty()) {
        let sum = Some(cell.parse().ok()?);
        match *place {
            Sum::Resource(place) => terms.used[place] = sum,
            Sum::Discomfort => terms.discomfort = sum,
        }
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
