//! Drive [EnergyPlus](https://energyplus.net) from Rust.
//!
//! A [`Simulation`] is a run of the engine as a coroutine: [`Simulation::advance`] is a plain call that
//! computes one zone time step and returns. Between two calls the run stands at the end of a zone time
//! step, where variables and meters are read and actuators are set.
//!
//! ```no_run
//! use b2b_energyplus::{Library, Run, Event};
//!
//! let library = Library::load("libenergyplusapi.so".as_ref())?;
//! let mut simulation = Run::new("model.epJSON", "weather.epw")
//!     .request("Zone Mean Air Temperature", "CORE_ZN")
//!     .start(&library)?;
//! let temperature = simulation.variable("Zone Mean Air Temperature", "CORE_ZN")?;
//! while let Some(event) = simulation.advance()? {
//!     if event == Event::Step {
//!         println!("{:.2} °C", simulation.read(temperature));
//!     }
//! }
//! # Ok::<(), b2b_energyplus::Error>(())
//! ```
//!
//! What to know of the engine:
//!
//! - Two runs may be interleaved on one thread, and a process may use several threads, but the engine
//!   itself must never run on two threads at once: its results are then silently wrong. Every entry into it
//!   is under one process-wide lock, so parallel work belongs in several processes.
//! - A crash of the engine (a segmentation fault in its C++ code) ends the process. Validate models first.

mod api;
mod convert;
mod coroutine;
pub mod digest;
mod error;
pub mod install;
mod library;
mod message;
mod simulation;
#[cfg(target_os = "linux")]
pub mod snapshot;

pub use error::{Error, Result};
pub use library::Library;
pub use message::{Level, Message, Messages};
pub use simulation::{Actuator, Clock, Event, Meter, Run, Simulation, Variable};
