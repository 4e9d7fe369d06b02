//! Whether a folder holds what it says.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::result::POLICY;
use super::{Entrant, Measures, RunResult, read_result};
use crate::evaluation::{Episode, Evaluation, Finished, Outcome, Progress, Row, Versions};
use crate::problem::{Problem, Stage, Through};
use crate::scores::normalized_score;
use crate::{Baselines, Error, Result, Surroundings};

/// Relative difference of numbers that were added up in another order.
const ROUNDING: f64 = 1e-9;

/// Something that was looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What.
    pub what: &'static str,
    /// What was found: good, or not.
    pub found: std::result::Result<String, String>,
}

/// Episodes to run once more.
#[derive(Clone, Copy, Debug)]
pub struct Rerun {
    /// How many.
    pub episodes: usize,
    /// Decides which.
    pub seed: u64,
}

type Found = std::result::Result<String, String>;

/// Looks at everything that a result says, as far as one look leaves sense to the next: its form, versions, problem, list
/// of episodes, sums and scores, measures; then runs a sample once more, with its baselines, and compares to the bit.
///
/// # Errors
/// What stops an evaluation; all that is wrong with the folder is in a [`Check`].
pub fn verify(
    folder: &Path,
    evaluation: &Evaluation<'_>,
    rerun: Rerun,
    progress: &dyn Progress,
) -> Result<Vec<Check>> {
    let (result, stages) = match read_result(folder) {
        Ok(read) => read,
        Err(error) => return Ok(vec![Check { what: "folder", found: Err(error.to_string()) }]),
    };
    let episodes: usize = stages.iter().map(|(_, rows)| rows.len()).sum();
    let mut checks = vec![
        Check {
            what: "folder",
            found: Ok(format!("{} of {}, {episodes} episodes", result.name, result.problem.name)),
        },
        Check { what: "versions", found: versions(&result) },
        Check { what: "problem", found: problem(&result) },
        Check { what: "episodes", found: list(&result, &stages) },
        Check { what: "scores", found: scores(&stages) },
        Check { what: "measures", found: measures(&result, &stages) },
    ];
    if rerun.episodes > 0 && checks.iter().all(|check| check.found.is_ok()) {
        let found = run_again(folder, &result, &stages, evaluation, rerun, progress)?;
        checks.push(Check { what: "episodes run again", found });
    }
    Ok(checks)
}

fn versions(result: &RunResult) -> Found {
    let (there, here) = (&result.versions, Versions::current());
    let pairs = [
        ("package", &there.package, &here.package),
        ("dataset", &there.generator, &here.generator),
        ("EnergyPlus", &there.engine, &here.engine),
        ("reactive controllers", &there.controllers, &here.controllers),
    ];
    let other: Vec<_> = pairs
        .into_iter()
        .filter(|(_, there, here)| there != here)
        .map(|(what, there, here)| format!("{what} {there} there and {here} here"))
        .collect();
    if other.is_empty() {
        Ok(format!("dataset {}, EnergyPlus {}", here.generator, here.engine))
    } else {
        Err(other.join("; "))
    }
}

fn problem(result: &RunResult) -> Found {
    let problem = &result.problem;
    problem.check().map_err(|error| error.to_string())?;
    if problem.hash() != result.problem_hash {
        return Err("the problem is not the one whose hash is given".into());
    }
    if problem.changes() != result.problem_changes {
        return Err(format!("it says nothing of what is changed in {}", problem.name));
    }
    let budget = problem.protocol.training_steps;
    if let Some(steps) = result.training_steps.filter(|steps| *steps > budget) {
        return Err(format!("it was trained for {steps} steps, and the budget is {budget}"));
    }
    Ok(match result.problem_changes.as_deref() {
        Some([]) => format!("{}, version {}, as it is shipped", problem.name, problem.version),
        Some(changes) => format!("{} with changes: {}", problem.name, changes.join(", ")),
        None => format!("{}, of somebody's own", problem.name),
    })
}

/// The episodes that a stage has to have.
fn expected(result: &RunResult, stage: Stage) -> Option<Vec<Episode>> {
    let Problem { protocol, .. } = &result.problem;
    let seeds = result.policies.get(&stage.to_string())?.seeds(&protocol.seeds);
    Some(result.problem.episodes(stage, &seeds))
}

fn list(result: &RunResult, stages: &[(Stage, Vec<Row>)]) -> Found {
    let names: Vec<_> = stages.iter().map(|(stage, _)| *stage).collect();
    let mut wanted = vec![Stage::Test];
    wanted.extend((result.problem.protocol.train_sample > 0).then_some(Stage::Train));
    for stage in wanted {
        if !names.contains(&stage) {
            return Err(format!("stage {stage} is missing"));
        }
    }
    for (stage, rows) in stages {
        let expected = expected(result, *stage).ok_or(format!("nobody acts in stage {stage}"))?;
        for (number, episode) in expected.iter().enumerate() {
            let asked = asked(episode);
            match rows.get(number) {
                None => return Err(format!("{stage}: {asked} is missing")),
                Some(row) if !is_of(row, episode) => {
                    return Err(format!("{stage}: where {asked} should be, there is {}", shown(row)));
                }
                Some(_) => {}
            }
        }
        if let Some(row) = rows.get(expected.len()) {
            return Err(format!("{stage}: {} is one too many", shown(row)));
        }
    }
    Ok("all that the problem asks for, and no other".into())
}

fn asked(episode: &Episode) -> String {
    format!("{}, {}, {}, seed {}", episode.subject.name, episode.task, episode.period, episode.seed)
}

fn shown(row: &Row) -> String {
    let record = &row.record;
    format!("{}, {}, {}, seed {}", record.building, record.task, record.period, record.seed)
}

