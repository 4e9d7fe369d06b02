//! The results of an experiment.

use std::path::Path;
use std::time::Duration;

use b2b_agent::Agent;
use b2b_benchmark::entry::{RunResult, Stages, read_result};
use b2b_benchmark::problem::Stage;
use b2b_evaluate::{Deviations, Row, read_kept};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::definition::{BudgetName, Experiment, ReportKind};
use crate::error::{Result, at};
use crate::folder::{Folder, State};
use crate::job::{Action, Job};
use crate::runner::{ENTRY, EVALUATION, MEASURED};

/// The results of the jobs of an experiment.
#[derive(Clone, Debug)]
pub struct Results {
    /// The budget.
    pub budget: BudgetName,
    /// Jobs with their results, in the order of the experiment.
    pub done: Vec<JobResult>,
    /// Jobs that failed, by key, with the error.
    pub failed: Vec<(String, String)>,
    /// Keys of jobs that have not run.
    pub missing: Vec<String>,
}

/// The result of a job, as the file of an experiment's jobs keeps it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Evaluated episodes.
    pub rows: Vec<Row>,
    /// Distributions of the deviations of each episode from its targets; empty if the report does not show them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    deviations: Vec<Option<Deviations>>,
    /// The entry on a benchmark problem.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) entry: Option<(RunResult, Stages)>,
    /// What a measurement printed.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    pub measured: Value,
    /// Wall-clock time, s.
    pub seconds: f64,
    /// [`Job::actions_sha256`]; empty in older results.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) actions_sha256: String,
}

/// An episode in `results.json`.
#[derive(Serialize)]
struct Episode<'a> {
    job: &'a str,
    agent: &'a str,
    steps: u64,
    building: &'a str,
    task: &'a str,
    period: &'a str,
    score: Option<f64>,
    resolved_score: Option<f64>,
    episode_return: f64,
    rms_deviation_k: f64,
    relative_energy: Option<f64>,
    daily_travel: f64,
    trajectory_hash: &'a str,
}

impl Results {
    /// Reads the results in the folder of an experiment: those of the jobs' folders and, of jobs without one, those that
    /// [`Folder::keep`] kept.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io) and those of the benchmark's reader, for a job that is marked as done.
    pub fn read(folder: &Folder, experiment: &Experiment, budget: BudgetName) -> Result<Self> {
        let mut results = Self { budget, done: Vec::new(), failed: Vec::new(), missing: Vec::new() };
        let jobs = experiment.jobs(budget);
        folder.check(&jobs)?;
        for job in jobs {
            match (JobResult::find(folder, &job, experiment.report)?, folder.own_state(&job)) {
                (Some(result), _) => results.done.push(result),
                (None, Some(State { error: Some(error), .. })) => results.failed.push((job.key, error)),
                (None, _) => results.missing.push(job.key),
            }
        }
        Ok(results)
    }

    /// Returns every scored episode as JSON: the same from one machine as from shards on several.
    pub fn json(&self) -> Value {
        let measured = |done: &JobResult| (!done.measured.is_null()).then(|| done.measured.clone());
        serde_json::json!({
            "budget": self.budget,
            "episodes": self.done.iter().flat_map(JobResult::episodes).collect::<Vec<_>>(),
            "measured": self.done.iter().filter_map(measured).collect::<Vec<_>>(),
            "failed": self.failed,
            "missing": self.missing,
        })
    }

    /// Returns the sum of the steps trained.
    pub fn steps(&self) -> u64 {
        self.done.iter().map(|done| done.steps).sum()
    }

    /// Returns the sum of the wall-clock times of the jobs.
    pub fn time(&self) -> Duration {
        Duration::from_secs_f64(self.done.iter().map(|done| done.seconds).sum())
    }

    /// Returns the episodes of an agent with their jobs.
    pub(crate) fn of<'a>(&'a self, agent: &'a str) -> impl Iterator<Item = (&'a JobResult, &'a Row)> {
        let own = self.done.iter().filter(move |done| done.agent == agent);
        own.flat_map(|done| done.rows.iter().map(move |row| (done, row)))
    }
}

