//! `b2b edit`: the changes reach the engine, and bad values are reported.

use std::path::{Path, PathBuf};

use crate::program::{assert_rejected, json};
use b2b_energyplus::install::{Engine, Quiet};
use b2b_energyplus::{Library, Run};
use serde_json::Value;

fn engine() -> Engine {
    Engine::ensure(&mut Quiet).unwrap()
}

fn model(name: &str) -> PathBuf {
    engine().models.unwrap().join(name)
}

/// Returns a path as one of the arguments of a command, which are split at spaces.
fn word(path: &Path) -> String {
    let text = path.to_str().unwrap().to_owned();
    assert!(!text.contains(' '));
    text
}

/// Returns the row of a change in the report.
fn effect<'a>(report: &'a Value, change: &str) -> &'a Value {
    report["changes"].as_array().unwrap().iter().find(|each| each["change"] == change).unwrap()
}

fn after(report: &Value, change: &str) -> f64 {
    effect(report, change)["after"].as_f64().unwrap()
}

/// Runs a model and returns the gas of two days of January, J.
fn gas(folder: &Path, model: &Path) -> f64 {
    let weather = engine().models.unwrap().parent().unwrap().join("weather");
    let weather = weather.join("USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw");
    let mut document: Value = serde_json::from_str(&std::fs::read_to_string(model).unwrap()).unwrap();
    document["RunPeriod"] = serde_json::json!({"January": {"begin_month": 1, "begin_day_of_month": 8,
        "end_month": 1, "end_day_of_month": 9, "day_of_week_for_start_day": "Monday"}});
    let control = document["SimulationControl"].as_object_mut().unwrap().values_mut().next().unwrap();
    control["run_simulation_for_weather_file_run_periods"] = "Yes".into();
    let file = folder.join("january.epJSON");
    std::fs::write(&file, document.to_string()).unwrap();
    let library = Library::load(&engine().library).unwrap();
    let mut simulation = Run::new(&file, &weather).start(&library).unwrap();
    let meter = simulation.meter("NaturalGas:Facility").unwrap();
    let mut sum = 0.0;
    while let Some(event) = simulation.advance().unwrap() {
        if event == b2b_energyplus::Event::Step {
            sum += simulation.read_meter(meter);
        }
    }
    sum
}

#[test]
fn more_infiltration_and_less_insulation_take_more_gas() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = word(&model("RefBldgWarehouseNew2004_Chicago.idf"));
    let edited = |options: &str, name: &str| {
        let report = json(folder.path(), &format!("edit {shipped} {options} --out {name}.epJSON"));
        (report, gas(folder.path(), &folder.path().join(format!("{name}.epJSON"))))
    };
    let (base, of_base) = edited("--infiltration 1", "base");
    let (leaky, of_leaky) = edited("--infiltration 3", "leaky");
    let (bare, of_bare) = edited("--wall-u 1.5 --roof-u 1.0 --equipment 1.0", "bare");
    assert!((after(&leaky, "infiltration") - 3.0 * after(&base, "infiltration")).abs() < 1e-9);
    assert!((after(&bare, "wall_u") - 1.5).abs() < 1e-9 && (after(&bare, "roof_u") - 1.0).abs() < 1e-9);
    assert!(of_leaky > 1.1 * of_base, "{of_leaky} {of_base}");
    assert!(of_bare > 1.2 * of_base, "{of_bare} {of_base}");
}

/// Layered glazing, massive walls with insulation between layers, and loads in all forms.
#[test]
fn an_example_of_the_engine_takes_every_change_and_can_be_imported() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = word(&model("RefBldgSmallOfficeNew2004_Chicago.idf"));
    let changes = "--wall-u 0.4 --roof-u 0.25 --window-u 1.6 --window-shgc 0.4 --window-to-wall 0.15 --infiltration 0.7 \
                   --x-scale 1.2 --y-scale 0.9 --north-axis 30 --people 2 --lights 0.5 --equipment 1.25";
    let report = json(folder.path(), &format!("edit {shipped} {changes} --out all.epJSON"));
    assert_eq!(report["changes"].as_array().unwrap().len(), 12);
    for (change, value) in
        [("wall_u", 0.4), ("roof_u", 0.25), ("window_u", 1.6), ("window_shgc", 0.4), ("window_to_wall", 0.15)]
    {
        assert!((after(&report, change) - value).abs() < 1e-6, "{report}");
    }
    for (change, factor) in [("people", 2.0), ("lights", 0.5), ("equipment", 1.25), ("x_scale", 1.2)] {
        let before = effect(&report, change)["before"].as_f64().unwrap();
        assert!((after(&report, change) / before - factor).abs() < 0.02, "{change}: {report}");
    }
    let weather = engine().models.unwrap().parent().unwrap().join("weather");
    let weather = word(&weather.join("USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw"));
    let imported = json(folder.path(), &format!("import all.epJSON --weather {weather}"));
    assert_eq!(imported["systems"].as_array().unwrap().len(), 5, "{imported}");
}

#[test]
fn a_bad_value_is_reported_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = word(&model("RefBldgWarehouseNew2004_Chicago.idf"));
    for (options, words) in [
        ("--wall-u 50", ["`wall_u` is 50", "from 0.03 to 6"]),
        ("--window-to-wall 0.9", ["`window_to_wall` is 0.9", "expected a number from"]),
        ("--people nobody", ["nobody", "--people"]),
        ("", ["required", "--wall-u"]),
    ] {
        assert_rejected(folder.path(), &format!("edit {shipped} {options} --out out.epJSON"), &words);
    }
    assert_rejected(
        folder.path(),
        &format!("edit {shipped} --lights 2 --out out.idf"),
        &["out.idf", ".epJSON"],
    );
    assert_rejected(
        folder.path(),
        "edit nowhere.idf --lights 2 --out out.epJSON",
        &["nowhere.idf", "does not exist"],
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    let own = folder.path().join("own.epJSON");
    std::fs::write(&own, "{}").unwrap();
    let words = ["--out ./own.epJSON is the model itself"];
    assert_rejected(folder.path(), "edit own.epJSON --lights 2 --out ./own.epJSON", &words);
    assert_eq!(std::fs::read_to_string(own).unwrap(), "{}");
}
