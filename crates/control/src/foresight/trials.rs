//! Episodes under schedules.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use b2b_base::aside::append;
use b2b_workers::{Episode, RolloutMemory};
use serde::Serialize;

use super::outcome::{Days, Outcome};
use super::schedule::Schedule;
use crate::kind::KindDescription;
use crate::parameter_set::to_json;
use crate::{Error, Result};

/// Runs the episodes of a search, one after another, in an episode that is reset for each.
pub(super) struct Trials<'a> {
    episode: &'a mut Episode,
    memory: RolloutMemory,
    record: Option<Record>,
    /// Called after each episode.
    done: &'a mut dyn FnMut(),
}

impl<'a> Trials<'a> {
    pub(super) fn new(episode: &'a mut Episode, record: Option<Record>, done: &'a mut dyn FnMut()) -> Self {
        let memory = RolloutMemory::new(episode.workers());
        Self { episode, memory, record, done }
    }

    /// Returns the outcome of an episode under a schedule: the next one of the record, or a new one.
    pub(super) fn run(&mut self, schedule: &Schedule) -> Result<Outcome> {
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

    fn simulate(&mut self, schedule: &Schedule) -> Result<Outcome> {
        let controller =
            KindDescription { name: super::NAME.to_owned(), seed: 0, values: to_json(schedule) }.to_order();
        let mut days = Days::new(self.episode.setting().episode.steps_per_hour);
        let metrics = self.episode.rollout(&controller, &mut self.memory, &mut days)?;
        Ok(days.outcome(&metrics))
    }
}

/// The outcomes of a search in a file, one line each, from which an interrupted search resumes.
pub(super) struct Record {
    path: PathBuf,
    file: File,
    known: std::vec::IntoIter<Outcome>,
}

impl Record {
    /// Opens the file of a search, or creates it. `head` is what the search depends on. An incomplete last line is dropped.
    ///
    /// # Errors
    /// [`Error::OtherTuning`] for the file of another search; [`Error::Io`].
    pub(super) fn open(path: &Path, head: &impl Serialize) -> Result<Self> {
        let io = |source| Error::Io { path: path.to_owned(), source };
        let other = |why: String| Error::OtherTuning { path: path.to_owned(), why };
        let head = serde_json::to_string(head).expect("plain data always serializes") + "\n";
        let text = match std::fs::read_to_string(path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            text => text.map_err(io)?,
        };
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let lines = match whole.strip_prefix(head.as_str()) {
            Some(lines) => lines,
            None if whole.is_empty() => "",
            None => {
                return Err(other(format!("it starts with {}", whole.lines().next().unwrap_or_default())));
            }
        };
        let known: Vec<Outcome> = lines
            .lines()
            .map(|line| serde_json::from_str(line).map_err(|error| other(error.to_string())))
            .collect::<Result<_>>()?;
        let mut file = append(path).map_err(io)?;
        file.set_len(whole.len() as u64).map_err(io)?;
        if whole.is_empty() {
            file.write_all(head.as_bytes()).map_err(io)?;
        }
        Ok(Self { path: path.to_owned(), file, known: known.into_iter() })
    }

    fn push(&mut self, outcome: &Outcome) -> Result<()> {
        let line = serde_json::to_string(outcome).expect("plain data always serializes") + "\n";
        let written = self.file.write_all(line.as_bytes());
        written.map_err(|source| Error::Io { path: self.path.clone(), source })
    }
}

#[cfg(test)]
mod tests {
    use super::super::outcome::Day;
    use super::*;

    #[test]
    fn a_record_returns_what_was_written_and_refuses_another_search() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("record.jsonl");
        let outcome = Outcome { days: vec![Day { used: 0.1 + 0.2, discomfort: 1.0 / 3.0 }; 2] };
        Record::open(&path, &"a").unwrap().push(&outcome).unwrap();
        let damaged = std::fs::read_to_string(&path).unwrap() + "{\"days\":";
        std::fs::write(&path, damaged).unwrap();
        let mut record = Record::open(&path, &"a").unwrap();
        assert_eq!((record.known.next(), record.known.next()), (Some(outcome), None));
        assert!(matches!(Record::open(&path, &"b"), Err(Error::OtherTuning { .. })));
    }
}
