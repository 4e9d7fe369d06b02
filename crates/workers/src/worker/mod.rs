//! The worker's side: an environment that executes the commands in its slot.
//!
//! A process that is started for an episode prepares a building, warms it up and waits: a template. All others are
//! copies of a waiting process: an episode is a copy of a template, and a snapshot a copy of an episode. A copy
//! attaches to its own slot and takes commands there like its original. The standard error of a worker goes to a log in
//! the pool's folder, for error messages.

pub(crate) mod action;
pub(crate) mod entry;
pub(crate) mod job;
pub(crate) mod owner;

use std::any::Any;
use std::cell::Cell;
use std::error::Error;
use std::fs::File;
use std::os::fd::AsFd;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use b2b_energyplus::snapshot::{Fork, become_ancestor, collapse_pages, give_back_memory, leave};
use b2b_energyplus::{Level, confine};
use rustix::process::WaitOptions;
use rustix::thread::CpuSet;
use rustix::time::{ClockId, clock_gettime};

use self::owner::Owner;
use super::episode::episode_report::EpisodeReport;
use super::episode::metrics_report;
use super::form::check_width;
use super::fragment::{RunnerOf, Runners, SharedMemory};
use super::order::{EpisodeOrder, FragmentOrder, Order};
use super::region::{Command, LONG_ORDER, Region, Status, Ticket, WIDTH};
use b2b_env::Env;
use b2b_env::Spaces;
use b2b_env::StepNumbers;

/// Interval at which a waiting process checks for its owner.
const LOOK_FOR_OWNER: Duration = Duration::from_millis(500);

/// Steps after which a copy moves its memory to large pages. Shorter episodes do not benefit.
const COLLAPSE_AFTER: usize = 288;

/// Serves the episodes of an order, which it read from the file `order`, and then never returns.
pub(super) fn serve(episode: EpisodeOrder, order: &Path, owner: Owner, runners: Runners) -> ! {
    // The owner passes its memory as the standard input.
    let region = std::io::stdin().as_fd().try_clone_to_owned().and_then(Region::open);
    let Ok(region) = region else { leave(1) };
    let ticket = episode.ticket;
    if !region.attach(ticket) {
        leave(1);
    }
    let worker = Worker {
        region: Arc::new(region),
        runners,
        owner,
        folder: order.parent().unwrap_or(Path::new("")).to_owned(),
        ticket: Cell::new(ticket),
        warm_up_cpu: Cell::default(),
        severes: Cell::default(),
        collapse_at: Cell::new(usize::MAX),
    };
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let env = worker.prepare(episode, order)?;
        worker.serve(env)
    }));
    match outcome {
        Ok(Ok(())) => leave(0),
        Ok(Err(error)) => worker.fail(&error.to_string()),
        Err(panic) => worker.fail(&panic_text(&*panic)),
    }
}

/// Returns the text of a panic.
pub(super) fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or_default();
    format!("the worker panicked: {text}")
}

/// Why a worker cannot continue.
type Cause = Box<dyn Error>;

struct Worker {
    region: Arc<Region>,
    runners: Runners,
    owner: Owner,
    /// The pool's folder.
    folder: PathBuf,
    /// The slot of this process; a copy has another.
    ticket: Cell<Ticket>,
    /// CPU time of the template's reset.
    warm_up_cpu: Cell<Duration>,
    /// Number of severe messages in the log.
    severes: Cell<usize>,
    /// Number of steps of the episode after which the memory moves to large pages.
    collapse_at: Cell<usize>,
}

impl Worker {
    /// Prepares the building of an order up to the end of warm-up, and writes the prepared building for the owner.
    fn prepare(&self, episode: EpisodeOrder, order: &Path) -> Result<Env, Cause> {
        become_ancestor()?;
        // The model is untrusted.
        confine();
        let watch = self.owner.watch(self.folder.clone())?;
        let mut env = episode.env()?;
        check_widths(env.spaces())?;
        let before = cpu_time();
        env.reset()?;
        self.warm_up_cpu.set(cpu_time().saturating_sub(before));
        env.set_finish_run(false);
        // The engine keeps its files open.
        std::fs::remove_dir_all(env.folder())?;
        let ready = order.with_extension("ready");
        let aside = order.with_extension("aside");
        std::fs::write(&aside, serde_json::to_vec(env.building())?)?;
        watch.stop()?;
        env.drop_model();
        give_back_memory();
        std::fs::rename(&aside, ready)?;
        Ok(env)
    }

