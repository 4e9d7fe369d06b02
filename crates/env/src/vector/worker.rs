//! The process side: an environment that stands somewhere, and does what its seat asks.
//!
//! There is one kind of process. Started as a program, it prepares a building, warms it up and stands at the end
//! of warm-up: a template. Every other is a copy of one that stands: of a template, an episode; of an episode, a
//! snapshot. A copy sits in a seat of its own and takes commands there like its original.

use std::cell::Cell;
use std::error::Error;
use std::ffi::OsString;
use std::os::fd::{AsFd, OwnedFd};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::Duration;

use b2b_energyplus::snapshot::{Fork, become_ancestor, give_back_memory, leave};
use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec};
use rustix::process::{Pid, PidfdFlags};
use rustix::thread::CpuSet;

use super::order::Order;
use super::region::{Command, Region, Standing};
use crate::env::Env;

/// How often a process that waits looks for its owner.
const LOOK_FOR_OWNER: Duration = Duration::from_millis(500);

/// The argument that makes a program a worker: see [`run_if_worker`].
pub(super) const FLAG: &str = "--b2b-worker";

/// Runs this process as a worker of a pool if it was started as one, and then never returns. A program that uses
/// [`Launcher::this_program`](super::Launcher::this_program) calls it first of all, before it starts a thread.
pub fn run_if_worker() {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    if let Some(flag) = arguments.iter().position(|argument| argument == FLAG) {
        run(&arguments[flag + 1..]);
    }
}

/// What the owner tells on the command line: its process, the seat, the order's file.
fn parse(arguments: &[OsString]) -> Option<(i32, u32, PathBuf)> {
    let number = |index: usize| arguments.get(index)?.to_str();
    Some((number(0)?.parse().ok()?, number(1)?.parse().ok()?, arguments.get(2)?.into()))
}

fn run(arguments: &[OsString]) -> ! {
    let Some((owner, seat, order)) = parse(arguments) else {
        eprintln!("{FLAG} is for the processes of a pool, which it starts by itself");
        leave(2)
    };
    // The owner gives its memory in the place of the standard input.
    let region = std::io::stdin().as_fd().try_clone_to_owned().and_then(Region::open);
    let (Ok(region), Some(owner)) = (region, Owner::find(owner)) else { leave(1) };
    let folder = order.parent().unwrap_or(Path::new("")).to_owned();
    let worker = Worker { region, owner, folder, seat: Cell::new(seat) };
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let env = worker.prepare(&order)?;
        worker.serve(env)
    }));
    match outcome {
        Ok(Ok(())) => leave(0),
        Ok(Err(error)) => worker.fail(&error.to_string()),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or_default();
            worker.fail(&format!("the worker panicked: {text}"))
        }
    }
}

/// Why a process cannot go on.
type Failure = Box<dyn Error>;

struct Worker {
    region: Region,
    owner: Owner,
    /// The pool's folder.
    folder: PathBuf,
    /// Where this process sits; a copy moves.
    seat: Cell<u32>,
}

impl Worker {
    /// Prepares what is ordered up to the end of warm-up, and tells the owner what it is.
    fn prepare(&self, order: &Path) -> Result<Env, Failure> {
        become_ancestor()?;
        self.region.sit(self.seat.get());
        let watch = Watch::start(self.owner.process.try_clone()?, self.folder.clone())?;
        let mut env = serde_json::from_slice::<Order>(&std::fs::read(order)?)?.env()?;
        env.reset()?;
        env.set_finish_run(false);
        // The engine keeps open what it still needs.
        std::fs::remove_dir_all(env.folder())?;
        let ready = order.with_extension("ready");
        let aside = order.with_extension("aside");
        std::fs::write(&aside, serde_json::to_vec(env.building())?)?;
        watch.stop()?;
        env.forget_model();
        give_back_memory();
        std::fs::rename(&aside, ready)?;
        Ok(env)
    }

    /// Does what the seat asks, until the episode is over or the owner gone.
    fn serve(&self, mut env: Env) -> Result<(), Failure> {
        let mut action = vec![0.0; env.action_space().len()];
        self.stand(&env);
        loop {
            match self.region.next_command(self.seat.get(), LOOK_FOR_OWNER) {
                None if self.owner.is_gone() => return self.tidy(),
                None => {}
                Some(Command::Step) if self.step(&mut env, &mut action)? => return Ok(()),
                Some(Command::Step) => {}
                Some(Command::Copy) => self.copy(&mut env)?,
            }
        }
    }

