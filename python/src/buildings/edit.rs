//! Changes of model files.

use std::path::PathBuf;

use b2b_building::edit::{Change, Edits, edit_file};
use pyo3::prelude::*;

use crate::buildings::catalog::catalog;
use crate::interpreter::error::{Exception, of_building};

/// Applies changes, given by name and value, to a model file, writes the result, and returns the report as JSON text.
#[pyfunction]
pub fn edit_model(
    py: Python<'_>,
    model: PathBuf,
    out: PathBuf,
    changes: Vec<(String, f64)>,
    allow_external: bool,
) -> PyResult<String> {
    if changes.is_empty() {
        let known = Change::ALL.map(Change::name).join(", ");
        return Err(Exception::Setting.new_err(format!("no change is given; pass at least one of {known}")));
    }
    let mut edits = Edits::default();
    for (name, value) in changes {
        edits.set(name.parse().map_err(of_building)?, value).map_err(of_building)?;
    }
    let edited =
        || edit_file(&model, &out, &edits, catalog()?.library(), allow_external).map_err(of_building);
    let report = py.detach(edited)?;
    Ok(serde_json::to_string(&report).expect("a report is plain data"))
}
