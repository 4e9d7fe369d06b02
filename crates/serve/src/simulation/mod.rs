//! A test: an episode of the building that a client initializes, advances and queries for results.

mod history;
mod indicators;
mod run;
mod scenario;

use std::sync::Arc;

use b2b_env::Error;
use b2b_workers::{WorkerOptions, Workers};
use serde_json::{Value, json};

use crate::calls::{Answer, Arguments, Call, Refusal, shown, to_number, unknown};
use crate::subject::{DAYS, Subject, WeatherErrors, series, times};
use run::{Clock, Run};
use scenario::{Change, Scenario};

/// Default step, s, as in most test cases of BOPTEST.
const DEFAULT_STEP: f64 = 3600.0;
const DAY: f64 = 86_400.0;
const YEAR: f64 = DAYS as f64 * DAY;
/// Warm-up and length of a scenario, days.
const SCENARIO: [f64; 2] = [7.0, 14.0];
/// Longest forecast with weather errors, s, because their model was fitted to 48 hours.
const LONGEST_UNCERTAIN: f64 = 48.0 * 3600.0;
/// Maximum number of values in a forecast.
const MOST_FORECASTS: f64 = 2e6;
/// Tolerance on multiples of a control step.
const EPSILON: f64 = 1e-6;

/// The start and the end of a test, s of the year, and the duration of its warm-up, s.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Span {
    start: f64,
    warm_up: f64,
    end: f64,
}

/// A test in progress.
pub(crate) struct Simulation {
    subject: Arc<Subject>,
    workers: Workers,
    /// Whether the test begins at the start of the year if a client does not initialize it.
    begins_itself: bool,
    clock: Clock,
    /// Control steps of an advance.
    step: u32,
    scenario: Scenario,
    run: Option<Run>,
    /// Why the last run was lost.
    lost: Option<String>,
}

impl Simulation {
    /// Returns a test before its first run. One that was selected begins at the start of the year, as in BOPTEST,
    /// unless a client initializes it.
    ///
    /// # Errors
    /// The errors of [`Workers::new`].
    pub fn new(subject: Arc<Subject>, options: WorkerOptions, begins_itself: bool) -> Result<Self, Error> {
        let clock = Clock::new(subject.spaces.episode.steps_per_hour);
        Ok(Self {
            workers: Workers::new(options)?,
            step: clock.steps(DEFAULT_STEP),
            clock,
            subject,
            begins_itself,
            scenario: Scenario::default(),
            run: None,
            lost: None,
        })
    }

    /// Answers a call.
    pub fn answer(&mut self, call: Call, arguments: &Arguments) -> Answer {
        let answer = match call {
            Call::Name => Ok(Answer::new("the name of the test case", json!({"name": self.subject.name()}))),
            Call::Inputs => Ok(Answer::new("the inputs", self.subject.points.inputs_payload())),
            Call::Measurements => {
                Ok(Answer::new("the measurements", self.subject.points.measurements_payload()))
            }
            Call::ForecastPoints => Ok(Answer::new("the forecast points", self.subject.forecasts.payload())),
            Call::Step => Ok(Answer::new("the step of an advance, s", json!(self.step_seconds()))),
            Call::Scenario => Ok(Answer::new("the scenario", self.scenario.payload())),
            Call::Kpi => self.kpi(),
            Call::SetStep => self.set_step(arguments),
            Call::SetScenario => self.set_scenario(arguments),
            Call::Initialize => self.initialize(arguments),
            Call::Advance => self.advance(arguments),
            Call::Results => self.results(arguments),
            Call::Forecast => self.forecast(arguments),
            Call::Submit => Err(Refusal::with_status(
                501,
                "`submit` is left out: BOPTEST's dashboard has no results of these buildings; keep the results of GET /kpi",
            )),
        };
        answer.unwrap_or_else(Answer::from)
    }

    fn step_seconds(&self) -> f64 {
        self.clock.seconds(self.step)
    }

    fn kpi(&mut self) -> Result<Answer, Refusal> {
        let price = self.scenario.price;
        Ok(Answer::new("the indicators since the end of the warm-up", self.begun()?.indicators(price)))
    }

    fn set_step(&mut self, arguments: &Arguments) -> Result<Answer, Refusal> {
        arguments.expect(&["step"])?;
        let control = self.clock.seconds(1);
        let remedy = format!("expected a multiple of the control step of {control} s, at most {DAY}");
        let step = arguments.number("step", &remedy)?;
        let count = (step / control).round();
        if !(control..=DAY).contains(&step) || (step / control - count).abs() > EPSILON {
            return Err(Refusal::bad(format!("`step` is {step}; {remedy}")));
        }
        self.step = count as u32;
        Ok(Answer::new("the step is set", json!({"step": self.step_seconds()})))
    }

