//! The progress bar of a training run.

use b2b_learn::train::{Monitor, ProgressRow};
use indicatif::ProgressBar;

use crate::terminal::progress::{spinner, training};

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

    fn evaluating(&mut self, steps: u64) {
        self.is_counting = false;
        self.replace(spinner(format!("{steps} steps: evaluating the agent"), self.quiet));
    }

    fn learning(&mut self, steps: u64) {
        if !std::mem::replace(&mut self.is_counting, true) {
            let bar = training(self.steps, steps.min(self.steps), self.quiet);
            self.replace(bar);
        }
    }

    fn update(&mut self, row: &ProgressRow) {
        self.learning(row.steps);
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
        // The last rollout may go beyond the end.
        self.bar.set_position(row.steps.min(self.steps));
    }

    fn warn(&mut self, text: &str) {
        self.bar.suspend(|| eprintln!("warning: {text}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_ends_at_its_length_and_an_evaluation_has_no_time_left() {
        let mut bar = Bar::new(60_000, true);
        let row = |steps| ProgressRow { steps, values: vec![("steps_per_s", 1000.0)] };
        bar.update(&row(30_000));
        assert_eq!((bar.bar.position(), bar.bar.length()), (30_000, Some(60_000)));
        bar.evaluating(0);
        bar.learning(0);
        assert_eq!(bar.bar.length(), Some(60_000), "the first update takes its time");
        bar.evaluating(62_208);
        assert_eq!(bar.bar.length(), Some(0), "a spinner, which has no length");
        assert_eq!(bar.bar.message(), "62208 steps: evaluating the agent");
        bar.update(&row(62_208));
        assert_eq!((bar.bar.position(), bar.bar.length()), (60_000, Some(60_000)));
    }
}
