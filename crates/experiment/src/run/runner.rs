//! Runs jobs: each action in a process of its own, so that a crash ends nothing else.

use std::io::Write;
use std::path::Path;
use std::process::Stdio;
use std::time::Instant;

use b2b_base::aside::{append, write_whole};
use b2b_base::parallel;
use b2b_workers::{ActionEnd, ActionProcess, Launcher};
use toml::Table;

use super::order::Order;
use crate::error::{Error, Result, at};
use crate::folder::{CONFIG, Folder, JobFolder, MEASURED, State};
use crate::job::{Action, Job};

/// The name under which a program carries out the actions of jobs: see [`Program`](super::Program).
pub const ACTION: &str = "job";

/// Runs jobs, several at a time.
pub struct Runner<'a> {
    /// Starts the program that carries out [`ACTION`].
    pub launcher: Launcher,
    /// The folder of results.
    pub folder: &'a Folder,
    /// Number of jobs at a time, each with one environment process.
    pub parallel: usize,
    /// Returns whether to stop.
    pub interrupted: fn() -> bool,
}

/// Counts the time of a job, and writes it every minute, so that little is lost when the program is killed.
struct Clock<'a> {
    own: &'a JobFolder,
    /// Time of the job's commands before this run, s.
    earlier: f64,
    begun: Instant,
    /// Time at which it was last written, s.
    written: f64,
}

impl<'a> Clock<'a> {
    fn new(own: &'a JobFolder, earlier: f64) -> Self {
        Self { own, earlier, begun: Instant::now(), written: earlier }
    }

    fn seconds(&self) -> f64 {
        self.earlier + self.begun.elapsed().as_secs_f64()
    }

    fn write(&mut self) -> Result<()> {
        self.written = self.seconds();
        self.own.set_seconds(self.written)
    }

    /// Writes the time if a minute has passed. A failed write is reported by the one at the end.
    fn tick(&mut self) {
        if self.seconds() >= self.written + 60.0 {
            drop(self.write());
        }
    }
}

impl Runner<'_> {
    /// Runs the unfinished jobs in order. A failed job does not stop the others. `done` is called with every job that
    /// ends and how it ended.
    ///
    /// # Errors
    /// [`Error::Interrupted`], when the processes have written their checkpoints; [`Error::OtherJob`]; [`Error::Io`].
    pub fn run(&self, jobs: &[Job], done: &(dyn Fn(&Job, &State) + Sync)) -> Result<()> {
        self.folder.check(jobs)?;
        let left: Vec<&Job> = jobs.iter().filter(|job| !self.folder.is_done(job)).collect();
        parallel::map(self.parallel, &left, |job| {
            let state = self.run_job(job)?;
            done(job, &state);
            Ok(())
        })
        .map(drop)
    }

    /// Runs the remaining actions of a job, and writes how it ended.
    fn run_job(&self, job: &Job) -> Result<State> {
        let own = self.folder.job(job);
        std::fs::create_dir_all(own.path()).map_err(at(own.path()))?;
        let mut clock = Clock::new(&own, self.folder.seconds(job));
        let mut error = None;
        for action in &job.actions[self.folder.actions_done(job)..] {
            let ended = self.act(job, &own, action, &mut clock);
            clock.write()?;
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
    fn act(
        &self,
        job: &Job,
        own: &JobFolder,
        action: &Action,
        clock: &mut Clock<'_>,
    ) -> Result<Option<String>> {
        if let Action::Train { agent, config, .. } = action {
            if own.is_trained(agent) {
                return Ok(other_training(own, agent, config));
            }
            own.set_config(config)?;
        }
        let result = matches!(action, Action::Measure(_)).then(|| own.path().join(MEASURED));
        self.carry_out(&Order::of(action, job), own.path(), &own.log(), result.as_deref(), &mut || {
            clock.tick();
        })
    }

    /// Carries out an order in a folder. Appends the command that does the same and the output to a log; the result
    /// goes to the log, too, or to a file. Calls `waiting` several times a second while it runs. Returns why it failed.
    pub(super) fn carry_out(
        &self,
        order: &Order,
        path: &Path,
        log: &Path,
        result: Option<&Path>,
        waiting: &mut dyn FnMut(),
    ) -> Result<Option<String>> {
        let mut file = append(log).map_err(at(log))?;
        writeln!(file, "$ {}", order.command()).map_err(at(log))?;
        let [output, errors] = [file.try_clone().map_err(at(log))?, file.try_clone().map_err(at(log))?];
        let process = ActionProcess::start(&self.launcher, ACTION, order, |command| {
            command.current_dir(path).stdin(Stdio::null()).stdout(output).stderr(errors);
        });
        let end = process.and_then(|process| {
            process.wait(|| {
                waiting();
                (self.interrupted)()
            })
        });
        let text = match end.map_err(at(self.launcher.program()))? {
            ActionEnd::Interrupted => return Err(Error::Interrupted),
            ActionEnd::Failed(why) => return Ok(Some(why)),
            ActionEnd::Done(text) => text + "\n",
        };
        match result {
            Some(result) => write_whole(result, text.as_bytes()).map_err(at(result))?,
            None => file.write_all(text.as_bytes()).map_err(at(log))?,
        }
        Ok(None)
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
