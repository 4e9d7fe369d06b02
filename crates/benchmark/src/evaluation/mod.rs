//! Episodes under a policy, many at a time.
//!
//! As many threads as asked for take episodes from a list, a building at a time; each has a pool of processes of its
//! own, in which it prepares the building and runs its episodes one after another. So memory grows with the threads,
//! not with the list, and a process that dies costs one episode.

mod bench;
mod folder;
mod record;
mod rollout;
mod table;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use b2b_building::RunPeriod;
use b2b_dataset::Catalog;
use b2b_env::Task;
use b2b_env::vector::Launcher;

use bench::{Bench, Group};
pub(crate) use folder::write;
pub use folder::{Folder, Versions};
pub use record::{Deviations, Finished, Hours, Outcome, Record};
pub use table::{Row, episode_table, read_stages, write_episodes, write_stages};

use crate::policy::Policy;
use crate::subject::Subject;
use crate::{Error, Result};

/// An episode to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Episode {
    /// The building.
    pub subject: Subject,
    /// What is asked.
    pub task: Task,
    /// On which days.
    pub period: RunPeriod,
    /// Seed of the policy.
    pub seed: u64,
    /// Zone time steps an hour, each one step of the environment.
    pub steps_per_hour: u32,
}

impl Episode {
    /// Simulated days.
    pub fn days(&self) -> u64 {
        u64::from(self.period.days())
    }
}

/// Who is told how far it is. Called from every thread.
pub trait Progress: Sync {
    /// So many episodes of so many simulated days together are about to be run: `episodes`, or the `baselines` of them.
    fn begin(&self, _what: &str, _episodes: usize, _days: u64) {}

    /// A simulated day is over.
    fn day(&self) {}

    /// An episode is over, or lost.
    fn episode(&self) {}
}

/// Nobody is told.
impl Progress for () {}

/// How episodes are run.
#[derive(Debug)]
pub struct Evaluation<'a> {
    /// Where buildings come from.
    pub catalog: &'a Catalog,
    /// How processes are started.
    pub launcher: Launcher,
    /// Episodes at a time.
    pub jobs: usize,
    /// Asked at least once a simulated day; when true, the evaluation ends with [`Error::Interrupted`].
    pub interrupted: fn() -> bool,
}

/// What the threads of an evaluation share.
struct Work<'a> {
    episodes: &'a [(usize, &'a Episode)],
    policy: &'a dyn Policy,
    progress: &'a dyn Progress,
    keep: &'a (dyn Fn(usize, Outcome) -> Result<()> + Sync),
    /// Set when a thread fails, for the others.
    failed: AtomicBool,
    interrupted: fn() -> bool,
}

impl Evaluation<'_> {
    /// Runs episodes and gives each to `keep` as it ends, by its number. An episode that cannot be run or whose
    /// process dies is [`Outcome::Lost`] with the reason. Episodes of one building are best beside each other.
    ///
    /// # Errors
    /// [`Error::ObservationShape`], [`Error::ActionShape`] and [`Error::NoPolicy`] for a policy that does not fit;
    /// [`Error::Interrupted`]; what `keep` says.
    pub fn run(
        &self,
        episodes: &[(usize, &Episode)],
        policy: &dyn Policy,
        progress: &dyn Progress,
        keep: &(dyn Fn(usize, Outcome) -> Result<()> + Sync),
    ) -> Result<()> {
        let (failed, interrupted) = (AtomicBool::new(false), self.interrupted);
        let work = Work { episodes, policy, progress, keep, failed, interrupted };
        let groups = Group::of(episodes);
        let next = AtomicUsize::new(0);
        let thread = || {
            // Buildings that nobody works on; after them, what is left of those of others.
            let own = std::iter::from_fn(|| groups.get(next.fetch_add(1, Ordering::Relaxed)));
            let outcome = own.chain(&groups).try_for_each(|group| self.work_on(group, &work));
            if outcome.is_err() {
                work.failed.store(true, Ordering::Relaxed);
            }
            outcome
        };
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..self.jobs.max(1)).map(|_| scope.spawn(thread)).collect();
            let outcomes: Vec<_> = threads
                .into_iter()
                .map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
                .collect();
            // A thread that stopped for another says that it was interrupted: the other's reason goes before.
            let interrupted = |outcome: &Result<()>| matches!(outcome, Err(Error::Interrupted));
            let (halted, others): (Vec<_>, Vec<_>) = outcomes.into_iter().partition(interrupted);
            others.into_iter().chain(halted).collect()
        })
    }

    /// Runs what is left of a building's episodes.
    fn work_on(&self, group: &Group<'_>, work: &Work<'_>) -> Result<()> {
        let mut bench = None;
        while let Some(position) = group.take() {
            let (number, episode) = work.episodes[position];
            let outcome = match self.finish(group, &mut bench, episode, work) {
                Ok(finished) => Outcome::Finished(Box::new(finished)),
                Err(error) if concerns_all(&error) => return Err(error),
                Err(error) => Outcome::Lost(error.to_string()),
            };
            (work.keep)(number, outcome)?;
            work.progress.episode();
        }
        Ok(())
    }

    fn finish(
        &self,
        group: &Group<'_>,
        bench: &mut Option<Bench>,
        episode: &Episode,
        work: &Work<'_>,
    ) -> Result<Finished> {
        work.check()?;
        let bench = match bench {
            Some(bench) => bench,
            None => bench.insert(Bench::new(self, group)?),
        };
        let finished = rollout::run(bench, episode, work)?;
        group.is_prepared(bench);
        Ok(finished)
    }
}

impl Work<'_> {
    /// Whether to go on.
    fn check(&self) -> Result<()> {
        let halt = (self.interrupted)() || self.failed.load(Ordering::Relaxed);
        if halt { Err(Error::Interrupted) } else { Ok(()) }
    }
}

/// Whether an error is more than one episode's.
fn concerns_all(error: &Error) -> bool {
    matches!(
        error,
        Error::Interrupted
            | Error::Env(b2b_env::Error::Interrupted)
            | Error::ObservationShape { .. }
            | Error::ActionShape { .. }
            | Error::NoPolicy { .. }
            | Error::Problem { .. }
    )
}
