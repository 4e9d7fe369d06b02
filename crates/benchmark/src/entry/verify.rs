//! Verification of a result's folder.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use b2b_env::EpisodeMetrics;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::entry_policy::EntryPolicy;
use super::measures::Measures;
use super::result::{POLICY, RunResult, read_result};
use crate::evaluation::{Episode, EpisodeInfo, Evaluation, Outcome, Progress, Row};
use crate::problem::{Problem, Stage, WrappedPolicy};
use crate::scores::Baseline;
use crate::versions::Versions;
use crate::{Baselines, Error, Result};

/// Relative tolerance for sums in another order.
const ROUNDING: f64 = 1e-9;

/// The outcome of one check.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What was checked.
    pub name: &'static str,
    /// A description, or the fault.
    pub outcome: CheckOutcome,
}

/// A random sample of episodes to run again.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Number of episodes.
    pub episodes: usize,
    /// Seed of the sample.
    pub seed: u64,
}

type CheckOutcome = std::result::Result<String, String>;

/// Checks a result: format, versions, problem, list of episodes, sums and scores, measures. If all pass, runs a sample of
/// the episodes and their baselines again and compares them bit for bit.
///
/// # Errors
/// Those of [`Evaluation::run`]; faults of the folder are in a [`Check`].
pub fn verify(
    folder: &Path,
    evaluation: &Evaluation<'_>,
    sample: Sample,
    progress: &dyn Progress,
) -> Result<Vec<Check>> {
    let (result, stages) = match read_result(folder) {
        Ok(read) => read,
        Err(error) => return Ok(vec![Check { name: "folder", outcome: Err(error.to_string()) }]),
    };
    let episodes: usize = stages.iter().map(|(_, rows)| rows.len()).sum();
    let mut checks = vec![
        Check {
            name: "folder",
            outcome: Ok(format!("{} of {}, {episodes} episodes", result.name, result.problem.name)),
        },
        Check { name: "versions", outcome: versions(&result) },
        Check { name: "problem", outcome: problem(&result) },
        Check { name: "episodes", outcome: episode_list(&result, &stages) },
        Check { name: "scores", outcome: scores(&stages) },
        Check { name: "measures", outcome: measures(&result, &stages) },
    ];
    if sample.episodes > 0 && checks.iter().all(|check| check.outcome.is_ok()) {
        let outcome = run_again(folder, &result, &stages, evaluation, sample, progress)?;
        checks.push(Check { name: "episodes run again", outcome });
    }
    Ok(checks)
}

fn versions(result: &RunResult) -> CheckOutcome {
    let here = Versions::current();
    match result.versions.differences(&here) {
        None => Ok(format!("dataset {}, EnergyPlus {}", here.generator, here.engine)),
        Some(differences) => Err(differences),
    }
}

fn problem(result: &RunResult) -> CheckOutcome {
    let problem = &result.problem;
    problem.check().map_err(|error| error.to_string())?;
    if problem.hash() != result.problem_hash {
        return Err("the problem does not have the hash that is given".into());
    }
    if problem.changes() != result.problem_changes {
        return Err(format!("the changes to {} are not those that are listed", problem.name));
    }
    let budget = problem.protocol.training_steps;
    if let Some(steps) = result.training_steps.filter(|steps| *steps > budget) {
        return Err(format!("it was trained for {steps} steps; the budget is {budget}"));
    }
    Ok(match result.problem_changes.as_deref() {
        Some([]) => format!("{}, version {}, unchanged", problem.name, problem.version),
        Some(changes) => format!("{} with changes: {}", problem.name, changes.join(", ")),
        None => format!("{}, a custom problem", problem.name),
    })
}

/// Returns the episodes that a stage must contain.
fn expected(result: &RunResult, stage: Stage) -> Option<Vec<Episode>> {
    let Problem { protocol, .. } = &result.problem;
    let seeds = result.policies.get(&stage.to_string())?.seeds(&protocol.seeds);
    Some(result.problem.episodes(stage, &seeds))
}

