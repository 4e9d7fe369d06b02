//! `b2b compare` from the outside, on runs of the real engine.

use std::path::Path;

use crate::program::{assert_rejected, b2b, json, stderr};

/// Runs the fastest building for two days.
fn record(folder: &Path, name: &str, arguments: &str) {
    let output = b2b(folder, &format!("run RestaurantFastFood --out {name} {arguments}"));
    assert!(output.status.success(), "{}", stderr(&output));
}

const DAYS: &str = "--period 01-01..01-02";

#[test]
fn runs_of_one_episode_are_compared_in_tables_json_and_page() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), "reactive", &format!("{DAYS} --task occupancy"));
    record(folder.path(), "random", &format!("{DAYS} --task occupancy --controller random"));
    let compared = json(folder.path(), "compare reactive random/trajectory.parquet --out page.html");
    let runs = compared["runs"].as_array().unwrap();
    assert_eq!((&compared["building"], &compared["steps"]), (&"RestaurantFastFood".into(), &576.into()));
    assert_eq!([&runs[0]["name"], &runs[1]["name"]], ["reactive", "random"]);
    // Metrics and differences match the summaries.
    let summary = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(folder.path().join(name).join("summary.json")).unwrap())
            .unwrap()
    };
    for column in
        ["return", "rms_deviation_k", "discomfort_k_h", "electricity_wh_m2", "gas_wh_m2", "daily_travel"]
    {
        let [ours, theirs] = ["reactive", "random"].map(|name| summary(name)[column].as_f64().unwrap());
        assert_eq!(runs[1]["metrics"][column].as_f64(), Some(theirs), "{column}");
        assert_eq!(runs[1]["difference"][column].as_f64(), Some(theirs - ours), "{column}");
        assert_eq!(runs[0]["difference"][column].as_f64(), Some(0.0), "{column}");
    }
    // The worst hours begin with the largest deviation; none is of a zone and day that is listed already.
    for run in runs {
        let hours = run["worst_hours"].as_array().unwrap();
        let sizes: Vec<_> = hours.iter().map(|hour| hour["deviation_k"].as_f64().unwrap().abs()).collect();
        assert!(!sizes.is_empty() && sizes.is_sorted_by(|a, b| a >= b), "{sizes:?}");
        let mut days: Vec<_> = hours.iter().map(|hour| (hour["zone"].to_string(), &hour["date"])).collect();
        days.sort_by_key(|(zone, date)| (zone.clone(), date.to_string()));
        days.dedup();
        assert_eq!(days.len(), hours.len());
        for hour in hours {
            let [zone, target, deviation] =
                ["temperature_c", "target_c", "deviation_k"].map(|key| hour[key].as_f64().unwrap());
            assert!((zone - target - deviation).abs() < 1e-9, "{hour}");
        }
    }
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(page.contains("RestaurantFastFood in Denver") && page.len() < 1_000_000, "{}", page.len());

    let output = b2b(folder.path(), "compare reactive random --name baseline --name chance");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for words in
        ["baseline", "chance", "difference", "peak electric demand", "worst hours", "Dining", "compare-"]
    {
        assert!(text.contains(words), "`{words}` is not in: {text}");
    }
    assert!(folder.path().join("b2b-out/compare-RestaurantFastFood-Denver-01-01..01-02.html").is_file());
}

