//! Verification of a result's folder.

mod rows;
mod sample;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use b2b_base::machine;
use b2b_control::Versions;
use b2b_env::{EpisodeMetrics, MetricValue, Resource, Term};

pub use sample::Sample;

use super::entry_policy::EntryPolicy;
use super::external::External;
use super::measures::Measures;
use super::result::{POLICY, RunResult, Stages, read_result};
use crate::Result;
use crate::problem::{Problem, Stage, WrappedPolicy};
use b2b_evaluate::{Baselines, BuiltIn, SiteInfo};
use b2b_evaluate::{Episode, Evaluation, Outcome, Progress, Row};

/// Relative tolerance for sums in another order.
const ROUNDING: f64 = 1e-9;
/// Relative tolerance of returns and energies on a machine whose libm rounds differently. Without fused multiply-add, returns
/// of a season differ by 4e-9.
pub const TOLERANCE: f64 = 1e-6;

/// The outcome of one check.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// The subject of the check.
    pub name: &'static str,
    /// A description, or the fault.
    pub outcome: CheckOutcome,
}

type CheckOutcome = std::result::Result<String, String>;

/// Verifies a result: checks it as [`check`] does and, if all checks pass, runs a sample of the episodes and their baselines
/// again. They are compared bit for bit on a machine that computes as that of the result does ([`machine::fingerprint`]),
/// and within [`TOLERANCE`] on another.
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
        checks.push(Check { name: "episodes run again", outcome });
    }
    Ok(checks)
}

/// Checks what a result says of itself: format, versions, problem, policies by their hashes, list of episodes, sums and
/// scores, known baselines, measures.
///
/// # Errors
/// [`Error::Install`] if the home folder is unknown; faults of the folder are in a [`Check`].
pub fn check(folder: &Path) -> Result<Vec<Check>> {
    Ok(read_and_check(folder)?.0)
}

/// A result that was read, its rows and its policies by stage.
type Read = (RunResult, Stages, Policies);
type Policies = BTreeMap<String, EntryPolicy>;

fn read_and_check(folder: &Path) -> Result<(Vec<Check>, Option<Read>)> {
    let (result, stages) = match read_result(folder) {
        Ok(read) => read,
        Err(error) => return Ok((vec![Check { name: "folder", outcome: Err(error.to_string()) }], None)),
    };
    let episodes: usize = stages.iter().map(|(_, rows)| rows.len()).sum();
    let policies = policies(folder, &result);
    let baselines = Baselines::open()?;
    let checks = vec![
        Check {
            name: "folder",
            outcome: Ok(format!("{} of {}, {episodes} episodes", result.name, result.problem.name)),
        },
        Check { name: "versions", outcome: versions(&result) },
        Check { name: "problem", outcome: problem(&result) },
        Check { name: "policies", outcome: policies.as_ref().map(described).map_err(Clone::clone) },
        Check { name: "episodes", outcome: episode_list(&result, &stages) },
        Check { name: "scores", outcome: rows::scores(&stages) },
        Check { name: "baselines", outcome: rows::baselines(&result, &stages, &baselines) },
        Check { name: "measures", outcome: measures(&result, &stages) },
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
                return Err(format!("{stage}: the policy is not that of random actions"));
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
    Ok("exactly those of the problem".into())
}

fn near(a: f64, b: f64) -> bool {
    is_near(a, b, ROUNDING)
}

fn is_near(a: f64, b: f64, tolerance: f64) -> bool {
    a == b || (a - b).abs() <= tolerance * a.abs().max(b.abs())
}

fn measures(result: &RunResult, stages: &[(Stage, Vec<Row>)]) -> CheckOutcome {
    match Measures::of(stages) {
        Some(measures) if measures == result.measures => Ok("those of the episodes".into()),
        _ => Err("they differ from those of the episodes".into()),
    }
}

/// Runs a sample again and compares hashes, metrics and baselines.
fn run_again(
    result: &RunResult,
    stages: &[(Stage, Vec<Row>)],
    policies: &Policies,
    evaluation: &Evaluation<'_>,
    sample: Sample,
    progress: &dyn Progress,
) -> Result<CheckOutcome> {
    let all: Vec<(Stage, usize)> =
        stages.iter().flat_map(|(stage, rows)| (0..rows.len()).map(|number| (*stage, number))).collect();
    let drawn = sample.draw(all.len());
    let accuracy = Accuracy::on(&result.machine);
    let mut external = None;
    for (stage, rows) in stages {
        let of_stage = drawn.iter().map(|index| all[*index]).filter(|(of, _)| of == stage);
        let numbers: Vec<usize> = of_stage.map(|(_, number)| number).collect();
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
        let policy = WrappedPolicy::new(policy.policy(), &result.problem, result.problem.side(*stage));
        let chosen: Vec<_> = numbers.iter().map(|number| (*number, &episodes[*number])).collect();
        let outcomes = Mutex::new(Vec::new());
        progress.begin("episodes", chosen.len(), chosen.iter().map(|(_, episode)| episode.days()).sum());
        evaluation.run(&chosen, &policy, progress, &|number, outcome| {
            outcomes.lock().unwrap_or_else(PoisonError::into_inner).push((number, outcome));
            Ok(())
        })?;
        for (number, outcome) in outcomes.into_inner().unwrap_or_else(PoisonError::into_inner) {
            let (row, episode) = (&rows[number], &episodes[number]);
            if let Err(why) = compare(row, episode, outcome, accuracy, evaluation, progress)? {
                return Ok(Err(format!("{stage}: {}: {why}", row.info)));
            }
        }
    }
    let (size, total) = (drawn.len(), all.len());
    if let Some(name) = external {
        return Ok(Ok(format!(
            "not run again: the policy `{name}` is a program of its author; the baselines of {size} of {total} agree {accuracy}"
        )));
    }
    let power = sample.power(size, total);
    Ok(Ok(format!("{size} of {total} agree {accuracy}, and so do their baselines; {power}")))
}

/// How exactly episodes that ran again are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Accuracy {
    /// Bit for bit: this machine computes as that of the result does.
    Bits,
    /// Within [`TOLERANCE`]: libm or instruction set differ.
    Tolerance,
}