/// Whether a row is of an episode. The task's hash has the building's energy scale in it.
fn is_of(row: &Row, episode: &Episode) -> bool {
    let record = &row.record;
    record.building == episode.subject.name.to_string()
        && record.task == episode.task.to_string()
        && record.period == episode.period.to_string()
        && record.seed == episode.seed
        && record.steps_per_hour == episode.steps_per_hour
        && record.steps as u64 == episode.days() * 24 * u64::from(episode.steps_per_hour)
}

fn near(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= ROUNDING * a.abs().max(b.abs())
}

fn scores(stages: &[(Stage, Vec<Row>)]) -> Found {
    for (stage, row) in stages.iter().flat_map(|(stage, rows)| rows.iter().map(move |row| (stage, row))) {
        let wrong = |why: String| Err(format!("{stage}: {}: {why}", shown(row)));
        let record = &row.record;
        if let Some(why) = &row.lost {
            return wrong(format!("it was lost: {why}"));
        }
        let sum = -record.temperature_penalty - record.energy_penalty;
        if !near(record.episode_return, sum) {
            return wrong(format!(
                "the return is {}, and its penalties add up to {sum}",
                record.episode_return
            ));
        }
        let score =
            row.baseline_return.and_then(|baseline| normalized_score(record.episode_return, baseline));
        if score.is_none() || score != row.score {
            return wrong(format!("the score is {:?}, and return over baseline is {score:?}", row.score));
        }
    }
    Ok("returns are the sums of their penalties, and scores are their ratios".into())
}

fn measures(result: &RunResult, stages: &[(Stage, Vec<Row>)]) -> Found {
    match Measures::of(stages) {
        Some(measures) if measures == result.measures => Ok("as the episodes have them".into()),
        _ => Err("they are not those of the episodes".into()),
    }
}

/// Runs a sample, and compares hashes, returns and baselines.
fn run_again(
    folder: &Path,
    result: &RunResult,
    stages: &[(Stage, Vec<Row>)],
    evaluation: &Evaluation<'_>,
    rerun: Rerun,
    progress: &dyn Progress,
) -> Result<Found> {
    let mut all: Vec<(Stage, usize)> =
        stages.iter().flat_map(|(stage, rows)| (0..rows.len()).map(|number| (*stage, number))).collect();
    all.shuffle(&mut ChaCha8Rng::seed_from_u64(rerun.seed));
    all.truncate(rerun.episodes);
    all.sort_by_key(|(stage, number)| (stage.to_string(), *number));
    for (stage, rows) in stages {
        let numbers: Vec<usize> =
            all.iter().filter(|(of, _)| of == stage).map(|(_, number)| *number).collect();
        let Some(episodes) = expected(result, *stage).filter(|_| !numbers.is_empty()) else { continue };
        let about = &result.policies[&stage.to_string()];
        let entrant = match Entrant::of(about, &folder.join(POLICY)) {
            Ok(entrant) => entrant,
            Err(error) => return Ok(Err(error.to_string())),
        };
        let policy = Through::new(entrant.policy(), &result.problem, result.problem.side(*stage));
        let sample: Vec<_> = numbers.iter().map(|number| (*number, &episodes[*number])).collect();
        let outcomes = Mutex::new(Vec::new());
        progress.begin("episodes", sample.len(), sample.iter().map(|(_, episode)| episode.days()).sum());
        evaluation.run(&sample, &policy, progress, &|number, outcome| {
            outcomes.lock().unwrap_or_else(PoisonError::into_inner).push((number, outcome));
            Ok(())
        })?;
        for (number, outcome) in outcomes.into_inner().unwrap_or_else(PoisonError::into_inner) {
            if let Err(why) = compare(&rows[number], &episodes[number], outcome, evaluation, progress)? {
                return Ok(Err(format!("{stage}: {}: {why}", shown(&rows[number]))));
            }
        }
    }
    Ok(Ok(format!("{} of them, to the bit, and their baselines", all.len())))
}

fn compare(
    row: &Row,
    episode: &Episode,
    outcome: Outcome,
    evaluation: &Evaluation<'_>,
    progress: &dyn Progress,
) -> Result<Found> {
    let Finished { record, .. } = match outcome {
        Outcome::Finished(finished) => *finished,
        Outcome::Lost(why) => return Ok(Err(format!("it was lost: {why}"))),
    };
    if record.trajectory_hash != row.record.trajectory_hash {
        let (there, here) = (&row.record.trajectory_hash, &record.trajectory_hash);
        return Ok(Err(format!("it went otherwise: hash {there} there and {here} here")));
    }
    let name = &row.record.policy;
    if (Row { record: crate::Record { policy: name.clone(), ..record.clone() }, ..row.clone() }) != *row {
        let (there, here) = (row.record.episode_return, record.episode_return);
        return Ok(Err(format!("its figures are others: return {there} there and {here} here")));
    }
    let surroundings =
        Surroundings { place: record.place.clone(), climate_zone: record.climate_zone.clone() };
    let cache = tempfile::tempdir().map_err(|source| Error::Io { path: std::env::temp_dir(), source })?;
    let baselines = Baselines::without_shipped(cache.path());
    let here = match baselines.episode_return(evaluation, episode, &surroundings, progress) {
        Err(Error::NoBaseline { why, .. }) => return Ok(Err(format!("its baseline was lost: {why}"))),
        here => here?,
    };
    let there = row.baseline_return.unwrap_or(f64::NAN);
    if near(there, here) {
        return Ok(Ok(String::new()));
    }
    Ok(Err(format!("its baseline is {there} there and {here} here")))
}
