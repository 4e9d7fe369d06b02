//! Runs jobs as processes of `b2b`.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use b2b_base::aside::{append, write_whole};
use rustix::process::{Pid, Signal, kill_process};
use toml::Table;

use super::arguments;
use crate::error::{Error, Result, at};
use crate::folder::{CONFIG, Folder, JobFolder, MEASURED, State};
use crate::job::{Action, Job};

/// Environment variable with the process that owns a job's command. The command stops when its owner is gone.
pub const OWNER: &str = "B2B_OWNER";
/// Interval at which processes are polled.
const POLL: Duration = Duration::from_millis(50);
/// Number of bytes at the end of a log to search for an error.
const TAIL: u64 = 4000;

/// Runs jobs, several at a time.
pub struct Runner<'a> {
    /// Makes a command that starts `b2b`.
    pub command: fn() -> Command,
    /// The folder of results.
    pub folder: &'a Folder,
    /// Number of jobs at a time, each with one environment process.
    pub parallel: usize,
    /// Returns whether to stop.
    pub interrupted: fn() -> bool,
}

/// How the jobs of a run ended.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ended {
    /// Number of jobs without an error, including jobs from earlier runs.
    pub done: usize,
    /// Number of jobs with an error.
    pub failed: usize,
}

impl Runner<'_> {
    /// Runs the unfinished jobs in order, and returns how all jobs ended. A failed job does not stop the others. `done`
    /// is called with every job that ends and how it ended.
    ///
    /// # Errors
    /// [`Error::Interrupted`], when the processes have written their checkpoints; [`Error::OtherJob`]; [`Error::Io`].
    pub fn run(&self, jobs: &[Job], done: &(dyn Fn(&Job, &State) + Sync)) -> Result<Ended> {
        self.folder.check(jobs)?;
        let left: Vec<&Job> = jobs.iter().filter(|job| !self.folder.is_done(job)).collect();
        self.each(&left, &|job| {
            let state = self.run_job(job)?;
            done(job, &state);
            Ok(())
        })?;
        let done = jobs.iter().filter(|job| self.folder.is_done(job)).count();
        Ok(Ended { done, failed: jobs.len() - done })
    }

    /// Works on the items, `parallel` at a time, and returns the results in the order of the items. Stops starting new
    /// work after an error.
    pub(crate) fn each<T: Sync, R: Send>(
        &self,
        items: &[T],
        work: &(dyn Fn(&T) -> Result<R> + Sync),
    ) -> Result<Vec<R>> {
        let next = AtomicUsize::new(0);
        let worker = || -> Result<Vec<(usize, R)>> {
            let mut results = Vec::new();
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(item) = items.get(index) else { return Ok(results) };
                let result = work(item).inspect_err(|_| next.store(items.len(), Ordering::Relaxed))?;
                results.push((index, result));
            }
        };
        let ended = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..self.parallel.min(items.len())).map(|_| scope.spawn(worker)).collect();
            let join =
                threads.into_iter().map(|thread| thread.join().expect("a thread of the runner panicked"));
            join.collect::<Vec<_>>()
        });
        let mut results: Vec<_> =
            ended.into_iter().collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
        results.sort_by_key(|(index, _)| *index);
        Ok(results.into_iter().map(|(_, result)| result).collect())
    }

    /// Runs the remaining actions of a job, and writes how it ended.
    fn run_job(&self, job: &Job) -> Result<State> {
        let own = self.folder.job(job);
        std::fs::create_dir_all(own.path()).map_err(at(own.path()))?;
        let earlier = self.folder.seconds(job);
        let begun = Instant::now();
        let mut error = None;
        for action in &job.actions[self.folder.actions_done(job)..] {
            let ended = self.act(job, &own, action);
            own.set_seconds(earlier + begun.elapsed().as_secs_f64())?;
            error = ended?;
            if error.is_some() {
                break;
            }
        }
        let state = State { error, seconds: self.folder.seconds(job), actions_sha256: job.actions_sha256() };
        own.set_state(&state)?;
        Ok(state)
    }

    /// Runs an action unless its result exists. Returns why it failed.
    fn act(&self, job: &Job, own: &JobFolder, action: &Action) -> Result<Option<String>> {
        if let Action::Train { agent, config, .. } = action {
            if own.is_trained(agent) {
                return Ok(other_training(own, agent, config));
            }
            own.set_config(config)?;
        }
        let result = matches!(action, Action::Measure(_)).then(|| own.path().join(MEASURED));
        self.command(own.path(), &own.log(), &arguments::of(action, job), result.as_deref())
    }

    /// Runs a command in a folder, and appends it and its output to a log, or writes its output to a result file.
    /// Returns why it failed.
    pub(super) fn command(
        &self,
        path: &Path,
        log: &Path,
        arguments: &[String],
        result: Option<&Path>,
    ) -> Result<Option<String>> {
        let mut file = append(log).map_err(at(log))?;
        writeln!(file, "$ b2b {}", arguments.join(" ")).map_err(at(log))?;
        let begin = file.metadata().map_err(at(log))?.len();
        let mut printed = tempfile::tempfile().map_err(at(path))?;
        let mut command = (self.command)();
        command.args(arguments).current_dir(path).env(OWNER, std::process::id().to_string());
        command.stdin(Stdio::null()).process_group(0);
        command.stdout(printed.try_clone().map_err(at(log))?);
        command.stderr(file.try_clone().map_err(at(log))?);
        let mut child = command.spawn().map_err(at(Path::new("b2b")))?;
        let status = self.wait(&mut child)?;
        let error = if status.success() { None } else { Some(cause(status, log, begin).map_err(at(log))?) };
        printed.rewind().map_err(at(log))?;
        let mut text = Vec::new();
        printed.read_to_end(&mut text).map_err(at(log))?;
        match result.filter(|_| error.is_none()) {
            Some(result) => write_whole(result, &text).map_err(at(result))?,
            None => file.write_all(&text).map_err(at(log))?,
        }
        Ok(error)
    }

    /// Waits for a process, and returns how it ended. An interrupt is passed on, so that a training writes its checkpoint.
    fn wait(&self, child: &mut Child) -> Result<ExitStatus> {
        let mut told = false;
        loop {
            if let Some(status) = child.try_wait().map_err(at(Path::new("b2b")))? {
                return if told { Err(Error::Interrupted) } else { Ok(status) };
            }
            if !told && (self.interrupted)() {
                told = true;
                // The process may just have ended.
                let _ = kill_process(Pid::from_child(child), Signal::TERM);
            }
            std::thread::sleep(POLL);
        }
    }
}

