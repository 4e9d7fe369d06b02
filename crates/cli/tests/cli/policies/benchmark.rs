//! `b2b benchmark` from the outside, on the real engine: two houses, one day.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::pages::browser::{self, Browser};
use crate::policies::onnx_file::linear_policy;
use crate::program::{assert_rejected, b2b, both_outputs, command};
use b2b_benchmark::Problem;
use b2b_benchmark::entry::read_result;
use b2b_benchmark::problem::Stage;
use b2b_building::{Conditioning, PreparedBuilding};
use b2b_control::ReactiveParameters;
use b2b_dataset::BuildingId;
use b2b_dataset::{BuildingName, Catalog, Placement};
use b2b_energyplus::install::Quiet;
use b2b_env::Setpoints;
use b2b_env::Spaces;
use b2b_evaluate::EpisodeResult;
use serde_json::json;

/// Two test houses and two to train on, of one to three zones, for one day.
const SMALL: &str = "dynamics-house --test SingleFamilyHouse-0018 SingleFamilyHouse-0387 \
                     --train SingleFamilyHouse-0001 SingleFamilyHouse-0002 --period 01-10..01-10 --seed 0 1";

fn run(folder: &Path, arguments: &str) -> String {
    let output = b2b(folder, &format!("benchmark run {arguments}"));
    assert!(output.status.success(), "{}", both_outputs(&output));
    both_outputs(&output)
}

fn assert_refused(folder: &Path, arguments: &str, words: &[&str]) {
    assert_rejected(folder, &format!("benchmark {arguments}"), words);
}

/// Returns whether a line of the table has both scores and the relative energy of the baseline.
fn scores_one(line: &str) -> bool {
    let cells: Vec<&str> = line.split_whitespace().collect();
    matches!(cells[..], [.., "1.000", "1.000", _, "1.00"])
}

fn bytes(folder: &Path, file: &str) -> Vec<u8> {
    std::fs::read(folder.join(file)).unwrap()
}

#[test]
fn the_reactive_controllers_score_one_and_two_runs_write_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let printed = run(folder.path(), &format!("{SMALL} --policy reactive --out reactive"));
    for building in ["SingleFamilyHouse-0018", "SingleFamilyHouse-0387"] {
        let line = printed.lines().find(|line| line.contains(building)).unwrap();
        assert!(scores_one(line), "{line}");
    }
    assert!(printed.contains("modified: ") && printed.contains("test.buildings"), "{printed}");
    let printed = run(folder.path(), &format!("{SMALL} --policy random --out first"));
    assert!(printed.contains('[') && printed.contains("generalization gap"), "{printed}");
    run(folder.path(), &format!("{SMALL} --policy random --out second --jobs 1"));
    for file in ["result.json", "episodes.parquet"] {
        assert_eq!(
            bytes(&folder.path().join("first"), file),
            bytes(&folder.path().join("second"), file),
            "{file}"
        );
    }
    let names = |of: &str| {
        let entries = std::fs::read_dir(folder.path().join(of)).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    assert_eq!(names("first"), ["episodes.parquet", "result.json"]);
    // A second run leaves the result unchanged.
    let before = std::fs::metadata(folder.path().join("first/result.json")).unwrap().modified().unwrap();
    run(folder.path(), &format!("{SMALL} --policy random --out first"));
    assert_eq!(
        std::fs::metadata(folder.path().join("first/result.json")).unwrap().modified().unwrap(),
        before
    );
    // Another policy is rejected.
    let other = format!("run {SMALL} --policy constant --out first");
    assert_refused(folder.path(), &other, &["contains a different evaluation", "policies"]);
}

