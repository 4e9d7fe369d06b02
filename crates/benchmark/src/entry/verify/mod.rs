//! Verification of a result's folder.

mod accuracy;
mod rows;
mod sample;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use b2b_control::Versions;

use accuracy::{Accuracy, different_metric};
pub use sample::Sample;

use super::entry_policy::{EntryPolicy, PolicyDescription};
use super::external::External;
use super::result::{POLICY, RunResult, Stages, read_result};
use super::violation::violation_of;
use crate::Result;
use crate::problem::{Problem, Stage, WrappedPolicy};
use b2b_evaluate::{Baseline, Baselines, BuiltIn, SiteInfo};
use b2b_evaluate::{EpisodePlan, EpisodeResult, Evaluation, Finished, Outcome, Progress, sequences};

/// Relative tolerance for sums computed in another order.
const ROUNDING: f64 = 1e-9;
/// Relative tolerance of sums and means from machines that round differently. Without fused multiply-add, returns of a
/// season differ by 4e-9.
pub const TOLERANCE: f64 = 1e-6;

/// The outcome of one check.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// The subject of the check.
    pub name: &'static str,
    /// A description, or the fault.
    pub outcome: CheckOutcome,
    /// Whether the episodes were not verified, because the policy that ran them is not in the result.
    pub unverified: bool,
}

impl Check {
    fn new(name: &'static str, outcome: CheckOutcome) -> Self {
        Self { name, outcome, unverified: false }
    }

    /// Returns whether the check verified its subject and found no fault.
    pub fn passed(&self) -> bool {
        self.outcome.is_ok() && !self.unverified
    }
}

type CheckOutcome = std::result::Result<String, String>;

/// Verifies a result: runs the checks of [`check`] and, if all of them pass, reruns a sample of the episodes and their
/// baselines; of a policy that keeps its memory, a sample of the [`sequences`]. Episodes are compared bit for bit on a
/// machine that rounds like the one that produced the result ([`fingerprint`](b2b_base::machine::fingerprint)), and
/// within [`TOLERANCE`] on another; baselines always within [`TOLERANCE`].
///
/// # Errors
/// The errors of [`check`] and [`Evaluation::run`]; faults of the folder are in a [`Check`].
pub fn verify(
    folder: &Path,
    evaluation: &Evaluation<'_>,
    sample: Sample,
    progress: &dyn Progress,
) -> Result<Vec<Check>> {
    let (mut checks, read) = read_and_check(folder)?;
    if let Some((result, stages, policies)) = read
        && checks.iter().all(|check| check.outcome.is_ok())
    {
        let outcome = run_again(&result, &stages, &policies, evaluation, sample, progress)?;
        let unverified = outcome.is_ok() && result.external().is_some();
        checks.push(Check { name: "episodes run again", outcome, unverified });
    }
    Ok(checks)
}

/// Checks a result against its own contents: format, versions, problem, hashes of policies, list of episodes, sums and
/// scores, known baselines, measures.
///
/// # Errors
/// [`Error::Install`](b2b_evaluate::Error::Install) if the home folder is unknown; faults of the folder are in a
/// [`Check`].
pub fn check(folder: &Path) -> Result<Vec<Check>> {
    Ok(read_and_check(folder)?.0)
}

/// A result with its rows and its policies by stage.
type Read = (RunResult, Stages, Policies);
type Policies = BTreeMap<String, EntryPolicy>;

fn read_and_check(folder: &Path) -> Result<(Vec<Check>, Option<Read>)> {
    let (result, stages) = match read_result(folder) {
        Ok(read) => read,
        Err(error) => return Ok((vec![Check::new("folder", Err(error.to_string()))], None)),
    };
    let episodes: usize = stages.iter().map(|(_, rows)| rows.len()).sum();
    let policies = policies(folder, &result);
    let baselines = Baselines::open()?;
    let named = format!("{} of {}, {episodes} episodes", result.name, result.problem.name);
    let checks = vec![
        Check::new("folder", Ok(named)),
        Check::new("versions", versions(&result)),
        Check::new("problem", problem(&result)),
        Check::new("policies", policies.as_ref().map(described).map_err(Clone::clone)),
        Check::new("episodes", episode_list(&result, &stages)),
        Check::new("scores", rows::scores(&stages)),
        Check::new("baselines", rows::baselines(&result, &stages, &baselines)),
        Check::new("measures", measures(&result, &stages)),
    ];
    Ok((checks, policies.ok().map(|policies| (result, stages, policies))))
}

