//! `building2building._core`: the Rust crates as Python classes.
//!
//! This crate only converts. [`catalog`] finds buildings, [`generator`] makes new ones, [`edit`] changes model files and [`calibration`] fits them to metered energy, and
//! [`table`] converts the dataset's rows; [`spaces`] and [`morphology`] describe observations and actions; [`env`] is an environment in its own process,
//! [`local`] one in this process, and [`vector`] a batch over the buildings of [`population`]; [`control`] has the built-in
//! controllers, [`record`] writes an episode, [`evaluation`] evaluates a policy on many buildings, [`learning`] trains agents, [`pilot`] is an agent's interface, [`benchmarks`] has the
//! benchmark problems; [`command`] is the command `b2b`, [`signals`] handles Ctrl-C, [`temporary`] makes temporary folders, and [`error`] defines the exceptions.

mod arrays;
mod benchmarks;
mod calibration;
mod catalog;
mod command;
mod control;
mod edit;
mod env;
mod error;
mod evaluation;
mod generator;
mod learning;
mod local;
mod morphology;
mod owner;
mod pilot;
mod pools;
mod population;
mod record;
mod signals;
mod spaces;
mod table;
mod temporary;
mod vector;

use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// The extension module.
#[pymodule]
mod _core {
    use super::*;

    #[pymodule_export]
    use super::benchmarks::{
        Problem, Restriction, measures, normalized_score, resolved_score, score_at_comfort,
    };
    #[pymodule_export]
    use super::calibration::calibrate;
    #[pymodule_export]
    use super::catalog::{
        Building, Setting, TypeInfo, building_types, check_weather, dataset_rows, find_building, places,
    };
    #[pymodule_export]
    use super::command::{command_arguments, run_command};
    #[pymodule_export]
    use super::control::{Controller, reactive_parameters};
    #[pymodule_export]
    use super::edit::edit_model;
    #[pymodule_export]
    use super::env::Env;
    #[pymodule_export]
    use super::evaluation::{baseline, baselines_folder, evaluate, evaluate_part};
    #[pymodule_export]
    use super::generator::{Generator, generate};
    #[pymodule_export]
    use super::learning::{agent_info, train};
    #[pymodule_export]
    use super::local::LocalEnv;
    #[pymodule_export]
    use super::morphology::{Edge, Morphology, Node, NodeSlot, NodeType};
    #[pymodule_export]
    use super::owner::Owner;
    #[pymodule_export]
    use super::pilot::Pilot;
    #[pymodule_export]
    use super::record::{Record, trajectory_hash};
    #[pymodule_export]
    use super::spaces::{Actuator, RoleSlot, Slot, Spaces, Zone};
    #[pymodule_export]
    use super::temporary::temporary_folder;
    #[pymodule_export]
    use super::vector::VecEnv;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::error::register(module)?;
        let in_info: Vec<_> = b2b_env::Term::in_info().map(|(_, name)| name).collect();
        module.add("TERMS_IN_INFO", PyTuple::new(module.py(), in_info)?)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
