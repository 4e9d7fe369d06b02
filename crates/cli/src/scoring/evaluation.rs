//! Parallel runs of lists of episodes, with progress bars and interrupts.

use std::collections::HashSet;
use std::sync::Mutex;

use anyhow::Result;
use b2b_dataset::{BuildingName, Catalog};
use b2b_evaluate::{EpisodePlan, Evaluation, Progress};
use indicatif::ProgressBar;

use crate::program::{self, weather};
use crate::terminal::interrupt;
use crate::terminal::progress::counter;

/// Returns an evaluation whose episodes run in worker processes of this program.
pub fn evaluation(catalog: &Catalog, jobs: usize) -> Evaluation<'_> {
    Evaluation { catalog, launcher: program::launcher(), jobs, interrupted: interrupt::requested }
}

/// Downloads the weather of dataset buildings in advance, with a progress bar and interrupts. The weather of types and
/// model files is fetched later.
pub fn fetch_weather(episodes: &[EpisodePlan], quiet: bool) -> Result<()> {
    let of_dataset = |episode: &EpisodePlan| match episode.subject.name {
        BuildingName::Id(id) => Some(&b2b_dataset::row(id).building),
        BuildingName::Type(_) | BuildingName::Model(_) => None,
    };
    weather::fetch(episodes.iter().filter_map(of_dataset), quiet)
}

/// A progress bar of simulated days, one for each stage of an evaluation.
pub struct Bars {
    quiet: bool,
    bar: Mutex<ProgressBar>,
    /// The notes that have been printed.
    notes: Mutex<HashSet<String>>,
}

impl Bars {
    /// Creates the progress of an evaluation, without bars if `quiet`.
    pub fn new(quiet: bool) -> Self {
        Self { quiet, bar: Mutex::new(ProgressBar::hidden()), notes: Mutex::default() }
    }

    fn with(&self, change: impl FnOnce(&mut ProgressBar)) {
        change(&mut self.bar.lock().unwrap_or_else(std::sync::PoisonError::into_inner));
    }
}

impl Progress for Bars {
    fn begin(&self, what: &str, episodes: usize, days: u64) {
        self.with(|bar| {
            bar.finish_and_clear();
            if episodes > 0 {
                *bar = counter(days as usize, &format!("simulated days of {episodes} {what}"), self.quiet);
            }
        });
    }

    fn day(&self) {
        self.with(|bar| bar.inc(1));
    }

    fn note(&self, building: &str, note: &str) {
        let line = format!("{building}: {note}");
        let mut notes = self.notes.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if notes.insert(line.clone()) {
            self.with(|bar| bar.suspend(|| eprintln!("{line}")));
        }
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        self.with(|bar| bar.finish_and_clear());
    }
}
