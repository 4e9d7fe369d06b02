//! The file of evaluations, one line each, from which an interrupted tuning run resumes.

use std::fs::File;
use std::io::Write;
use std::iter::repeat;
use std::path::{Path, PathBuf};

use b2b_base::aside::append;
use serde::{Deserialize, Serialize};

use super::outcome::{Outcome, relative_losses, resolved_losses, worst_loss, worst_travel};
use super::plan::Plan;
use crate::{Error, Result};

/// A set of parameters and its outcomes on the buildings of the search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Evaluation {
    /// Values of the searched parameters.
    pub(super) values: Vec<f64>,
    /// Outcome of each building, or only of the first ones if the set was dropped.
    pub(super) outcomes: Vec<Outcome>,
    /// The same with constant targets; empty unless the plan requires them.
    pub(super) constant: Vec<Outcome>,
}

impl Evaluation {
    /// Returns the largest of actuator travel and loss relative to the limits of the search, given the evaluation of
    /// the defaults. The loss is limited only under constant targets.
    pub(super) fn worst_to_limit(&self, plan: &Plan, defaults: &Self) -> f64 {
        let limits = plan.search_limits();
        let travel = worst_travel(limits, &defaults.outcomes, &self.outcomes);
        let constant = worst_travel(limits, &defaults.constant, &self.constant);
        travel.max(constant).max(worst_loss(limits, plan, &defaults.constant, &self.constant))
    }

    /// Returns the relative loss of each building: the loss by occupancy, times the resolved loss under constant
    /// targets if simulated, times the square of the excess over the limits on the worst building.
    pub(super) fn losses(&self, plan: &Plan, defaults: &Self) -> Vec<f64> {
        let factor = self.worst_to_limit(plan, defaults).max(1.0).powi(2);
        let constant = resolved_losses(plan, &defaults.constant, &self.constant);
        let occupancy = relative_losses(plan, &defaults.outcomes, &self.outcomes);
        occupancy
            .into_iter()
            .zip(constant.into_iter().chain(repeat(1.0)))
            .map(|(a, b)| a * b * factor)
            .collect()
    }
}

/// A set of parameters and its outcomes on the buildings of the validation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Validation {
    /// Values of the searched parameters.
    pub(super) values: Vec<f64>,
    /// Outcomes of each building, one per setpoint mode.
    pub(super) outcomes: Vec<Vec<Outcome>>,
}

/// A line of the file.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Line {
    Evaluation(Evaluation),
    Validation(Validation),
}

/// The evaluations of a plan, appended to a file.
pub(super) struct Record {
    path: PathBuf,
    file: File,
    pub(super) evaluations: Vec<Evaluation>,
    validations: Vec<Validation>,
}

impl Record {
    /// Opens the file of a plan, or creates it. An incomplete last line is dropped.
    pub(super) fn open(path: &Path, plan: &Plan) -> Result<Self> {
        let io = |source| Error::Io { path: path.to_owned(), source };
        let head = serde_json::to_string(plan).expect("a plan is plain data") + "\n";
        let text = match std::fs::read_to_string(path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            text => text.map_err(io)?,
        };
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let lines = match whole.strip_prefix(head.as_str()) {
            Some(lines) => lines,
            None if whole.is_empty() => "",
            None => {
                let why = format!("it starts with {}", whole.lines().next().unwrap_or_default());
                return Err(Error::OtherTuning { path: path.to_owned(), why });
            }
        };
        let mut file = append(path).map_err(io)?;
        file.set_len(whole.len() as u64).map_err(io)?;
        if whole.is_empty() {
            file.write_all(head.as_bytes()).map_err(io)?;
        }
        let (evaluations, validations) = (Vec::new(), Vec::new());
        let mut record = Self { path: path.to_owned(), file, evaluations, validations };
        lines.lines().try_for_each(|line| record.read(plan, line))?;
        Ok(record)
    }

    /// Appends an evaluation.
    pub(super) fn push(&mut self, evaluation: Evaluation) -> Result<()> {
        let line = self.append(Line::Evaluation(evaluation))?;
        self.keep(line);
        Ok(())
    }

    /// Returns the validation of a set of parameters; simulates and appends it if the file lacks it.
    pub(super) fn validation(
        &mut self,
        values: &[f64],
        make: impl FnOnce() -> Result<Vec<Vec<Outcome>>>,
    ) -> Result<Vec<Vec<Outcome>>> {
        if let Some(known) = self.validations.iter().find(|known| known.values == values) {
            return Ok(known.outcomes.clone());
        }
        let outcomes = make()?;
        let line = Validation { values: values.to_vec(), outcomes: outcomes.clone() };
        let line = self.append(Line::Validation(line))?;
        self.keep(line);
        Ok(outcomes)
    }

    fn append(&mut self, line: Line) -> Result<Line> {
        let text = serde_json::to_string(&line).expect("an evaluation is plain data") + "\n";
        let written = self.file.write_all(text.as_bytes());
        written.map_err(|source| Error::Io { path: self.path.clone(), source })?;
        Ok(line)
    }

    fn keep(&mut self, line: Line) {
        match line {
            Line::Evaluation(evaluation) => self.evaluations.push(evaluation),
            Line::Validation(validation) => self.validations.push(validation),
        }
    }

    fn read(&mut self, plan: &Plan, text: &str) -> Result<()> {
        let other = |why: String| Error::OtherTuning { path: self.path.clone(), why };
        let line: Line = serde_json::from_str(text).map_err(|error| other(error.to_string()))?;
        let (found, expected) = match &line {
            Line::Evaluation(evaluation) => (evaluation.outcomes.len(), 1..=plan.buildings.len()),
            Line::Validation(validation) => {
                (validation.outcomes.len(), plan.validation.len()..=plan.validation.len())
            }
        };
        if !expected.contains(&found) {
            let expected = format!("{} to {}", expected.start(), expected.end());
            return Err(other(format!("an evaluation has {found} buildings; expected {expected}")));
        }
        self.keep(line);
        Ok(())
    }
}
