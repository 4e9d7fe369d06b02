//! `building2building._core`: the Rust crates as Python classes.
//!
//! This crate only converts types. [`buildings`] finds, generates, edits and calibrates buildings; [`spaces`] describes
//! observations and actions; [`env`] is one environment and [`vector`] a batch; [`control`] has the built-in
//! controllers; [`evaluation`] evaluates policies, also on benchmark problems; [`learning`] trains agents;
//! [`interpreter`] is about Python itself: exceptions, signals, arrays, and the command `b2b`.

mod buildings;
mod control;
mod env;
mod evaluation;
mod interpreter;
mod learning;
mod spaces;
mod vector;

use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// The extension module.
#[pymodule]
mod _core {
    use super::*;

    #[pymodule_export]
    use super::buildings::calibration::calibrate;
    #[pymodule_export]
    use super::buildings::catalog::{
        Building, Setting, TypeInfo, building_types, check_weather, dataset_rows, find_building, places,
    };
    #[pymodule_export]
    use super::buildings::edit::edit_model;
    #[pymodule_export]
    use super::buildings::generator::{Generator, generate};
    #[pymodule_export]
    use super::control::{Controller, reactive_parameters};
    #[pymodule_export]
    use super::env::Env;
    #[pymodule_export]
    use super::env::local::LocalEnv;
    #[pymodule_export]
    use super::env::owner::Owner;
    #[pymodule_export]
    use super::env::record::{Record, trajectory_hash};
    #[pymodule_export]
    use super::evaluation::benchmarks::{
        Baseline, Problem, Restriction, measures, normalized_score, resolved_score,
    };
    #[pymodule_export]
    use super::evaluation::{baseline, baselines_folder, evaluate, evaluate_part};
    #[pymodule_export]
    use super::interpreter::command::{carry_out, run_command};
    #[pymodule_export]
    use super::interpreter::temporary::temporary_folder;
    #[pymodule_export]
    use super::learning::pilot::Pilot;
    #[pymodule_export]
    use super::learning::{agent_info, next_comfort_weight, train};
    #[pymodule_export]
    use super::spaces::morphology::{Edge, Morphology, Node, NodeSlot, NodeType};
    #[pymodule_export]
    use super::spaces::{Actuator, RoleSlot, Slot, Spaces, Zone};
    #[pymodule_export]
    use super::vector::VecEnv;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::interpreter::error::register(module)?;
        let in_info: Vec<_> = b2b_env::Term::in_info().map(|(_, name)| name).collect();
        module.add("TERMS_IN_INFO", PyTuple::new(module.py(), in_info)?)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
