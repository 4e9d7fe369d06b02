//! Runs the episodes of an evaluation in parallel.

use std::panic::{AssertUnwindSafe, catch_unwind};

use b2b_base::parallel::{self, Halt};

use super::bench::{Bench, BuildingGroup};
use super::episode::EpisodePlan;
use super::finished::{Lost, Outcome};
use super::parallel::{Evaluation, Work};
use super::progress::Progress;
use super::recording::Recorded;
use super::rollout;
use super::rollout::SequenceController;
use crate::panics::panic_message;
use crate::policy::Policy;
use crate::{Error, Result};

/// Receives the index of an episode and its steps, or why it was lost.
pub type KeepRecorded<'a> = dyn Fn(usize, std::result::Result<&Recorded<'_>, Lost>) -> Result<()> + Sync + 'a;

impl Evaluation<'_> {
    /// Runs episodes and passes each with its number to `keep` as it ends. An episode that cannot be run or whose
    /// process dies is [`Lost`]. Episodes of one building should be adjacent in the list. A policy that keeps its
    /// memory runs the [sequences](super::sequences) of the list.
    ///
    /// # Errors
    /// [`Error::ObservationShape`], [`Error::ActionShape`], [`Error::InvalidPolicy`], [`Error::Agent`],
    /// [`Error::Policy`] and [`Error::Problem`] for an incompatible policy; [`Error::Interrupted`]; errors of `keep`.
    pub fn run(
        &self,
        episodes: &[(usize, &EpisodePlan)],
        policy: &dyn Policy,
        progress: &dyn Progress,
        keep: &(dyn Fn(usize, Outcome) -> Result<()> + Sync),
    ) -> Result<()> {
        let (halt, interrupted) = (Halt::default(), self.interrupted);
        let recorded = &|_: usize, _: &Recorded<'_>| Ok(());
        self.run_all(&Work { episodes, policy, progress, keep, recorded, halt, interrupted })
    }

    /// Like [`Evaluation::run`], but passes the steps of each episode, or why it was lost, to `keep` with its number.
    ///
    /// # Errors
    /// Same as [`Evaluation::run`].
    pub fn record(
        &self,
        episodes: &[(usize, &EpisodePlan)],
        policy: &dyn Policy,
        progress: &dyn Progress,
        keep: &KeepRecorded<'_>,
    ) -> Result<()> {
        let (halt, interrupted) = (Halt::default(), self.interrupted);
        let recorded = &|number: usize, recorded: &Recorded<'_>| keep(number, Ok(recorded));
        let lost = &|number: usize, outcome: Outcome| match outcome {
            Ok(_) => Ok(()),
            Err(lost) => keep(number, Err(lost)),
        };
        self.run_all(&Work { episodes, policy, progress, keep: lost, recorded, halt, interrupted })
    }

    fn run_all(&self, work: &Work<'_>) -> Result<()> {
        let groups = BuildingGroup::of(work.episodes, work.policy);
        // Every building once, then again for each thread: a thread that runs out of new buildings joins the others.
        let shares: Vec<_> = groups.iter().cycle().take(groups.len() * (self.jobs + 1)).collect();
        parallel::map_until(&work.halt, self.jobs, &shares, |group| self.work_on(group, work)).map(drop)
    }

    /// Runs the remaining sequences of a building.
    fn work_on(&self, group: &BuildingGroup<'_>, work: &Work<'_>) -> Result<()> {
        let mut bench = None;
        while let Some(sequence) = group.take() {
            let (mut memory, mut lost) = (None, None);
            for (number, episode) in sequence.into_iter().map(|position| work.episodes[position]) {
                let outcome = match &lost {
                    // The memory of the episodes after it is unknown.
                    Some(reason) => Err(Lost { reason: format!("an earlier episode was lost: {reason}") }),
                    None => self.outcome(group, &mut bench, &mut memory, (number, episode), work)?,
                };
                if let Err(Lost { reason }) = &outcome {
                    lost.get_or_insert_with(|| reason.clone());
                }
                (work.keep)(number, outcome)?;
                work.progress.episode();
            }
        }
        Ok(())
    }

    /// Runs an episode. A panic, for example in a library reading a damaged network, loses the episode and its workers.
    fn outcome(
        &self,
        group: &BuildingGroup<'_>,
        bench: &mut Option<Bench>,
        memory: &mut SequenceController,
        episode: (usize, &EpisodePlan),
        work: &Work<'_>,
    ) -> Result<Outcome> {
        let finish = || {
            work.check()?;
            let bench = match bench {
                Some(bench) => bench,
                None => bench.insert(Bench::new(self, work.policy.controls(), group, work.progress)?),
            };
            let finished = rollout::run(bench, episode, memory, work)?;
            group.is_prepared(bench);
            Ok(finished)
        };
        match catch_unwind(AssertUnwindSafe(finish)) {
            Ok(Ok(finished)) => Ok(Ok(finished)),
            Ok(Err(error)) if ends_evaluation(&error) => Err(error),
            Ok(Err(error)) => Ok(Err(Lost { reason: error.to_string() })),
            Err(panic) => {
                *bench = None;
                Ok(Err(Lost { reason: format!("it panicked: {}", panic_message(&*panic)) }))
            }
        }
    }
}

/// Returns whether an error concerns more than one episode.
fn ends_evaluation(error: &Error) -> bool {
    matches!(
        error,
        Error::Interrupted
            | Error::Env(b2b_env::Error::Interrupted)
            | Error::Agent(_)
            | Error::ObservationShape { .. }
            | Error::ActionShape { .. }
            | Error::InvalidPolicy { .. }
            | Error::Problem { .. }
            | Error::Policy(_)
    )
}
