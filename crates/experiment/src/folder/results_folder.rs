//! The folder of an experiment's results.

use std::collections::HashMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use b2b_base::aside::write_whole;
use serde::{Deserialize, Serialize};

use super::job_folder::{JobFolder, State, write_json};
use super::job_result::JobResult;
use crate::definition::{Budget, Experiment, ReportKind};
use crate::error::{Error, Result, at};
use crate::job::Job;

/// The folder of an experiment: `experiment.json`, a folder per job under `jobs`, and `jobs.json` with the results of
/// finished jobs, whose folders are then no longer needed.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    identity: Identity,
    /// Results by key: from `jobs.json`, or taken over from another folder.
    kept: Arc<HashMap<String, JobResult>>,
}

/// The experiment and budget whose results a folder has.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Identity {
    /// Name of the experiment, or path of its file.
    experiment: String,
    /// Name of the budget.
    budget: String,
}

const IDENTITY: &str = "experiment.json";
const KEPT: &str = "jobs.json";

impl Folder {
    /// Returns the folder of an experiment with a budget. It need not exist.
    ///
    /// # Errors
    /// [`Error::OtherExperiment`] if it has results of another one; [`Error::Io`].
    pub fn of(path: &Path, source: &str, budget: &Budget) -> Result<Self> {
        let identity = Identity { experiment: source.to_owned(), budget: budget.name.clone() };
        let kept = Arc::new(read_kept(path)?);
        if let Some(other) = read_identity(path)?
            && other != identity
        {
            let name =
                |identity: &Identity| format!("{} with budget {}", identity.experiment, identity.budget);
            return Err(Error::OtherExperiment {
                path: path.to_owned(),
                other: name(&other),
                experiment: name(&identity),
            });
        }
        Ok(Self { path: path.to_owned(), identity, kept })
    }

