//! Base models of the six building types.

use b2b_building::{BuildingType, Model};
use b2b_climate::Site;
use b2b_energyplus::Library;
use b2b_energyplus::install::Engine;

use crate::house::{self, House};
use crate::{Error, Result};

/// Returns the base model of a type: for the house one generated for the site, for the others the [`prototype`].
///
/// # Errors
/// The errors of [`prototype`].
pub fn base_model(
    building_type: BuildingType,
    engine: &Engine,
    library: &Library,
    site: &Site,
) -> Result<Model> {
    match building_type {
        BuildingType::SingleFamilyHouse => house::house(&House::default(), site),
        _ => prototype(building_type, engine, library),
    }
}

/// Returns the model that buildings of a type are derived from: the ASHRAE 90.1-2019 prototype that ships with the
/// engine; an empty model for the house, which is generated from its parameters alone.
///
/// # Errors
/// [`Error::NoStockModels`] when the engine was installed without its models; [`Error::Building`] when the engine cannot
/// convert the file.
pub fn prototype(building_type: BuildingType, engine: &Engine, library: &Library) -> Result<Model> {
    if building_type == BuildingType::SingleFamilyHouse {
        return Ok(Model::default());
    }
    let file = format!("ASHRAE901_{}_STD2019_Denver.idf", building_type.name());
    let models = engine.models.as_ref().ok_or_else(|| Error::NoStockModels { file: file.clone() })?;
    Ok(Model::read(&models.join(file), &library.in_this_process())?)
}