fn episode_list(result: &RunResult, stages: &[(Stage, Vec<Row>)]) -> CheckOutcome {
    let names: Vec<_> = stages.iter().map(|(stage, _)| *stage).collect();
    let mut wanted = vec![Stage::Test];
    wanted.extend((result.problem.protocol.train_sample > 0).then_some(Stage::Train));
    for stage in wanted {
        if !names.contains(&stage) {
            return Err(format!("stage {stage} is missing"));
        }
    }
    for (stage, rows) in stages {
        let expected = expected(result, *stage).ok_or(format!("no policy for stage {stage}"))?;
        for (number, episode) in expected.iter().enumerate() {
            match rows.get(number) {
                None => return Err(format!("{stage}: {episode} is missing")),
                Some(row) if !is_of(row, episode) => {
                    return Err(format!("{stage}: expected {episode}, found {}", row.info));
                }
                Some(_) => {}
            }
        }
        if let Some(row) = rows.get(expected.len()) {
            return Err(format!("{stage}: {} is not part of the problem", row.info));
        }
    }
    Ok("exactly those of the problem".into())
}

/// Returns whether a row is that of an episode. Task hashes are not compared: they include the building's energy scale.
fn is_of(row: &Row, episode: &Episode) -> bool {
    let EpisodeInfo { building, task, period, seed, steps_per_hour, .. } = &row.info;
    *building == episode.subject.name.to_string()
        && *task == episode.task.to_string()
        && *period == episode.period.to_string()
        && *seed == episode.seed
        && *steps_per_hour == episode.steps_per_hour
        && row.metrics().is_none_or(|metrics| metrics.steps as u64 == episode.steps())
}

fn near(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= ROUNDING * a.abs().max(b.abs())
}

fn scores(stages: &[(Stage, Vec<Row>)]) -> CheckOutcome {
    for (stage, row) in stages.iter().flat_map(|(stage, rows)| rows.iter().map(move |row| (stage, row))) {
        score(row).map_err(|why| format!("{stage}: {}: {why}", row.info))?;
    }
    Ok("returns are the sums of their penalties, and scores are the ratios of returns".into())
}

fn score(row: &Row) -> std::result::Result<(), String> {
    let scored = row.outcome.as_ref().map_err(|lost| format!("it was lost: {lost}"))?;
    let EpisodeMetrics { episode_return, temperature_penalty, energy_penalty, .. } = scored.metrics;
    let sum = -temperature_penalty - energy_penalty;
    if !near(episode_return, sum) {
        return Err(format!("the return is {episode_return}; its penalties sum to {sum}"));
    }
    let (Some(baseline_return), Some(energy)) = (scored.baseline_return, scored.baseline_energy) else {
        return Err("its baseline is missing".into());
    };
    let baseline = Baseline { episode_return: baseline_return, energy };
    let score = baseline.score(episode_return);
    if score.is_none() || score != scored.score {
        return Err(format!("the score is {:?}; return over baseline is {score:?}", scored.score));
    }
    let resolved = baseline.resolved_score(episode_return, scored.metrics.steps);
    if resolved.is_none() || resolved != scored.resolved_score {
        return Err(format!("the resolved score is {:?}; expected {resolved:?}", scored.resolved_score));
    }
    Ok(())
}

fn measures(result: &RunResult, stages: &[(Stage, Vec<Row>)]) -> CheckOutcome {
    match Measures::of(stages) {
        Some(measures) if measures == result.measures => Ok("those of the episodes".into()),
        _ => Err("they differ from those of the episodes".into()),
    }
}

