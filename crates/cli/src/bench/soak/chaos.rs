//! Random kills and stops of templates and workers in any phase.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use b2b_workers::{WorkerOptions, Workers};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustix::process::{Pid, Signal, kill_process};
use serde::Serialize;

/// Maximum pause between two hits.
const PAUSE: Duration = Duration::from_millis(600);
/// Share of the hits that stop a process instead of killing it: each makes the batch wait for a time limit.
const STOPS: f64 = 0.08;
/// Share of the hits that target templates.
const TEMPLATES: f64 = 0.35;

/// A thread that kills and stops processes until [`Chaos::end`] is called.
pub struct Chaos {
    thread: JoinHandle<Hits>,
    end: Arc<AtomicBool>,
}

/// The processes that were hit.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Hits {
    /// Workers that were killed.
    pub workers_killed: Vec<u32>,
    /// Workers that were stopped by SIGSTOP.
    pub workers_stopped: Vec<u32>,
    /// Ready templates that were killed.
    pub templates_killed: usize,
    /// Ready templates that were stopped.
    pub templates_stopped: usize,
    /// Templates that were killed while they prepared.
    pub preparing_killed: usize,
    /// Templates that were stopped while they prepared.
    pub preparing_stopped: usize,
}

/// Returns options with short time limits, so that a stopped process is detected quickly.
pub fn with_short_time_limits(options: WorkerOptions) -> WorkerOptions {
    WorkerOptions {
        step_time_limit: Duration::from_secs(10),
        preparation_time_limit: Duration::from_secs(60),
        ..options
    }
}

impl Chaos {
    /// Starts killing and stopping worker processes.
    pub fn start(seed: u64, workers: Workers) -> Self {
        let end = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&end);
        let thread = std::thread::spawn(move || {
            let random = ChaCha8Rng::seed_from_u64(seed);
            let mut attacker = Attacker { random, workers, hits: Hits::default(), may_hit_preparing: true };
            while !ended.load(Ordering::Relaxed) {
                std::thread::sleep(PAUSE.mul_f64(attacker.random.random()));
                attacker.hit();
            }
            attacker.hits
        });
        Self { thread, end }
    }

    /// Ends the thread and returns the processes that it hit.
    pub fn end(self) -> Hits {
        self.end.store(true, Ordering::Relaxed);
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

impl Hits {
    /// Returns whether an episode was lost because its worker was hit.
    pub fn explains(&self, lost: &str) -> bool {
        let hit = self.workers_killed.iter().chain(&self.workers_stopped);
        hit.into_iter().any(|process| lost.contains(&format!("worker process {process} ")))
    }

    /// Returns how many processes were hit, by kind.
    pub fn text(&self) -> String {
        format!(
            "killed {} workers and stopped {}; killed {} ready templates and stopped {}; killed {} preparing templates and stopped {}",
            self.workers_killed.len(),
            self.workers_stopped.len(),
            self.templates_killed,
            self.templates_stopped,
            self.preparing_killed,
            self.preparing_stopped
        )
    }
}

struct Attacker {
    random: ChaCha8Rng,
    workers: Workers,
    hits: Hits,
    /// Whether a preparing template may be hit: a preparation survives one hit, but not two in a row.
    may_hit_preparing: bool,
}

impl Attacker {
    fn hit(&mut self) {
        let templates = self.workers.template_processes();
        let Some(template) = templates.choose(&mut self.random).copied() else { return };
        let stops = self.random.random_bool(STOPS);
        let signal = if stops { Signal::STOP } else { Signal::KILL };
        if self.random.random_bool(TEMPLATES) {
            self.hit_template(template, signal);
        } else if let Some(worker) = children(template).choose(&mut self.random).copied()
            && send(worker, signal)
        {
            let hit = if stops { &mut self.hits.workers_stopped } else { &mut self.hits.workers_killed };
            hit.push(worker);
        }
    }

    fn hit_template(&mut self, template: u32, signal: Signal) {
        let preparing = self.workers.preparing_processes();
        self.may_hit_preparing |= preparing.is_empty();
        let prepares = preparing.contains(&template);
        if prepares && !std::mem::take(&mut self.may_hit_preparing) || !send(template, signal) {
            return;
        }
        let count = match (prepares, signal == Signal::STOP) {
            (false, false) => &mut self.hits.templates_killed,
            (false, true) => &mut self.hits.templates_stopped,
            (true, false) => &mut self.hits.preparing_killed,
            (true, true) => &mut self.hits.preparing_stopped,
        };
        *count += 1;
    }
}

/// Returns the processes copied from a template, including those that have not reported yet.
fn children(template: u32) -> Vec<u32> {
    let children = std::fs::read_to_string(format!("/proc/{template}/task/{template}/children"));
    children.unwrap_or_default().split_whitespace().filter_map(|child| child.parse().ok()).collect()
}

fn send(process: u32, signal: Signal) -> bool {
    Pid::from_raw(process as i32).is_some_and(|process| kill_process(process, signal).is_ok())
}
