//! `b2b calibrate` on the real engine: known multipliers are recovered from the energy that they cause.

use std::fmt::Write;
use std::path::Path;

use crate::program::{assert_rejected, json};
use b2b_building::MonthlyEnergy;
use b2b_climate::Place;
use b2b_dataset::{BuildingName, Catalog, Placement};
use b2b_energyplus::install::Quiet;
use serde_json::Value;

/// A generated warehouse with a coarse time step.
fn warehouse(folder: &Path) {
    let generated = json(folder, "generate Warehouse --count 1 --seed 1 --place Denver --out w");
    assert_eq!(generated["written"], 1);
    let model = std::fs::read_to_string(folder.join("w/Warehouse-seed1-0001.epJSON")).unwrap();
    let mut model: Value = serde_json::from_str(&model).unwrap();
    model["Timestep"] = serde_json::json!({"Timestep": {"number_of_timesteps_per_hour": 1}});
    model["ConvergenceLimits"] = serde_json::json!({"Limits": {"minimum_system_timestep": 60}});
    std::fs::write(folder.join("model.epJSON"), model.to_string()).unwrap();
}

/// Writes the monthly energy of a model as a table of metered energy.
fn meter(folder: &Path, model: &str) {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let name = BuildingName::Model(folder.join(model));
    let placement = Placement { place: Some(Place::find("Denver").unwrap()), ..Placement::default() };
    let found = catalog.find(&name, &placement, &mut Quiet).unwrap();
    let energy = MonthlyEnergy::of(&found.model, &found.weather, catalog.library()).unwrap();
    let mut table = "month,electricity_kwh,gas_kwh\n".to_owned();
    for month in 0..12 {
        writeln!(table, "{},{},{}", month + 1, energy.electricity[month], energy.gas[month]).unwrap();
    }
    std::fs::write(folder.join("metered.csv"), table).unwrap();
}

#[test]
fn known_multipliers_are_recovered_within_5_percent() {
    let folder = tempfile::tempdir().unwrap();
    warehouse(folder.path());
    let same = json(folder.path(), "edit model.epJSON --wall-u 1 --out same.epJSON");
    let wall_u = 1.3 * same["changes"][0]["before"].as_f64().unwrap();
    let truth = [("infiltration", 1.6), ("lights", 0.7), ("wall_u", 1.3)];
    let options = format!("--infiltration 1.6 --lights 0.7 --wall-u {wall_u}");
    json(folder.path(), &format!("edit model.epJSON {options} --out truth.epJSON"));
    meter(folder.path(), "truth.epJSON");

    let parameters: String = truth.iter().map(|(name, _)| format!(" --parameter {name}")).collect();
    let calibrate =
        format!("calibrate model.epJSON --place Denver --energy metered.csv{parameters} --out fitted.epJSON");
    let report = json(folder.path(), &calibrate);
    println!("{report:#}");
    for (found, (name, multiplier)) in report["parameters"].as_array().unwrap().iter().zip(truth) {
        assert_eq!(found["name"], name);
        let error = found["multiplier"].as_f64().unwrap() / multiplier - 1.0;
        assert!(error.abs() < 0.05, "{name}: {error}");
    }
    for fuel in report["fuels"].as_array().unwrap() {
        assert_eq!(fuel["before"]["meets_guideline_14"], false, "{fuel}");
        assert_eq!(fuel["after"]["meets_guideline_14"], true, "{fuel}");
        assert!(fuel["after"]["cv_rmse_percent"].as_f64().unwrap() < 1.0, "{fuel}");
    }
    let infiltration = |model: &str| {
        let edited = json(folder.path(), &format!("edit {model} --infiltration 1 --out again.epJSON"));
        edited["changes"][0]["before"].as_f64().unwrap()
    };
    assert!((infiltration("fitted.epJSON") / infiltration("truth.epJSON") - 1.0).abs() < 0.05);
}

#[test]
fn bad_arguments_are_reported_with_the_line_and_write_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("metered.csv");
    let calibrate = "calibrate Warehouse --energy metered.csv --out out.epJSON";
    for (text, words) in [
        ("month,gas_kwh\n1,5\n13,6\n", ["metered.csv, line 3", "from 1 to 12"]),
        ("month,oil\n", ["metered.csv, line 1", "electricity_kwh and gas_kwh"]),
        ("month,gas_kwh\n1,5\n2,6\n", ["4 parameters", "fewer with --parameter"]),
    ] {
        std::fs::write(&table, text).unwrap();
        assert_rejected(folder.path(), calibrate, &words);
    }
    for (arguments, words) in [
        ("calibrate Warehouse --energy metered.csv --out out.idf", [".epJSON", "out.idf"]),
        ("calibrate Warehouse --out out.epJSON", ["--energy", "required"]),
        ("calibrate Warehouse --energy none.csv --out out.epJSON", ["none.csv", "No such file"]),
        (&format!("{calibrate} --control setpoints"), ["--control", "its own controls"]),
        (&format!("{calibrate} --parameter x_scale"), ["`x_scale`", "expected one of infiltration"]),
    ] {
        assert_rejected(folder.path(), arguments, &words);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