/// Returns why a finished training run is not the job's; `None` if it is. Training runs of one job differ only by seed.
fn other_training(own: &JobFolder, agent: &str, config: &Table) -> Option<String> {
    let but_seed = |mut config: Table| {
        config.remove("seed");
        config
    };
    let before = own.config().map(but_seed);
    (before != Some(but_seed(config.clone()))).then(|| {
        format!(
            "the training in {} has ended with other options than the job has ({CONFIG}); remove the folder {}",
            own.path().join(agent).display(),
            own.path().display()
        )
    })
}

/// Returns why a command failed: its signal, or its error or last line in the log after `begin`.
fn cause(status: ExitStatus, log: &Path, begin: u64) -> std::io::Result<String> {
    if let Some(signal) = status.signal() {
        return Ok(format!("killed by signal {signal}"));
    }
    let mut file = File::open(log)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(begin.max(length.saturating_sub(TAIL))))?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    let last = text.lines().rev().find(|line| !line.trim().is_empty());
    let error = text.lines().rev().find_map(|line| line.strip_prefix("error: "));
    Ok(error.or(last).map_or_else(|| status.to_string(), str::to_owned))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cause_of_a_failure_comes_from_the_last_command() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "error: of an earlier command\n$ b2b train\n").unwrap();
        let begin = file.path().metadata().unwrap().len();
        let cause_of = |status: i32| cause(ExitStatus::from_raw(status), file.path(), begin).unwrap();
        assert_eq!(cause_of(9), "killed by signal 9");
        assert_eq!(cause_of(1 << 8), "exit status: 1");
        std::fs::write(file.path(), "error: of an earlier command\n$ b2b train\nerror: no space\n  help\n")
            .unwrap();
        assert_eq!(cause_of(1 << 8), "no space");
    }
}
