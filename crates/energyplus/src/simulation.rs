//! A run of a model over a weather file, advanced one zone time step at a time.

#![allow(unsafe_code, reason = "the C API of EnergyPlus")]

use std::io::Read;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::confinement::confined;
use crate::coroutine::{EngineRun, Outcome, Stops, c_string};
use crate::event::Event;
use crate::message::{Level, Messages};
use crate::{Error, Library, Result};
use b2b_base::scratch::temporary_folder;

/// Byte order mark of UTF-8.
const MARK: &[u8; 3] = b"\xef\xbb\xbf";

/// A run to be started: model, weather file and the variables to read.
#[derive(Clone, Debug)]
pub struct Run {
    model: PathBuf,
    weather: PathBuf,
    output: Option<PathBuf>,
    requests: Vec<(String, String)>,
    stops: Stops,
}

impl Run {
    /// Creates a run of a model (IDF or epJSON) over a weather file (EPW).
    pub fn new(model: impl Into<PathBuf>, weather: impl Into<PathBuf>) -> Self {
        Self {
            model: model.into(),
            weather: weather.into(),
            output: None,
            requests: Vec::new(),
            stops: Stops { warmup_steps: false, every: 1 },
        }
    }

    /// Sets the output folder of EnergyPlus. Default: a temporary folder, removed with the simulation.
    #[must_use]
    pub fn output(mut self, folder: impl Into<PathBuf>) -> Self {
        self.output = Some(folder.into());
        self
    }

    /// Requests a variable: only requested variables can be read.
    #[must_use]
    pub fn request(mut self, name: impl Into<String>, key: impl Into<String>) -> Self {
        self.requests.push((name.into(), key.into()));
        self
    }

    /// Suspends the run at every zone time step of warm-up too, so that warm-up can be controlled.
    #[must_use]
    pub fn yield_in_warmup(mut self) -> Self {
        self.stops.warmup_steps = true;
        self
    }

    /// Suspends the run after every `steps` zone time steps of the run period instead of each; 0 for never.
    #[must_use]
    pub fn stop_every(mut self, steps: u32) -> Self {
        self.stops.every = steps;
        self
    }

    /// Starts the run and advances it to [`Event::Started`]: input read, systems sized, handles ready.
    ///
    /// # Errors
    /// [`Error::MissingFile`] if an input file does not exist; [`Error::Engine`] if EnergyPlus rejects the input;
    /// [`Error::Ended`] if the model has no run period.
    pub fn start(self, library: &Library) -> Result<Simulation> {
        let mut simulation = self.prepare(library)?;
        match simulation.advance()? {
            Some(Event::Started) => Ok(simulation),
            _ => Err(simulation.ended()),
        }
    }

    /// Runs the model to its end without suspending, like the EnergyPlus command, and returns its messages. Output goes
    /// to the output folder; without one, only the messages are kept and no [`Host`](crate::Host) is used. Runs in a
    /// thread that is confined as by [`confine`](crate::confine) but may also write to this folder.
    ///
    /// # Errors
    /// The errors of [`Run::start`].
    pub fn to_end(self, library: &Library) -> Result<Messages> {
        let output = self.output.clone();
        if let (Some(host), Some(output)) = (&library.host, &output) {
            return host.run_to_end(&self.model, &self.weather, output);
        }
        confined(output.as_deref(), || {
            let mut simulation = self.stop_every(0).prepare(library)?;
            while simulation.advance()?.is_some() {}
            Ok(simulation.messages())
        })
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
                let temporary = temporary_folder("b2b-")?;
                (temporary.path().to_owned(), Some(temporary))
            }
        };
        let weather = without_mark(&self.weather, &folder)?;
        let arguments =
            ["energyplus", "-d", path_text(&folder)?, "-w", path_text(&weather)?, path_text(&self.model)?];
        let run = EngineRun::new(library, &arguments, &self.requests, self.stops)?;
        Ok(Simulation { run, model: self.model, _temporary: temporary })
    }
}

