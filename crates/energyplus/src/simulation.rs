//! A run of a model over a weather file, advanced one zone time step at a time.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::coroutine::{EngineRun, Outcome, Stops, c_string};
use crate::message::{Level, Messages};
use crate::{Error, Library, Result};

/// Where a run stands when [`Simulation::advance`] returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Before the first zone time step of warm-up: handles can be had and actuators set.
    Started,
    /// At the end of a zone time step of warm-up (only with [`Run::yield_in_warmup`]).
    WarmupStep,
    /// Warm-up is complete: the next step is the first of the run period.
    WarmedUp,
    /// At the end of a zone time step of the run period.
    Step,
}

/// What to run: a model, a weather file, and the variables that will be read.
#[derive(Clone, Debug)]
pub struct Run {
    model: PathBuf,
    weather: PathBuf,
    output: Option<PathBuf>,
    requests: Vec<(String, String)>,
    stops: Stops,
}

impl Run {
    /// A run of a model (IDF or epJSON) over a weather file (EPW).
    pub fn new(model: impl Into<PathBuf>, weather: impl Into<PathBuf>) -> Self {
        Self {
            model: model.into(),
            weather: weather.into(),
            output: None,
            requests: Vec::new(),
            stops: Stops { warmup_steps: false, every: 1 },
        }
    }

    /// Where the engine writes its files. By default a temporary folder that goes with the simulation.
    #[must_use]
    pub fn output(mut self, folder: impl Into<PathBuf>) -> Self {
        self.output = Some(folder.into());
        self
    }

    /// Announces a variable that will be read: the engine computes only what is asked for.
    #[must_use]
    pub fn request(mut self, name: impl Into<String>, key: impl Into<String>) -> Self {
        self.requests.push((name.into(), key.into()));
        self
    }

    /// Suspends the run at every zone time step of warm-up too, so that it can be controlled there.
    #[must_use]
    pub fn yield_in_warmup(mut self) -> Self {
        self.stops.warmup_steps = true;
        self
    }

    /// Suspends the run at the end of every so many zone time steps of the run period, instead of every one; 0 is
    /// never. This is the engine at its own speed.
    #[must_use]
    pub fn stop_every(mut self, steps: u32) -> Self {
        self.stops.every = steps;
        self
    }

    /// Starts the run and takes it to [`Event::Started`]: input read, systems sized, handles ready.
    ///
    /// # Errors
    /// [`Error::MissingFile`] before the engine is asked; [`Error::Engine`] when it refuses the input.
    pub fn start(self, library: &Library) -> Result<Simulation> {
        let mut simulation = self.prepare(library)?;
        match simulation.advance()? {
            Some(Event::Started) => Ok(simulation),
            _ => Err(simulation.ended()),
        }
    }

    /// Runs the model to its end without stopping anywhere, as the EnergyPlus command does, and returns
    /// what it said. What it wrote is in the output folder.
    ///
    /// # Errors
    /// As [`Run::start`].
    pub fn to_end(self, library: &Library) -> Result<Messages> {
        let mut simulation = self.stop_every(0).prepare(library)?;
        while simulation.advance()?.is_some() {}
        Ok(simulation.messages())
    }

    fn prepare(self, library: &Library) -> Result<Simulation> {
        for (what, path) in [("model", &self.model), ("weather file", &self.weather)] {
            if !path.is_file() {
                return Err(Error::MissingFile { what, path: path.clone() });
            }
        }
        let (folder, temporary) = match &self.output {
            Some(folder) => (folder.clone(), None),
            None => {
                let temporary = temporary_folder()?;
                (temporary.path().to_owned(), Some(temporary))
            }
        };
        let arguments = [
            "energyplus",
            "-d",
            path_text(&folder)?,
            "-w",
            path_text(&self.weather)?,
            path_text(&self.model)?,
        ];
        let run = EngineRun::new(library, &arguments, &self.requests, self.stops)?;
        Ok(Simulation { run, model: self.model, _temporary: temporary })
    }
}

/// A temporary folder for the engine's files.
pub(crate) fn temporary_folder() -> Result<TempDir> {
    tempfile::Builder::new()
        .prefix("b2b-")
        .tempdir()
        .map_err(|source| Error::Io { path: std::env::temp_dir(), source })
}

pub(crate) fn path_text(path: &Path) -> Result<&str> {
    path.to_str().ok_or_else(|| Error::Io {
        path: path.to_owned(),
        source: std::io::Error::other("the path is not valid UTF-8, which EnergyPlus needs"),
    })
}

/// A variable that can be read; belongs to the simulation that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variable(i32);

/// A meter that can be read; belongs to the simulation that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Meter(i32);

/// An actuator that can be set; belongs to the simulation that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Actuator(i32);

/// The engine's clock at the end of the last zone time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Hours since the start of the run period.
    pub elapsed_hours: f64,
    /// Hour of the day in (0, 24], the end of the step.
    pub hour_of_day: f64,
    /// Day of the year, 1 to 366.
    pub day_of_year: u16,
    /// Day of the week, 1 (Sunday) to 7 (Saturday).
    pub day_of_week: u8,
}

/// A run in progress. See the [crate] for what it promises.
///
/// Dropping it stops the engine cleanly (a few milliseconds) and removes its temporary files.
pub struct Simulation {
    // The order matters: the run ends before its folder goes.
    run: EngineRun,
    model: PathBuf,
    _temporary: Option<TempDir>,
}