/// The paper's table of buildings: type, minimum and maximum size of the observation under constant targets, number of
/// actuators. Varying targets add two slots per controlled zone.
const PAPER: [(&str, [usize; 2], usize); 6] = [
    ("SingleFamilyHouse", [9, 11], 2),
    ("RestaurantFastFood", [10, 10], 4),
    ("Warehouse", [10, 10], 5),
    ("RetailStandalone", [12, 12], 9),
    ("OfficeSmall", [13, 13], 10),
    ("OfficeMedium", [25, 25], 36),
];
/// The paper's table of action-space transfers.
const TRANSFERS: [(&str, [usize; 2]); 4] = [
    ("unitary-5-10", [5, 10]),
    ("unitary-10-5", [10, 5]),
    ("central-33-36", [33, 36]),
    ("central-36-33", [36, 33]),
];

#[test]
fn every_side_of_every_problem_has_the_sizes_of_the_paper() {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let mut prepared: HashMap<BuildingId, (Arc<PreparedBuilding>, PathBuf)> = HashMap::new();
    for problem in Problem::all() {
        let mut actions = Vec::new();
        for side in [&problem.train, &problem.test] {
            let listed = side.buildings.ids();
            assert_eq!(side.sizes.len(), side.buildings.types().len(), "{}", problem.name);
            for size in &side.sizes {
                // One building for each type and use: buildings of a type have the same systems.
                let of_type =
                    |id: &&BuildingId| id.building_type() == size.building_type && listed.contains(id);
                let first = listed.iter().find(of_type).copied().unwrap();
                let id = prepared.keys().find(of_type).copied().unwrap_or(first);
                let (building, weather) = prepared.entry(id).or_insert_with(|| {
                    let found =
                        catalog.find(&BuildingName::Id(id), &Placement::default(), &mut Quiet).unwrap();
                    let weather = found.weather.clone();
                    (Arc::new(found.prepare(catalog.library()).unwrap()), weather)
                });
                let (_, slots, actuators) =
                    PAPER.iter().find(|(name, ..)| *name == id.building_type().name()).unwrap();
                let controlled =
                    building.zones.iter().filter(|zone| zone.conditioning != Conditioning::None).count();
                for task in &side.tasks {
                    let (period, weather) = ("01-10..01-10".parse().unwrap(), weather.clone());
                    let episode =
                        b2b_env::EpisodeConfig { weather, period, steps_per_hour: 12, task: task.clone() };
                    let spaces = Spaces::new(Arc::clone(building), episode);
                    let cooled =
                        |zone: &&b2b_building::Zone| zone.conditioning == Conditioning::HeatingAndCooling;
                    let pairs = 2 * controlled + building.zones.iter().filter(cooled).count();
                    let target_slots = match (&task.setpoints, task.preview) {
                        (Setpoints::Constant { .. }, _) => 0,
                        // And whether the day is a holiday.
                        (Setpoints::Band { .. }, None) => pairs + 1,
                        // The next change of every zone, and prices, temperatures and radiation of a day.
                        (Setpoints::Band { .. }, Some(_)) => 2 * pairs + 3 * 24 + 1,
                        _ => 2 * controlled,
                    };
                    let seen = spaces.observation.len();
                    assert!(
                        (slots[0] + target_slots..=slots[1] + target_slots).contains(&seen),
                        "{}: {seen}",
                        problem.name
                    );
                    assert!(problem.protocol.observation_width.is_none_or(|width| seen <= width));
                    let left = match side.restriction {
                        None => *actuators,
                        Some(restriction) => {
                            restriction.apply(&spaces, &ReactiveParameters::default()).unwrap().kept().len()
                        }
                    };
                    assert_eq!(spaces.action.len(), *actuators, "{}", problem.name);
                    assert!(
                        (size.observation[0]..=size.observation[1]).contains(&seen) && size.action == left
                    );
                }
            }
            actions.push(side.sizes[0].action);
        }
        if let Some((_, sizes)) = TRANSFERS.iter().find(|(name, _)| *name == problem.name) {
            assert_eq!(actions, sizes);
            assert_eq!(problem.train.buildings.ids(), problem.test.buildings.ids());
        }
    }
}