    /// Creates the folder if there is none.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn create(&self) -> Result<()> {
        std::fs::create_dir_all(&self.path).map_err(at(&self.path))?;
        if read_identity(&self.path)?.is_none() {
            write_json(&self.path.join(IDENTITY), &self.identity)?;
        }
        Ok(())
    }

    /// Writes the results taken over from other folders.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn save(&self) -> Result<()> {
        let mut kept: Vec<JobResult> = self.kept.values().cloned().collect();
        kept.sort_by(|a, b| a.key.cmp(&b.key));
        self.keep(&kept)
    }

    /// Opens a folder with results, and returns it with its experiment, which has the tasks of the budget, and the budget.
    ///
    /// # Errors
    /// [`Error::NoResults`]; [`Error::Io`]; errors from [`Experiment::named`] and [`Experiment::budget`].
    pub fn open(path: &Path) -> Result<(Self, Experiment, Budget)> {
        let identity = read_identity(path)?.ok_or_else(|| Error::NoResults { path: path.to_owned() })?;
        let experiment = Experiment::named(&identity.experiment)?;
        let budget = experiment.budget(&identity.budget)?.clone();
        let experiment = experiment.with_tasks_of(&budget);
        Ok((Self { path: path.to_owned(), identity, kept: Arc::new(read_kept(path)?) }, experiment, budget))
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the folder of a job.
    pub fn job(&self, job: &Job) -> JobFolder {
        self.keyed(&job.key)
    }

    /// Returns the folder of a job, given its key.
    pub(crate) fn keyed(&self, key: &str) -> JobFolder {
        JobFolder::at(self.path.join("jobs").join(key))
    }

    /// Returns how a job ended; `None` if it has not.
    pub fn state(&self, job: &Job) -> Option<State> {
        self.job(job).state().or_else(|| {
            let JobResult { seconds, actions_sha256, .. } = self.kept(job)?;
            Some(State { error: None, seconds: *seconds, actions_sha256: actions_sha256.clone() })
        })
    }

    /// Checks that the results of jobs match their actions, or the leading ones: the experiment's definition may have
    /// changed since.
    ///
    /// # Errors
    /// [`Error::OtherJob`].
    pub fn check(&self, jobs: &[Job]) -> Result<()> {
        let is_other =
            |job: &&Job| self.state(job).is_some_and(|state| job.actions_of(&state.actions_sha256).is_none());
        match jobs.iter().find(is_other) {
            Some(job) => Err(Error::OtherJob { path: self.path.clone(), job: job.key.clone() }),
            None => Ok(()),
        }
    }

    /// Checks that the results of jobs that are done have this program's versions.
    ///
    /// # Errors
    /// [`Error::OtherVersion`]; errors of [`Folder::result`].
    pub fn check_versions(&self, jobs: &[Job], report: ReportKind) -> Result<()> {
        for job in jobs.iter().filter(|job| self.is_done(job)) {
            self.result(job, report)?.map_or(Ok(()), |result| self.check_version(&result))?;
        }
        Ok(())
    }

    fn check_version(&self, result: &JobResult) -> Result<()> {
        result.outdated().map_or(Ok(()), |differences| {
            Err(Error::OtherVersion { path: self.path.clone(), job: result.key.clone(), differences })
        })
    }

    /// Returns how many of a job's leading actions have results in its folder; 0 after a failure.
    pub(crate) fn actions_done(&self, job: &Job) -> usize {
        let ended = self.job(job).state().filter(|state| state.error.is_none());
        ended.and_then(|state| job.actions_of(&state.actions_sha256)).unwrap_or(0)
    }

    /// Returns the wall-clock time that a job has taken so far, s.
    pub(crate) fn seconds(&self, job: &Job) -> f64 {
        let kept = || Some(self.kept(job)?.seconds);
        self.job(job).seconds().or_else(kept).unwrap_or(0.0)
    }

    /// Returns the result of a job for a report, from the job's own folder or from what [`Folder::keep`] kept; `None`
    /// if the job is not done.
    ///
    /// # Errors
    /// Errors from reading the files of a job that is marked as done.
    pub fn result(&self, job: &Job, report: ReportKind) -> Result<Option<JobResult>> {
        let own = JobResult::read(&self.job(job), job, report)?;
        Ok(own.or_else(|| self.kept(job).filter(|_| self.is_done(job)).cloned()))
    }

    /// Returns the result of a job in `jobs.json`.
    pub(crate) fn kept(&self, job: &Job) -> Option<&JobResult> {
        self.kept.get(&job.key)
    }

    /// Keeps the results of jobs in `jobs.json`, one per line, so that their folders are no longer needed. Results of
    /// other jobs in the file follow after them. Shards may call this at the same time.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn keep(&self, results: &[JobResult]) -> Result<()> {
        let path = self.path.join(IDENTITY);
        let lock = File::open(&path).map_err(at(&path))?;
        lock.lock().map_err(at(&path))?;
        let mut others = read_kept(&self.path)?;
        results.iter().for_each(|result| drop(others.remove(&result.key)));
        let mut others: Vec<&JobResult> = others.values().collect();
        others.sort_by(|a, b| a.key.cmp(&b.key));
        let line = |result: &JobResult| serde_json::to_string(result).expect("plain data always serializes");
        let lines: Vec<String> = results.iter().chain(others).map(line).collect();
        let text = format!("[\n{}\n]\n", lines.join(",\n"));
        let path = self.path.join(KEPT);
        // A report of finished jobs does not touch the file.
        if std::fs::read(&path).is_ok_and(|there| there == text.as_bytes()) {
            return Ok(());
        }
        write_whole(&path, text.as_bytes()).map_err(at(&path))
    }

    /// Takes over the results of jobs that are done in the folder of another experiment, and returns their number.
    /// [`Folder::save`] writes them. A job there is the same if it has the same key, options and episodes, and if its
    /// result has what this experiment's report shows.
    ///
    /// # Errors
    /// [`Error::NoResults`] if `other` has no experiment; [`Error::OtherVersion`]; [`Error::Io`] and errors from the
    /// benchmark's reader.
    pub fn reuse(&mut self, jobs: &[Job], report: ReportKind, other: &Path) -> Result<usize> {
        let (other, experiment, budget) = Self::open(other)?;
        let theirs = experiment.jobs(&budget);
        let mut count = 0;
        for job in jobs.iter().filter(|job| theirs.contains(job)) {
            if self.is_done(job) {
                continue;
            }
            let result = other.result(job, report)?;
            if let Some(result) = result.filter(|result| result.serves(report)) {
                other.check_version(&result)?;
                Arc::make_mut(&mut self.kept).insert(job.key.clone(), result);
                count += 1;
            }
        }
        Ok(count)
    }

    /// Returns whether all actions of a job have ended without an error.
    pub fn is_done(&self, job: &Job) -> bool {
        let all = |state: State| {
            state.error.is_none() && job.actions_of(&state.actions_sha256) == Some(job.actions.len())
        };
        self.state(job).is_some_and(all)
    }
}

fn read_identity(folder: &Path) -> Result<Option<Identity>> {
    let path = folder.join(IDENTITY);
    if !path.exists() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(&path).map_err(at(&path))?;
    Ok(Some(serde_json::from_str(&text).map_err(|error| at(&path)(error.into()))?))
}

fn read_kept(folder: &Path) -> Result<HashMap<String, JobResult>> {
    let path = folder.join(KEPT);
    if !path.exists() {
        return Ok(HashMap::new());
    }
    let text = std::fs::read_to_string(&path).map_err(at(&path))?;
    let kept: Vec<JobResult> = serde_json::from_str(&text).map_err(|error| at(&path)(error.into()))?;
    let mut by_key = HashMap::new();
    for result in kept {
        let key = result.key.clone();
        let is_empty = result.rows.is_empty() && result.entry.is_none() && result.measured.is_null();
        let why = if is_empty { "has no results" } else { "is there twice" };
        if is_empty || by_key.insert(key.clone(), result).is_some() {
            return Err(at(&path)(std::io::Error::other(format!("the job {key} {why}; remove its line"))));
        }
    }
    Ok(by_key)
}
