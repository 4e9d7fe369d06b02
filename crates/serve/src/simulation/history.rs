//! The points of a test at every control step.

use serde_json::{Map, Value};

use crate::calls::{Refusal, unknown};
use crate::subject::Points;

/// Maximum number of values in an answer, because more would take gigabytes as text.
const MOST_VALUES: usize = 4_000_000;

/// The points at every control step since the beginning of the warm-up, in the units of BOPTEST.
#[derive(Debug)]
pub(super) struct History {
    /// Names of the points in the order of a row: measurements, values of inputs, activations.
    names: Vec<String>,
    /// Time of the first row, and time between rows, s.
    first: f64,
    step: f64,
    rows: Vec<f64>,
}

impl History {
    /// Returns an empty history that begins at a time, s.
    pub fn new(points: &Points, first: f64, step: f64) -> Self {
        let measurements = points.measurements.iter().map(|point| point.name.clone());
        let values = points.inputs.iter().map(|input| input.value.clone());
        let activations = points.inputs.iter().map(|input| input.activation.clone());
        Self { names: measurements.chain(values).chain(activations).collect(), first, step, rows: Vec::new() }
    }

    /// Adds a control step: the observation at its end, and the action applied in it.
    pub fn add(&mut self, points: &Points, observation: &[f64], action: &[f64], overrides: &[Option<f64>]) {
        let measured = points.measurements.iter().zip(observation);
        self.rows.extend(measured.map(|(point, value)| point.unit.express(*value)));
        let applied = points.inputs.iter().zip(action);
        self.rows.extend(applied.map(|(input, value)| input.unit.express(*value)));
        self.rows.extend(overrides.iter().map(|value| f64::from(u8::from(value.is_some()))));
    }

    /// Returns the last row with its time.
    pub fn last(&self) -> Value {
        let width = self.names.len();
        let count = self.rows.len() / width.max(1);
        let row = &self.rows[count.saturating_sub(1) * width..];
        let mut payload: Map<String, Value> =
            self.names.iter().cloned().zip(row.iter().map(|value| Value::from(*value))).collect();
        payload
            .insert("time".to_owned(), Value::from(self.first + count.saturating_sub(1) as f64 * self.step));
        Value::Object(payload)
    }

    /// Returns the values of points between two times, both included, with the times.
    ///
    /// # Errors
    /// A refusal of an unknown point, or of too many values for an answer.
    pub fn between(&self, points: &[String], from: f64, to: f64) -> Result<Value, Refusal> {
        let width = self.names.len();
        let times = (0..self.rows.len() / width.max(1)).map(|row| self.first + row as f64 * self.step);
        let chosen: Vec<(usize, f64)> =
            times.enumerate().filter(|(_, time)| (from..=to).contains(time)).collect();
        let asked = chosen.len() * points.len();
        if asked > MOST_VALUES {
            return Err(Refusal::bad(format!(
                "{} points at {} times are {asked} values; ask for at most {MOST_VALUES}: fewer `point_names` or a later \
                 `start_time`",
                points.len(),
                chosen.len()
            )));
        }
        let mut payload = Map::new();
        for name in points.iter().filter(|name| *name != "time") {
            let column = self.column(name)?;
            let values: Vec<f64> = chosen.iter().map(|(row, _)| self.rows[row * width + column]).collect();
            payload.insert(name.clone(), Value::from(values));
        }
        let times: Vec<f64> = chosen.iter().map(|(_, time)| *time).collect();
        payload.insert("time".to_owned(), Value::from(times));
        Ok(Value::Object(payload))
    }

    fn column(&self, name: &str) -> Result<usize, Refusal> {
        let known = self.names.iter().map(String::as_str);
        let remedy = "GET /measurements and GET /inputs list them";
        let position = self.names.iter().position(|each| each == name);
        position.ok_or_else(|| unknown("point", name, known, remedy))
    }
}
