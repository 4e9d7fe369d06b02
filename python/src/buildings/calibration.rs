//! Calibration of models against metered energy.

use std::path::PathBuf;

use b2b_building::calibration::{Calibration, Metered, PARAMETERS, Report};
use b2b_building::edit::Change;
use b2b_climate::Place;
use b2b_dataset::{BuildingName, Placement};
use pyo3::prelude::*;

use crate::buildings::catalog::catalog;
use crate::evaluation::{running, wait_for};
use crate::interpreter::error::{Exception, of_building};
use crate::interpreter::signals::Signals;

/// A model: name, place, weather file, permission of external code, and whether it keeps its design days.
type ModelKey = (String, Option<String>, Option<PathBuf>, bool, bool);

/// Fits a model to a table of metered energy, writes the calibrated model, and returns the report as JSON text.
#[pyfunction]
pub fn calibrate(
    py: Python<'_>,
    model: ModelKey,
    energy: PathBuf,
    out: PathBuf,
    parameters: Vec<String>,
    iterations: usize,
    jobs: Option<usize>,
) -> PyResult<String> {
    let _running = running()?;
    let (name, place, weather, allow_external, keep_design_days) = model;
    let name: BuildingName = name.parse().map_err(of_building)?;
    let place = place.as_deref().map(Place::find).transpose().map_err(of_building)?;
    let placement = Placement { place, weather, allow_external, keep_design_days, ..Placement::default() };
    let parameters = parameters.iter().map(|text| parameter(text)).collect::<PyResult<Vec<_>>>()?;
    let jobs = jobs.or_else(|| std::thread::available_parallelism().ok().map(usize::from)).unwrap_or(1);
    let report = py.detach(|| -> PyResult<Report> {
        let catalog = catalog()?;
        let metered = Metered::read(&energy).map_err(of_building)?;
        let found = catalog.find(&name, &placement, &mut Signals).map_err(of_building)?;
        let calibration = Calibration {
            name: &name.to_string(),
            model: &found.model,
            source: name.file(),
            notes: &found.notes,
            place: &found.place,
            weather: &found.weather,
            metered: &metered,
            parameters: &parameters,
            max_iterations: iterations,
            jobs: if catalog.library().is_hosted() { jobs } else { 1 },
        };
        wait_for(|| calibration.run(catalog.library(), &out, &()), || true, of_building)
    })?;
    Ok(serde_json::to_string(&report).expect("a report is plain data"))
}

fn parameter(name: &str) -> PyResult<Change> {
    let known = || PARAMETERS.map(Change::name).join(", ");
    let found = name.parse::<Change>().ok().filter(|change| PARAMETERS.contains(change));
    found.ok_or_else(|| {
        Exception::Setting.new_err(format!("`{name}` cannot be calibrated; expected one of {}", known()))
    })
}