impl Accuracy {
    fn on(machine_of_result: &str) -> Self {
        if machine_of_result == machine::fingerprint() { Self::Bits } else { Self::Tolerance }
    }

    fn same(self, there: f64, here: f64) -> bool {
        match self {
            Self::Bits => there == here,
            Self::Tolerance => is_near(there, here, TOLERANCE),
        }
    }
}

impl std::fmt::Display for Accuracy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Bits => f.write_str("bit for bit"),
            Self::Tolerance => {
                write!(f, "within a relative {TOLERANCE:e} (the result is from a different kind of machine)")
            }
        }
    }
}

fn compare(
    row: &Row,
    episode: &Episode,
    outcome: Outcome,
    accuracy: Accuracy,
    evaluation: &Evaluation<'_>,
    progress: &dyn Progress,
) -> Result<CheckOutcome> {
    let (mut here, step_rewards, there) = match (outcome, row.outcome.clone()) {
        (Ok(finished), Ok(there)) => (finished.record, finished.step_rewards, there),
        (Err(lost), _) | (_, Err(lost)) => return Ok(Err(format!("it was lost: {lost}"))),
    };
    // The name of the policy is that of the user's file.
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
        return Ok(Err("the distribution of its step rewards differs from that of the rerun".into()));
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
    compare_baseline(row, episode, &here.info.site(), evaluation, progress)
}

/// Runs the baseline of an episode again and compares it.
fn compare_baseline(
    row: &Row,
    episode: &Episode,
    site: &SiteInfo,
    evaluation: &Evaluation<'_>,
    progress: &dyn Progress,
) -> Result<CheckOutcome> {
    let Ok(there) = &row.outcome else { return Ok(Err("it was lost".into())) };
    let cache = tempfile::tempdir()
        .map_err(|source| b2b_evaluate::Error::Io { path: std::env::temp_dir(), source })?;
    let baselines = Baselines::without_shipped(cache.path());
    let baseline = match baselines.baseline(evaluation, episode, site, progress) {
        Err(b2b_evaluate::Error::NoBaseline { why, .. }) => {
            return Ok(Err(format!("its baseline was lost: {why}")));
        }
        baseline => baseline?,
    };
    let returns = (there.baseline_return.unwrap_or(f64::NAN), baseline.episode_return);
    let energies = (there.baseline_energy.unwrap_or(f64::NAN), baseline.energy);
    for (what, (there, here)) in [("return", returns), ("energy", energies)] {
        // The shipped baselines may be from another kind of machine than the result.
        if !is_near(there, here, TOLERANCE) {
            return Ok(Err(format!(
                "the {what} of its baseline is {there} in the result and {here} in the rerun"
            )));
        }
    }
    Ok(Ok(String::new()))
}

