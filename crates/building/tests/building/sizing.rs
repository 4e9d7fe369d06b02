//! Sizing on the real engine.

use std::path::{Path, PathBuf};

use b2b_building::{Error, Model, Sizes};
use b2b_energyplus::install::{Engine, Quiet};
use b2b_energyplus::{Event, Level, Library, Run};
use serde_json::{Value, json};

const DENVER: &str = "USA_CO_Denver-Aurora-Buckley.AFB.724695_TMY3.epw";
const MIAMI: &str = "USA_FL_Miami.Intl.AP.722020_TMY3.epw";

/// Days of January from a Sunday, so that they include workdays.
const DAYS: usize = 3;

/// The folder of the engine.
fn engine() -> PathBuf {
    Engine::ensure(&mut Quiet).unwrap().root
}

fn library() -> Library {
    let file = format!("{}energyplusapi{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    Library::load(&engine().join(file)).unwrap()
}

fn weather(file: &str) -> PathBuf {
    engine().join("pyenergyplus/data/weather").join(file)
}

/// An archetype over the first days of January at 12 steps per hour, without outputs.
fn archetype(name: &str, library: &Library) -> Model {
    let idf = engine().join(format!("pyenergyplus/data/model/ASHRAE901_{name}_STD2019_Denver.idf"));
    let mut model = Model::from_epjson(&library.convert_idf(&idf).unwrap(), &idf).unwrap();
    let outputs = |class: &&str| class.starts_with("Output:") || class.starts_with("OutputControl:");
    let outputs: Vec<_> = model.classes().filter(outputs).map(str::to_owned).collect();
    outputs.iter().chain(&["RunPeriod".into(), "Timestep".into()]).for_each(|c| model.remove_class(c));
    model.insert("Timestep", "Timestep", json!({"number_of_timesteps_per_hour": 12}));
    let days = json!({
        "begin_month": 1, "begin_day_of_month": 1, "end_month": 1, "end_day_of_month": DAYS,
        "day_of_week_for_start_day": "Sunday",
    });
    model.insert("RunPeriod", "days", days);
    model
}

/// Results of a run.
struct Trace {
    /// Temperatures of every zone at every step, °C.
    temperatures: Vec<f64>,
    /// Energy of the HVAC systems over the run, electricity and gas, J.
    hvac: [f64; 2],
    severe: usize,
}

fn run(model: &Model, library: &Library) -> Trace {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("model.epJSON");
    std::fs::write(&input, model.to_epjson()).unwrap();
    let mut run = Run::new(&input, weather(DENVER));
    let zones = model.names("Zone");
    for zone in &zones {
        run = run.request("Zone Mean Air Temperature", zone);
    }
    let mut simulation = run.start(library).unwrap();
    let zones: Vec<_> =
        zones.iter().map(|z| simulation.variable("Zone Mean Air Temperature", z).unwrap()).collect();
    let meters = ["Electricity:HVAC", "NaturalGas:HVAC"].map(|m| simulation.meter(m).unwrap());
    let mut trace = Trace { temperatures: Vec::new(), hvac: [0.0; 2], severe: 0 };
    while let Some(event) = simulation.advance().unwrap() {
        if event == Event::Step {
            trace.temperatures.extend(zones.iter().map(|&z| simulation.read(z)));
            meters.iter().zip(&mut trace.hvac).for_each(|(&m, sum)| *sum += simulation.read_meter(m));
        }
    }
    trace.severe = simulation.message_count(Level::Severe);
    trace
}

fn autosized(model: &Model) -> Vec<String> {
    let objects = model.classes().flat_map(|class| model.objects(class));
    let holds = |fields: &Value| fields.to_string().to_lowercase().contains("\"autosize\"");
    objects.filter(|(_, f)| holds(&Value::Object((*f).clone()))).map(|(name, _)| name.to_owned()).collect()
}

/// The model with the plain ventilation rate procedure: its limit exists only while systems are sized.
fn without_outdoor_air_limit(mut model: Model) -> Model {
    const CLASS: &str = "Controller:MechanicalVentilation";
    for name in model.names(CLASS) {
        let controller = model.get_mut(CLASS, &name).unwrap();
        controller["system_outdoor_air_method"] = json!("Standard62.1VentilationRateProcedure");
    }
    model
}

/// Hard-sizes an archetype and compares simulated days with the autosized model's.
fn a_hard_sized_model_behaves_as_the_autosized_one(name: &str) {
    let library = library();
    let shipped = without_outdoor_air_limit(archetype(name, &library));
    let mut hard = shipped.clone();
    let left = Sizes::of(&shipped, &weather(DENVER), &library).unwrap().write_into(&mut hard);
    assert_eq!(left.left, [""; 0]);
    assert_eq!(autosized(&hard), [""; 0]);

    let (expected, got) = (run(&shipped, &library), run(&hard, &library));
    assert_eq!(got.temperatures.len(), DAYS * 24 * 12 * shipped.names("Zone").len());
    let difference = expected.temperatures.iter().zip(&got.temperatures).map(|(a, b)| (a - b).abs());
    let kelvin = difference.fold(0.0, f64::max);
    let relative = |(a, b): (&f64, &f64)| if a == b { 0.0 } else { (a - b).abs() / a.abs() };
    let energy = expected.hvac.iter().zip(&got.hvac).map(relative).fold(0.0, f64::max);
    println!("{name}: {kelvin:.1e} K, energy {energy:.1e}, severe {} {}", expected.severe, got.severe);
    assert!(kelvin < 1e-6, "{name}: {kelvin} K");
    assert!(energy < 1e-7, "{name}: relative error of the energy {energy}");
    assert!(got.severe <= expected.severe, "{name}: severe messages");
}

#[test]
fn the_small_office_keeps_its_behavior() {
    a_hard_sized_model_behaves_as_the_autosized_one("OfficeSmall");
}

#[test]
fn the_medium_office_keeps_its_behavior_except_for_the_outdoor_air_limit() {
    a_hard_sized_model_behaves_as_the_autosized_one("OfficeMedium");
}

#[test]
fn the_retail_store_keeps_its_behavior() {
    a_hard_sized_model_behaves_as_the_autosized_one("RetailStandalone");
}

#[test]
fn the_restaurant_keeps_its_behavior() {
    a_hard_sized_model_behaves_as_the_autosized_one("RestaurantFastFood");
}

#[test]
fn the_warehouse_keeps_its_behavior() {
    a_hard_sized_model_behaves_as_the_autosized_one("Warehouse");
}

#[test]
fn sizes_follow_the_site_of_the_weather_file() {
    let library = library();
    let office = archetype("OfficeSmall", &library);
    let flow = |epw: &str| {
        let sizes = Sizes::of(&office, &weather(epw), &library).unwrap();
        sizes.get("Fan:OnOff", "PSZ-AC:1 Fan", "maximum_flow_rate").unwrap()
    };
    // The same heat takes a smaller volume of denser air.
    assert!(flow(MIAMI) < 0.95 * flow(DENVER));
}

#[test]
fn the_error_of_a_failed_sizing_has_the_messages_of_the_engine() {
    let library = library();
    let mut office = archetype("OfficeSmall", &library);
    office.remove_class("SizingPeriod:DesignDay");
    let error = Sizes::of(&office, &weather(DENVER), &library).unwrap_err();
    assert!(matches!(error, Error::Engine(_)), "{error}");
    assert!(error.to_string().to_lowercase().contains("design"), "{error}");
    let error = Sizes::of(&office, Path::new("none.epw"), &library).unwrap_err();
    assert!(error.to_string().contains("none.epw"), "{error}");
}