    fn set_scenario(&mut self, arguments: &Arguments) -> Result<Answer, Refusal> {
        let change = Change::read(arguments)?;
        let mut measurements = Value::Null;
        if let Some(weeks) = change.time_period {
            let first = self.subject.first_day(weeks).map(|day| f64::from(day - 1) * DAY);
            let start = first.ok_or_else(|| Refusal::bad(format!("the weather has no {weeks}")))?;
            let [warm_up, length] = SCENARIO.map(|days| days * DAY);
            let span = Span { start, warm_up, end: start + length };
            measurements = self.begin(span)?;
        }
        self.scenario.apply(&change);
        Ok(Answer::new("the scenario is set", change.payload(measurements)))
    }

    fn initialize(&mut self, arguments: &Arguments) -> Result<Answer, Refusal> {
        arguments.expect(&["start_time", "warmup_period"])?;
        let latest = YEAR - self.clock.seconds(1);
        let remedy = format!("expected seconds since 1 January, 0 to {latest}");
        let start = arguments.number("start_time", &remedy)?;
        if !(0.0..=latest).contains(&start) {
            return Err(Refusal::bad(format!("`start_time` is {start}; {remedy}")));
        }
        let remedy = "expected seconds before `start_time`, 0 or more";
        let warm_up = arguments.number("warmup_period", remedy)?;
        if warm_up < 0.0 {
            return Err(Refusal::bad(format!("`warmup_period` is {warm_up}; {remedy}")));
        }
        let measurements = self.begin(Span { start, warm_up, end: YEAR })?;
        self.scenario.time_period = None;
        let began = self.clock.seconds(self.clock.steps(start));
        let mut message = match began == start {
            true => format!("the test begins at {began} s"),
            false => format!("the test begins at {began} s, the control step before {start} s"),
        };
        if warm_up > start {
            message += &format!("; `warmup_period` is {warm_up}, but the warm-up begins on 1 January");
        }
        Ok(Answer::new(message, measurements))
    }

    /// Begins a run and returns its first measurements.
    fn begin(&mut self, span: Span) -> Result<Value, Refusal> {
        self.run = None;
        self.lost = None;
        match Run::begin(&self.subject, &self.workers, self.clock, span) {
            Ok(run) => Ok(self.run.insert(run).measurements()),
            Err(error) => Err(self.fail("the test cannot begin", &error)),
        }
    }

    /// The run in progress.
    fn begun(&mut self) -> Result<&mut Run, Refusal> {
        const REMEDY: &str =
            "PUT /initialize {start_time, warmup_period} or PUT /scenario {time_period} begins a run";
        if let Some(why) = &self.lost {
            return Err(Refusal::bad(format!("the last run ended with an error ({why}); {REMEDY}")));
        }
        if self.run.is_none() && self.begins_itself {
            self.begin(Span { start: 0.0, warm_up: 0.0, end: YEAR })?;
        }
        self.run.as_mut().ok_or_else(|| Refusal::bad(format!("no run has begun; {REMEDY}")))
    }

    /// Ends the run after an error.
    fn fail(&mut self, what: &str, error: &run::Error) -> Refusal {
        self.run = None;
        if let run::Error::Env(Error::Interrupted) = error {
            return Refusal::with_status(503, "the server is stopping");
        }
        self.lost = Some(error.to_string());
        Refusal::with_status(500, format!("{what}: {error}"))
    }

    fn advance(&mut self, arguments: &Arguments) -> Result<Answer, Refusal> {
        self.begun()?;
        let (overrides, mut notes) = self.overrides(arguments)?;
        let (subject, steps) = (Arc::clone(&self.subject), self.step);
        let run = self.begun()?;
        if run.is_over() {
            return Ok(Answer::new("the test is over; begin another to go on", json!({})));
        }
        let from = run.time();
        if let Err(error) = run.advance(&subject, &overrides, steps) {
            return Err(self.fail("the simulation failed", &error));
        }
        let run = self.begun()?;
        if notes.is_empty() {
            notes = format!("advanced from {from} s to {} s", run.time());
        }
        Ok(Answer::new(notes, run.measurements()))
    }