/// Returns the first metric that differs: all of them bit for bit, or those that are averages within the tolerance.
fn different_metric(
    there: &EpisodeMetrics,
    here: &EpisodeMetrics,
    accuracy: Accuracy,
) -> Option<(&'static str, f64, f64)> {
    let values = |metrics: &EpisodeMetrics| {
        [
            ("return", Some(metrics.episode_return)),
            ("temperature penalty", Some(metrics.temperature_penalty)),
            ("energy penalty", Some(metrics.energy_penalty)),
            ("energy", metrics.used(Resource::ENERGY)),
            ("RMS deviation", Some(metrics.rms_deviation)),
            ("mean absolute deviation", Some(metrics.mean_abs_deviation)),
            ("discomfort", Some(metrics.discomfort)),
            ("cost", metrics.terms.get(Term::Cost)),
            ("emissions", metrics.terms.get(Term::Emissions)),
        ]
    };
    let mut pairs = values(there).into_iter().zip(values(here));
    let found = pairs.find_map(|((name, there), (_, here))| {
        different(name, there, here, |there, here| accuracy.same(there, here))
    });
    let other = || {
        EpisodeMetrics::columns().find_map(|column| {
            let [there, here] = [there, here].map(|metrics| column.get(metrics).map(MetricValue::as_f64));
            different(column.name, there, here, |there, here| there == here)
        })
    };
    found.or_else(|| (accuracy == Accuracy::Bits).then(other).flatten())
}

/// Returns a metric with its values if they differ. A result may be from before a metric.
fn different(
    name: &'static str,
    there: Option<f64>,
    here: Option<f64>,
    is_same: impl Fn(f64, f64) -> bool,
) -> Option<(&'static str, f64, f64)> {
    let (there, here) = (there?, here.unwrap_or(f64::NAN));
    (!is_same(there, here)).then_some((name, there, here))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_compared_on_the_same_kind_of_machine_and_values_on_another() {
        assert_eq!(Accuracy::on(&machine::fingerprint()), Accuracy::Bits);
        assert_eq!(Accuracy::on("x86_64, glibc 2.17"), Accuracy::Tolerance);
        let there =
            EpisodeMetrics { episode_return: -100.0, temperature_penalty: 100.0, ..Default::default() };
        let near = EpisodeMetrics { episode_return: -100.0 * (1.0 + 4e-9), ..there.clone() };
        let far = EpisodeMetrics { episode_return: -100.01, ..there.clone() };
        let different = |here: &EpisodeMetrics, accuracy| different_metric(&there, here, accuracy);
        assert_eq!(different(&there, Accuracy::Bits), None);
        assert_eq!(different(&near, Accuracy::Bits).unwrap().0, "return");
        assert_eq!(different(&near, Accuracy::Tolerance), None);
        assert_eq!(different(&far, Accuracy::Tolerance).unwrap().0, "return");
        let travels = EpisodeMetrics { daily_travel: 1.0, ..there.clone() };
        assert_eq!(different(&travels, Accuracy::Bits), Some(("daily_travel", 0.0, 1.0)));
        let mut younger = EpisodeMetrics { occupied_too_cold: Some(0.5), ..there.clone() };
        younger.terms.set(Term::Heating, 2.0);
        assert_eq!(different(&younger, Accuracy::Bits), None, "the result is from before these metrics");
        assert_eq!(different_metric(&younger, &there, Accuracy::Bits).unwrap().0, "heating_wh_m2");
    }
}
