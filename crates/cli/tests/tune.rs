//! `b2b tune` on the real engine, and the use of its results.
#![cfg(target_os = "linux")]

mod program;

use program::{assert_rejected, json};
use serde_json::Value;

const TINY: &str = "tune --type SingleFamilyHouse --buildings 1 --period 01-08..01-08";

#[test]
fn a_resumed_tuning_gives_the_result_of_an_uninterrupted_one() {
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

    let other = format!("{TINY} --evaluations 3 --seed 1 --out parts");
    assert_rejected(folder, &other, &["another tuning run", "SingleFamilyHouse.jsonl"]);
}

#[test]
fn a_dataset_building_uses_the_tuned_parameters_of_its_class_by_default() {
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
    let run = "run SingleFamilyHouse-0042 --parameters";
    assert_rejected(folder, &format!("{run} wrong.json"), &["unitary.min_flow", "1.5"]);
    assert_rejected(folder, &format!("{run} best"), &["default, tuned or a JSON file"]);
}
