//! `b2b evaluate`, `b2b score` and `b2b baseline` from the outside, on the real engine.

use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::program::{assert_rejected, b2b, command, json};
use b2b_energyplus::install::{Engine, Quiet};
use serde_json::Value;

const HOUSES: &str = "SingleFamilyHouse-0014 SingleFamilyHouse-0042";

#[test]
fn a_killed_evaluation_resumes_and_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let evaluate = |out: &str| {
        format!(
            "evaluate {HOUSES} --policy random --task constant --period 01-10..01-10 07-10..07-10 --jobs 1 --out {out}"
        )
    };
    let summary = json(folder.path(), &evaluate("whole"));
    assert_eq!((summary["episodes"].as_u64(), summary["lost"].as_array().unwrap().len()), (Some(4), 0));
    assert_eq!(summary["windows"].as_array().unwrap().len(), 2);
    assert!(summary["windows"][0]["all"]["scores"]["interquartile_mean"]["value"].as_f64().unwrap() > 1.0);

    let episodes = folder.path().join("killed/episodes");
    let names = || {
        let entries = std::fs::read_dir(&episodes).into_iter().flatten();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.ends_with(".json")).collect::<Vec<_>>()
    };
    let mut process = command(folder.path(), &evaluate("killed")).stderr(Stdio::null()).spawn().unwrap();
    let deadline = Instant::now() + Duration::from_secs(300);
    while names().is_empty() && process.try_wait().unwrap().is_none() {
        assert!(Instant::now() < deadline, "no episode ended");
        std::thread::sleep(Duration::from_millis(5));
    }
    process.kill().unwrap();
    process.wait().unwrap();
    let kept = names();
    assert!((1..4).contains(&kept.len()), "{kept:?}");
    let written = |name: &String| std::fs::metadata(episodes.join(name)).unwrap().modified().unwrap();
    let before: Vec<_> = kept.iter().map(written).collect();
    assert!(b2b(folder.path(), &evaluate("killed")).status.success());
    assert_eq!(kept.iter().map(written).collect::<Vec<_>>(), before, "nothing is repeated");
    let table = |out: &str| std::fs::read(folder.path().join(out).join("episodes.parquet")).unwrap();
    assert_eq!(table("killed"), table("whole"));
    let page = std::fs::read_to_string(folder.path().join("killed/report.html")).unwrap();
    assert!(page.contains("Plotly.newPlot") && page.contains("SingleFamilyHouse-0042"));
}

#[test]
fn evaluations_of_the_same_episodes_are_compared_on_one_page() {
    let folder = tempfile::tempdir().unwrap();
    for (policy, days) in
        [("reactive", "01-10..01-10"), ("random", "01-10..01-10"), ("constant", "01-11..01-11")]
    {
        let evaluate = format!(
            "evaluate SingleFamilyHouse-0014 --policy {policy} --task constant --period {days} --out {policy}"
        );
        assert!(b2b(folder.path(), &evaluate).status.success());
    }
    assert!(b2b(folder.path(), "evaluate compare reactive random --out page.html").status.success());
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    assert!(page.contains("2 policies on 1 episodes") && page.contains("Per-step rewards"));
    let refused = |arguments: &str, words: &[&str]| assert_rejected(folder.path(), arguments, words);
    refused(
        "evaluate compare reactive constant",
        &["`constant`", "01-11..01-11", "not an episode of reactive"],
    );
    refused("evaluate compare reactive nowhere", &["nowhere", "b2b evaluate"]);
    refused("evaluate compare reactive", &["FOLDER"]);
    refused("evaluate", &["--policy", "--out"]);
}