#[test]
fn a_result_is_not_a_link_to_another() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::create_dir(path.join("theirs")).unwrap();
    for name in ["result.json", "episodes.parquet", "unfinished", "policy"] {
        let out = path.join(format!("out-{name}"));
        std::fs::create_dir(&out).unwrap();
        std::os::unix::fs::symlink(path.join("theirs"), out.join(name)).unwrap();
        let arguments = format!("benchmark run dynamics-house --policy reactive --out out-{name}");
        assert_rejected(path, &arguments, &["is not empty and contains no evaluation"]);
    }
    assert_eq!(std::fs::read_dir(path.join("theirs")).unwrap().count(), 0);
}

#[test]
fn a_killed_run_resumes_and_is_not_a_result_before_that() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = |out: &str| format!("{SMALL} --policy random --jobs 1 --out {out}");
    run(folder.path(), &arguments("whole"));
    let kept = folder.path().join("killed/unfinished/test/episodes");
    let episodes = || {
        std::fs::read_dir(&kept).map_or(0, |entries| {
            entries
                .filter(|entry| {
                    entry.as_ref().unwrap().path().extension().is_some_and(|ending| ending == "json")
                })
                .count()
        })
    };
    let mut process = command(folder.path(), &format!("benchmark run {}", arguments("killed")))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let deadline = Instant::now() + Duration::from_secs(300);
    while episodes() == 0 && process.try_wait().unwrap().is_none() {
        assert!(Instant::now() < deadline, "no episode ended");
        std::thread::sleep(Duration::from_millis(5));
    }
    process.kill().unwrap();
    process.wait().unwrap();
    assert!(!folder.path().join("killed/result.json").exists());
    assert_refused(folder.path(), "report killed", &["killed is unfinished", "benchmark run"]);
    assert_refused(folder.path(), "verify killed", &["FAILED", "killed is unfinished"]);
    // An episode that was edited meanwhile is run again.
    let edited = kept.join("000000.json");
    let text = std::fs::read_to_string(&edited).unwrap();
    let changed = text.replacen("_penalty\":", "_penalty\":1", 1);
    assert_ne!(changed, text);
    std::fs::write(&edited, changed).unwrap();
    run(folder.path(), &arguments("killed"));
    for file in ["result.json", "episodes.parquet"] {
        assert_eq!(
            bytes(&folder.path().join("killed"), file),
            bytes(&folder.path().join("whole"), file),
            "{file}"
        );
    }
}

#[test]
fn withheld_actuators_change_neither_the_building_nor_the_score_of_the_reactive_controllers() {
    let folder = tempfile::tempdir().unwrap();
    let day = "--period 01-10..01-10 --seed 0";
    for (name, sizes) in [("unitary-5-10", ["5", "10"]), ("unitary-10-5", ["10", "5"])] {
        let printed = run(folder.path(), &format!("{name} {day} --policy reactive --out {name}"));
        let line = printed.lines().find(|line| line.contains("OfficeSmall-0005")).unwrap();
        assert!(scores_one(line), "{line}");
        let (_, stages) = read_result(&folder.path().join(name)).unwrap();
        let hash = |stage: usize| &stages[stage].1[0].outcome.as_ref().unwrap().trajectory_hash;
        // On both sides, the reactive controllers drive the withheld actuators as if they drove all.
        assert_eq!(hash(0), hash(1), "{sizes:?}");
    }
    // A network of each side's shape acts on its side, and is refused on the other.
    for actions in [5, 10] {
        std::fs::write(folder.path().join(format!("{actions}.onnx")), linear_policy(23, actions, 0.0))
            .unwrap();
    }
    run(folder.path(), &format!("unitary-5-10 {day} --policy 10.onnx --train-policy 5.onnx --out fits"));
    let (result, stages) = read_result(&folder.path().join("fits")).unwrap();
    assert!(stages.iter().all(|(_, rows)| rows[0].metrics().unwrap().clamped_actions == 0));
    assert_eq!(std::fs::read_dir(folder.path().join("fits/policy")).unwrap().count(), 2);
    assert_eq!(result.policies.len(), 2);
    let refused = format!("run unitary-10-5 {day} --policy 10.onnx --out refused");
    assert_refused(folder.path(), &refused, &["10.onnx", "returns 10 values", "has 5", "supply air flow"]);
    assert_refused(
        folder.path(),
        &format!("run unitary-5-10 {day} --policy 5.onnx --out other"),
        &["returns 5", "has 10", "supply air temperature"],
    );
    // With pinned actuators, the controllers no longer match the baseline.
    let printed =
        run(folder.path(), &format!("unitary-10-5 {day} --fallback pin --policy reactive --out pinned"));
    let line = printed.lines().find(|line| line.contains("OfficeSmall-0005")).unwrap();
    assert!(!line.ends_with(" 1.000"), "{line}");
    assert!(printed.contains("modified: ") && printed.contains("restriction.left_to"), "{printed}");
}