#[test]
fn runs_of_operation_lead_with_cost_energy_discomfort_and_peak() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), "reactive", &format!("{DAYS} --task operate+tou --controller reactive"));
    record(folder.path(), "guideline", &format!("{DAYS} --task operate+tou"));
    let output = b2b(folder.path(), "compare reactive guideline --out page.html");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", stderr(&output));
    let lead = text.lines().nth(2).unwrap();
    for words in ["cost (USD/m²)", "HVAC energy", "thermal discomfort", "15 min"] {
        assert!(lead.contains(words), "`{words}` is not in: {text}");
    }
    let compared = json(folder.path(), "compare reactive guideline --out page.html");
    for hour in compared["runs"][0]["worst_hours"].as_array().unwrap() {
        let [zone, setpoint, deviation] =
            ["temperature_c", "target_c", "deviation_k"].map(|key| hour[key].as_f64().unwrap());
        assert!((zone - setpoint - deviation).abs() < 1e-9 && deviation != 0.0, "{hour}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&read("guideline/summary.json")).unwrap();
    let cost: f64 =
        summary["bill"].as_array().unwrap().iter().map(|part| part["cost"].as_f64().unwrap()).sum();
    assert_eq!(summary["currency"], "USD");
    assert!(cost > 0.0 && summary["cost_tot"].as_f64().unwrap() > 0.0);
    // The modes of the guideline are on the page of its run alone.
    let modes = "\"states\":[\"occupied\",";
    assert!(read("guideline/picture.html").contains(modes) && !read("reactive/picture.html").contains(modes));
}

#[test]
fn runs_of_one_controller_are_named_after_seeds_or_folders() {
    let folder = tempfile::tempdir().unwrap();
    for (name, arguments) in [("a", "random --seed 1"), ("b", "random --seed 2"), ("c", "constant")] {
        record(folder.path(), name, &format!("{DAYS} --controller {arguments}"));
    }
    let names = |runs: &str| {
        let compared = json(folder.path(), &format!("compare {runs} --out page.html"));
        let runs = compared["runs"].as_array().unwrap().iter();
        runs.map(|run| run["name"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(names("a c"), ["random", "constant"]);
    assert_eq!(names("a b"), ["random, seed 1", "random, seed 2"]);
    assert_eq!(names("c c/"), ["c", "c/"]);
}

#[test]
fn runs_that_do_not_belong_together_are_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let rejected = |arguments: &str, words: &[&str]| assert_rejected(folder.path(), arguments, words);
    const DAY: &str = "--period 01-01..01-01 --steps-per-hour 4";
    record(folder.path(), "a", DAY);
    record(folder.path(), "days", "--period 01-02..01-02 --steps-per-hour 4");
    record(folder.path(), "place", &format!("{DAY} --place Miami"));
    record(folder.path(), "task", &format!("{DAY} --task occupancy"));
    record(folder.path(), "fast", "--period 01-01..01-01 --steps-per-hour 6");
    rejected("compare", &["RUN", "required"]);
    rejected("compare a", &["a is one run", "at least two"]);
    rejected("compare a none", &["no run at none", "b2b run"]);
    rejected("compare a days", &["run period", "01-01..01-01 in a", "01-02..01-02 in days"]);
    rejected("compare a place", &["place", "Denver in a", "Miami in place"]);
    rejected("compare a task", &["task", "operate in a", "occupancy in task"]);
    rejected("compare a fast", &["steps per hour", "4 in a", "6 in fast"]);
    rejected("compare a days --name one", &["--name has 1 names for 2 runs"]);
    // Folders that are not runs, and files that do not belong to each other.
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    rejected("compare a empty", &["empty has no trajectory.parquet"]);
    let copy = |file: &str, from: &str, to: &str| {
        std::fs::create_dir_all(folder.path().join(to)).unwrap();
        std::fs::copy(folder.path().join(from).join(file), folder.path().join(to).join(file)).unwrap();
    };
    copy("trajectory.parquet", "a", "bare");
    rejected("compare a bare", &["cannot read bare/summary.json"]);
    copy("summary.json", "task", "bare");
    rejected("compare a bare", &["bare are of different runs"]);
    std::fs::write(folder.path().join("bare/summary.json"), "{}").unwrap();
    rejected("compare a bare", &["bare/summary.json is not a summary"]);
    copy("summary.json", "a", "bare");
    let summary = folder.path().join("bare/summary.json");
    let told = std::fs::read_to_string(&summary).unwrap();
    std::fs::write(&summary, told.replacen("\"return\": -", "\"return\": -1", 1)).unwrap();
    rejected("compare a bare", &["bare/summary.json was changed", "run the episode again"]);
    std::fs::write(&summary, told).unwrap();
    std::fs::write(folder.path().join("bare/trajectory.parquet"), "PAR1").unwrap();
    rejected("compare a bare", &["bare/trajectory.parquet is not a trajectory"]);
}

#[test]
fn runs_of_different_buildings_are_rejected() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), "restaurant", "--period 01-01..01-01");
    let run = "run SingleFamilyHouse --period 01-01..01-01 --out house";
    assert!(b2b(folder.path(), run).status.success());
    let words = ["building", "RestaurantFastFood in restaurant", "SingleFamilyHouse in house"];
    assert_rejected(folder.path(), "compare restaurant house", &words);
    assert!(!folder.path().join("b2b-out").exists());
}
