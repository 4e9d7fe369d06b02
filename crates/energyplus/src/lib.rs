//! Control of [EnergyPlus](https://energyplus.net) simulations from Rust.
//!
//! A [`Simulation`] runs EnergyPlus as a coroutine: [`Simulation::advance`] is a plain call that computes one zone time
//! step and returns. Between calls the run is suspended at the end of a zone time step, where variables and meters can
//! be read and actuators set.
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
//! Limitations:
//!
//! - Runs may be interleaved on one thread, and a process may use several threads, but EnergyPlus itself must never run
//!   on two threads at once: its results would be silently wrong. Every call into it holds one process-wide lock, which
//!   [`exclusive`] holds for several calls; use several processes for parallel work.
//! - A crash of EnergyPlus (a segmentation fault in its C++ code) ends the process. A [`Host`] converts, sizes and runs
//!   models in other processes.

mod abort_line;
mod api;
mod confinement;
mod convert;
mod coroutine;
mod error;
mod event;
mod host;
pub mod install;
mod library;
mod message;
mod program;
mod simulation;
pub mod snapshot;

pub use confinement::{Confinement, confine, confine_with};
pub use error::{Error, Result};
pub use event::Event;
pub use host::Host;
pub use library::{Exclusive, Library, exclusive};
pub use message::{Level, Message, Messages};
pub use program::{Ended, run_program};
pub use simulation::{Actuator, Clock, Meter, Run, Simulation, Variable};