#[test]
fn an_adapted_policy_is_scored_before_and_after_adaptation() {
    let folder = tempfile::tempdir().unwrap();
    // Zeros are the middle of every bound; the width is the paper's, with zones in order and zeros behind them.
    std::fs::write(folder.path().join("before.onnx"), linear_policy(20, 2, 0.0)).unwrap();
    for house in ["SingleFamilyHouse-0018", "SingleFamilyHouse-0387"] {
        std::fs::write(folder.path().join(format!("{house}.onnx")), linear_policy(20, 2, -0.9)).unwrap();
    }
    let arguments =
        format!("{SMALL} --policy before.onnx --adapted 2016={{building}}.onnx --trained-steps 100");
    let printed = run(folder.path(), &format!("{arguments} --out adapted"));
    assert!(printed.contains("jump-start") && printed.contains("after 2016 steps"), "{printed}");
    let (result, stages) = read_result(&folder.path().join("adapted")).unwrap();
    let names: Vec<_> = stages.iter().map(|(stage, _)| *stage).collect();
    assert_eq!(names, [Stage::Test, Stage::Train, Stage::Untrained, Stage::Adapted(2016)]);
    let mean = |stage: usize| {
        let rows = &stages[stage].1;
        rows.iter().filter_map(EpisodeResult::score).sum::<f64>() / rows.len() as f64
    };
    let adaptation = result.measures.adaptation.unwrap();
    assert!((adaptation.jump_start.value - (mean(2) - mean(0))).abs() < 1e-9 * mean(2));
    assert!((adaptation.curve[1].scores.mean.value - mean(3)).abs() < 1e-9 * mean(3));
    let refused = |more: &str, words: &[&str]| {
        assert_refused(folder.path(), &format!("run {SMALL} --policy before.onnx {more} --out x"), words);
    };
    refused("--adapted 77=before.onnx", &["after 77 steps", "2016"]);
    refused("--adapted 2016=none/{building}.onnx", &["adapted-2016", "none/SingleFamilyHouse-0018.onnx"]);
    refused("--trained-steps 4000001", &["4000001", "4000000"]);
    refused("--attributes given", &["takes 20 values", "has 34", "building floor_area", "garage present"]);
}