    fn slot(&self) -> u32 {
        self.ticket.get().slot
    }

    /// Executes the commands in the slot until the episode is over or the owner has died.
    fn serve(&self, mut env: Env) -> Result<(), Cause> {
        let mut action = vec![0.0; env.action_space().len()];
        let mut runner = None;
        self.report_ready(&env);
        loop {
            match self.region.next_command(self.slot(), LOOK_FOR_OWNER) {
                None if self.owner.is_gone() => return self.tidy(),
                None => self.reap(),
                Some(Command::Step) if self.step(&mut env, &mut action)? => return Ok(()),
                Some(Command::Step) => {}
                Some(command @ (Command::Fragment | Command::LongFragment)) => {
                    let order = self.order(command)?;
                    if self.fragment(&mut env, &mut runner, &order)? {
                        return Ok(());
                    }
                }
                Some(Command::Copy) => self.copy(&mut env)?,
            }
        }
    }

    /// Hands the slot back with the current observation.
    fn report_ready(&self, env: &Env) {
        let slot = self.slot();
        self.region.write_observation(slot, env.observation());
        self.region.set_status(slot, Status::Running);
        self.region.complete(slot);
    }

    /// Makes one step. Returns whether it was the last.
    fn step(&self, env: &mut Env, action: &mut [f64]) -> Result<bool, Cause> {
        let (region, slot) = (&self.region, self.slot());
        region.read_action(slot, action);
        let step = env.step(action)?;
        region.write_observation(slot, step.observation);
        region.write_action(slot, step.action);
        region.set_step_numbers(slot, step.numbers());
        self.end_step(env)
    }

    /// The order in the slot.
    fn order(&self, command: Command) -> Result<FragmentOrder, Cause> {
        let ticket = self.ticket.get();
        let text = match command {
            Command::LongFragment => std::fs::read(self.folder.join(ticket.file(LONG_ORDER)))?,
            _ => self.region.report(ticket.slot),
        };
        match Order::parse(&text)? {
            Order::Fragment(order) => Ok(order),
            other => Err(format!("an episode cannot carry out the order `{}`", other.name()).into()),
        }
    }

    /// Runs a fragment. Returns whether the episode is over.
    fn fragment(
        &self,
        env: &mut Env,
        runner: &mut Option<RunnerOf>,
        FragmentOrder { runner: kind, order }: &FragmentOrder,
    ) -> Result<bool, Cause> {
        let (region, slot, order) = (&self.region, self.slot(), order.get().as_bytes());
        if runner.as_ref().is_some_and(|runner| !runner.serves(kind, order)) {
            *runner = None;
        }
        let runner = match runner {
            Some(runner) => runner,
            None => runner.insert(self.runners.make(kind, env, order)?),
        };
        let steps = runner.run(env, order, &SharedMemory::new(Arc::clone(region)))?;
        region.set_fragment_steps(slot, steps);
        region.write_observation(slot, env.observation());
        region.set_step_numbers(slot, StepNumbers::default());
        self.end_step(env)
    }

    /// Hands the slot back. Returns whether the episode is over.
    fn end_step(&self, env: &Env) -> Result<bool, Cause> {
        let truncated = env.is_truncated();
        if truncated {
            self.write_reports(env)?;
            self.region.set_status(self.slot(), Status::Truncated);
        } else if env.metrics().steps >= self.collapse_at.get() {
            self.collapse_at.set(usize::MAX);
            collapse_pages()?;
        }
        self.log_severe_messages(env);
        self.region.complete(self.slot());
        Ok(truncated)
    }

