//! The results of an experiment.

use std::fs::File;
use std::path::{Path, PathBuf};

use b2b_benchmark::entry::{RunResult, Stages, read_result};
use b2b_benchmark::problem::Stage;
use b2b_benchmark::{Deviations, Row, read_episodes, read_kept};
use serde::Serialize;
use serde_json::Value;

use crate::definition::{BudgetName, Experiment};
use crate::error::{Result, at};
use crate::folder::Folder;
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

/// The result of a job.
#[derive(Clone, Debug)]
pub struct JobResult {
    /// Key of the job.
    pub key: String,
    /// Name of the agent.
    pub agent: String,
    /// Steps trained.
    pub steps: u64,
    /// Evaluated episodes.
    pub rows: Vec<Row>,
    /// The folder of their evaluation.
    evaluation: PathBuf,
    /// The entry on a benchmark problem.
    pub(crate) entry: Option<(RunResult, Stages)>,
    /// What a measurement printed.
    pub measured: Value,
    /// Wall-clock time, s.
    pub seconds: f64,
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
    /// Reads the results in the folder of an experiment.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io) and those of the benchmark's reader, for a job that is marked as done.
    pub fn read(folder: &Folder, experiment: &Experiment, budget: BudgetName) -> Result<Self> {
        let mut results = Self { budget, done: Vec::new(), failed: Vec::new(), missing: Vec::new() };
        for job in experiment.jobs(budget) {
            match folder.state(&job) {
                None => results.missing.push(job.key),
                Some(state) => match state.error {
                    Some(error) => results.failed.push((job.key, error)),
                    None => results.done.push(JobResult::read(&folder.job(&job), &job, state.seconds)?),
                },
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

    /// Returns the sum of the wall-clock times of the jobs, hours.
    pub fn hours(&self) -> f64 {
        self.done.iter().map(|done| done.seconds).sum::<f64>() / 3600.0
    }

    /// Returns the episodes of an agent with their jobs.
    pub(crate) fn of<'a>(&'a self, agent: &'a str) -> impl Iterator<Item = (&'a JobResult, &'a Row)> {
        let own = self.done.iter().filter(move |done| done.agent == agent);
        own.flat_map(|done| done.rows.iter().map(move |row| (done, row)))
    }
}

impl JobResult {
    fn read(path: &Path, job: &Job, seconds: f64) -> Result<Self> {
        let mut result = Self {
            key: job.key.clone(),
            agent: job.agent().to_owned(),
            steps: job.steps(),
            rows: Vec::new(),
            evaluation: path.join(EVALUATION),
            entry: None,
            measured: Value::Null,
            seconds,
        };
        for action in &job.actions {
            match action {
                Action::Train { .. } => {}
                Action::Evaluate(_) => {
                    let path = result.evaluation.join("episodes.parquet");
                    let rows = read_episodes(File::open(&path).map_err(at(&path))?);
                    result.rows = rows.map_err(|error| at(&path)(std::io::Error::other(error)))?;
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
        let own = self.rows.iter().enumerate().filter(move |(_, row)| is_own(row));
        own.filter_map(|(number, _)| Some(read_kept(&self.evaluation, number)?.deviations))
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
