//! Episodes under schedules.

use std::path::Path;

use b2b_workers::{Episode, RolloutMemory};
use serde::Serialize;

use super::outcome::{Days, EpisodeUse};
use super::schedule::Schedule;
use crate::Result;
use crate::kind::KindDescription;
use crate::parameter_set::to_json;
use crate::search::record_file::RecordFile;

/// Runs the episodes of a search, one after another, in an episode that is reset for each.
pub(super) struct Trials<'a> {
    episode: &'a mut Episode,
    memory: RolloutMemory,
    record: Option<TrialRecord>,
    /// Called after each episode.
    done: &'a mut dyn FnMut(),
}

impl<'a> Trials<'a> {
    pub(super) fn new(
        episode: &'a mut Episode,
        record: Option<TrialRecord>,
        done: &'a mut dyn FnMut(),
    ) -> Self {
        let memory = RolloutMemory::new(episode.workers());
        Self { episode, memory, record, done }
    }

    /// Returns the outcome of an episode under a schedule: the next one of the record, or a new one.
    pub(super) fn run(&mut self, schedule: &Schedule) -> Result<EpisodeUse> {
        let known = self.record.as_mut().and_then(|record| record.known.next());
        let outcome = match known {
            Some(outcome) => outcome,
            None => {
                let outcome = self.simulate(schedule)?;
                if let Some(record) = &mut self.record {
                    record.push(&outcome)?;
                }
                outcome
            }
        };
        (self.done)();
        Ok(outcome)
    }

    fn simulate(&mut self, schedule: &Schedule) -> Result<EpisodeUse> {
        let controller =
            KindDescription { name: super::NAME.to_owned(), seed: 0, values: to_json(schedule) }.to_order();
        let mut days = Days::new(self.episode.setting().episode.steps_per_hour);
        let metrics = self.episode.rollout(&controller, &mut self.memory, &mut days)?;
        Ok(days.outcome(&metrics))
    }
}

/// The outcomes of a search in a file, from which an interrupted search resumes.
pub(super) struct TrialRecord {
    file: RecordFile,
    known: std::vec::IntoIter<EpisodeUse>,
}

impl TrialRecord {
    /// Opens the file of a search, or creates it. `head` is what the search depends on.
    ///
    /// # Errors
    /// The errors of [`RecordFile::open`].
    pub(super) fn open(path: &Path, head: &impl Serialize) -> Result<Self> {
        let (file, lines) = RecordFile::open(path, head)?;
        let read = |line: &String| serde_json::from_str(line).map_err(|error| file.other(error.to_string()));
        let known: Vec<EpisodeUse> = lines.iter().map(read).collect::<Result<_>>()?;
        Ok(Self { file, known: known.into_iter() })
    }

    fn push(&mut self, outcome: &EpisodeUse) -> Result<()> {
        self.file.push(outcome)
    }
}

#[cfg(test)]
mod tests {
    use super::super::outcome::DayUse;
    use super::*;
    use crate::Error;

    #[test]
    fn a_record_returns_what_was_written_and_refuses_another_search() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("record.jsonl");
        let outcome = EpisodeUse { days: vec![DayUse { used: 0.1 + 0.2, discomfort: 1.0 / 3.0 }; 2] };
        TrialRecord::open(&path, &"a").unwrap().push(&outcome).unwrap();
        let damaged = std::fs::read_to_string(&path).unwrap() + "{\"days\":";
        std::fs::write(&path, damaged).unwrap();
        let mut record = TrialRecord::open(&path, &"a").unwrap();
        assert_eq!((record.known.next(), record.known.next()), (Some(outcome), None));
        assert!(matches!(TrialRecord::open(&path, &"b"), Err(Error::OtherTuning { .. })));
    }
}