/// Returns a weather file, or, if it begins with a byte order mark, a copy without it in `folder`: the engine would not
/// recognize the first line and would simulate another location.
fn without_mark(weather: &Path, folder: &Path) -> Result<PathBuf> {
    let failed = |path: &Path, source| Error::Io { path: path.to_owned(), source };
    let mut first = [0; MARK.len()];
    let file = std::fs::File::open(weather);
    let read = file.and_then(|mut file| file.read(&mut first)).map_err(|source| failed(weather, source))?;
    if first[..read] != *MARK {
        return Ok(weather.to_owned());
    }
    let bytes = std::fs::read(weather).map_err(|source| failed(weather, source))?;
    let copy = folder.join("weather.epw");
    std::fs::write(&copy, &bytes[MARK.len()..]).map_err(|source| failed(&copy, source))?;
    Ok(copy)
}

pub(crate) fn path_text(path: &Path) -> Result<&str> {
    path.to_str().ok_or_else(|| Error::Io {
        path: path.to_owned(),
        source: std::io::Error::other("the path is not valid UTF-8, which EnergyPlus requires"),
    })
}

/// Handle of an output variable; valid for the simulation that returned it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variable(i32);

/// Handle of a meter; valid for the simulation that returned it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Meter(i32);

/// Handle of an actuator; valid for the simulation that returned it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Actuator(i32);

/// The clock of EnergyPlus at the end of the last zone time step.
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

/// A run in progress: see the [crate] documentation.
///
/// Dropping it stops EnergyPlus cleanly within a few milliseconds and removes its temporary files.
pub struct Simulation {
    // Fields are dropped in order: the run ends before its folder is removed.
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
    /// Advances to the next [`Event`]. Returns `None` at the end of the run period.
    ///
    /// # Errors
    /// [`Error::Engine`] with the messages of EnergyPlus if it terminated by itself.
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

    /// Stops the run. Further calls of [`Simulation::advance`] return `None`.
    pub fn stop(&mut self) {
        self.run.stop();
    }

    /// Returns the handle of a requested variable, for example `Zone Mean Air Temperature` of a zone.
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

    /// Returns the handle of a meter, for example `Electricity:HVAC`. No `Output:Meter` object is needed.
    ///
    /// # Errors
    /// [`Error::UnknownMeter`].
    pub fn meter(&self, name: &str) -> Result<Meter> {
        let c_name = c_string(name)?;
        // SAFETY: the state is live; the string lives through the call.
        let handle = unsafe { (self.run.api().getMeterHandle)(self.run.state(), c_name.as_ptr()) };
        // The first meter of every model, `Electricity:Facility`, has index 0, which the lookup of EnergyPlus reports
        // as not found.
        let first = name.eq_ignore_ascii_case("Electricity:Facility").then_some(0);
        let handle = if handle >= 0 { Some(handle) } else { first };
        handle.map(Meter).ok_or_else(|| Error::UnknownMeter { name: name.to_owned() })
    }

    /// Returns the handle of an actuator, given component type, control type and object name.
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

    /// Returns the value of a variable, in its unit in the EnergyPlus documentation.
    #[inline]
    pub fn read(&self, variable: Variable) -> f64 {
        // SAFETY: the state is live; the engine checks the range of the handle.
        unsafe { (self.run.api().getVariableValue)(self.run.state(), variable.0) }
    }

    /// Returns the meter reading of the last zone time step, J (or the unit of the meter).
    #[inline]
    pub fn read_meter(&self, meter: Meter) -> f64 {
        // SAFETY: the state is live; the engine checks the range of the handle.
        unsafe { (self.run.api().getMeterValue)(self.run.state(), meter.0) }
    }

    /// Sets an actuator; the value holds until it is set again. It must be finite: EnergyPlus does not check it.
    #[inline]
    pub fn set(&mut self, actuator: Actuator, value: f64) {
        debug_assert!(value.is_finite(), "actuator set to {value}");
        // SAFETY: the state is live; the engine checks the range of the handle.
        unsafe { (self.run.api().setActuatorValue)(self.run.state(), actuator.0, value) }
    }

    /// Returns the clock of EnergyPlus.
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

    /// Returns the messages of EnergyPlus so far.
    pub fn messages(&self) -> Messages {
        self.run.messages()
    }

    /// Returns the number of messages of a level so far; cheaper than [`Simulation::messages`].
    pub fn message_count(&self, level: Level) -> usize {
        self.run.with_messages(|m| m.count(level))
    }

    fn ended(&self) -> Error {
        Error::Ended { model: self.model.clone() }
    }
}