/// Reads the policies of every stage, whose files must have the hashes that the result gives.
fn policies(folder: &Path, result: &RunResult) -> std::result::Result<Policies, String> {
    let mut policies = Policies::new();
    for (stage, description) in &result.policies {
        let policy = EntryPolicy::of(description, &folder.join(POLICY)).map_err(|error| error.to_string())?;
        if policy.description() != *description {
            return Err(format!("{stage}: the description of the policy does not match its files"));
        }
        let stage_of = stage.parse::<Stage>()?;
        match stage_of {
            Stage::Untrained if *description != EntryPolicy::BuiltIn(BuiltIn::random()).description() => {
                return Err(format!("{stage}: the policy does not act at random"));
            }
            Stage::Adapted(steps) if !result.problem.protocol.adaptation.contains(&steps) => {
                return Err(format!("{stage}: the problem has no scores after {steps} steps"));
            }
            _ => {}
        }
        let episodes = expected(result, stage_of).unwrap_or_default();
        if let Some(missing) = policy.missing(&episodes) {
            return Err(format!("{stage}: the policy `{missing}` is missing"));
        }
        if let Some(why) = violation_of(&policy, &result.problem, stage_of, result.training_steps) {
            return Err(format!("{stage}: {why}"));
        }
        policies.insert(stage.clone(), policy);
    }
    Ok(policies)
}

fn described(policies: &Policies) -> String {
    let files: usize = policies.values().map(|policy| policy.files().len()).sum();
    format!("{} stages, {files} files with the given SHA-256", policies.len())
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
        return Err("the problem does not match its hash".into());
    }
    if let Some(question) =
        Problem::all().iter().find(|known| known.name == problem.name).map(|known| &known.question)
        && *question != problem.question
    {
        return Err(format!("its question is not {}'s: {}", problem.name, problem.question));
    }
    if problem.changes() != result.problem_changes {
        return Err(format!("the changes to {} do not match the listed changes", problem.name));
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
fn expected(result: &RunResult, stage: Stage) -> Option<Vec<EpisodePlan>> {
    let Problem { protocol, .. } = &result.problem;
    let seeds = result.policies.get(&stage.to_string())?.seeds(&protocol.seeds);
    Some(result.problem.episodes(stage, &seeds))
}

fn episode_list(result: &RunResult, stages: &[(Stage, Vec<EpisodeResult>)]) -> CheckOutcome {
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
                Some(row) if !rows::is_of(row, episode) => {
                    return Err(format!("{stage}: expected {episode}, found {}", row.info));
                }
                Some(_) => {}
            }
        }
        if let Some(row) = rows.get(expected.len()) {
            return Err(format!("{stage}: {} is not part of the problem", row.info));
        }
    }
    counts(result, stages)?;
    Ok("exactly the episodes of the problem".into())
}

/// Checks the stated seeds and numbers of episodes of every stage.
fn counts(result: &RunResult, stages: &[(Stage, Vec<EpisodeResult>)]) -> std::result::Result<(), String> {
    let seeds = |policy: &PolicyDescription| policy.seeds(&result.problem.protocol.seeds);
    let seeds: BTreeMap<_, _> =
        result.policies.iter().map(|(stage, policy)| (stage.clone(), seeds(policy))).collect();
    if seeds != result.seeds {
        return Err(format!("the stated seeds are {:?}, but the policies have {seeds:?}", result.seeds));
    }
    let episodes: BTreeMap<_, _> =
        stages.iter().map(|(stage, rows)| (stage.to_string(), rows.len())).collect();
    if episodes != result.episodes {
        return Err(format!(
            "the numbers of episodes are stated as {:?}; the table has {episodes:?}",
            result.episodes
        ));
    }
    Ok(())
}

fn near(a: f64, b: f64) -> bool {
    is_near(a, b, ROUNDING)
}

fn is_near(a: f64, b: f64, tolerance: f64) -> bool {
    a == b || (a - b).abs() <= tolerance * a.abs().max(b.abs())
}

