//! Checks of results by evaluating agents again.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use b2b_agent::Agent;
use b2b_base::{machine, parallel};
use b2b_benchmark::entry::read_result;
use b2b_evaluate::EpisodeResult;

use super::order::Order;
use super::runner::Runner;
use crate::definition::{Budget, Experiment, best_of};
use crate::error::{Error, Result, at};
use crate::folder::{ENTRY, EVALUATION, JobResult, read_rows, test_rows};
use crate::job::{AGENT, Action, Entry, Episodes, Job};

/// Relative difference of scores on machines that do not give the same bits.
const TOLERANCE: f64 = 1e-3;

/// The check of an agent or controller.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// Key of the job, with `, best` for the best agent of a job that evaluates two.
    pub job: String,
    /// Why the results do not match the agent or controller; `None` if they do.
    pub fault: Option<String>,
}

/// An agent or controller with the results to compare with.
struct Subject<'a> {
    name: String,
    policy: Checkable,
    episodes: &'a Episodes,
    /// The entry on a benchmark problem that the episodes belong to.
    entry: Option<&'a Entry>,
    agent_sha256: Option<&'a str>,
    machine: &'a str,
    rows: &'a [EpisodeResult],
}

/// A policy to evaluate again.
enum Checkable {
    /// The folder of an agent.
    Agent(PathBuf),
    /// The name of a controller.
    Controller(String),
}

/// Re-evaluates the experiment's `controllers` and the agents whose folders are available, and compares their episodes
/// with the results that `Folder::keep` kept: bit for bit on a machine that rounds like the one that produced them,
/// otherwise scores within a relative 0.001. With `buildings`, at most that many buildings of each agent are evaluated,
/// evenly spaced over its results. `done` is called with every check. Agents that were entered on a benchmark problem are
/// entered again; entries of built-in policies are left out.
///
/// # Errors
/// [`Error::NoAgents`] if there is neither; the errors of [`Runner::run`].
pub fn check(
    runner: &Runner<'_>,
    experiment: &Experiment,
    budget: &Budget,
    buildings: Option<NonZeroUsize>,
    done: &(dyn Fn(&Checked) + Sync),
) -> Result<Vec<Checked>> {
    let jobs: Vec<Job> = experiment.jobs(budget);
    let kept = jobs.iter().filter_map(|job| Some((job, runner.folder.kept(job)?)));
    let to_check: Vec<Subject<'_>> =
        kept.flat_map(|(job, result)| subjects(runner, experiment, job, result)).collect();
    let all = parallel::map(runner.parallel, &to_check, |subject| -> Result<Checked> {
        let checked = Checked { fault: fault(runner, subject, buildings)?, job: subject.name.clone() };
        done(&checked);
        Ok(checked)
    })?;
    match all.is_empty() {
        true => Err(Error::NoAgents { path: runner.folder.path().to_owned() }),
        false => Ok(all),
    }
}

/// Returns the controller of a job, or its agents whose folders are available.
fn subjects<'a>(
    runner: &Runner<'_>,
    experiment: &Experiment,
    job: &'a Job,
    result: &'a JobResult,
) -> Vec<Subject<'a>> {
    let folder = runner.folder.job(job);
    let episodes = match job.actions.last() {
        Some(Action::Evaluate(episodes) | Action::EvaluateLast(episodes)) => episodes,
        Some(Action::Enter(entry)) => {
            return entered(folder.path(), job, entry, result).into_iter().collect();
        }
        _ => return Vec::new(),
    };
    let policy = match job.policy() {
        AGENT => Checkable::Agent(folder.path().join(result.agent_folder())),
        controller => Checkable::Controller(controller.to_owned()),
    };
    let own = Subject {
        name: job.key.clone(),
        policy,
        episodes,
        entry: None,
        agent_sha256: result.agent_sha256.as_deref(),
        machine: &result.machine,
        rows: &result.rows,
    };
    let best = result.best.as_ref().map(|best| Subject {
        name: best_of(&job.key),
        policy: Checkable::Agent(folder.path().join(AGENT)),
        episodes,
        entry: None,
        agent_sha256: best.agent_sha256.as_deref(),
        machine: &best.machine,
        rows: &best.rows,
    });
    [own].into_iter().chain(best).filter(|subject| subject.policy.is_at_hand(experiment)).collect()
}

/// Returns the agents of an entry, one for each seed; `None` unless all are available.
fn entered<'a>(path: &Path, job: &'a Job, entry: &'a Entry, result: &'a JobResult) -> Option<Subject<'a>> {
    let agent = |action: &Action| match action {
        Action::Train { agent, .. } => Some(path.join(agent)),
        _ => None,
    };
    let agents: Vec<PathBuf> = job.actions.iter().filter_map(agent).collect();
    let are_all = agents.iter().all(|agent| agent.join("agent.json").exists());
    Some(Subject {
        name: job.key.clone(),
        // Results have the hash of the last one.
        policy: Checkable::Agent(agents.last().filter(|_| are_all)?.clone()),
        episodes: &entry.episodes,
        entry: Some(entry),
        agent_sha256: result.agent_sha256.as_deref(),
        machine: &result.machine,
        rows: &result.rows,
    })
}