/// Runs a sample again and compares hashes, metrics and baselines.
fn run_again(
    folder: &Path,
    result: &RunResult,
    stages: &[(Stage, Vec<Row>)],
    evaluation: &Evaluation<'_>,
    sample: Sample,
    progress: &dyn Progress,
) -> Result<CheckOutcome> {
    let mut all: Vec<(Stage, usize)> =
        stages.iter().flat_map(|(stage, rows)| (0..rows.len()).map(|number| (*stage, number))).collect();
    all.shuffle(&mut ChaCha8Rng::seed_from_u64(sample.seed));
    all.truncate(sample.episodes);
    all.sort_by_key(|(stage, number)| (stage.to_string(), *number));
    for (stage, rows) in stages {
        let numbers: Vec<usize> =
            all.iter().filter(|(of, _)| of == stage).map(|(_, number)| *number).collect();
        let Some(episodes) = expected(result, *stage).filter(|_| !numbers.is_empty()) else { continue };
        let description = &result.policies[&stage.to_string()];
        let policy = match EntryPolicy::of(description, &folder.join(POLICY)) {
            Ok(policy) => policy,
            Err(error) => return Ok(Err(error.to_string())),
        };
        let policy = WrappedPolicy::new(policy.policy(), &result.problem, result.problem.side(*stage));
        let chosen: Vec<_> = numbers.iter().map(|number| (*number, &episodes[*number])).collect();
        let outcomes = Mutex::new(Vec::new());
        progress.begin("episodes", chosen.len(), chosen.iter().map(|(_, episode)| episode.days()).sum());
        evaluation.run(&chosen, &policy, progress, &|number, outcome| {
            outcomes.lock().unwrap_or_else(PoisonError::into_inner).push((number, outcome));
            Ok(())
        })?;
        for (number, outcome) in outcomes.into_inner().unwrap_or_else(PoisonError::into_inner) {
            if let Err(why) = compare(&rows[number], &episodes[number], outcome, evaluation, progress)? {
                return Ok(Err(format!("{stage}: {}: {why}", rows[number].info)));
            }
        }
    }
    Ok(Ok(format!("{} of them agree bit for bit, and so do their baselines", all.len())))
}

fn compare(
    row: &Row,
    episode: &Episode,
    outcome: Outcome,
    evaluation: &Evaluation<'_>,
    progress: &dyn Progress,
) -> Result<CheckOutcome> {
    let mut here = match outcome {
        Ok(finished) => finished.record,
        Err(lost) => return Ok(Err(format!("it was lost: {lost}"))),
    };
    // The name of the policy is that of the user's file.
    here.info.policy.clone_from(&row.info.policy);
    let there = match row.outcome.clone() {
        Ok(there) => there,
        Err(lost) => return Ok(Err(format!("it was lost: {lost}"))),
    };
    if here.trajectory_hash != there.trajectory_hash {
        let (there, here) = (&there.trajectory_hash, &here.trajectory_hash);
        return Ok(Err(format!("its trajectory differs: hash {there} there and {here} here")));
    }
    if here.info != row.info || here.metrics != there.metrics {
        let (there, here) = (there.metrics.episode_return, here.metrics.episode_return);
        return Ok(Err(format!("its metrics differ: return {there} there and {here} here")));
    }
    let site = here.info.site();
    let cache = tempfile::tempdir().map_err(|source| Error::Io { path: std::env::temp_dir(), source })?;
    let baselines = Baselines::without_shipped(cache.path());
    let baseline = match baselines.baseline(evaluation, episode, &site, progress) {
        Err(Error::NoBaseline { why, .. }) => return Ok(Err(format!("its baseline was lost: {why}"))),
        baseline => baseline?,
    };
    let returns = (there.baseline_return.unwrap_or(f64::NAN), baseline.episode_return);
    let energies = (there.baseline_energy.unwrap_or(f64::NAN), baseline.energy);
    for (what, (there, here)) in [("return", returns), ("energy", energies)] {
        if !near(there, here) {
            return Ok(Err(format!("the {what} of its baseline is {there} there and {here} here")));
        }
    }
    Ok(Ok(String::new()))
}
