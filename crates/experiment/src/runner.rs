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

use crate::definition::REACTIVE;
use crate::error::{Error, Result, at};
use crate::folder::{Folder, State};
use crate::job::{AGENT, Action, Entry, Episodes, Job};

/// Names in the folder of a job.
const CONFIG: &str = "config.toml";
pub(crate) const ENTRY: &str = "entry";
pub(crate) const EVALUATION: &str = "evaluation";
pub(crate) const MEASURED: &str = "result.json";
/// What a finished training leaves in its folder.
const TRAINED: &str = "summary.json";

/// Environment variable with the process that a command of a job belongs to: the command stops when its owner is gone.
pub const OWNER: &str = "B2B_OWNER";
/// Interval at which processes are polled.
const POLL: Duration = Duration::from_millis(50);
/// Bytes at the end of a log that are searched for an error.
const TAIL: u64 = 4000;

/// Runs jobs, as many at a time as it is told.
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
    /// Number of jobs without an error, including those of earlier runs.
    pub done: usize,
    /// Number of jobs with an error.
    pub failed: usize,
}

impl Runner<'_> {
    /// Runs the jobs that are not done, in their order, and returns how all ended. A failed job does not stop the others.
    /// `done` is called with every job that ends and with how it ended.
    ///
    /// # Errors
    /// [`Error::Interrupted`], when the processes have written their checkpoints; [`Error::OtherJob`]; [`Error::Io`].
    pub fn run(&self, jobs: &[Job], done: &(dyn Fn(&Job, &State) + Sync)) -> Result<Ended> {
        self.folder.check(jobs)?;
        let left: Vec<&Job> = jobs.iter().filter(|job| !self.folder.is_done(job)).collect();
        let next = AtomicUsize::new(0);
        let work = || -> Result<()> {
            while let Some(job) = left.get(next.fetch_add(1, Ordering::Relaxed)) {
                let state = self.run_job(job)?;
                done(job, &state);
            }
            Ok(())
        };
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..self.parallel.min(left.len())).map(|_| scope.spawn(work)).collect();
            let ended =
                threads.into_iter().map(|thread| thread.join().expect("a thread of the runner panicked"));
            ended.collect::<Vec<_>>().into_iter().collect::<Result<()>>()
        })?;
        let done = jobs.iter().filter(|job| self.folder.is_done(job)).count();
        Ok(Ended { done, failed: jobs.len() - done })
    }

    /// Runs a job from where it is, and writes how it ended.
    fn run_job(&self, job: &Job) -> Result<State> {
        let path = self.folder.job(job);
        std::fs::create_dir_all(&path).map_err(at(&path))?;
        let earlier = self.folder.seconds(job);
        let begun = Instant::now();
        let mut error = None;
        for action in &job.actions {
            let ended = self.act(job, &path, action);
            self.folder.set_seconds(job, earlier + begun.elapsed().as_secs_f64())?;
            error = ended?;
            if error.is_some() {
                break;
            }
        }
        let state = State { error, seconds: self.folder.seconds(job), actions_sha256: job.actions_sha256() };
        self.folder.set_state(job, &state)?;
        Ok(state)
    }

    /// Runs an action unless it has its result. Returns why it failed.
    fn act(&self, job: &Job, path: &Path, action: &Action) -> Result<Option<String>> {
        let arguments: Vec<String> = match action {
            Action::Train { agent, config, .. } => {
                if path.join(agent).join(TRAINED).exists() {
                    return Ok(None);
                }
                let text = toml::to_string(config).expect("a table of plain values always serializes");
                let file = path.join(CONFIG);
                write_whole(&file, text.as_bytes()).map_err(at(&file))?;
                words(&["train", "--config", CONFIG, "--out", agent, "--jobs", "1", "--json"])
            }
            Action::Enter(entry) => enter(entry, job.agent()),
            Action::Evaluate(episodes) => {
                evaluate(episodes, if job.agent() == REACTIVE { REACTIVE } else { AGENT })
            }
            Action::Measure(arguments) => arguments.iter().cloned().chain(words(&["--json"])).collect(),
        };
        let result = matches!(action, Action::Measure(_)).then(|| path.join(MEASURED));
        self.command(path, &self.folder.log(job), &arguments, result.as_deref())
    }

    /// Runs a command in a folder, and adds it and its output to a log, or writes its output to the file of a result. Returns why
    /// it failed.
    pub(crate) fn command(
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
                // A process that has just ended cannot be told.
                let _ = kill_process(Pid::from_child(child), Signal::TERM);
            }
            std::thread::sleep(POLL);
        }
    }
}

/// Returns the arguments that evaluate a policy, with the result in the folder [`EVALUATION`].
pub(crate) fn evaluate(episodes: &Episodes, policy: &str) -> Vec<String> {
    let Episodes { buildings, tasks, periods } = episodes;
    let mut arguments = words(&["evaluate", "--policy", policy, "--out", EVALUATION]);
    arguments.extend(words(&["--jobs", "1", "--json", "--task"]));
    arguments.extend(tasks.iter().cloned());
    arguments.push("--period".into());
    arguments.extend(periods.iter().cloned());
    arguments.push("--".into());
    arguments.extend(buildings.iter().cloned());
    arguments
}

/// Returns the arguments that make an entry.
fn enter(entry: &Entry, name: &str) -> Vec<String> {
    let Entry { problem, policy, steps, seeds, test, .. } = entry;
    let mut arguments = words(&["benchmark", "run", problem, "--policy", policy, "--entry", name]);
    arguments.extend(words(&["--out", ENTRY, "--jobs", "1", "--json"]));
    arguments.extend(steps.iter().flat_map(|steps| ["--trained-steps".into(), steps.to_string()]));
    for (option, values) in [("--seed", seeds.iter().map(u64::to_string).collect()), ("--test", test.clone())]
    {
        if !values.is_empty() {
            arguments.push(option.into());
            arguments.extend(values);
        }
    }
    arguments
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// Returns why a command failed: its signal, its error in the log from `begin` on, or the last line there.
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
    fn the_cause_of_a_failure_is_that_of_the_last_command() {
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
