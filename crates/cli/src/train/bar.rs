//! The progress bar of a training run.

use b2b_learn::train::{Monitor, Row};
use indicatif::ProgressBar;

use crate::progress::{spinner, training};

/// A bar of environment steps with speed and scores.
pub struct Bar {
    quiet: bool,
    steps: u64,
    bar: ProgressBar,
    is_counting: bool,
    /// Scores of the last evaluation.
    evaluated: String,
}

impl Bar {
    /// Creates the bar, hidden if `quiet`.
    pub fn new(steps: u64, quiet: bool) -> Self {
        Self { quiet, steps, bar: ProgressBar::hidden(), is_counting: false, evaluated: String::new() }
    }

    /// Removes the bar.
    pub fn finish(&mut self) {
        self.bar.finish_and_clear();
    }

    fn replace(&mut self, bar: ProgressBar) {
        self.bar.finish_and_clear();
        self.bar = bar;
    }
}

impl Monitor for Bar {
    fn stage(&mut self, what: &str) {
        self.is_counting = false;
        self.replace(spinner(what.to_owned(), self.quiet));
        if self.bar.is_hidden() && !self.quiet {
            eprintln!("{what}");
        }
    }

    fn update(&mut self, row: &Row) {
        if !std::mem::replace(&mut self.is_counting, true) {
            let bar = training(self.steps, row.steps, self.quiet);
            self.replace(bar);
        }
        if let (Some(score), Some(rms), Some(energy)) =
            (row.get("score"), row.get("rms_deviation_k"), row.get("energy_ratio"))
        {
            self.evaluated = format!("score {score:.3}, RMS {rms:.2} K, energy {energy:.2}");
            if self.bar.is_hidden() && !self.quiet {
                eprintln!("{} steps: {}", row.steps, self.evaluated);
            }
        }
        let speed = row.get("steps_per_s").unwrap_or_default();
        self.bar.set_message(format!("{speed:.0}/s  {}", self.evaluated));
        self.bar.set_position(row.steps);
    }

    fn warn(&mut self, text: &str) {
        self.bar.suspend(|| eprintln!("warning: {text}"));
    }
}
