//! Measures every actuator of a building type at its home, as in `cargo run --example authority OfficeSmall`.

use std::sync::Arc;

use b2b_building::{BuildingType, PreparedBuilding, climate};
use b2b_energyplus::Library;
use b2b_energyplus::install::{Engine, Quiet};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).ok_or("give a building type")?;
    let building_type: BuildingType = name.parse()?;
    let engine = Engine::ensure(&mut Quiet)?;
    let library = Library::load(&engine.library)?;
    let weather = climate::Place::find(building_type.home())?.epw(&mut Quiet)?;
    let model = building_type.base_model(&engine, &library, &climate::Site::read(&weather)?)?;
    let building = Arc::new(PreparedBuilding::new(building_type.name(), model, &weather, &library)?);
    println!("{}", b2b_env::authority::measure(&library, &building, &weather)?);
    Ok(())
}
