//! Progress bars on standard error. They are hidden when standard error is not a terminal.

use std::ops::ControlFlow;
use std::time::Duration;

use b2b_building::{Date, RunPeriod};
use b2b_energyplus::install;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::terminal::interrupt;

/// Time between two frames of a spinner.
const TURN: Duration = Duration::from_millis(120);

const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// Returns a date such as `14 Jan`.
pub fn date_text(date: Date) -> String {
    format!("{} {}", date.day(), MONTHS[date.month() as usize - 1])
}

/// The progress of downloads. An interrupt cancels them.
pub struct Download {
    quiet: bool,
    bar: ProgressBar,
}

impl Download {
    /// Creates the progress of downloads, without a bar if `quiet`.
    pub fn new(quiet: bool) -> Self {
        Self { quiet, bar: ProgressBar::hidden() }
    }
}

impl install::Progress for Download {
    fn begin(&mut self, what: &str, total_bytes: u64) {
        self.bar = bar(total_bytes, "{msg}  {wide_bar} {bytes}/{total_bytes}", self.quiet);
        self.bar.set_message(what.to_owned());
        if self.bar.is_hidden() && !self.quiet {
            eprintln!("{what}");
        }
    }

    fn advance(&mut self, bytes: u64) -> ControlFlow<()> {
        self.bar.set_position(bytes);
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn end(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// The progress of an episode in simulated days.
pub struct Days {
    bar: ProgressBar,
    period: RunPeriod,
    steps_per_day: usize,
}

impl Days {
    /// Creates the progress of an episode, without a bar if `quiet`.
    pub fn new(period: RunPeriod, steps_per_hour: u32, quiet: bool) -> Self {
        let days = u64::from(period.days());
        let bar = bar(days, "{msg:>6}  {wide_bar} {pos}/{len} days, {days_per_second}", quiet);
        Self { bar, period, steps_per_day: 24 * steps_per_hour as usize }
    }

    /// Restarts the clock from which the speed is computed.
    pub fn start(&self) {
        self.bar.reset_elapsed();
    }

    /// Updates the bar to the number of completed steps, at the end of each day.
    pub fn step(&self, steps: usize) {
        if steps.is_multiple_of(self.steps_per_day) {
            self.bar.set_message(date_text(self.date(steps)));
            self.bar.set_position((steps / self.steps_per_day) as u64);
        }
    }

    /// Returns the date after a number of steps.
    pub fn date(&self, steps: usize) -> Date {
        let day = (steps / self.steps_per_day) as u32;
        self.period.date(day.min(self.period.days() - 1))
    }
}

impl Drop for Days {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Returns a bar that counts up to `length`.
pub fn counter(length: usize, name: &str, quiet: bool) -> ProgressBar {
    bar(length as u64, &format!("{{wide_bar}} {{pos}}/{{len}} {name}, {{eta}} left"), quiet)
}

/// Returns a bar of training steps that begins at `done`, with a message.
pub fn training(steps: u64, done: u64, quiet: bool) -> ProgressBar {
    let bar = bar(steps, "{wide_bar} {pos}/{len} steps, {msg}, {eta} left", quiet);
    bar.set_position(done);
    bar.reset_eta();
    bar
}

/// Returns a spinner with a message, for work of unknown length. It turns until it is finished.
pub fn spinner(message: String, quiet: bool) -> ProgressBar {
    let bar = bar(0, "{spinner} {msg}", quiet);
    bar.set_message(message);
    if !quiet {
        bar.enable_steady_tick(TURN);
    }
    bar
}

fn bar(length: u64, template: &str, quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let days_per_second = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
        let speed = state.pos() as f64 / state.elapsed().as_secs_f64().max(1e-3);
        // A progress bar that cannot be written must not stop the work.
        let _ = write!(out, "{speed:.0} simulated days/s");
    };
    let style = ProgressStyle::with_template(template).expect("the templates are constants that parse");
    let style = style.with_key("days_per_second", days_per_second).progress_chars("━╸ ");
    ProgressBar::with_draw_target(Some(length), target).with_style(style)
}
