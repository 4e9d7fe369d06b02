//! `b2b tune` on the real engine, and the use of its results.

use std::path::Path;

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
    let shipped: Value = serde_json::from_str(include_str!("../../../../control/data/tuned.json")).unwrap();
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

/// Asserts that `b2b run` has the totals of a plan, with its schedule and without.
fn assert_carried_out(folder: &Path, out: &str, plan: &Value) {
    let run = "run SingleFamilyHouse-0042 --period 01-10..01-11";
    let file = format!("{out}/SingleFamilyHouse-0042_01-10..01-11.json");
    let planned = json(folder, &format!("{run} --controller foresight --parameters {file}"));
    for (run, total) in [(planned, "result"), (json(folder, run), "guideline")] {
        for (name, pointer) in [("cost_tot", "used"), ("tdis_tot", "discomfort")] {
            let (run, found) = (run[name].as_f64().unwrap(), plan[total][pointer].as_f64().unwrap());
            assert!((run - found).abs() < 1e-9 * found.abs().max(1.0), "{name}: {run}, {found}");
        }
    }
}

#[test]
fn a_schedule_with_foresight_resumes_and_carries_out_what_the_search_found() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let search = "tune foresight SingleFamilyHouse-0042 --period 01-10..01-11 --rounds 1 --pairs 2 --out";
    let whole = json(folder, &format!("{search} whole"));
    let plan = &whole[0];
    let number = |pointer: &str| plan.pointer(pointer).unwrap().as_f64().unwrap();
    assert!(number("/result/used") <= number("/guideline/used"));
    assert_eq!(plan["schedule"]["days"].as_array().unwrap().len(), 2);

    let record = "searches/SingleFamilyHouse-0042_01-10..01-11.jsonl";
    let lines = std::fs::read_to_string(folder.join("whole").join(record)).unwrap();
    let lines: Vec<&str> = lines.lines().collect();
    assert_eq!(plan["episodes"], lines.len() - 1, "a line for each episode after the head");
    std::fs::create_dir_all(folder.join("parts/searches")).unwrap();
    std::fs::write(folder.join("parts").join(record), lines[..5].join("\n") + "\n").unwrap();
    assert_eq!(json(folder, &format!("{search} parts")), whole);

    assert_carried_out(folder, "whole", plan);
    // A search in predicted weather sees other savings; its totals are the actual weather's.
    let noisy = &json(folder, &format!("{search} noisy --forecast-error 3"))[0];
    assert_carried_out(folder, "noisy", noisy);
    assert_ne!(noisy["savings"], plan["savings"]);
    assert_eq!(noisy["guideline"], plan["guideline"]);
    assert_eq!(noisy["episodes"], lines.len() + 1, "and two in the actual weather");

    // The house has one unit: a search by zone finds the same, for points by name.
    let by_zone = &json(folder, &format!("{search} zones --by-zone"))[0];
    assert_carried_out(folder, "zones", by_zone);
    assert_eq!(by_zone["savings"], plan["savings"]);
    assert_ne!(by_zone["schedule"]["shifts"], plan["schedule"]["shifts"]);

    assert_rejected(folder, &format!("{search} whole --seed 1"), &["schedule of another search"]);
    assert_rejected(folder, &format!("{search} whole --steps-per-hour 6"), &["schedule of another search"]);
    assert_rejected(folder, &format!("{search} noisy --forecast-error 2"), &["schedule of another search"]);
    assert_rejected(
        folder,
        &format!("{search} other --forecast-error 20"),
        &["forecast_error is 20", "0 to 5"],
    );
    let events = format!("{search} other --task operate+hq-flex-d --forecast-error 2");
    assert_rejected(folder, &events, &["forecast_error is 2", "hq-flex-d"]);
    let tracking = format!("{search} other --task constant");
    assert_rejected(folder, &tracking, &["constant", "operate"]);
}

#[test]
fn a_model_predictive_controller_identifies_the_model_that_its_file_holds() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let episode = "SingleFamilyHouse-0042 --period 07-15..07-16";
    let model = json(folder, &format!("tune mpc {episode}"));
    assert_eq!(model["identified"], "07-01..07-14");
    let shifts: Vec<_> = model["effects"].as_array().unwrap().iter().map(|effect| &effect["shift"]).collect();
    assert!(shifts.contains(&&"minimum flow shift".into()), "{shifts:?}");
    let run = |arguments: &str| json(folder, &format!("run {episode} --controller mpc {arguments}"));
    let own = run("");
    assert_eq!(own["trajectory_hash"], run("--parameters model.json")["trajectory_hash"]);
    let guideline = json(folder, &format!("run {episode}"));
    assert_ne!(own["trajectory_hash"], guideline["trajectory_hash"], "{model}");
    assert!(own["cost_tot"].as_f64().unwrap() < guideline["cost_tot"].as_f64().unwrap());

    let text = std::fs::read_to_string(folder.join("model.json")).unwrap();
    std::fs::write(folder.join("other.json"), text.replace("minimum flow shift", "earlier start")).unwrap();
    let other = format!("run {episode} --controller mpc --parameters other.json");
    assert_rejected(folder, &other, &["unknown shift `earlier start`", "minimum flow shift"]);
    let tracking = format!("run {episode} --controller mpc --task constant");
    assert_rejected(folder, &tracking, &["mpc", "constant", "operate"]);
}
