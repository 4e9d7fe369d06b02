//! The result of a job.

use std::path::Path;

use b2b_agent::Agent;
use b2b_benchmark::entry::{RunResult, Stages, read_result};
use b2b_benchmark::problem::Stage;
use b2b_control::Versions;
use b2b_evaluate::statistics::Sample;
use b2b_evaluate::{Deviations, EpisodeResult, read_kept};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::job_folder::{ENTRY, EVALUATION, EVALUATION_LAST, JobFolder, MEASURED, State};
use crate::definition::{ReportKind, best_of};
use crate::error::{Result, at};
use crate::job::{AGENT, Action, Job, LAST_AGENT};

/// The result of a job, as kept in `jobs.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JobResult {
    /// Key of the job.
    pub key: String,
    /// Name of the agent.
    pub agent: String,
    /// Steps trained.
    pub steps: u64,
    /// SHA-256 of the trained agent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub agent_sha256: Option<String>,
    /// Fingerprint of the machine of the evaluation ([`b2b_base::machine`]): machines with the same one give the same
    /// bits. Empty without an evaluation.
    pub machine: String,
    /// Versions that the episodes depend on; `None` in an entry, which states its own, and in older results.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub versions: Option<Versions>,
    /// Evaluated episodes of the agent: of the last agent if the job evaluates two.
    pub rows: Vec<EpisodeResult>,
    /// Distributions of the deviations of each episode from its targets; empty if the report does not show them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub deviations: Vec<Option<Deviations>>,
    /// The best agent of the training by held-out days, if the job evaluates two.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub best: Option<Evaluated>,
    /// The entry on a benchmark problem.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub entry: Option<(RunResult, Stages)>,
    /// Output of a measurement.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    pub measured: Value,
    /// Wall-clock time, s.
    pub seconds: f64,
    /// [`Job::actions_sha256`]; empty in older results.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub actions_sha256: String,
}

/// The evaluation of one agent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Evaluated {
    /// SHA-256 of the agent; `None` for a controller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub agent_sha256: Option<String>,
    /// See [`JobResult::machine`].
    pub machine: String,
    /// Evaluated episodes.
    pub rows: Vec<EpisodeResult>,
    /// See [`JobResult::deviations`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub deviations: Vec<Option<Deviations>>,
}

impl JobResult {
    /// Reads the result of a job from its own folder; `None` if the job is not done.
    pub(super) fn read(folder: &JobFolder, job: &Job, report: ReportKind) -> Result<Option<Self>> {
        let Some(State { error: None, seconds, actions_sha256 }) = folder.state() else { return Ok(None) };
        if job.actions_of(&actions_sha256) != Some(job.actions.len()) {
            return Ok(None);
        }
        let (key, agent) = (job.key.clone(), job.agent().to_owned());
        let mut result = Self { key, agent, steps: job.steps(), seconds, actions_sha256, ..Self::default() };
        for action in &job.actions {
            result.add(folder.path(), job, action, report)?;
        }
        Ok(Some(result))
    }

    /// Adds the result of an action.
    fn add(&mut self, path: &Path, job: &Job, action: &Action, report: ReportKind) -> Result<()> {
        match action {
            Action::Train { agent, .. } => {
                let policy = if job.has_last() { LAST_AGENT } else { &agent[..] };
                self.agent_sha256 = Some(Agent::read(&path.join(policy))?.sha256().to_owned());
            }
            Action::Evaluate(_) if job.has_last() => {
                let agent_sha256 = Some(Agent::read(&path.join(AGENT))?.sha256().to_owned());
                let evaluated = Evaluated::read(&path.join(EVALUATION), report)?;
                self.best = Some(Evaluated { agent_sha256, ..evaluated });
            }
            Action::Evaluate(_) => self.set(&path.join(EVALUATION), report)?,
            Action::EvaluateLast(_) => self.set(&path.join(EVALUATION_LAST), report)?,
            Action::Enter(_) => {
                let (entry, stages) = read_result(&path.join(ENTRY))?;
                self.rows = test_rows(&stages);
                self.machine.clone_from(&entry.machine);
                self.entry = Some((entry, stages));
            }
            Action::Measure(_) => {
                let path = path.join(MEASURED);
                let text = std::fs::read_to_string(&path).map_err(at(&path))?;
                self.measured = serde_json::from_str(&text).map_err(|error| at(&path)(error.into()))?;
            }
        }
        Ok(())
    }

    fn set(&mut self, folder: &Path, report: ReportKind) -> Result<()> {
        let Evaluated { machine, rows, deviations, .. } = Evaluated::read(folder, report)?;
        (self.machine, self.rows, self.deviations) = (machine, rows, deviations);
        self.versions = Some(Definition::read(folder)?.versions);
        Ok(())
    }

    /// Describes how the versions that the episodes depend on differ from this program's, if they are known.
    /// `guideline36` is the baseline of operation alone.
    pub(crate) fn outdated(&self) -> Option<String> {
        let theirs = self.versions.as_ref().or(self.entry.as_ref().map(|(entry, _)| &entry.versions))?;
        let mut here = Versions { package: theirs.package.clone(), ..Versions::current() };
        if !self.rows.iter().any(|row| row.info.task.starts_with("operate")) {
            here.guideline36 = theirs.guideline36;
        }
        theirs.differences(&here)
    }

