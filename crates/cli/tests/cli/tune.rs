//! `b2b tune` on the real engine, and the use of its results.

use crate::program::{assert_rejected, json};
use serde_json::Value;

const TINY: &str = "tune --type SingleFamilyHouse --buildings 2 --validation 1 --period 01-08..01-08";

#[test]
fn a_resumed_tuning_gives_the_result_of_an_uninterrupted_one() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let whole = json(folder, &format!("{TINY} --evaluations 5 --out whole"));
    assert_eq!((&whole[0]["objective"], &whole[1]["objective"]), (&"comfort".into(), &"energy".into()));
    for tuned in whole.as_array().unwrap() {
        assert_eq!(tuned["evaluations"], 5);
        assert!(tuned["measured"]["relative_loss"].as_f64().unwrap() <= 1.0);
    }
    assert_eq!(whole[1]["energy_scale"], whole[0]["measured"]["energy"], "the comfort set defines the scale");

    // A part of the comfort search, then the rest, then the energy search.
    let files = ["comfort", "energy"].map(|name| format!("evaluations/SingleFamilyHouse-{name}.jsonl"));
    json(folder, &format!("{TINY} --evaluations 5 --objective comfort --out parts"));
    let comfort = read(&format!("parts/{}", files[0]));
    let lines: Vec<&str> = comfort.lines().collect();
    std::fs::write(folder.join("parts").join(&files[0]), lines[..4].join("\n") + "\n").unwrap();
    assert_eq!(json(folder, &format!("{TINY} --evaluations 5 --out parts")), whole);
    for file in &files {
        assert_eq!(read(&format!("parts/{file}")), read(&format!("whole/{file}")));
    }
    assert_eq!(serde_json::from_str::<Value>(&read("parts/tuned.json")).unwrap(), whole);
    let scale: Value = serde_json::from_str(&read("parts/energy_scale.json")).unwrap();
    assert_eq!(scale[0]["energy_scale"], whole[0]["measured"]["energy"]);

    let other = format!("{TINY} --evaluations 5 --seed 1 --out parts");
    assert_rejected(folder, &other, &["another tuning run", "SingleFamilyHouse-comfort.jsonl"]);
    assert_rejected(folder, &format!("{TINY} --objective both"), &["both", "comfort or energy"]);
}

#[test]
fn a_dataset_building_uses_the_set_of_its_class_and_the_tasks_objective_by_default() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let shipped: Value = serde_json::from_str(include_str!("../../../control/data/tuned.json")).unwrap();
    let set = |objective: &str| {
        let of_houses = |tuned: &&Value| {
            tuned["class"]["building_type"] == "SingleFamilyHouse" && tuned["objective"] == objective
        };
        shipped.as_array().unwrap().iter().find(of_houses).map(|tuned| tuned["parameters"].to_string())
    };
    std::fs::write(folder.join("comfort.json"), set("comfort").unwrap()).unwrap();
    // The defaults where the class has no energy set.
    std::fs::write(folder.join("energy.json"), set("energy").unwrap_or("{}".into())).unwrap();
    let hash = |task: &str, parameters: &str| {
        let run = format!("run SingleFamilyHouse-0042 --task {task} --period 01-08..01-08");
        json(folder, &format!("{run} {parameters}"))["trajectory_hash"].clone()
    };
    for (task, own) in [("occupancy", "comfort.json"), ("occupancy+energy0.5", "energy.json")] {
        let tuned = hash(task, "");
        assert_eq!(hash(task, "--parameters tuned"), tuned);
        assert_eq!(hash(task, &format!("--parameters {own}")), tuned);
    }
    assert_ne!(hash("occupancy", "--parameters default"), hash("occupancy", ""));

    std::fs::write(folder.join("wrong.json"), r#"{"unitary": {"min_flow": 1.5}}"#).unwrap();
    let run = "run SingleFamilyHouse-0042 --task constant --parameters";
    assert_rejected(folder, &format!("{run} wrong.json"), &["unitary.min_flow", "1.5"]);
    assert_rejected(folder, &format!("{run} best"), &["default, tuned or a JSON file"]);
}