    /// The values of the activated inputs in the units of the action, with notes on clamped values.
    fn overrides(&self, arguments: &Arguments) -> Result<(Vec<Option<f64>>, String), Refusal> {
        let inputs = &self.subject.points.inputs;
        let names = || inputs.iter().flat_map(|input| [&input.value, &input.activation]).map(String::as_str);
        let is_known = |name: &str| name == "time" || names().any(|known| known == name);
        if let Some((name, _)) = arguments.iter().find(|(name, _)| !is_known(name)) {
            return Err(unknown("input", name, names(), "GET /inputs lists them"));
        }
        let mut notes = Vec::new();
        let mut overrides = Vec::with_capacity(inputs.len());
        for input in inputs {
            let [low, high] = input.bounds;
            let unit = input.unit.name;
            let remedy = format!("expected a number from {low} to {high} ({unit})");
            let is_active = activation(arguments, &input.activation)?;
            // A value that is not activated has no effect, but an invalid value is still refused.
            let value =
                arguments.get(&input.value).map(|_| arguments.number(&input.value, &remedy)).transpose()?;
            if value.is_some() && arguments.get(&input.activation).is_none() {
                notes.push(format!(
                    "WARNING: `{}` has no effect unless `{}` is 1",
                    input.value, input.activation
                ));
            }
            overrides.push(match (is_active, value) {
                (false, _) => None,
                (true, Some(value)) => {
                    let used = value.clamp(low, high);
                    if used != value {
                        notes.push(format!(
                            "WARNING: `{}` is {value}, beyond {low} to {high} ({unit}); {used} is used",
                            input.value
                        ));
                    }
                    Some(input.unit.own(used))
                }
                (true, None) => {
                    let missing = format!("`{}` is 1, but `{}` is missing", input.activation, input.value);
                    return Err(Refusal::bad(format!("{missing}; {remedy}")));
                }
            });
        }
        Ok((overrides, notes.join("; ")))
    }

    fn results(&mut self, arguments: &Arguments) -> Result<Answer, Refusal> {
        arguments.expect(&["point_names", "start_time", "final_time"])?;
        let points = arguments.names("point_names")?;
        let remedy = "expected seconds since 1 January";
        let [from, to] = ["start_time", "final_time"].map(|name| arguments.any_number(name, remedy));
        let (from, to) = (from?, to?);
        if from > to {
            return Err(Refusal::bad(format!(
                "`start_time` is {from}, after `final_time` {to}; exchange them"
            )));
        }
        Ok(Answer::new("the results", self.begun()?.results(&points, from, to)?))
    }

    fn forecast(&mut self, arguments: &Arguments) -> Result<Answer, Refusal> {
        arguments.expect(&["point_names", "horizon", "interval"])?;
        let points = arguments.names("point_names")?;
        let [horizon, interval] = forecast_length(arguments, points.len())?;
        let errors = self.scenario.errors();
        if errors != (WeatherErrors { seed: errors.seed, ..WeatherErrors::default() })
            && horizon > LONGEST_UNCERTAIN
        {
            return Err(Refusal::bad(format!(
                "`horizon` is {horizon}; at most {LONGEST_UNCERTAIN} s with errors of the weather forecast"
            )));
        }
        let now = self.begun()?.time();
        let times = times(now, horizon, interval);
        let Subject { forecasts, prices, .. } = &*self.subject;
        let mut named = Vec::with_capacity(points.len() + 1);
        for name in points.into_iter().filter(|name| name != "time") {
            let Some(values) = forecasts.values(&name, &times, prices, errors) else {
                let remedy = "GET /forecast_points lists them";
                return Err(unknown("forecast point", &name, forecasts.names(), remedy));
            };
            named.push((name, values));
        }
        named.push(("time".to_owned(), times));
        Ok(Answer::new("the forecast", series(named)))
    }
}

/// Horizon and interval of a forecast, s.
fn forecast_length(arguments: &Arguments, points: usize) -> Result<[f64; 2], Refusal> {
    let remedy = format!("expected seconds, 0 to {YEAR} (a year)");
    let horizon = arguments.number("horizon", &remedy)?;
    if !(0.0..=YEAR).contains(&horizon) {
        return Err(Refusal::bad(format!("`horizon` is {horizon}; {remedy}")));
    }
    let remedy = "expected seconds, more than 0";
    let interval = arguments.number("interval", remedy)?;
    if interval <= 0.0 {
        return Err(Refusal::bad(format!("`interval` is {interval}; {remedy}")));
    }
    let count = (horizon / interval + 1.0) * points.max(1) as f64;
    match count > MOST_FORECASTS {
        true => Err(Refusal::bad(format!(
            "`interval` {interval} makes {count:.0} values until `horizon` {horizon}; use a longer one: at most \
             {MOST_FORECASTS:.0} values"
        ))),
        false => Ok([horizon, interval]),
    }
}

/// Returns whether an input is activated.
fn activation(arguments: &Arguments, name: &str) -> Result<bool, Refusal> {
    let Some(value) = arguments.get(name) else { return Ok(false) };
    let is_one = match value {
        Value::Bool(active) => Some(*active),
        Value::String(text) if text.eq_ignore_ascii_case("true") => Some(true),
        Value::String(text) if text.eq_ignore_ascii_case("false") => Some(false),
        value => match to_number(value) {
            Some(1.0) => Some(true),
            Some(0.0) => Some(false),
            _ => None,
        },
    };
    is_one.ok_or_else(|| Refusal::bad(format!("`{name}` is `{}`; expected 1 or 0", shown(value))))
}
