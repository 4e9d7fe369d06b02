//! A run of a test: one episode, its controller, and the record of its steps.

use std::time::Instant;

use b2b_building::{Date, RunPeriod};
use b2b_control::AnyController;
use b2b_env::Environment;
use b2b_tariff::Moment;
use b2b_workers::{Episode, Workers};
use serde_json::Value;

use super::Span;
use super::history::History;
use super::indicators::Indicators;
use crate::calls::Refusal;
use crate::subject::{DAYS, PriceScenario, Subject};

/// Why a run ends early.
#[derive(Debug, thiserror::Error)]
pub(super) enum Error {
    /// The engine or its process.
    #[error(transparent)]
    Env(#[from] b2b_env::Error),
    /// The baseline controller.
    #[error(transparent)]
    Control(#[from] b2b_control::Error),
}

/// Converts between times and control steps of the year.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    per_hour: u32,
}

impl Clock {
    /// Returns a clock with this many control steps per hour.
    pub fn new(per_hour: u32) -> Self {
        Self { per_hour }
    }

    /// Returns the time at the beginning of a control step, s.
    pub fn seconds(self, step: u32) -> f64 {
        f64::from(step) * 3600.0 / f64::from(self.per_hour)
    }

    /// Returns the control step that a time is in.
    pub fn steps(self, seconds: f64) -> u32 {
        (seconds * f64::from(self.per_hour) / 3600.0 + 1e-6).floor() as u32
    }

    fn per_day(self) -> u32 {
        24 * self.per_hour
    }

    /// Returns the moment at which a control step begins.
    fn moment(self, step: u32) -> Moment {
        let hour = f64::from(step % self.per_day()) / f64::from(self.per_hour);
        Moment { day: step / self.per_day() % DAYS + 1, hour }
    }
}

/// A run.
pub(super) struct Run {
    clock: Clock,
    episode: Episode,
    baseline: Box<dyn AnyController>,
    action: Vec<f64>,
    /// Control steps of the year, now and at the end of the test.
    now: u32,
    end: u32,
    history: History,
    indicators: Indicators,
    pauses: Pauses,
}

impl Run {
    /// Begins a run: the engine starts at midnight before the warm-up, and the baseline controls the building until the
    /// start of the test.
    ///
    /// # Errors
    /// The errors of the episode and of the controller.
    pub fn begin(subject: &Subject, workers: &Workers, clock: Clock, span: Span) -> Result<Self, Error> {
        let [start, end] = [span.start, span.end].map(|time| clock.steps(time));
        let kept = clock.steps((span.start - span.warm_up).max(0.0));
        let first_day = kept / clock.per_day() + 1;
        let last_day = end.div_ceil(clock.per_day());
        let period = RunPeriod::new(Date::of_day(first_day), Date::of_day(last_day));
        let mut episode = workers.episode(&subject.setting(period))?;
        episode.reset()?;
        let spaces = episode.spaces().clone();
        let mut run = Self {
            clock,
            baseline: subject.baseline(&spaces)?,
            action: vec![0.0; spaces.action.len()],
            now: (first_day - 1) * clock.per_day(),
            end,
            history: History::new(&subject.points, clock.seconds(kept), clock.seconds(1)),
            indicators: Indicators::begin(&spaces, episode.observation(), first_day),
            pauses: Pauses::default(),
            episode,
        };
        let none = vec![None; run.action.len()];
        while run.now < kept {
            run.step(subject, &none)?;
        }
        run.keep_first(subject, &none);
        while run.now < start {
            run.step(subject, &none)?;
            run.keep(subject, &none);
        }
        run.indicators = Indicators::begin(&spaces, run.episode.observation(), clock.moment(start).day);
        Ok(run)
    }

    /// Keeps the first row, with the inputs that the baseline is about to set.
    fn keep_first(&mut self, subject: &Subject, none: &[Option<f64>]) {
        let observation = self.episode.observation();
        self.baseline.boxed_clone().act(observation, &mut self.action);
        self.history.add(&subject.points, observation, &self.action, none);
    }

    fn keep(&mut self, subject: &Subject, overrides: &[Option<f64>]) {
        self.history.add(&subject.points, self.episode.observation(), &self.action, overrides);
    }

    /// Advances one control step: the baseline sets every actuator, then the activated inputs replace its values.
    fn step(&mut self, subject: &Subject, overrides: &[Option<f64>]) -> Result<(), Error> {
        self.baseline.act(self.episode.observation(), &mut self.action);
        for (actuator, value) in self.action.iter_mut().zip(overrides) {
            *actuator = value.unwrap_or(*actuator);
        }
        let began = self.clock.moment(self.now);
        let step = self.episode.step(&self.action)?;
        self.indicators.add(began, step.observation, &step.terms, &subject.prices);
        self.action.copy_from_slice(step.action);
        self.now += 1;
        Ok(())
    }

    /// Advances by a number of control steps, or to the end of the test if that comes first.
    ///
    /// # Errors
    /// The errors of the episode.
    pub fn advance(&mut self, subject: &Subject, overrides: &[Option<f64>], steps: u32) -> Result<(), Error> {
        self.pauses.end(self.clock.seconds(steps));
        let until = self.end.min(self.now + steps);
        while self.now < until {
            self.step(subject, overrides)?;
            self.keep(subject, overrides);
        }
        self.pauses.begin();
        Ok(())
    }

    /// Returns whether the test is at its end.
    pub fn is_over(&self) -> bool {
        self.now >= self.end
    }

    /// Returns the time, s of the year.
    pub fn time(&self) -> f64 {
        self.clock.seconds(self.now)
    }

    /// Returns the current values of all points.
    pub fn measurements(&self) -> Value {
        self.history.last()
    }

    /// Returns the values of points between two times.
    ///
    /// # Errors
    /// Same as [`History::between`].
    pub fn results(&self, points: &[String], from: f64, to: f64) -> Result<Value, Refusal> {
        self.history.between(points, from, to)
    }

    /// Returns the indicators since the start of the test.
    pub fn indicators(&self, price: PriceScenario) -> Value {
        self.indicators.payload(price, self.pauses.mean())
    }
}

/// The client's time between two advances, as a share of the step.
#[derive(Debug, Default)]
struct Pauses {
    since: Option<Instant>,
    sum: f64,
    count: u32,
}

impl Pauses {
    fn begin(&mut self) {
        self.since = Some(Instant::now());
    }

    fn end(&mut self, step: f64) {
        if let Some(since) = self.since.take() {
            self.sum += since.elapsed().as_secs_f64() / step;
            self.count += 1;
        }
    }

    fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_in_the_control_step_that_began_last() {
        let clock = Clock::new(12);
        assert_eq!([0.0, 299.0, 300.0, 86_399.9].map(|time| clock.steps(time)), [0, 0, 1, 287]);
        assert_eq!(clock.moment(288 + 6), Moment { day: 2, hour: 0.5 });
        assert_eq!(clock.seconds(288), 86_400.0);
        let coarse = Clock::new(6);
        assert_eq!((0..500).find(|step| coarse.steps(coarse.seconds(*step)) != *step), None);
    }
}
