//! New buildings from the generator.

use std::path::PathBuf;
use std::sync::Arc;

use b2b_building::BuildingType;
use b2b_climate::WeatherFile;
use b2b_dataset::Places;
use b2b_workers::Population;
use pyo3::prelude::*;

use crate::buildings::catalog::{Building, Inner, catalog};
use crate::interpreter::error::of_building;
use crate::interpreter::signals::Signals;

/// A generator of new buildings of a type, no two of which are the same.
#[pyclass(frozen, module = "building2building._core")]
pub struct Generator {
    building_type: BuildingType,
    places: Places,
    settings: Vec<b2b_dataset::Setting>,
}

#[pymethods]
impl Generator {
    #[new]
    fn new(
        building_type: &str,
        places: Vec<String>,
        weather: Vec<PathBuf>,
        settings: Vec<String>,
    ) -> PyResult<Self> {
        let building_type: BuildingType = building_type.parse().map_err(of_building)?;
        let places = read_places(places, &weather)?;
        let settings = read_settings(&settings)?;
        // Reports invalid places and parameters now rather than at the first draw.
        b2b_dataset::sample(building_type, 1, 0, &places, &settings).map_err(of_building)?;
        Ok(Self { building_type, places, settings })
    }
}

impl Generator {
    /// Returns the population to draw its buildings from.
    pub fn population(&self) -> Population {
        let Self { building_type, places, settings } = self;
        Population::Generated {
            building_type: *building_type,
            places: places.clone(),
            settings: settings.clone(),
        }
    }
}

/// Returns the places of a generator: all, some by name, or weather files.
fn read_places(names: Vec<String>, weather: &[PathBuf]) -> PyResult<Places> {
    let read = |path: &PathBuf| WeatherFile::read(path, None).map(Arc::new);
    Ok(match (names.as_slice(), weather) {
        ([], []) => Places::All,
        (_, []) => Places::Named(names),
        (_, files) => Places::Files(files.iter().map(read).collect::<Result<_, _>>().map_err(of_building)?),
    })
}

/// Parses settings that fix or narrow parameters.
fn read_settings(settings: &[String]) -> PyResult<Vec<b2b_dataset::Setting>> {
    settings.iter().map(|text| text.parse()).collect::<Result<_, _>>().map_err(of_building)
}

/// Samples buildings of a type with a seed, like `b2b generate`.
#[pyfunction]
#[pyo3(signature = (building_type, count, seed, places, weather, settings))]
pub fn generate(
    py: Python<'_>,
    building_type: &str,
    count: usize,
    seed: u64,
    places: Vec<String>,
    weather: Vec<PathBuf>,
    settings: Vec<String>,
) -> PyResult<Vec<Building>> {
    let building_type: BuildingType = building_type.parse().map_err(of_building)?;
    let settings = read_settings(&settings)?;
    let make = || -> PyResult<Vec<Building>> {
        let places = read_places(places, &weather)?;
        let buildings =
            b2b_dataset::sample(building_type, count, seed, &places, &settings).map_err(of_building)?;
        let catalog = catalog()?;
        let building = |(number, building): (usize, &b2b_dataset::Building)| {
            let (model, weather) = catalog.generate(building, &mut Signals).map_err(of_building)?;
            let name = format!("{building_type}-seed{seed}-{number:04}");
            Ok(Building { inner: Arc::new(Inner::of_generated(name, building, model, weather)) })
        };
        (1..).zip(&buildings).map(building).collect()
    };
    py.detach(make)
}
