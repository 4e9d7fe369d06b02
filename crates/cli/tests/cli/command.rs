//! The `b2b` command from the outside, on the real engine.

use std::fs::File;
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::Stdio;
use std::time::Duration;

use crate::program::sandbox::{B2B, Sandbox};
use crate::program::{stderr, wait_until, workers_of};
use b2b_climate::Place;
use b2b_energyplus::install::Quiet;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

/// The fastest building, for two days.
const SHORT: &str = "run RestaurantFastFood --period 01-01..01-02";

#[test]
fn the_front_page_teaches_without_arguments_and_on_help() {
    let sandbox = Sandbox::new();
    let text = |arguments: &str| {
        let output = sandbox.b2b(arguments);
        assert!(output.status.success() && output.stderr.is_empty(), "{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    for page in [text(""), text("--help")] {
        for words in [
            "Start here:\n  b2b run OfficeSmall",
            "Evaluate policies:\n  evaluate ",
            "downloaded automatically",
        ] {
            assert!(page.contains(words), "`{words}` is not in: {page}");
        }
        assert!(page.lines().all(|line| line.chars().count() <= 120), "{page}");
    }
}

#[test]
fn run_prints_one_json_object_with_every_promised_key() {
    let sandbox = Sandbox::new();
    let object = sandbox.json(SHORT);
    for key in ["building", "place", "period", "controller", "trajectory_hash"] {
        assert!(object[key].is_string(), "{key}: {object}");
    }
    for key in [
        "steps",
        "seed",
        "return",
        "temperature_penalty",
        "energy_penalty",
        "rms_deviation_k",
        "mean_abs_deviation_k",
        "hours_outside_band",
        "discomfort_k_h",
        "cost_m2",
        "emissions_kg_m2",
        "peak_electricity_w_m2",
        "daily_travel",
        "electricity_wh_m2",
        "gas_wh_m2",
        "meter_relative_error",
        "engine_warnings",
        "engine_severes",
        "clamped_actions",
        "cpu_s",
        "environment_cpu_s",
    ] {
        assert!(object[key].is_number(), "{key}: {object}");
    }
    assert_eq!(object["steps"], 2 * 24 * 12);
    assert_eq!((&object["task"], &object["controller"]), (&"operate".into(), &"guideline36".into()));
    for indicator in ["cost_tot", "ener_tot", "tdis_tot", "pele_tot", "emis_tot"] {
        assert!(object[indicator].is_number(), "{indicator}: {object}");
    }
    assert!(object["meter_relative_error"].as_f64().unwrap() < 1e-9, "{object}");
    for zone in object["zones"].as_array().unwrap() {
        assert!(zone["name"].is_string() && zone["rms_deviation_k"].is_number(), "{zone}");
        assert!(zone["mean_abs_deviation_k"].is_number() && zone["hours_outside_band"].is_number(), "{zone}");
        assert!(zone["heating_and_cooling"].is_boolean(), "{zone}");
    }
    let files: Vec<_> = object["files"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    assert_eq!(files.len(), 3);
    for file in files {
        assert!(sandbox.work.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn the_summary_file_is_what_json_prints() {
    let sandbox = Sandbox::new();
    let printed = sandbox.json(&format!("{SHORT} --out here"));
    let file = File::open(sandbox.work.path().join("here/summary.json")).unwrap();
    assert_eq!(serde_json::from_reader::<_, Value>(file).unwrap(), printed);
}

#[test]
fn the_same_run_twice_in_two_processes_has_the_same_hash() {
    let hash = |seed: u32| {
        let object = Sandbox::new().json(&format!("{SHORT} --controller random --seed {seed}"));
        object["trajectory_hash"].as_str().unwrap().to_owned()
    };
    let first = hash(1);
    assert_eq!(hash(1), first);
    assert_ne!(hash(2), first);
}

#[test]
fn the_text_report_shows_metrics_zones_and_files() {
    let sandbox = Sandbox::new();
    let output = sandbox.b2b(&format!("{SHORT} --controller constant"));
    let text = String::from_utf8(output.stdout).unwrap();
    for word in
        ["RestaurantFastFood in Denver", "peak electric demand", "actuator travel", "Kitchen", "picture.html"]
    {
        assert!(text.contains(word), "{text}");
    }
    assert_eq!(std::fs::read_dir(sandbox.temporary.path()).unwrap().count(), 0);
}

#[test]
fn a_house_has_no_outdoor_air_of_its_systems_and_no_zero_instead() {
    let page = include_str!("../../../../docs/tasks.md");
    assert!(page.contains("The ventilation of houses is separate"));
    let output = Sandbox::new().b2b("run SingleFamilyHouse --period 01-01..01-01");
    let text = String::from_utf8(output.stdout).unwrap();
    let line = text.lines().find(|line| line.contains("outdoor air per person")).unwrap();
    assert!(line.ends_with("none through the systems"), "{line}");
}

#[test]
fn the_trajectory_file_has_a_row_per_step_and_a_named_column_per_value() {
    let sandbox = Sandbox::new();
    sandbox.json(&format!("{SHORT} --out here"));
    let file = File::open(sandbox.work.path().join("here/trajectory.parquet")).unwrap();
    let table = ParquetRecordBatchReaderBuilder::try_new(file).unwrap();
    assert_eq!(table.metadata().file_metadata().num_rows(), 2 * 24 * 12);
    let schema = table.schema();
    assert_eq!(schema.metadata()["building"], "RestaurantFastFood");
    for name in [
        "step",
        "month",
        "hour",
        "Kitchen air temperature",
        "outdoor air temperature",
        "HVAC non-electric",
        "Kitchen supply air flow",
        "Dining supply air temperature",
        "temperature penalty",
        "energy penalty",
        "reward",
    ] {
        let field = schema.field_with_name(name).unwrap_or_else(|_| panic!("no {name} in {schema}"));
        assert!(field.metadata().contains_key("unit"), "{field}");
    }
}

#[test]
fn a_misspelled_argument_is_answered_with_the_valid_ones() {
    for (arguments, words) in [
        ("run OficeSmall", ["OficeSmall", "OfficeSmall"]),
        ("show Warehose", ["Warehose", "Warehouse"]),
        ("run Warehouse --place Dever", ["Dever", "Denver"]),
        ("run Warehouse --period 02-30..03-05", ["02-30", "MM-DD"]),
        ("run Warehouse --period spring", ["spring", "winter, summer, full_year"]),
        ("run Warehouse --period sumer", ["sumer", "did you mean summer?"]),
        ("run Warehouse --parameters tund", ["tund", "did you mean tuned?"]),
        ("run mall", ["mall", ".idf or .epJSON"]),
        (
            "run Warehouse --controller reactiv",
            ["did you mean reactive?", "expected guideline36, own, reactive"],
        ),
        ("run Warehouse --task warm", ["`warm`", "occupancy+energy0.5"]),
        ("run Warehouse --task constant:99", ["target", "99"]),
        ("run Warehouse --task operate:21-24", ["operate:21-24", "operate:21-24/15.6-28"]),
        ("generate Warehouse --count 1 --zone 5A --place Denver --out g", ["--zone", "--weather"]),
        ("run Warehouse --task none.json", ["none.json", "No such file"]),
        ("run Warehouse --steps-per-hour 7", ["7", "12"]),
        ("run Warehouse --weather nowhere.epw", ["nowhere.epw", "No such file"]),
        ("list palces", ["palces", "places"]),
        ("run Warehouse --control setpoint", ["`setpoint`", "did you mean `setpoints`?"]),
        ("edit m.idf --lights two", ["two", "expected a number"]),
        ("run Warehouse --seed x", ["'x'", "expected a whole number"]),
        ("serve Warehouse --host 1.2", ["1.2", "expected an IP address, such as 127.0.0.1"]),
    ] {
        let sandbox = Sandbox::new();
        sandbox.assert_refused(&mut sandbox.command(B2B, arguments), &words);
    }
}

#[test]
fn a_truncated_weather_file_is_rejected_by_name() {
    let sandbox = Sandbox::new();
    let whole = std::fs::read(Place::find("Denver").unwrap().epw(&mut Quiet).unwrap()).unwrap();
    std::fs::write(sandbox.work.path().join("half.epw"), &whole[..whole.len() / 2]).unwrap();
    let mut command = sandbox.command(B2B, "run Warehouse --weather half.epw --json");
    sandbox.assert_refused(&mut command, &["half.epw", "columns"]);
}

#[test]
fn a_missing_engine_is_reported_with_a_remedy() {
    let sandbox = Sandbox::new();
    let empty = tempfile::tempdir().unwrap();
    let mut command = sandbox.command(B2B, SHORT);
    command.env("B2B_ENERGYPLUS", empty.path());
    sandbox.assert_refused(&mut command, &["B2B_ENERGYPLUS", empty.path().to_str().unwrap()]);
    let mut command = sandbox.command(B2B, SHORT);
    command.env_remove("B2B_ENERGYPLUS").env("B2B_CACHE", empty.path()).env("B2B_OFFLINE", "1");
    sandbox.assert_refused(&mut command, &["B2B_OFFLINE", "b2b setup"]);
    // With this variable, EnergyPlus would simulate January for July, and the sizes would be kept.
    let mut command = sandbox.command(B2B, SHORT);
    command.env("FULLANNUALRUN", "Yes");
    sandbox.assert_refused(&mut command, &["FULLANNUALRUN", "unset it"]);
}

#[test]
fn doctor_fails_and_names_a_problem() {
    let sandbox = Sandbox::new();
    let mut command = sandbox.command(B2B, "doctor");
    let output = command.env("B2B_ENERGYPLUS", "/nowhere").output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("✗ EnergyPlus") && text.contains("/nowhere"), "{text}");
}

#[test]
fn a_full_disk_is_reported_with_the_file_and_leaves_nothing_behind() {
    use rustix::process::{Resource, Rlimit, prlimit};

    let sandbox = Sandbox::new();
    let before = sandbox.left_behind();
    let mut command = sandbox.command("bash", "-c");
    let run = "run RestaurantFastFood --period 01-01..01-31 --controller random --json";
    command.arg(format!("trap '' XFSZ; exec {B2B} {run}"));
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_until(|| runs_an_episode(child.id()));
    // Once its workers run, its files may have 400 KiB at most: too little for a month of random actions.
    let limit = Some(400 << 10);
    prlimit(Some(Pid::from_child(&child)), Resource::Fsize, Rlimit { current: limit, maximum: limit })
        .unwrap();
    let output = child.wait_with_output().unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("trajectory.parquet") && said.contains("File too large"), "{said}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "");
    assert_eq!(sandbox.left_behind(), before);
}

#[test]
fn an_impossible_output_folder_is_rejected_before_the_run() {
    let sandbox = Sandbox::new();
    std::fs::write(sandbox.work.path().join("taken"), "").unwrap();
    for out in ["taken", "taken/below"] {
        let mut command = sandbox.command(B2B, &format!("{SHORT} --out {out}"));
        sandbox.assert_refused(&mut command, &["taken"]);
    }
}

#[test]
fn an_interrupted_run_stops_between_steps_and_leaves_nothing_behind() {
    for signal in [Signal::INT, Signal::TERM] {
        let sandbox = Sandbox::new();
        let mut command = sandbox.command(B2B, "run RestaurantFastFood --period full_year");
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let process = child.id();
        wait_until(|| runs_an_episode(process));
        std::thread::sleep(Duration::from_millis(300));
        kill_process(Pid::from_child(&child), signal).unwrap();
        let output = child.wait_with_output().unwrap();
        let said = stderr(&output);
        assert_eq!((output.status.code(), output.status.signal()), (Some(130), None), "{said}");
        assert!(said.starts_with("interrupted after "), "{said}");
        assert_eq!(sandbox.left_behind(), Vec::<PathBuf>::new());
        assert_eq!(workers_of(process), Vec::<u32>::new(), "processes of the run that are still there");
    }
}

#[test]
fn a_run_under_nohup_survives_a_hangup() {
    let sandbox = Sandbox::new();
    let mut command =
        sandbox.command("nohup", &format!("{B2B} run RestaurantFastFood --period 01-01..01-21"));
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let process = child.id();
    wait_until(|| runs_an_episode(process));
    kill_process(Pid::from_child(&child), Signal::HUP).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
}

#[test]
fn interrupted_commands_that_start_processes_leave_nothing_behind() {
    for arguments in [
        "check RestaurantFastFood-0001 --jobs 1",
        "bench vector --type RestaurantFastFood --environments 2 --days 20",
        "collect own/restaurant-v0 RestaurantFastFood --out datasets --jobs 1",
    ] {
        let sandbox = Sandbox::new();
        let mut command = sandbox.command(B2B, arguments);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        wait_until(|| !children_of(child.id()).is_empty());
        std::thread::sleep(Duration::from_secs(1));
        kill_process(Pid::from_child(&child), Signal::TERM).unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{arguments}: {}", stderr(&output));
        assert_eq!(sandbox.left_behind(), Vec::<PathBuf>::new(), "{arguments}");
    }
}

/// Returns the child processes of a process.
fn children_of(process: u32) -> Vec<u32> {
    let child = |entry: std::fs::DirEntry| {
        let id = entry.file_name().to_str()?.parse().ok()?;
        let stat = std::fs::read_to_string(entry.path().join("stat")).ok()?;
        // After the name in parentheses: state, parent.
        let parent: u32 = stat.rsplit(')').next()?.split_whitespace().nth(1)?.parse().ok()?;
        (parent == process).then_some(id)
    };
    std::fs::read_dir("/proc").unwrap().flatten().filter_map(child).collect()
}

/// Returns whether a command has a template and the copy that runs the episode.
fn runs_an_episode(command: u32) -> bool {
    workers_of(command).len() >= 2
}

#[test]
fn bench_speed_measures_the_costs_of_a_step() {
    let speeds = Sandbox::new().json("bench speed --type RestaurantFastFood --days 4");
    let speed = &speeds.as_array().unwrap()[0];
    assert_eq!((&speed["type"], &speed["steps"]), (&"RestaurantFastFood".into(), &(4 * 2 * 288).into()));
    for key in ["engine_ms", "advance_ms", "env_ms", "operation_ms"] {
        assert!(speed[key].as_f64().unwrap() > 0.0, "{speed}");
    }
}

#[test]
fn bench_train_measures_both_designs_and_the_shares_of_their_time() {
    let arguments = "bench train --type SingleFamilyHouse --environments 2 --steps 1000 --python none";
    let rows = Sandbox::new().json(arguments);
    let rows = rows.as_array().unwrap();
    let designs: Vec<_> = rows.iter().map(|row| row["design"].as_str().unwrap()).collect();
    assert_eq!(designs, ["fragments", "lockstep"]);
    for row in rows {
        // A rollout of the preset has 672 steps of each environment.
        assert_eq!((&row["type"], &row["steps"]), (&"SingleFamilyHouse".into(), &1344.into()));
        assert!(row["steps_per_s"].as_f64().unwrap() > 0.0, "{row}");
        assert!(row["sb3_steps_per_s"].is_null(), "{row}");
        let shares =
            ["environment_share", "inference_share", "learner_share"].map(|key| row[key].as_f64().unwrap());
        assert!(shares.iter().all(|share| *share > 0.0), "{row}");
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{row}");
    }
}

#[test]
fn a_typo_gets_the_nearest_name_and_no_word_is_cut() {
    let sandbox = Sandbox::new();
    for (arguments, near) in [
        ("rnu OfficeSmall", "'run'"),
        ("run SmallOffice", "did you mean OfficeSmall?"),
        ("run OfficeSmall --task occupency", "did you mean occupancy?"),
    ] {
        let output = sandbox.command(B2B, arguments).env("COLUMNS", "80").output().unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.replace('\n', " ").contains(near), "{said}");
        let longest = said.lines().map(|line| line.chars().count()).max().unwrap();
        assert!(longest <= 80, "{said}");
    }
    sandbox.assert_refused(&mut sandbox.command(B2B, "run nowhere.idf"), &["nowhere.idf", "does not exist"]);
    for arguments in ["view OfficeSmall", "compare a b", "evaluate compare a b", "benchmark report a"] {
        let mut command = sandbox.command(B2B, &format!("{arguments} --out x.pdf"));
        sandbox.assert_refused(&mut command, &["x.pdf", ".html"]);
    }
}

#[test]
fn the_warnings_of_the_engine_are_in_the_summary() {
    let object = Sandbox::new().json(SHORT);
    let warnings = object["warning_messages"].as_array().unwrap();
    assert!(object["engine_warnings"].as_u64().unwrap() > 0, "{object}");
    assert_eq!(warnings.len() as u64, object["engine_warnings"].as_u64().unwrap().min(100));
    assert!(warnings.iter().all(|text| !text.as_str().unwrap().is_empty()), "{warnings:?}");
}
