//! Base models of the six building types.

use b2b_building::{BuildingType, Model};
use b2b_climate::Site;
use b2b_energyplus::Library;
use b2b_energyplus::install::Engine;

use crate::house::{self, House};
use crate::{Error, Result};

/// Returns the base model of a type: a house generated for the site, or the [`prototype`].
///
/// # Errors
/// The errors of [`prototype`].
pub fn base_model(
    building_type: BuildingType,
    engine: &Engine,
    library: &Library,
    site: &Site,
) -> Result<Model> {
    match building_type.is_house() {
        true => house::house(&House::default(), site),
        false => prototype(building_type, engine, library),
    }
}

/// Returns the model from which buildings of a type are derived: the ASHRAE 90.1-2019 prototype that ships with the
/// engine, or an empty model for the house, which is generated from its parameters alone.
///
/// # Errors
/// [`Error::NoStockModels`] when the engine was installed without its models; [`Error::Building`] when the engine
/// cannot convert the file.
pub fn prototype(building_type: BuildingType, engine: &Engine, library: &Library) -> Result<Model> {
    let Some(prototype) = &building_type.data().prototype else { return Ok(Model::default()) };
    let missing = || Error::NoStockModels { file: prototype.file.to_owned() };
    let models = engine.models.as_ref().ok_or_else(missing)?;
    Ok(Model::read(&models.join(prototype.file), library)?)
}