fn measures(result: &RunResult, stages: &[(Stage, Vec<EpisodeResult>)]) -> CheckOutcome {
    match result.has_measures_of(stages) {
        true => Ok("as the episodes give".into()),
        false => Err("they differ from what the episodes give".into()),
    }
}

/// Returns the policy of a stage behind the spaces of its side.
fn wrapped<'a>(policy: &'a EntryPolicy, result: &'a RunResult, stage: Stage) -> WrappedPolicy<'a> {
    WrappedPolicy::new(policy.policy(), &result.problem, result.problem.side(stage))
}

/// What a sample is drawn from: the episodes of every stage, by number, or whole sequences of a policy that keeps its
/// memory.
fn units(
    result: &RunResult,
    stages: &[(Stage, Vec<EpisodeResult>)],
    policies: &Policies,
) -> Vec<(Stage, Vec<usize>)> {
    let of_stage = |(stage, _): &(Stage, Vec<EpisodeResult>)| {
        let episodes = expected(result, *stage).unwrap_or_default();
        let policy = wrapped(policies.get(&stage.to_string())?, result, *stage);
        let units = sequences(&episodes, &policy).into_iter();
        Some(units.map(|numbers| (*stage, numbers)).collect::<Vec<_>>())
    };
    stages.iter().filter_map(of_stage).flatten().collect()
}

/// Runs a sample again and compares hashes, metrics and baselines.
fn run_again(
    result: &RunResult,
    stages: &[(Stage, Vec<EpisodeResult>)],
    policies: &Policies,
    evaluation: &Evaluation<'_>,
    sample: Sample,
    progress: &dyn Progress,
) -> Result<CheckOutcome> {
    let all = units(result, stages, policies);
    let drawn = sample.draw(all.len());
    let accuracy = Accuracy::on(&result.machine);
    let mut external = None;
    for (stage, rows) in stages {
        let of_stage = drawn.iter().map(|index| &all[*index]).filter(|(of, _)| of == stage);
        let numbers: Vec<usize> = of_stage.flat_map(|(_, numbers)| numbers).copied().collect();
        let Some(episodes) = expected(result, *stage).filter(|_| !numbers.is_empty()) else { continue };
        let policy = &policies[&stage.to_string()];
        if let EntryPolicy::External(External { name, .. }) = policy {
            for number in numbers {
                let (row, episode) = (&rows[number], &episodes[number]);
                let site = row.info.site();
                if let Err(why) = compare_baseline(row, episode, &site, evaluation, progress)? {
                    return Ok(Err(format!("{stage}: {}: {why}", row.info)));
                }
            }
            external.get_or_insert(name);
            continue;
        }
        let chosen: Vec<_> = numbers.iter().map(|number| (*number, &episodes[*number])).collect();
        let policy = wrapped(policy, result, *stage);
        for (number, outcome) in outcomes(&chosen, &policy, evaluation, progress)? {
            let (row, episode) = (&rows[number], &episodes[number]);
            if let Err(why) = compare(row, episode, outcome, accuracy, evaluation, progress)? {
                return Ok(Err(format!("{stage}: {}: {why}", row.info)));
            }
        }
    }
    let (size, total) = (drawn.len(), all.len());
    if let Some(name) = external {
        return Ok(Ok(format!(
            "not run again: the policy `{name}` is the author's own program; the baselines of {size} of {total} agree {accuracy}"
        )));
    }
    let power = sample.power(size, total);
    let what = if all.iter().any(|(_, numbers)| numbers.len() > 1) { " sequences of episodes" } else { "" };
    Ok(Ok(format!("{size} of {total}{what} agree {accuracy}, and so do their baselines; {power}")))
}

/// Runs episodes and returns their outcomes by number.
fn outcomes(
    chosen: &[(usize, &EpisodePlan)],
    policy: &WrappedPolicy<'_>,
    evaluation: &Evaluation<'_>,
    progress: &dyn Progress,
) -> Result<Vec<(usize, Outcome)>> {
    let outcomes = Mutex::new(Vec::new());
    progress.begin("episodes", chosen.len(), chosen.iter().map(|(_, episode)| episode.days()).sum());
    evaluation.run(chosen, policy, progress, &|number, outcome| {
        outcomes.lock().unwrap_or_else(PoisonError::into_inner).push((number, outcome));
        Ok(())
    })?;
    Ok(outcomes.into_inner().unwrap_or_else(PoisonError::into_inner))
}

