//! Yearly HVAC energy of dataset buildings under the prototypes' own thermostats and schedules, without a controller.
//!
//! ```sh
//! cargo run --release -p b2b-dataset --example own_control [ID...]
//! ```
//!
//! Without ids, it runs the commercial buildings of the small test, in about ten minutes. Prints CSV: id, place,
//! electricity and gas in kWh per m² of conditioned floor.

use std::error::Error;

use b2b_building::{BuildingType, Model, PreparedBuilding};
use b2b_climate::Site;
use b2b_dataset::{BuildingId, Row, archetype};
use b2b_energyplus::install::{Cache, Engine, Quiet};
use b2b_energyplus::{Event, Library, Run};

const METERS: [&str; 2] = ["Electricity:HVAC", "NaturalGas:HVAC"];
const JOULES_PER_KWH: f64 = 3.6e6;

fn main() -> Result<(), Box<dyn Error>> {
    let engine = Engine::ensure(&mut Quiet)?;
    let library = Library::load(&engine.library)?;
    let ids = std::env::args().skip(1).map(|id| id.parse()).collect::<Result<Vec<BuildingId>, _>>()?;
    println!("id,place,electricity,gas");
    let small = |row: &&Row| row.test_small && row.id.building_type() != BuildingType::SingleFamilyHouse;
    let wanted = |row: &&Row| if ids.is_empty() { small(row) } else { ids.contains(&row.id) };
    for row in b2b_dataset::all().filter(wanted) {
        let [electricity, gas] = energy(row, &engine, &library)?;
        println!("{},{},{electricity:.1},{gas:.1}", row.id, row.building.place());
    }
    Ok(())
}

/// Electricity and gas, kWh/m².
fn energy(row: &Row, engine: &Engine, library: &Library) -> Result<[f64; 2], Box<dyn Error>> {
    let weather = row.building.weather(&Cache::from_env()?, &mut Quiet)?;
    let prototype = archetype::prototype(row.id.building_type(), engine, library)?;
    let model = row.building.model(&prototype, &Site::read(&weather)?)?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("model.epJSON");
    std::fs::write(&path, whole_year(&model).to_epjson())?;
    let mut simulation = Run::new(&path, &weather).start(library)?;
    let meters = METERS.map(|meter| simulation.meter(meter).ok());
    let mut joules = [0.0; 2];
    while let Some(event) = simulation.advance()? {
        if event == Event::Step {
            for (sum, meter) in joules.iter_mut().zip(meters) {
                *sum += meter.map_or(0.0, |meter| simulation.read_meter(meter));
            }
        }
    }
    drop(simulation);
    let area = PreparedBuilding::new(&row.id.to_string(), model, &weather, library)?.conditioned_floor_area;
    Ok(joules.map(|sum| sum / JOULES_PER_KWH / area))
}

/// The prototypes run three months of a year.
fn whole_year(model: &Model) -> Model {
    let mut model = model.clone();
    model.remove_class("RunPeriod");
    let fields = serde_json::json!({
        "begin_month": 1,
        "begin_day_of_month": 1,
        "end_month": 12,
        "end_day_of_month": 31,
        "day_of_week_for_start_day": "Sunday",
    });
    model.insert("RunPeriod", "Year", fields);
    model
}