    fn write_reports(&self, env: &Env) -> Result<(), Cause> {
        let ticket = self.ticket.get();
        metrics_report::write(&self.region, ticket, &self.folder, env.metrics())?;
        if self.region.options(ticket.slot).finish_run {
            let cpu = self.warm_up_cpu.get() + cpu_time();
            let report = EpisodeReport { engine: env.engine_report(), cpu };
            std::fs::write(self.folder.join(ticket.file("json")), serde_json::to_vec(&report)?)?;
        }
        Ok(())
    }

    /// Writes severe messages of the engine to the log, in case it crashes.
    fn log_severe_messages(&self, env: &Env) {
        let severes = env.message_count(Level::Severe);
        if severes > self.severes.get() {
            let messages = env.messages();
            let new = messages.at_least(Level::Severe).skip(self.severes.get());
            new.for_each(|message| eprintln!("{}: {}", message.level, message.text));
            self.severes.set(severes);
        }
    }

    /// Copies this process for each listed slot. The copies return from here, too, in their slots.
    fn copy(&self, env: &mut Env) -> Result<(), Cause> {
        self.reap();
        let own = self.ticket.get();
        for ticket in self.region.copies(own.slot) {
            let finish_run = self.region.options(ticket.slot).finish_run;
            let meter_file = finish_run.then(|| self.folder.join(ticket.file("mtr")));
            match env.fork(meter_file.as_deref()) {
                Ok(Fork::Original) => {}
                Ok(Fork::Copy(opened)) => return self.become_copy(env, ticket, opened.map_err(Into::into)),
                Err(error) => {
                    self.ticket.set(ticket);
                    self.report(&error.to_string());
                    self.ticket.set(own);
                }
            }
        }
        self.region.complete(own.slot);
        Ok(())
    }

    /// Initializes a copy.
    fn become_copy(&self, env: &mut Env, ticket: Ticket, opened: Result<(), Cause>) -> Result<(), Cause> {
        if !self.region.attach(ticket) {
            leave(0);
        }
        self.ticket.set(ticket);
        opened?;
        rustix::stdio::dup2_stderr(File::create(self.folder.join(ticket.file("log")))?)?;
        let options = self.region.options(ticket.slot);
        pin(options.processor);
        self.collapse_at.set(env.metrics().steps + COLLAPSE_AFTER);
        if let Some(steps) = options.max_steps {
            env.truncate_after(steps);
        }
        if options.finish_run {
            // The engine writes its last files by name.
            std::fs::create_dir_all(env.folder())?;
            env.set_finish_run(true);
        }
        self.report_ready(env);
        Ok(())
    }

    /// Collects the exit status of ended copies, for the owner.
    fn reap(&self) {
        while let Ok(Some((process, status))) = rustix::process::wait(WaitOptions::NOHANG) {
            self.region.record_exit(process.as_raw_pid() as u32, status.as_raw());
        }
    }

    fn report(&self, why: &str) {
        let slot = self.slot();
        self.region.write_report(slot, why.as_bytes());
        self.region.set_status(slot, Status::Failed);
        self.region.complete(slot);
    }

    fn fail(&self, why: &str) -> ! {
        self.report(why);
        leave(1)
    }

    /// Removes files that a dead owner cannot remove.
    fn tidy(&self) -> Result<(), Cause> {
        let _ = std::fs::remove_dir_all(&self.folder);
        Ok(())
    }
}

/// Checks that action and observation fit into a slot.
///
/// # Errors
/// [`TooWide`](b2b_env::Error::TooWide).
fn check_widths(spaces: &Spaces) -> b2b_env::Result<()> {
    check_width(spaces, "actuators", spaces.action.len(), WIDTH)?;
    check_width(spaces, "observation slots", spaces.observation.len(), WIDTH)
}

/// CPU time of this process.
fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Pins this process to one of its processors, to keep its caches warm.
fn pin(processor: Option<u32>) {
    let Some(processor) = processor else { return };
    let Ok(may) = rustix::thread::sched_getaffinity(None) else { return };
    let may: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|cpu| may.is_set(*cpu)).collect();
    let mut one = CpuSet::new();
    one.set(may[processor as usize % may.len()]);
    // A refusal only costs speed.
    let _ = rustix::thread::sched_setaffinity(None, &one);
}