    /// Says that it stands, and where.
    fn stand(&self, env: &Env) {
        let seat = self.seat.get();
        self.region.sit(seat);
        self.region.write_observation(seat, env.observation());
        self.region.set_standing(seat, Standing::Running);
        self.region.hand_back(seat);
    }

    /// One step; whether it was the last.
    fn step(&self, env: &mut Env, action: &mut [f64]) -> Result<bool, Failure> {
        let (region, seat) = (&self.region, self.seat.get());
        region.read_action(seat, action);
        let step = env.step(action)?;
        region.write_observation(seat, step.observation);
        region.write_action(seat, step.action);
        region.set_penalties(seat, [step.reward.temperature_penalty, step.reward.energy_penalty]);
        let truncated = step.truncated;
        if truncated {
            region.write_report(seat, &serde_json::to_vec(env.metrics())?);
            region.set_standing(seat, Standing::Truncated);
        }
        region.hand_back(seat);
        Ok(truncated)
    }

    /// Copies this process for each seat listed. The copies return from here too, in their seats.
    fn copy(&self, env: &mut Env) -> Result<(), Failure> {
        let own = self.seat.get();
        for seat in self.region.copies(own) {
            match env.fork() {
                Ok(Fork::Original) => {}
                Ok(Fork::Copy(opened)) => {
                    self.seat.set(seat);
                    opened?;
                    pin(self.region.processor(seat));
                    if let steps @ 1.. = self.region.steps(seat) {
                        env.truncate_after(steps as usize);
                    }
                    self.stand(env);
                    return Ok(());
                }
                Err(error) => {
                    self.seat.set(seat);
                    self.report(&error.to_string());
                    self.seat.set(own);
                }
            }
        }
        self.region.hand_back(own);
        Ok(())
    }

    fn report(&self, why: &str) {
        let seat = self.seat.get();
        self.region.write_report(seat, why.as_bytes());
        self.region.set_standing(seat, Standing::Failed);
        self.region.hand_back(seat);
    }

    fn fail(&self, why: &str) -> ! {
        self.report(why);
        leave(1)
    }

    /// Removes what the owner can no longer remove.
    fn tidy(&self) -> Result<(), Failure> {
        let _ = std::fs::remove_dir_all(&self.folder);
        Ok(())
    }
}

/// Keeps this process to one of the processors it may use, so that it finds its caches warm. `None` for any.
fn pin(processor: Option<u32>) {
    let Some(processor) = processor else { return };
    let Ok(may) = rustix::thread::sched_getaffinity(None) else { return };
    let may: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|cpu| may.is_set(*cpu)).collect();
    let mut one = CpuSet::new();
    one.set(may[processor as usize % may.len()]);
    // A refusal costs speed alone.
    let _ = rustix::thread::sched_setaffinity(None, &one);
}

/// The process that a pool belongs to.
struct Owner {
    process: OwnedFd,
}

impl Owner {
    /// `None` when it is gone already.
    fn find(owner: i32) -> Option<Self> {
        let process = rustix::process::pidfd_open(Pid::from_raw(owner)?, PidfdFlags::empty()).ok()?;
        let is_parent = rustix::process::getppid().is_some_and(|pid| pid.as_raw_pid() == owner);
        is_parent.then_some(Self { process })
    }

    fn is_gone(&self) -> bool {
        let mut ends = [PollFd::new(&self.process, PollFlags::IN)];
        rustix::event::poll(&mut ends, Some(&Timespec::default())).is_ok_and(|ready| ready > 0)
    }
}

/// A thread that ends this process with its owner, while it is too busy to look.
struct Watch {
    thread: JoinHandle<()>,
    bell: OwnedFd,
}

impl Watch {
    fn start(owner: OwnedFd, folder: PathBuf) -> std::io::Result<Self> {
        let bell = rustix::event::eventfd(0, EventfdFlags::CLOEXEC)?;
        let rung = bell.try_clone()?;
        let thread = std::thread::Builder::new().spawn(move || {
            let mut ends = [PollFd::new(&owner, PollFlags::IN), PollFd::new(&rung, PollFlags::IN)];
            let _ = rustix::event::poll(&mut ends, None);
            if !ends[1].revents().contains(PollFlags::IN) {
                let _ = std::fs::remove_dir_all(folder);
                leave(1);
            }
        })?;
        Ok(Self { thread, bell })
    }

    fn stop(self) -> std::io::Result<()> {
        rustix::io::write(&self.bell, &1u64.to_ne_bytes())?;
        self.thread.join().map_err(|_| std::io::Error::other("the watch panicked"))
    }
}