/// Returns why a result does not match its agent or controller; `None` if it does.
fn fault(
    runner: &Runner<'_>,
    subject: &Subject<'_>,
    buildings: Option<NonZeroUsize>,
) -> Result<Option<String>> {
    let Subject { policy, episodes, entry, .. } = subject;
    let policy = match policy {
        Checkable::Controller(name) => name.clone(),
        Checkable::Agent(path) => {
            if let Some(fault) = other_agent(path, subject.agent_sha256) {
                return Ok(Some(fault));
            }
            let path = entry.map_or_else(|| path.clone(), |entry| path.with_file_name(&entry.policy));
            std::path::absolute(&path).map_err(at(&path))?.to_string_lossy().into_owned()
        }
    };
    let temporary = std::env::temp_dir();
    let again = b2b_base::scratch::folder_in(&temporary, "b2b-check-").map_err(at(&temporary))?;
    let buildings = spread(&episodes.buildings, buildings);
    let is_own = |row: &&EpisodeResult| buildings.contains(&row.info.building);
    let there: Vec<EpisodeResult> = subject.rows.iter().filter(is_own).cloned().collect();
    let order = match entry {
        Some(entry) => {
            let entry = Entry { policy, test: buildings, ..(*entry).clone() };
            Order::Enter { entry, name: "again".into(), out: ENTRY.into() }
        }
        None => Order::evaluate(&policy, &Episodes { buildings, ..(*episodes).clone() }, EVALUATION),
    };
    if let Some(error) =
        runner.carry_out(&order, again.path(), &again.path().join("log.txt"), None, &mut || ())?
    {
        return Ok(Some(error));
    }
    let rows = match entry {
        Some(_) => test_rows(&read_result(&again.path().join(ENTRY))?.1),
        None => read_rows(&again.path().join(EVALUATION))?,
    };
    Ok(difference(&there, &rows, subject.machine == machine::fingerprint()))
}

/// Returns why a folder does not contain the agent of a result; `None` if it does.
fn other_agent(path: &Path, sha256: Option<&str>) -> Option<String> {
    match Agent::read(path) {
        Ok(agent) if sha256 == Some(agent.sha256()) => None,
        Ok(_) => Some(format!("{} is not the agent of the results", path.display())),
        Err(error) => Some(error.to_string()),
    }
}

impl Checkable {
    fn is_at_hand(&self, experiment: &Experiment) -> bool {
        match self {
            Self::Agent(path) => path.join("agent.json").exists(),
            // Next to agents, the reactive controllers are baselines, which `b2b baseline --check` checks.
            Self::Controller(name) => experiment.controllers.contains(name),
        }
    }
}

/// Returns at most `limit` of `all`, evenly spaced.
fn spread(all: &[String], limit: Option<NonZeroUsize>) -> Vec<String> {
    b2b_base::spread::spread(all, limit.map_or(all.len(), NonZeroUsize::get))
}

/// Returns the first difference between the episodes of results and their reruns.
fn difference(there: &[EpisodeResult], here: &[EpisodeResult], bits: bool) -> Option<String> {
    if there.len() != here.len() {
        return Some(format!("{} episodes in the results, {} now", there.len(), here.len()));
    }
    there.iter().zip(here).find_map(|(there, here)| {
        let (Ok(before), Ok(now)) = (&there.outcome, &here.outcome) else {
            return Some(format!("{} was lost", there.info));
        };
        let is_near = match (before.score, now.score) {
            (Some(before), Some(now)) => now == before || (now / before - 1.0).abs() <= TOLERANCE,
            (before, now) => before == now,
        };
        let is_same = is_near && (!bits || before.trajectory_hash == now.trajectory_hash);
        let score =
            |score: Option<f64>| score.map_or_else(|| "no score".to_owned(), |score| score.to_string());
        (!is_same).then(|| {
            format!("{}: {} in the results, {} now", there.info, score(before.score), score(now.score))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_spreads_over_all_buildings() {
        let all: Vec<String> = (0..40).map(|index| index.to_string()).collect();
        let spread = |limit| spread(&all, NonZeroUsize::new(limit));
        assert_eq!(spread(4), ["0", "10", "20", "30"]);
        assert_eq!(spread(3), ["0", "13", "26"]);
        assert_eq!((spread(0), spread(41)), (all.clone(), all.clone()));
    }
}
