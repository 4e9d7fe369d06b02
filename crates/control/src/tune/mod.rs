//! Tuning of the reactive controllers: one set of parameters for a class of buildings, optimized on training buildings.
//!
//! 1. [`training_buildings`] draws training buildings of a class for a [`Plan`].
//! 2. [`Rollouts`] keeps their templates ready for episodes over a winter and a summer week.
//! 3. [`tune`] evaluates the default parameters, then proposals of a Bayesian search. The return of a building is divided
//!    by its loss under the defaults, so that buildings have equal weight, and the score is the 25th percentile over the
//!    buildings, as in the paper (which tunes on its test buildings; no test building is used here). The search maximizes
//!    a score penalized by actuator travel, and the best set is chosen among those under which no actuators hunt.
//!
//! Every evaluation is appended to a file: a tuning run with the same plan resumes from there and returns the same result.

mod outcome;
mod plan;
mod record;
mod rollouts;
mod search;
mod space;

use std::path::Path;

pub use outcome::{Outcome, measured};
use outcome::{is_calm, score, search_score};
pub use plan::{Plan, training_buildings};
use record::{Evaluation, Record};
pub use rollouts::Rollouts;
use search::Search;

use crate::{ReactiveParameters, Result, Tuned};

/// Evaluates up to `evaluations` sets of parameters, including those in the file, and returns the best. The first set is
/// the defaults, so that the result is at least as good. `evaluate` returns the outcome of each building of the plan;
/// `done` is called after each evaluation with their number and the best score. `command` is stored in the result.
///
/// # Errors
/// [`Error::OtherTuning`](crate::Error::OtherTuning) if the file belongs to another plan; [`Error::Io`](crate::Error::Io);
/// errors of `evaluate`.
pub fn tune(
    plan: &Plan,
    evaluations: usize,
    file: &Path,
    command: &str,
    mut evaluate: impl FnMut(&ReactiveParameters) -> Result<Vec<Outcome>>,
    mut done: impl FnMut(usize, f64),
) -> Result<Tuned> {
    let axes = space::axes(plan.class);
    let mut record = Record::open(file, plan)?;
    let mut search = Search::new(axes, plan.seed)?;
    let mut best = (0, f64::NEG_INFINITY);
    for number in 0..evaluations.max(1) {
        if number == record.evaluations.len() {
            let values = match number {
                0 => axes.iter().map(|axis| axis.of(&ReactiveParameters::default())).collect(),
                _ => search.propose()?,
            };
            let outcomes = evaluate(&space::parameters(axes, &values))?;
            record.push(Evaluation { values, outcomes })?;
        }
        let evaluation = &record.evaluations[number];
        let defaults = &record.evaluations[0].outcomes;
        search.tell(&evaluation.values, search_score(defaults, &evaluation.outcomes))?;
        let score = score(defaults, &evaluation.outcomes);
        if score > best.1 && is_calm(defaults, &evaluation.outcomes) {
            best = (number, score);
        }
        done(number + 1, best.1);
    }
    let [default, chosen] = [0, best.0].map(|number| &record.evaluations[number]);
    Ok(Tuned {
        class: plan.class,
        parameters: space::parameters(axes, &chosen.values),
        measured: measured(&default.outcomes, &chosen.outcomes),
        evaluations: evaluations.max(1),
        seed: plan.seed,
        dataset: plan.dataset.to_owned(),
        buildings: plan.buildings.clone(),
        periods: plan.periods.clone(),
        task: plan.task.clone(),
        command: command.to_owned(),
    })
}

#[cfg(test)]
mod tests;
