//! Temporary folders.

use std::path::PathBuf;

use pyo3::prelude::*;

use crate::interpreter::error::Exception;

/// Creates a temporary folder for the caller to remove. If the process is killed, a later one removes the folder.
#[pyfunction]
pub fn temporary_folder(prefix: &str) -> PyResult<PathBuf> {
    let folder = b2b_base::scratch::temporary_folder(prefix);
    Ok(folder.map_err(|error| Exception::Process.new_err(error.to_string()))?.keep())
}