    /// Returns the folder of the agent whose episodes are [`JobResult::rows`], in the folder of the job.
    pub fn agent_folder(&self) -> &'static str {
        if self.best.is_some() { LAST_AGENT } else { AGENT }
    }

    /// Returns whether it has the data that a report needs.
    pub(super) fn serves(&self, report: ReportKind) -> bool {
        let has_all = self.policies().all(|(_, rows, deviations)| deviations.len() == rows.len());
        report != ReportKind::Weights || has_all
    }

    /// Returns a value of an episode of the job with its agent and seed, by which the seeds of one training differ.
    pub(crate) fn sample<'a>(&'a self, row: &'a EpisodeResult, value: f64) -> Sample<'a> {
        let seeded = self.key.rsplit_once('_').and_then(|(agent, seed)| Some((agent, seed.parse().ok()?)));
        let (agent, seed) = seeded.unwrap_or((&self.key, row.info.seed));
        Sample { agent, seed, ..Sample::of(&row.info, value) }
    }

    /// Returns the policies of the job with their episodes and distributions of deviations.
    pub fn policies(&self) -> impl Iterator<Item = (String, &[EpisodeResult], &[Option<Deviations>])> {
        let best =
            self.best.as_ref().map(|best| (best_of(&self.agent), &best.rows[..], &best.deviations[..]));
        [(self.agent.clone(), &self.rows[..], &self.deviations[..])].into_iter().chain(best)
    }
}

impl Evaluated {
    fn read(folder: &Path, report: ReportKind) -> Result<Self> {
        let (rows, machine) = (read_rows(folder)?, Definition::read(folder)?.machine);
        let mut deviations = Vec::new();
        if report == ReportKind::Weights {
            deviations.extend((0..rows.len()).map(|number| Some(read_kept(folder, number)?.deviations)));
        }
        Ok(Self { agent_sha256: None, machine, rows, deviations })
    }
}

/// Returns the test episodes of an entry.
pub fn test_rows(stages: &Stages) -> Vec<EpisodeResult> {
    let test = stages.iter().find(|(stage, _)| *stage == Stage::Test);
    test.map_or_else(Vec::new, |(_, rows)| rows.clone())
}

/// Reads the episodes of an evaluation.
pub fn read_rows(folder: &Path) -> Result<Vec<EpisodeResult>> {
    b2b_evaluate::read_rows(folder).map_err(|error| at(folder)(std::io::Error::other(error)))
}

/// The machine that an evaluation ran on, and the versions.
#[derive(Deserialize)]
struct Definition {
    machine: String,
    versions: Versions,
}

impl Definition {
    fn read(folder: &Path) -> Result<Self> {
        let path = folder.join("evaluation.json");
        let text = std::fs::read_to_string(&path).map_err(at(&path))?;
        serde_json::from_str(&text).map_err(|error| at(&path)(error.into()))
    }
}

#[cfg(test)]
mod tests {
    use b2b_benchmark::entry::Measures;

    use super::*;

    fn shipped(name: &str) -> String {
        let path = format!("{}/../../results/{name}/jobs.json", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(path).unwrap()
    }

    #[test]
    fn the_seeds_of_a_training_are_of_one_agent() {
        let found = |name: &str, agent: &str| -> Vec<(String, u64)> {
            let results: Vec<JobResult> = serde_json::from_str(&shipped(name)).unwrap();
            let own = results.iter().filter(|result| result.agent == agent);
            let samples = own.map(|result| result.sample(&result.rows[0], 0.0));
            samples.map(|sample| (sample.agent.to_owned(), sample.seed)).collect()
        };
        let training = "generalist/SingleFamilyHouse_constant_winter".to_owned();
        assert_eq!(found("dynamics", "generalist"), [0, 1, 2].map(|seed| (training.clone(), seed)));
        let entered = ["adapt-house-faults", "adapt-office-small-faults"];
        assert_eq!(found("memory", "flat"), entered.map(|problem| (format!("flat/{problem}"), 0)));
    }

    #[test]
    fn measures_of_shipped_entries_follow_from_their_episodes() {
        for name in ["board", "memory"] {
            let results: Vec<JobResult> = serde_json::from_str(&shipped(name)).unwrap();
            let (entry, stages) = results.last().unwrap().entry.as_ref().unwrap();
            let measures = Measures::of(stages, entry.problem.protocol.consecutive());
            assert!(measures.as_ref() == Some(&entry.measures), "{name}");
        }
    }

    #[test]
    fn results_of_other_versions_are_told_apart() {
        let of = |name: &str, change: &dyn Fn(&mut Versions)| {
            let results: Vec<JobResult> = serde_json::from_str(&shipped(name)).unwrap();
            let mut versions = Versions::current();
            change(&mut versions);
            JobResult { versions: Some(versions), ..results[0].clone() }.outdated()
        };
        let older = |versions: &mut Versions| versions.guideline36 -= 1;
        assert!(of("operation", &older).unwrap().starts_with("guideline36 revision"));
        // The baseline of the tracking tasks is the reactive controllers.
        assert_eq!(of("ppo", &older), None);
        assert_eq!(of("ppo", &|versions| versions.package.push('1')), None);
        assert_eq!(
            of("ppo", &|versions| versions.engine = "25.1.0".into()).unwrap().split(' ').next(),
            Some("EnergyPlus")
        );
    }

    #[test]
    fn shipped_results_are_read_and_written_unchanged() {
        for name in ["ppo", "dynamics", "weights", "board"] {
            let text = shipped(name);
            let results: Vec<JobResult> = serde_json::from_str(&text).unwrap();
            let lines: Vec<_> = results.iter().map(|result| serde_json::to_string(result).unwrap()).collect();
            assert!(!results.is_empty() && text == format!("[\n{}\n]\n", lines.join(",\n")), "{name}");
        }
    }
}
