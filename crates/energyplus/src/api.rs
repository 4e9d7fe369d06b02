//! The functions of the C API of EnergyPlus that this crate calls.

#![allow(unsafe_code, reason = "the C API of EnergyPlus")]

use std::ffi::{c_char, c_int, c_void};
use std::path::Path;

/// Opaque state of EnergyPlus.
pub(crate) type State = *mut c_void;
/// Callback at a point of the run.
pub(crate) type StateCallback = extern "C" fn(State);
/// Callback with an error level and a message.
pub(crate) type ErrorCallback = extern "C" fn(c_int, *const c_char);
/// Callback with a line of standard output.
pub(crate) type ConsoleCallback = extern "C" fn(*const c_char);

macro_rules! functions {
    ($(fn $name:ident($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// Function pointers; always valid, as the library is never unloaded.
        #[allow(non_snake_case)]
        pub(crate) struct Api {
            $(pub(crate) $name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Api {
            /// Loads the library and resolves every function. It is never unloaded: unloading would run C++ destructors
            /// while it may still be in use.
            pub(crate) fn load(path: &Path) -> Result<Self, libloading::Error> {
                // SAFETY: loading runs the initializers of a library that the user named as EnergyPlus,
                // which only set up its own static data.
                let library = std::mem::ManuallyDrop::new(unsafe { libloading::Library::new(path)? });
                Ok(Self {
                    // SAFETY: the signatures below match the engine's C headers (25.2); the pointers stay valid because
                    // the library is never unloaded.
                    $($name: unsafe { *library.get(concat!(stringify!($name), "\0").as_bytes())? },)*
                })
            }
        }
    };
}

functions! {
    fn stateNew() -> State;
    fn stateDelete(State);
    fn energyplus(State, c_int, *const *const c_char) -> c_int;
    fn stopSimulation(State);
    fn setConsoleOutputState(State, c_int);
    fn energyPlusVersion() -> *const c_char;

    fn registerErrorCallback(State, ErrorCallback);
    fn registerStdOutCallback(State, ConsoleCallback);
    fn callbackBeginZoneTimeStepBeforeInitHeatBalance(State, StateCallback);
    fn callbackAfterNewEnvironmentWarmupComplete(State, StateCallback);
    fn callbackEndOfZoneTimeStepAfterZoneReporting(State, StateCallback);

    fn apiDataFullyReady(State) -> c_int;
    fn kindOfSim(State) -> c_int;
    fn warmupFlag(State) -> c_int;
    fn dayOfYear(State) -> c_int;
    fn dayOfWeek(State) -> c_int;
    fn currentTime(State) -> f64;
    fn currentSimTime(State) -> f64;

    fn requestVariable(State, *const c_char, *const c_char);
    fn getVariableHandle(State, *const c_char, *const c_char) -> c_int;
    fn getVariableValue(State, c_int) -> f64;
    fn getMeterHandle(State, *const c_char) -> c_int;
    fn getMeterValue(State, c_int) -> f64;
    fn getActuatorHandle(State, *const c_char, *const c_char, *const c_char) -> c_int;
    fn setActuatorValue(State, c_int, f64);
}
