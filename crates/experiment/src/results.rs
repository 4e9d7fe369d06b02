//! The results of an experiment.

use std::time::Duration;

use b2b_env::EpisodeMetrics;
use b2b_evaluate::statistics::Sample;
use b2b_evaluate::{Deviations, EpisodeResult, Scored};
use serde::Serialize;
use serde_json::Value;

use crate::definition::{Budget, Experiment};
use crate::error::Result;
use crate::folder::{Folder, JobResult, State};

/// An episode with its job.
pub(crate) type Ran<'a> = (&'a JobResult, &'a EpisodeResult);

/// The results of the jobs of an experiment.
#[derive(Clone, Debug)]
pub struct Results {
    /// The budget.
    pub budget: Budget,
    /// Jobs with their results, in the order of the experiment.
    pub done: Vec<JobResult>,
    /// Jobs that failed, by key, with the error.
    pub failed: Vec<(String, String)>,
    /// Keys of jobs that have not run.
    pub missing: Vec<String>,
}

/// An episode in `results.json`.
#[derive(Serialize)]
struct Episode<'a> {
    job: &'a str,
    agent: String,
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
    #[serde(flatten)]
    operation: Option<Operation>,
    trajectory_hash: &'a str,
}

/// The indicators of an episode of operation, under BOPTEST's names.
#[derive(Serialize)]
struct Operation {
    cost_tot: Option<f64>,
    ener_tot: Option<f64>,
    tdis_tot: f64,
    pele_tot: Option<f64>,
    baseline_tdis_tot: Option<f64>,
}

impl Results {
    /// Returns empty results under a budget.
    pub fn none(budget: Budget) -> Self {
        Self { budget, done: Vec::new(), failed: Vec::new(), missing: Vec::new() }
    }

    /// Reads the results in an experiment's folder: from each job's own folder or, if that is gone, from what
    /// [`Folder::keep`] kept.
    ///
    /// # Errors
    /// [`Error::OtherJob`](crate::Error::OtherJob); [`Error::Io`](crate::Error::Io) and errors from the benchmark's
    /// reader, for a job that is marked as done.
    pub fn read(folder: &Folder, experiment: &Experiment, budget: &Budget) -> Result<Self> {
        let mut results = Self::none(budget.clone());
        let jobs = experiment.jobs(budget);
        folder.check(&jobs)?;
        for job in jobs {
            match (folder.result(&job, experiment.report)?, folder.job(&job).state()) {
                (Some(result), _) => results.done.push(result),
                (None, Some(State { error: Some(error), .. })) => results.failed.push((job.key, error)),
                (None, _) => results.missing.push(job.key),
            }
        }
        Ok(results)
    }

    /// Returns every episode that was not lost, with measurements and the failed and missing jobs, as JSON, the same
    /// whether jobs ran on one machine or in shards on several.
    pub fn json(&self) -> Value {
        let measured = |done: &JobResult| (!done.measured.is_null()).then(|| done.measured.clone());
        serde_json::json!({
            "budget": self.budget.name,
            "episodes": self.done.iter().flat_map(episodes).collect::<Vec<_>>(),
            "measured": self.done.iter().filter_map(measured).collect::<Vec<_>>(),
            "failed": self.failed,
            "missing": self.missing,
        })
    }

    /// Describes how the versions of results differ from this program's, if they do.
    pub fn outdated(&self) -> Option<String> {
        let all: Vec<(&str, String)> =
            self.done.iter().filter_map(|done| Some((&done.key[..], done.outdated()?))).collect();
        let (key, differences) = all.first()?;
        Some(format!(
            "{} of {} results are of another version, such as {key}: {differences}",
            all.len(),
            self.done.len()
        ))
    }

    /// Returns the sum of the steps trained.
    pub fn steps(&self) -> u64 {
        self.done.iter().map(|done| done.steps).sum()
    }

    /// Returns the sum of the wall-clock times of the jobs.
    pub fn time(&self) -> Duration {
        Duration::from_secs_f64(self.done.iter().map(|done| done.seconds).sum())
    }

    /// Returns the training runs of a policy by name, with the episodes of each.
    pub(crate) fn trainings<'a>(
        &'a self,
        policy: &str,
    ) -> impl Iterator<Item = (&'a JobResult, &'a [EpisodeResult])> {
        let own = move |done: &'a JobResult| {
            let found = done.policies().find(|(name, ..)| name == policy);
            found.map(|(_, rows, _)| (done, rows))
        };
        self.done.iter().filter_map(own)
    }

    /// Returns the episodes of a policy with their jobs.
    pub(crate) fn of<'a>(&'a self, policy: &str) -> impl Iterator<Item = Ran<'a>> {
        self.trainings(policy).flat_map(|(done, rows)| rows.iter().map(move |row| (done, row)))
    }

    /// Returns the distributions of deviations in a policy's episodes, as far as the evaluation keeps them.
    pub(crate) fn deviations<'a>(
        &'a self,
        policy: &str,
        is_own: impl Fn(&EpisodeResult) -> bool,
    ) -> impl Iterator<Item = &'a Deviations> {
        let own = self.done.iter().flat_map(JobResult::policies).filter(move |(name, ..)| name == policy);
        let episodes = own.flat_map(|(_, rows, deviations)| rows.iter().zip(deviations));
        episodes.filter(move |(row, _)| is_own(row)).filter_map(|(_, deviations)| deviations.as_ref())
    }
}

/// Returns the values of episodes that have one.
pub(crate) fn samples<'a>(rows: &[Ran<'a>], value: impl Fn(&'a Scored) -> Option<f64>) -> Vec<Sample<'a>> {
    rows.iter().filter_map(|&(job, row)| Some(job.sample(row, value(row.scored()?)?))).collect()
}

/// Returns the episodes of a job that were not lost.
fn episodes(done: &JobResult) -> Vec<Episode<'_>> {
    let mut episodes = Vec::new();
    for (agent, rows, _) in done.policies() {
        episodes.extend(rows.iter().filter_map(|row| episode(done, agent.clone(), row)));
    }
    episodes
}

fn operation(scored: &Scored) -> Option<Operation> {
    let EpisodeMetrics { cost_tot, ener_tot, tdis_tot, pele_tot, .. } = scored.metrics;
    let baseline_tdis_tot = scored.baseline_discomfort;
    Some(Operation { cost_tot, ener_tot, tdis_tot: tdis_tot?, pele_tot, baseline_tdis_tot })
}

fn episode<'a>(done: &'a JobResult, agent: String, row: &'a EpisodeResult) -> Option<Episode<'a>> {
    let scored = row.scored()?;
    Some(Episode {
        job: &done.key,
        agent,
        steps: done.steps,
        building: &row.info.building,
        task: &row.info.task,
        period: &row.info.period,
        score: scored.score,
        resolved_score: scored.resolved_score,
        episode_return: scored.metrics.episode_return,
        rms_deviation_k: scored.metrics.rms_deviation,
        relative_energy: scored.relative_energy(),
        daily_travel: scored.metrics.daily_travel,
        operation: operation(scored),
        trajectory_hash: &scored.trajectory_hash,
    })
}