impl JobResult {
    /// Returns the result of a job for a report, from the job's own folder or as [`Folder::keep`] kept it; `None` if the job is not
    /// done.
    pub(crate) fn find(folder: &Folder, job: &Job, report: ReportKind) -> Result<Option<Self>> {
        match folder.own_state(job) {
            Some(State { error: None, seconds, actions_sha256 }) => {
                let read = Self::read(&folder.job(job), job, seconds, report)?;
                Ok(Some(Self { actions_sha256, ..read }))
            }
            _ => Ok(folder.kept(job).cloned()),
        }
    }

    /// Returns whether it has what a report shows.
    pub(crate) fn serves(&self, report: ReportKind) -> bool {
        report != ReportKind::Weights || self.deviations.len() == self.rows.len()
    }

    fn read(path: &Path, job: &Job, seconds: f64, report: ReportKind) -> Result<Self> {
        let mut result = Self {
            key: job.key.clone(),
            agent: job.agent().to_owned(),
            steps: job.steps(),
            agent_sha256: None,
            machine: String::new(),
            rows: Vec::new(),
            deviations: Vec::new(),
            entry: None,
            measured: Value::Null,
            seconds,
            actions_sha256: String::new(),
        };
        for action in &job.actions {
            match action {
                Action::Train { agent, .. } => {
                    result.agent_sha256 = Some(Agent::read(&path.join(agent))?.sha256().to_owned());
                }
                Action::Evaluate(_) => {
                    let folder = path.join(EVALUATION);
                    result.rows = read_rows(&folder)?;
                    result.machine = read_machine(&folder)?;
                    if report == ReportKind::Weights {
                        let kept = |number| Some(read_kept(&folder, number)?.deviations);
                        result.deviations = (0..result.rows.len()).map(kept).collect();
                    }
                }
                Action::Enter(_) => {
                    let (entry, stages) = read_result(&path.join(ENTRY))?;
                    let test = stages.iter().find(|(stage, _)| *stage == Stage::Test);
                    result.rows = test.map_or_else(Vec::new, |(_, rows)| rows.clone());
                    result.entry = Some((entry, stages));
                }
                Action::Measure(_) => {
                    let path = path.join(MEASURED);
                    let text = std::fs::read_to_string(&path).map_err(at(&path))?;
                    result.measured = serde_json::from_str(&text).map_err(|error| at(&path)(error.into()))?;
                }
            }
        }
        Ok(result)
    }

    /// Returns the distributions of deviations of some episodes, as far as the evaluation keeps them.
    pub(crate) fn deviations<'a>(
        &'a self,
        is_own: impl Fn(&Row) -> bool + 'a,
    ) -> impl Iterator<Item = Deviations> + 'a {
        let own = self.rows.iter().zip(&self.deviations).filter(move |(row, _)| is_own(row));
        own.filter_map(|(_, deviations)| deviations.clone())
    }

    fn episodes(&self) -> Vec<Episode<'_>> {
        self.rows.iter().filter_map(|row| self.episode(row)).collect()
    }

    fn episode<'a>(&'a self, row: &'a Row) -> Option<Episode<'a>> {
        let scored = row.outcome.as_ref().ok()?;
        Some(Episode {
            job: &self.key,
            agent: &self.agent,
            steps: self.steps,
            building: &row.info.building,
            task: &row.info.task,
            period: &row.info.period,
            score: scored.score,
            resolved_score: scored.resolved_score,
            episode_return: scored.metrics.episode_return,
            rms_deviation_k: scored.metrics.rms_deviation,
            relative_energy: scored.relative_energy(),
            daily_travel: scored.metrics.daily_travel,
            trajectory_hash: &scored.trajectory_hash,
        })
    }
}

/// Reads the episodes of an evaluation.
pub(crate) fn read_rows(folder: &Path) -> Result<Vec<Row>> {
    b2b_evaluate::read_rows(folder).map_err(|error| at(folder)(std::io::Error::other(error)))
}

/// Returns the machine that an evaluation ran on.
fn read_machine(folder: &Path) -> Result<String> {
    #[derive(Deserialize)]
    struct Definition {
        machine: String,
    }
    let path = folder.join("evaluation.json");
    let text = std::fs::read_to_string(&path).map_err(at(&path))?;
    let definition: Definition = serde_json::from_str(&text).map_err(|error| at(&path)(error.into()))?;
    Ok(definition.machine)
}
