//! `building2building._core`: what the Python package needs of the Rust crates, in Python's types.
//!
//! Nothing is decided here. [`catalog`] finds buildings, [`spaces`] tells what is seen and driven, [`env`] is one
//! environment in a process of its own, [`vector`] many, [`local`] one in this process, [`control`] the controllers that
//! come with the crates, [`evaluation`] runs a policy on many buildings, [`benchmarks`] knows the benchmark's problems.

mod arrays;
mod benchmarks;
mod catalog;
mod control;
mod env;
mod error;
mod evaluation;
mod local;
mod pools;
mod spaces;
mod vector;

use pyo3::prelude::*;

/// The names of the module.
#[pymodule]
mod _core {
    use super::*;

    #[pymodule_export]
    use super::benchmarks::{Problem, Restriction, measures, normalized_score};
    #[pymodule_export]
    use super::catalog::{Building, Setting, building_types, dataset_table, find_building, generate, places};
    #[pymodule_export]
    use super::control::{Controller, trajectory_hash};
    #[pymodule_export]
    use super::env::Env;
    #[pymodule_export]
    use super::evaluation::{compute_normalized_score, evaluate};
    #[pymodule_export]
    use super::local::LocalEnv;
    #[pymodule_export]
    use super::spaces::{Morphology, Spaces};
    #[pymodule_export]
    use super::vector::VecEnv;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }

    /// Runs this process as a worker if it was started as one, and then never returns.
    #[pyfunction]
    fn run_if_worker() {
        b2b_env::vector::run_if_worker();
    }
}