impl std::fmt::Debug for Simulation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Simulation({})", self.model.display())
    }
}

impl Simulation {
    /// Computes on to the next [`Event`]; `None` when the run period is over.
    ///
    /// # Errors
    /// [`Error::Engine`] with the engine's own messages when it stopped by itself.
    #[inline]
    pub fn advance(&mut self) -> Result<Option<Event>> {
        match self.run.resume() {
            Outcome::At(event) => Ok(Some(event)),
            Outcome::Returned(0) => Ok(None),
            Outcome::Returned(code) => {
                Err(Error::Engine { code, model: self.model.clone(), messages: self.run.messages() })
            }
        }
    }

    /// Ends the run now. Further calls of [`Simulation::advance`] return `None`.
    pub fn stop(&mut self) {
        self.run.stop();
    }

    /// A handle to a requested variable, for example `Zone Mean Air Temperature` of a zone.
    ///
    /// # Errors
    /// [`Error::UnknownVariable`].
    pub fn variable(&self, name: &str, key: &str) -> Result<Variable> {
        let (c_name, c_key) = (c_string(name)?, c_string(key)?);
        // SAFETY: the state is live; the strings live through the call.
        let handle =
            unsafe { (self.run.api().getVariableHandle)(self.run.state(), c_name.as_ptr(), c_key.as_ptr()) };
        (handle >= 0)
            .then_some(Variable(handle))
            .ok_or_else(|| Error::UnknownVariable { name: name.to_owned(), key: key.to_owned() })
    }

    /// A handle to a meter, for example `Electricity:HVAC`. No `Output:Meter` is needed.
    ///
    /// # Errors
    /// [`Error::UnknownMeter`].
    pub fn meter(&self, name: &str) -> Result<Meter> {
        let c_name = c_string(name)?;
        // SAFETY: the state is live; the string lives through the call.
        let handle = unsafe { (self.run.api().getMeterHandle)(self.run.state(), c_name.as_ptr()) };
        // The first meter of every model, `Electricity:Facility`, has index 0, which the engine's look-up
        // takes for "not found".
        let first = name.eq_ignore_ascii_case("Electricity:Facility").then_some(0);
        let handle = if handle >= 0 { Some(handle) } else { first };
        handle.map(Meter).ok_or_else(|| Error::UnknownMeter { name: name.to_owned() })
    }

    /// A handle to an actuator: component type, control type and object name.
    ///
    /// # Errors
    /// [`Error::UnknownActuator`].
    pub fn actuator(&self, component: &str, control: &str, key: &str) -> Result<Actuator> {
        let (c_component, c_control, c_key) = (c_string(component)?, c_string(control)?, c_string(key)?);
        // SAFETY: the state is live; the strings live through the call.
        let handle = unsafe {
            (self.run.api().getActuatorHandle)(
                self.run.state(),
                c_component.as_ptr(),
                c_control.as_ptr(),
                c_key.as_ptr(),
            )
        };
        (handle >= 0).then_some(Actuator(handle)).ok_or_else(|| Error::UnknownActuator {
            component: component.to_owned(),
            control: control.to_owned(),
            key: key.to_owned(),
        })
    }

    /// The value of a variable, in the unit that the engine's documentation gives for it.
    #[inline]
    pub fn read(&self, variable: Variable) -> f64 {
        // SAFETY: the state is live; the engine checks the range of the handle.
        unsafe { (self.run.api().getVariableValue)(self.run.state(), variable.0) }
    }

    /// The energy of the last zone time step, J (or the meter's own unit).
    #[inline]
    pub fn read_meter(&self, meter: Meter) -> f64 {
        // SAFETY: the state is live; the engine checks the range of the handle.
        unsafe { (self.run.api().getMeterValue)(self.run.state(), meter.0) }
    }

    /// Sets an actuator; it holds until it is set again. The value must be finite: the engine does not
    /// check it.
    #[inline]
    pub fn set(&mut self, actuator: Actuator, value: f64) {
        debug_assert!(value.is_finite(), "an actuator was given {value}");
        // SAFETY: the state is live; the engine checks the range of the handle.
        unsafe { (self.run.api().setActuatorValue)(self.run.state(), actuator.0, value) }
    }

    /// What an actuator was last set to.
    pub fn actuator_value(&self, actuator: Actuator) -> f64 {
        // SAFETY: the state is live; the engine checks the range of the handle.
        unsafe { (self.run.api().getActuatorValue)(self.run.state(), actuator.0) }
    }

    /// The engine's clock.
    pub fn clock(&self) -> Clock {
        let (api, state) = (self.run.api(), self.run.state());
        // SAFETY: the state is live; the functions only read it.
        unsafe {
            Clock {
                elapsed_hours: (api.currentSimTime)(state),
                hour_of_day: (api.currentTime)(state),
                day_of_year: (api.dayOfYear)(state) as u16,
                day_of_week: (api.dayOfWeek)(state) as u8,
            }
        }
    }

    /// What the engine has said up to now.
    pub fn messages(&self) -> Messages {
        self.run.messages()
    }

    /// How many messages of a level the engine has given up to now; cheaper than [`Simulation::messages`].
    pub fn message_count(&self, level: Level) -> usize {
        self.run.with_messages(|m| m.count(level))
    }

    fn ended(&self) -> Error {
        Error::Ended { model: self.model.clone() }
    }
}
