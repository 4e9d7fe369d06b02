//! Tuning of the reactive controllers: one set of parameters for a class of buildings, found on training buildings.
//!
//! 1. [`Plan::new`] draws training buildings of a class.
//! 2. [`Rollouts`] keeps them ready to begin episodes over a winter and a summer week.
//! 3. [`tune`] tries the default parameters, then what a Bayesian search proposes. A building's return is divided by
//!    what the defaults had on it, so that buildings weigh alike, and the score is the 25th percentile over the
//!    buildings, as in the paper (which tunes on its test buildings; here none is seen). The search is told of scores
//!    made worse by how much the actuators move, and the best is chosen among those with which no building hunts.
//!
//! Every evaluation is appended to a file; the same plan goes on from there, and comes to the same result.

mod record;
mod rollouts;
mod search;
mod space;

use std::path::Path;

use b2b_building::{Class, RunPeriod};
use b2b_dataset::{BuildingId, GENERATOR_VERSION, Split};
use b2b_env::{Metrics, Task};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

pub use rollouts::Rollouts;

use crate::{Error, Measured, ReactiveParameters, Result, Tuned};
use record::{Evaluation, Record};
use search::Search;

/// What is tuned, on what.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// For whom.
    pub class: Class,
    /// Version of the dataset.
    pub dataset: &'static str,
    /// The training buildings, by id.
    pub buildings: Vec<String>,
    /// The days that each runs.
    pub periods: Vec<RunPeriod>,
    /// The task, by its spelling.
    pub task: String,
    /// Seed of the buildings and of the search.
    pub seed: u64,
    /// What is searched.
    pub parameters: Vec<&'static str>,
}

/// What the episodes of a building came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Sum of the rewards.
    pub episode_return: f64,
    /// Steps.
    pub steps: usize,
    /// HVAC energy, Wh/m².
    pub energy: f64,
    /// Way of an actuator in times its range a day, mean over actuators and episodes.
    pub daily_travel: f64,
}

/// Daily travel beyond which actuators hunt, unless those of the defaults travel further. A target that jumps up and
/// down once a day takes an actuator there and back twice, which is four times its range.
const CALM: f64 = 5.0;

impl Outcome {
    /// Over some episodes.
    pub fn of(episodes: &[Metrics]) -> Self {
        let share = 1.0 / episodes.len().max(1) as f64;
        episodes.iter().fold(Self::default(), |sum, metrics| Self {
            episode_return: sum.episode_return + metrics.episode_return,
            steps: sum.steps + metrics.steps,
            energy: sum.energy + metrics.electricity + metrics.gas,
            daily_travel: sum.daily_travel + share * metrics.daily_travel(),
        })
    }

    /// The return, made worse by how much the actuators move: twice as bad where they begin to hunt.
    fn weighted_return(&self) -> f64 {
        self.episode_return * (1.0 + (self.daily_travel / CALM).powi(2))
    }
}

/// So many training buildings of a class, drawn by a seed, in the order of their ids.
///
/// # Errors
/// [`Error::TooFewBuildings`].
pub fn training_buildings(class: Class, count: usize, seed: u64) -> Result<Vec<BuildingId>> {
    let rows = b2b_dataset::rows(class.building_type).iter();
    let of_class = rows.filter(|row| row.split == Split::Train && row.building.class() == class);
    let mut left: Vec<BuildingId> = of_class.map(|row| row.id).collect();
    if count == 0 || count > left.len() {
        return Err(Error::TooFewBuildings { class: class.to_string(), there: left.len(), asked: count });
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut drawn: Vec<_> =
        (0..count).map(|_| left.swap_remove(random.random_range(0..left.len()))).collect();
    drawn.sort_by_key(|id| id.number());
    Ok(drawn)
}

impl Plan {
    /// A plan for a class on so many training buildings.
    ///
    /// # Errors
    /// [`Error::TooFewBuildings`].
    pub fn new(
        class: Class,
        buildings: &[BuildingId],
        periods: &[RunPeriod],
        task: &Task,
        seed: u64,
    ) -> Self {
        Self {
            class,
            dataset: GENERATOR_VERSION,
            buildings: buildings.iter().map(ToString::to_string).collect(),
            periods: periods.to_vec(),
            task: task.to_string(),
            seed,
            parameters: space::axes(class).iter().map(space::Axis::name).collect(),
        }
    }
}

/// Evaluates up to so many sets of parameters, those of the file included, and gives the best. The first are the
/// defaults, so that it is none worse. `evaluate` gives what each building of the plan comes to; `done` is called
/// with the number of evaluations and the best score, after each. `command` is kept with the result.
///
/// # Errors
/// [`Error::OtherTuning`] when the file is of another plan; what `evaluate` says; [`Error::Io`].
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
        search.tell(
            &evaluation.values,
            percentile_of(Outcome::weighted_return, defaults, &evaluation.outcomes),
        )?;
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

/// What outcomes come to beside those of the default parameters.
pub fn measured(defaults: &[Outcome], outcomes: &[Outcome]) -> Measured {
    Measured {
        default_score: score(defaults, defaults),
        score: score(defaults, outcomes),
        default_penalty: mean_penalty(defaults),
        penalty: mean_penalty(outcomes),
        default_daily_travel: mean_travel(defaults),
        daily_travel: mean_travel(outcomes),
        energy: mean_energy(outcomes),
    }
}

/// The 25th percentile over the buildings of the return in times what the defaults lost: −1 is as good as the defaults,
/// 0 is perfect.
fn score(defaults: &[Outcome], outcomes: &[Outcome]) -> f64 {
    percentile_of(|outcome| outcome.episode_return, defaults, outcomes)
}

fn percentile_of(value: fn(&Outcome) -> f64, defaults: &[Outcome], outcomes: &[Outcome]) -> f64 {
    let relative = |(outcome, default): (&Outcome, &Outcome)| {
        value(outcome) / value(default).abs().max(f64::MIN_POSITIVE)
    };
    percentile_25(outcomes.iter().zip(defaults).map(relative).collect())
}

/// Whether no building's actuators hunt. A mean would hide one that does.
fn is_calm(defaults: &[Outcome], outcomes: &[Outcome]) -> bool {
    let calm =
        |(outcome, default): (&Outcome, &Outcome)| outcome.daily_travel <= default.daily_travel.max(CALM);
    outcomes.iter().zip(defaults).all(calm)
}

/// Interpolated between neighbours.
fn percentile_25(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = 0.25 * (values.len() - 1) as f64;
    let (below, above) = (values[place.floor() as usize], values[place.ceil() as usize]);
    below + place.fract() * (above - below)
}

/// Penalty of a step, mean over the buildings.
fn mean_penalty(outcomes: &[Outcome]) -> f64 {
    mean_of_steps(outcomes, |outcome| -outcome.episode_return)
}

/// Energy of a step, mean over the buildings, Wh/m².
fn mean_energy(outcomes: &[Outcome]) -> f64 {
    mean_of_steps(outcomes, |outcome| outcome.energy)
}

/// Daily travel, mean over the buildings.
fn mean_travel(outcomes: &[Outcome]) -> f64 {
    outcomes.iter().map(|outcome| outcome.daily_travel).sum::<f64>() / outcomes.len() as f64
}

fn mean_of_steps(outcomes: &[Outcome], sum: impl Fn(&Outcome) -> f64) -> f64 {
    outcomes.iter().map(|outcome| sum(outcome) / outcome.steps.max(1) as f64).sum::<f64>()
        / outcomes.len() as f64
}

#[cfg(test)]
mod tests;
