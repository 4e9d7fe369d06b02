//! The file of evaluations, one line each, from which an interrupted tuning run resumes.

use std::iter::repeat;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::outcome::{CellOutcome, relative_losses, resolved_losses, worst_loss, worst_travel};
use super::plan::TuningPlan;
use crate::Result;
use crate::search::record_file::RecordFile;

/// A set of parameters and its outcomes on the buildings of the search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ParameterEvaluation {
    /// Values of the searched parameters.
    pub(super) values: Vec<f64>,
    /// Outcome of each building, or only of the first ones if the set was dropped.
    pub(super) outcomes: Vec<CellOutcome>,
    /// The same with constant targets; empty unless the plan requires them.
    pub(super) constant: Vec<CellOutcome>,
}

impl ParameterEvaluation {
    /// Returns the largest of actuator travel and loss relative to the limits of the search, given the evaluation of
    /// the defaults. The loss is limited only under constant targets.
    pub(super) fn worst_to_limit(&self, plan: &TuningPlan, defaults: &Self) -> f64 {
        let limits = plan.search_limits();
        let travel = worst_travel(limits, &defaults.outcomes, &self.outcomes);
        let constant = worst_travel(limits, &defaults.constant, &self.constant);
        travel.max(constant).max(worst_loss(limits, plan, &defaults.constant, &self.constant))
    }

    /// Returns the relative loss of each building: the loss by occupancy, times the resolved loss under constant
    /// targets if simulated, times the square of the worst building's ratio to the limits if above 1.
    pub(super) fn losses(&self, plan: &TuningPlan, defaults: &Self) -> Vec<f64> {
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
    pub(super) outcomes: Vec<Vec<CellOutcome>>,
}

/// A line of the file.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Line {
    Evaluation(ParameterEvaluation),
    Validation(Validation),
}

/// The evaluations of a plan, appended to a file.
pub(super) struct EvaluationRecord {
    file: RecordFile,
    pub(super) evaluations: Vec<ParameterEvaluation>,
    validations: Vec<Validation>,
}

impl EvaluationRecord {
    /// Opens the file of a plan, or creates it. An incomplete last line is dropped.
    pub(super) fn open(path: &Path, plan: &TuningPlan) -> Result<Self> {
        let (file, lines) = RecordFile::open(path, plan)?;
        let mut record = Self { file, evaluations: Vec::new(), validations: Vec::new() };
        lines.iter().try_for_each(|line| record.read(plan, line))?;
        Ok(record)
    }

    /// Appends an evaluation.
    pub(super) fn push(&mut self, evaluation: ParameterEvaluation) -> Result<()> {
        let line = self.append(Line::Evaluation(evaluation))?;
        self.keep(line);
        Ok(())
    }

    /// Returns the validation of a set of parameters; simulates and appends it if the file lacks it.
    pub(super) fn validation(
        &mut self,
        values: &[f64],
        make: impl FnOnce() -> Result<Vec<Vec<CellOutcome>>>,
    ) -> Result<Vec<Vec<CellOutcome>>> {
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
        self.file.push(&line)?;
        Ok(line)
    }

    fn keep(&mut self, line: Line) {
        match line {
            Line::Evaluation(evaluation) => self.evaluations.push(evaluation),
            Line::Validation(validation) => self.validations.push(validation),
        }
    }

    fn read(&mut self, plan: &TuningPlan, text: &str) -> Result<()> {
        let line: Line = serde_json::from_str(text).map_err(|error| self.file.other(error.to_string()))?;
        let (found, expected) = match &line {
            Line::Evaluation(evaluation) => (evaluation.outcomes.len(), 1..=plan.buildings.len()),
            Line::Validation(validation) => {
                (validation.outcomes.len(), plan.validation.len()..=plan.validation.len())
            }
        };
        if !expected.contains(&found) {
            let expected = format!("{} to {}", expected.start(), expected.end());
            return Err(self.file.other(format!("an evaluation has {found} buildings; expected {expected}")));
        }
        self.keep(line);
        Ok(())
    }
}