#[test]
fn invalid_arguments_are_rejected_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &str, words: &[&str]| assert_rejected(folder.path(), arguments, words);
    std::fs::write(folder.path().join("no.onnx"), "this is no model").unwrap();
    refused("evaluate --policy no.onnx --out x", &["no.onnx is not a valid ONNX model"]);
    refused("evaluate --policy none.onnx --out x", &["none.onnx"]);
    refused(
        "evaluate --policy reactiv --out x",
        &["`reactiv` (did you mean `reactive`?)", "planner", ".onnx"],
    );
    refused("evaluate --policy hold,off --out x", &["an evaluation has one policy", "b2b evaluate compare"]);
    refused("evaluate --policy hold off --out x", &["`off` is a controller", "b2b evaluate compare"]);
    refused("run OfficeSmall --controller own hold", &["`hold` is a controller", "b2b compare"]);
    refused("evaluate --policy random --task constnt --out x", &["constnt", "occupancy", "operate+tou"]);
    refused("evaluate --policy random --task constant+energyNaN --out x", &["energyNaN", "energy0.5"]);
    refused("evaluate --policy random --task constant+energyinf --out x", &["energyinf", "energy0.5"]);
    refused("evaluate OfficeSmal-1 --policy random --out x", &["OfficeSmal"]);
    refused("evaluate --policy random --split test_big --out x", &["test_big", "test_small"]);
    refused("evaluate --policy random", &["--out"]);
    refused(
        "evaluate OfficeSmall-0001 --type Warehouse --policy random --out x",
        &["--type", "cannot be used with"],
    );
    refused("evaluate --type Warehouse --zone 9 --policy random --out x", &["9", "1..=8"]);
    assert!(!folder.path().join("x").exists());
    std::fs::write(folder.path().join("thesis.tex"), "").unwrap();
    refused("evaluate --policy random --out .", &["contains no evaluation"]);
    refused("score no.onnx", &["no.onnx is not a trajectory"]);
    refused("score none.parquet", &["cannot read none.parquet"]);
}

#[test]
fn a_trajectory_is_scored_and_the_reactive_controllers_score_one() {
    let folder = tempfile::tempdir().unwrap();
    let run = |controller: &str| {
        let day = "run SingleFamilyHouse-0014 --period 01-10..01-10 --task occupancy+energy0.5";
        json(folder.path(), &format!("{day} --controller {controller} --out {controller}"))
    };
    let score = |of: &str| json(folder.path(), &format!("score {of}/trajectory.parquet"));
    let (reactive, random) = (run("reactive"), run("random"));
    let close = |a: &Value, b: f64| (a.as_f64().unwrap() - b).abs() < 1e-9 * b.abs();
    assert!(close(&score("reactive")["score"], 1.0));
    let scored = score("random");
    let ratio = random["return"].as_f64().unwrap() / reactive["return"].as_f64().unwrap();
    assert!(close(&scored["score"], ratio) && ratio > 1.0, "{scored}");
    assert_eq!(json(folder.path(), "score random"), scored, "by the folder of the run");
    let words = ["SingleFamilyHouse-0014, not of Warehouse"];
    assert_rejected(folder.path(), "score random --building Warehouse", &words);
    std::fs::write(folder.path().join("reactive/evaluation.json"), "{}").unwrap();
    let again = "run SingleFamilyHouse-0014 --period 01-10..01-10 --out reactive";
    assert_rejected(folder.path(), again, &["reactive has the output of `b2b evaluate`"]);
    std::fs::remove_file(folder.path().join("reactive/evaluation.json")).unwrap();
    std::fs::write(folder.path().join("late.json"), r#"{"optimum_start": 0}"#).unwrap();
    let late = json(
        folder.path(),
        "run SingleFamilyHouse-0014 --period 01-10..01-10 --parameters late.json --seed 3",
    );
    assert_eq!(late["parameters"]["optimum_start"], 0.0);
    let name = late["files"][0].as_str().unwrap().to_owned();
    assert!(name.contains("guideline36-late-seed3/"), "{name}");
    assert!(close(&scored["return"], random["return"].as_f64().unwrap()));

    // The discomfort is the run's, an integral from its start.
    let run = "run SingleFamilyHouse-0014 --period 01-10..01-10 --controller own --out own";
    let own = json(folder.path(), run);
    assert!(own["tdis_tot"].as_f64().unwrap() > 0.0);
    assert_eq!(score("own")["discomfort_k_h"], own["tdis_tot"]);

    // With a weather file, the baseline has the same weather.
    let models = Engine::ensure(&mut Quiet).unwrap().models.unwrap();
    let weather = models.parent().unwrap().join("weather/USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw");
    let weather = format!("--weather {}", weather.display());
    let day = "run SingleFamilyHouse-0014 --period 01-10..01-10 --task occupancy+energy0.5";
    json(folder.path(), &format!("{day} {weather} --controller reactive --out chicago"));
    assert_rejected(
        folder.path(),
        "score chicago/trajectory.parquet",
        &["the trajectory's weather", "--weather"],
    );
    let score = json(folder.path(), &format!("score chicago/trajectory.parquet {weather}"));
    assert!(close(&score["score"], 1.0), "{score}");
}