#[test]
fn the_leaderboard_opens_in_a_browser_without_an_error() {
    let Some(path) = browser::find() else {
        eprintln!("skipped: there is no Chromium on the path; B2B_BROWSER names one");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for policy in ["reactive", "random"] {
        run(folder.path(), &format!("{SMALL} --policy {policy} --out {policy}"));
    }
    let made = b2b(folder.path(), "benchmark report reactive random --out board.html");
    assert!(made.status.success(), "{}", both_outputs(&made));
    let mut browser = Browser::start(&path, folder.path());
    browser
        .open(&folder.path().join("board.html"), "document.querySelectorAll('.boards .main-svg').length > 0");
    let mut count = |what: &str| browser.value(&format!("document.querySelectorAll('{what}').length"));
    assert_eq!((count(".boards table"), count(".js-plotly-plot")), (json!(1), json!(5)));
    assert_eq!(count(".boards tbody tr"), json!(2));
    assert_eq!(count("nav li"), json!(0), "one problem needs no contents");
    let first = browser.value("document.querySelector('.boards tbody td').textContent");
    assert_eq!(first, json!("1. reactive"));
    let scale =
        |row: usize| format!("document.querySelectorAll('.boards tbody tr')[{row}].children[7].textContent");
    let [of_reactive, of_random] = [0, 1].map(|row| browser.value(&scale(row)).to_string());
    assert!(
        of_reactive.starts_with("\"1.000") && of_random.starts_with("\"0.000"),
        "{of_reactive} {of_random}"
    );

    let other =
        "dynamics-house --test SingleFamilyHouse-0018 --train SingleFamilyHouse-0001 --period 01-10..01-10";
    run(folder.path(), &format!("{other} --seed 0 --policy constant --out other"));
    let made = b2b(folder.path(), "benchmark report reactive other --out board.html");
    assert!(made.status.success(), "{}", both_outputs(&made));
    browser.emulate(400, false);
    let page = folder.path().join("board.html");
    browser.open(&page, "document.querySelectorAll('.boards .main-svg').length > 10");
    let contents = browser.value(
        "[...document.querySelectorAll('nav a')].every(link => document.querySelector(link.getAttribute('href')))",
    );
    assert_eq!(contents, json!(true));
    assert_eq!(browser.value("document.querySelectorAll('nav a').length"), json!(2), "two problems");
    assert_eq!(browser.value("document.documentElement.scrollWidth"), json!(400));
    assert_eq!(browser.value(browser::OUTSIDE), json!([]));
    assert_eq!(browser.errors, [""; 0]);
}

#[test]
fn a_models_own_controls_and_a_shipped_supervisor_enter_a_problem_and_are_verified() {
    let folder = tempfile::tempdir().unwrap();
    let problem =
        "operate-house --test SingleFamilyHouse-0018 --train SingleFamilyHouse-0001 --period 01-10..01-10";
    let agent = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../results/supervision/jobs/graph/all-types_operate_all-periods_0/agent");
    for (policy, out) in [("own", "own"), (agent.to_str().unwrap(), "agent")] {
        run(folder.path(), &format!("{problem} --seed 0 --policy {policy} --out {out}"));
        let verified = b2b(folder.path(), &format!("benchmark verify {out}"));
        assert!(verified.status.success(), "{}", both_outputs(&verified));
    }
    let (_, stages) = read_result(&folder.path().join("agent")).unwrap();
    assert!(stages.iter().all(|(_, rows)| rows[0].score().unwrap() != 1.0), "the guideline's own actions");
}

#[test]
fn invalid_arguments_are_rejected_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &str, words: &[&str]| assert_refused(folder.path(), arguments, words);
    refused("run dynamics-hous --policy random --out x", &["dynamics-hous`", "dynamics-house"]);
    refused("show dynamics-howse", &["dynamics-house"]);
    refused("run dynamics-house --policy reactiv --out x", &["`reactiv`", "planner"]);
    refused("run dynamics-house --policy none-{seed}.onnx --out x", &["none-0.onnx"]);
    refused("run cross-domain --policy random --out x", &["--train-type"]);
    refused(
        "run cross-domain --train-type OfficeSmall --test-type OfficeSmall --policy random --out x",
        &["OfficeSmall alone", "dynamics adaptation"],
    );
    refused(
        "run dynamics-office-small --train OfficeSmall-1 --test OfficeSmall-1 --policy random --out x",
        &["buildings are on both sides", "OfficeSmall-0001"],
    );
    refused(
        "run dynamics-office-small --train OfficeSmall-515 --policy random --out x",
        &["OfficeSmall-0515", "test split"],
    );
    assert!(!folder.path().join("x").exists());
    std::fs::write(folder.path().join("thesis.tex"), "").unwrap();
    refused("run dynamics-house --policy random --out .", &["contains no evaluation"]);
    refused("verify .", &["contains no result"]);
    refused("report .", &["contains no result"]);
}
