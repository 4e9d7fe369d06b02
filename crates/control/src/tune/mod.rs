//! Tuning of the reactive controllers: one set of parameters for a class of buildings and an objective, optimized on
//! training buildings.
//!
//! 1. [`TrainingBuildings::draw`] draws training buildings of a class for the search and for the validation of a
//!    [`TuningPlan`].
//! 2. [`Rollouts`] keeps their templates ready for episodes of three days in winter and three in summer.
//! 3. [`tune`] evaluates the default parameters, then proposals of a search. The loss of a building is divided by the
//!    loss of the defaults, so buildings have equal weight; the score is the 75th percentile over the buildings (the
//!    25th of the return, as in the paper, which tunes on its test buildings; no test building is used here),
//!    multiplied by a factor if actuators hunt or constant targets are not held on the worst building. Buildings are
//!    simulated one after another, and a proposal that cannot win is dropped: most are, after one building. The search
//!    ends early when it no longer lowers the score. On central air loops, each building is also simulated with
//!    constant targets.
//! 4. The best sets and the defaults are validated on other training buildings under other setpoints, and the one with
//!    the lowest median loss over all of them is chosen, unless actuators hunt or it is clearly worse than the defaults
//!    anywhere. If none is eligible, the next best sets are validated.
//!
//! Every evaluation is appended to a file: a tuning run with the same plan resumes from there and returns the same
//! result.

mod limits;
mod outcome;
mod plan;
mod race;
mod record;
mod rollouts;
mod search;
mod selection;
mod space;

use std::path::Path;

pub use outcome::{CellOutcome, travel_limit};
pub use plan::{TrainingBuildings, TuningPlan};
use race::Best;
use record::{EvaluationRecord, ParameterEvaluation};
pub use rollouts::Rollouts;
use search::ParameterSearch;
use selection::select;
pub use selection::{Cells, measured};

use crate::{ReactiveParameters, Result, Tuned};

/// The search ends when this many consecutive evaluations have lowered the best score by less than [`MIN_GAIN`].
const PATIENCE: usize = 20;
/// Smallest relative gain that counts.
const MIN_GAIN: f64 = 0.01;
/// Number of sets validated at once.
const FINALISTS: usize = 4;
/// Maximum number of sets validated, beside the defaults.
const MAX_FINALISTS: usize = 12;

/// A building of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanBuilding {
    /// A building of the search, by its index.
    Search(usize),
    /// A building of the search with constant targets, by its index.
    Constant(usize),
    /// A building of the validation, by its index.
    Validation(usize),
}

/// Evaluates at most `evaluations` sets of parameters (including those in the file) until the search stalls, validates
/// the best and returns the chosen one. The first set is the defaults, so that the result is at least as good.
/// `simulate` returns the outcomes of a building: one for the search, one per setpoint mode for the validation. `done`
/// is called after each evaluation with the number so far. `command` is stored in the result.
///
/// # Errors
/// [`Error::OtherTuning`](crate::Error::OtherTuning) if the file belongs to another plan;
/// [`Error::Io`](crate::Error::Io); errors of `simulate`.
pub fn tune(
    plan: &TuningPlan,
    evaluations: usize,
    file: &Path,
    command: &str,
    mut simulate: impl FnMut(&ReactiveParameters, PlanBuilding) -> Result<Vec<CellOutcome>>,
    done: impl FnMut(usize),
) -> Result<Tuned> {
    let mut record = EvaluationRecord::open(file, plan)?;
    let evaluations = search(plan, evaluations.max(1), &mut record, &mut simulate, done)?;
    let sets = validate(plan, evaluations, &mut record, &mut simulate)?;
    let cells: Vec<Cells> = sets.iter().map(|(_, cells)| cells.clone()).collect();
    let chosen = select(plan, &cells);
    Ok(Tuned {
        class: plan.class,
        objective: plan.objective,
        parameters: space::parameters(plan.axes(), &sets[chosen].0),
        measured: measured(plan, &cells[0], &cells[chosen]),
        evaluations,
        seed: plan.seed,
        dataset: plan.dataset.to_owned(),
        buildings: plan.buildings.clone(),
        validation: plan.validation.clone(),
        periods: plan.periods.clone(),
        energy_scale: plan.energy_scale,
        command: command.to_owned(),
    })
}

