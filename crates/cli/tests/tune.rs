//! Tuning from the command line, on the real engine, and what becomes of its result.
#![cfg(target_os = "linux")]

mod common;

use std::path::Path;

use common::{b2b, json, stderr};
use serde_json::Value;

fn refused(folder: &Path, arguments: &str) -> String {
    let output = b2b(folder, arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments}");
    stderr(&output)
}

const TINY: &str = "tune --type SingleFamilyHouse --buildings 1 --period 01-08..01-08";

#[test]
fn a_tuning_goes_on_where_it_stood_and_its_result_is_what_an_uninterrupted_one_has() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let whole = json(folder, &format!("{TINY} --evaluations 3 --out whole"));
    assert_eq!(whole[0]["evaluations"], 3);
    let measured = &whole[0]["measured"];
    assert!(measured["score"].as_f64().unwrap() >= measured["default_score"].as_f64().unwrap());

    json(folder, &format!("{TINY} --evaluations 2 --out parts"));
    let before = read("parts/evaluations/SingleFamilyHouse.jsonl");
    assert_eq!(json(folder, &format!("{TINY} --evaluations 3 --out parts")), whole);
    let after = read("parts/evaluations/SingleFamilyHouse.jsonl");
    assert!(after.starts_with(&before), "what was evaluated is not evaluated again");
    assert_eq!(after, read("whole/evaluations/SingleFamilyHouse.jsonl"));
    assert_eq!(serde_json::from_str::<Value>(&read("parts/tuned.json")).unwrap(), whole);
    let scale: Value = serde_json::from_str(&read("parts/energy_scale.json")).unwrap();
    assert_eq!(scale[0]["energy_scale"], whole[0]["measured"]["energy"]);

    let said = refused(folder, &format!("{TINY} --evaluations 3 --seed 1 --out parts"));
    assert!(said.contains("another tuning run") && said.contains("SingleFamilyHouse.jsonl"), "{said}");
}

#[test]
fn a_building_of_the_dataset_runs_with_the_parameters_of_its_class_unless_told_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let shipped: Value = serde_json::from_str(include_str!("../../control/data/tuned.json")).unwrap();
    let house =
        shipped.as_array().unwrap().iter().find(|t| t["class"]["building_type"] == "SingleFamilyHouse");
    std::fs::write(folder.join("same.json"), house.unwrap()["parameters"].to_string()).unwrap();
    let hash = |parameters: &str| {
        let run = "run SingleFamilyHouse-0042 --task occupancy --period 01-08..01-08";
        json(folder, &format!("{run} {parameters}"))["trajectory_hash"].clone()
    };
    let tuned = hash("");
    assert_eq!(hash("--parameters tuned"), tuned);
    assert_eq!(hash("--parameters same.json"), tuned);
    assert_ne!(hash("--parameters default"), tuned);

    std::fs::write(folder.join("wrong.json"), r#"{"unitary": {"min_flow": 1.5}}"#).unwrap();
    let said = refused(folder, "run SingleFamilyHouse-0042 --parameters wrong.json");
    assert!(said.contains("unitary.min_flow") && said.contains("1.5"), "{said}");
    let said = refused(folder, "run SingleFamilyHouse-0042 --parameters best");
    assert!(said.contains("default, tuned or a JSON file"), "{said}");
}