fn compare(
    row: &EpisodeResult,
    episode: &EpisodePlan,
    outcome: Outcome,
    accuracy: Accuracy,
    evaluation: &Evaluation<'_>,
    progress: &dyn Progress,
) -> Result<CheckOutcome> {
    let (finished, there) = match (outcome, row.outcome.clone()) {
        (Ok(finished), Ok(there)) => (finished, there),
        (Err(lost), _) | (_, Err(lost)) => return Ok(Err(format!("the episode was lost: {lost}"))),
    };
    let Finished { record: mut here, step_rewards, terms, .. } = finished;
    // The policy is named after the user's file.
    here.info.policy.clone_from(&row.info.policy);
    if accuracy == Accuracy::Bits && here.inputs != there.inputs {
        return Ok(Err(format!(
            "its inputs differ: the result has {:?}, the rerun {:?}",
            there.inputs, here.inputs
        )));
    }
    if accuracy == Accuracy::Bits && here.trajectory_hash != there.trajectory_hash {
        let (there, here) = (&there.trajectory_hash, &here.trajectory_hash);
        return Ok(Err(format!("its trajectory differs: the result has hash {there}, the rerun {here}")));
    }
    if accuracy == Accuracy::Bits && step_rewards != there.step_rewards {
        return Ok(Err("the distribution of its step rewards differs from the rerun's".into()));
    }
    if accuracy == Accuracy::Tolerance {
        // It includes the energy scale, which the engine computes.
        here.info.task_hash.clone_from(&row.info.task_hash);
    }
    if here.info != row.info {
        return Ok(Err(format!("the result has {:?}, the rerun {:?}", row.info, here.info)));
    }
    if let Some((name, there, here)) = different_metric(&there.metrics, &here.metrics, accuracy) {
        return Ok(Err(format!(
            "its metrics differ: {name} is {there} in the result and {here} in the rerun"
        )));
    }
    let resource = terms.used(episode.task.resource);
    if let Err(why) = agrees("its resource", there.resource, resource, TOLERANCE) {
        return Ok(Err(why));
    }
    compare_baseline(row, episode, &here.info.site(), evaluation, progress)
}

/// Runs the baseline of an episode again and compares it.
fn compare_baseline(
    row: &EpisodeResult,
    episode: &EpisodePlan,
    site: &SiteInfo,
    evaluation: &Evaluation<'_>,
    progress: &dyn Progress,
) -> Result<CheckOutcome> {
    let Ok(there) = &row.outcome else { return Ok(Err("it was lost".into())) };
    let cache = b2b_base::scratch::folder_in(&std::env::temp_dir(), "b2b-")
        .map_err(|source| b2b_evaluate::Error::Io { path: std::env::temp_dir(), source })?;
    let baselines = Baselines::without_shipped(cache.path());
    let baseline = match baselines.baseline(evaluation, episode, site, progress) {
        Err(b2b_evaluate::Error::NoBaseline { why, .. }) => {
            return Ok(Err(format!("its baseline was lost: {why}")));
        }
        baseline => baseline?,
    };
    // It may be from another kind of machine than the result.
    Ok(agree(there.baseline().as_ref(), &baseline, TOLERANCE).map(|()| String::new()))
}

/// Compares the baseline of a row with the one here.
fn agree(there: Option<&Baseline>, here: &Baseline, tolerance: f64) -> std::result::Result<(), String> {
    let there = there.ok_or("its baseline is missing")?;
    let amounts = |of: &Baseline| [Some(of.episode_return), Some(of.energy), of.resource, of.discomfort];
    let names = ["return", "energy", "resource", "discomfort"];
    for (name, (there, here)) in names.iter().zip(amounts(there).into_iter().zip(amounts(here))) {
        agrees(&format!("the {name} of its baseline"), there, here, tolerance)?;
    }
    Ok(())
}

/// Compares an amount in a result, which may be older than the amount, with the one here.
fn agrees(
    what: &str,
    there: Option<f64>,
    here: Option<f64>,
    tolerance: f64,
) -> std::result::Result<(), String> {
    let Some(there) = there else { return Ok(()) };
    let here = here.unwrap_or(f64::NAN);
    if is_near(there, here, tolerance) {
        return Ok(());
    }
    Err(format!("{what} is {there} in the result; expected {here}"))
}