/// Fills the record up to a number of evaluations, or until the search stalls. Returns the number of evaluations.
fn search(
    plan: &TuningPlan,
    evaluations: usize,
    record: &mut EvaluationRecord,
    simulate: &mut impl FnMut(&ReactiveParameters, PlanBuilding) -> Result<Vec<CellOutcome>>,
    mut done: impl FnMut(usize),
) -> Result<usize> {
    let mut search = ParameterSearch::new(plan.axes(), plan.seed)?;
    let mut best: Option<Best> = None;
    let mut scores = Vec::new();
    for number in 0..evaluations {
        if number == record.evaluations.len() {
            let values = match (plan.starts.get(number), &best) {
                (Some(start), _) => start.clone(),
                (None, best) => {
                    search.propose(best.as_ref().map(|best| &record.evaluations[best.number].values[..]))?
                }
            };
            let evaluation = race(plan, record, best.as_ref(), values, simulate)?;
            record.push(evaluation)?;
        }
        let (evaluation, defaults) = (&record.evaluations[number], &record.evaluations[0]);
        let is_complete = evaluation.outcomes.len() == plan.buildings.len();
        let candidate = Best { number, losses: evaluation.losses(plan, defaults) };
        let score = match &best {
            Some(best) if !is_complete => best.estimate(&candidate.losses),
            _ => candidate.score(),
        };
        search.tell(&evaluation.values, score)?;
        let is_better = best.as_ref().is_none_or(|best| score < best.score());
        if is_complete && is_better && evaluation.worst_to_limit(plan, defaults) <= 1.0 {
            best = Some(candidate);
        }
        done(number + 1);
        scores.push(best.as_ref().map_or(f64::INFINITY, Best::score));
        if has_stalled(plan, &scores) {
            break;
        }
    }
    Ok(scores.len())
}

/// Returns whether the best score, given after each evaluation, has stopped falling. On central air loops, where few
/// sets are within the limits, the search continues until a set beats the defaults, whose score is 1.
fn has_stalled(plan: &TuningPlan, scores: &[f64]) -> bool {
    let Some(earlier) = scores.len().checked_sub(1 + PATIENCE).filter(|number| *number >= search::UNIFORM)
    else {
        return false;
    };
    let best = scores[scores.len() - 1];
    let has_found = !plan.constant_targets || best < 1.0 - MIN_GAIN;
    has_found && best > (1.0 - MIN_GAIN) * scores[earlier]
}

/// Simulates the buildings of the search one after another, until the set is dropped.
fn race(
    plan: &TuningPlan,
    record: &EvaluationRecord,
    best: Option<&Best>,
    values: Vec<f64>,
    simulate: &mut impl FnMut(&ReactiveParameters, PlanBuilding) -> Result<Vec<CellOutcome>>,
) -> Result<ParameterEvaluation> {
    let parameters = space::parameters(plan.axes(), &values);
    let is_out = |evaluation: &ParameterEvaluation| match (best, record.evaluations.first()) {
        (Some(best), Some(defaults)) => best.is_beyond(&evaluation.losses(plan, defaults)),
        _ => false,
    };
    let mut evaluation = ParameterEvaluation { values, outcomes: Vec::new(), constant: Vec::new() };
    for building in 0..plan.buildings.len() {
        evaluation.outcomes.extend(simulate(&parameters, PlanBuilding::Search(building))?);
        if plan.constant_targets && !is_out(&evaluation) {
            evaluation.constant.extend(simulate(&parameters, PlanBuilding::Constant(building))?);
        }
        if is_out(&evaluation) {
            break;
        }
    }
    Ok(evaluation)
}

/// Returns the cells of the defaults and of the best sets of the search, a few at a time until one is eligible. Sets
/// without a validation in the record are validated.
fn validate(
    plan: &TuningPlan,
    evaluations: usize,
    record: &mut EvaluationRecord,
    simulate: &mut impl FnMut(&ReactiveParameters, PlanBuilding) -> Result<Vec<CellOutcome>>,
) -> Result<Vec<(Vec<f64>, Cells)>> {
    let ranked = ranked(plan, &record.evaluations[..evaluations]);
    let mut cells = |number: usize| -> Result<(Vec<f64>, Cells)> {
        let ParameterEvaluation { values, outcomes: search, constant } = record.evaluations[number].clone();
        let parameters = space::parameters(plan.axes(), &values);
        let validation = record.validation(&values, || {
            (0..plan.validation.len())
                .map(|building| simulate(&parameters, PlanBuilding::Validation(building)))
                .collect()
        })?;
        Ok((values, Cells { search, constant, validation }))
    };
    let mut sets = vec![cells(0)?];
    for finalists in ranked[..ranked.len().min(MAX_FINALISTS)].chunks(FINALISTS) {
        for number in finalists {
            sets.push(cells(*number)?);
        }
        if sets[1..].iter().any(|(_, set)| set.is_eligible(plan, &sets[0].1)) {
            break;
        }
    }
    Ok(sets)
}

/// Returns the numbers of the complete evaluations within the limits of the search, best first, without the defaults
/// and repetitions.
fn ranked(plan: &TuningPlan, evaluations: &[ParameterEvaluation]) -> Vec<usize> {
    let defaults = &evaluations[0];
    let mut ranked: Vec<(f64, usize)> = Vec::new();
    for (number, evaluation) in evaluations.iter().enumerate().skip(1) {
        let is_repeated = evaluations[..number].iter().any(|other| other.values == evaluation.values);
        if evaluation.outcomes.len() == plan.buildings.len()
            && evaluation.worst_to_limit(plan, defaults) <= 1.0
            && !is_repeated
        {
            ranked.push((outcome::percentile_75(&evaluation.losses(plan, defaults)), number));
        }
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked.into_iter().map(|(_, number)| number).collect()
}

#[cfg(test)]
mod tests;
