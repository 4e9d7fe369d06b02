//! Untrusted models, damaged files and crashes of the engine cause an error and nothing else.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use crate::policies::onnx_file::endless_policy;
use crate::program::{assert_rejected, b2b, both_outputs, command, json, stderr, wait_until, workers_of};
use b2b_energyplus::install::{Engine, Quiet};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use tempfile::TempDir;

const WAREHOUSE: &str = "RefBldgWarehouseNew2004_Chicago.idf";
const CHICAGO: &str = "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw";

/// Returns a folder with the weather of Chicago and a warehouse with more objects.
fn folder_with(objects: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let models = Engine::ensure(&mut Quiet).unwrap().models.unwrap();
    let weather = models.parent().unwrap().join("weather").join(CHICAGO);
    std::fs::copy(weather, folder.path().join("w.epw")).unwrap();
    let model = std::fs::read(models.join(WAREHOUSE)).unwrap();
    std::fs::write(folder.path().join("m.idf"), [&model, objects.as_bytes()].concat()).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<PathBuf> {
    let mut names: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    names
}

#[test]
fn no_command_takes_a_model_that_runs_code_or_reads_elsewhere() {
    let folder = folder_with(
        "\nExternalInterface,FunctionalMockupUnitImport;\n\
         ExternalInterface:FunctionalMockupUnitImport,./evil.fmu,0,0;\n\
         PythonPlugin:Instance,Plugin,Yes,module,Class;\n\
         Schedule:File,Outside,,/etc/hostname,1,0,8760,Comma;\n",
    );
    std::fs::write(folder.path().join("metered.csv"), "month,electricity_kwh,gas_kwh\n1,2,3\n2,3,4\n")
        .unwrap();
    let files = names(folder.path());
    for arguments in [
        "run m.idf --weather w.epw",
        "import m.idf --weather w.epw --run 01-01..01-01",
        "edit m.idf --lights 2 --out edited.epJSON",
        "calibrate m.idf --weather w.epw --energy metered.csv --out calibrated.epJSON",
        "show m.idf --weather w.epw",
        "view m.idf --weather w.epw",
        "doctor --authority m.idf --weather w.epw",
    ] {
        let words = [
            "ExternalInterface:FunctionalMockupUnitImport `",
            "native code",
            "PythonPlugin:Instance `Plugin` runs Python code",
            "Schedule:File `Outside` names the file `/etc/hostname`",
            "--allow-external",
        ];
        assert_rejected(folder.path(), arguments, &words);
        assert_eq!(names(folder.path()), files, "{arguments}");
    }
    let evaluation = "evaluate m.idf --weather w.epw --policy reactive --period 01-01..01-01 --out e";
    assert_rejected(folder.path(), evaluation, &["PythonPlugin:Instance `Plugin`", "--allow-external"]);
}

#[test]
fn a_file_next_to_the_model_is_read_and_one_elsewhere_on_request() {
    let schedule = |file: &str| format!("\nSchedule:File,Shares,,{file},1,0,8760,Comma;\n");
    let elsewhere = tempfile::Builder::new().suffix(".csv").tempfile().unwrap();
    std::fs::write(elsewhere.path(), "0.5\n".repeat(8760)).unwrap();
    let folder = folder_with(&schedule("shares.csv"));
    let import = "import m.idf --weather w.epw";
    assert_rejected(folder.path(), import, &["`Shares`", "`shares.csv`, which is missing"]);
    std::fs::write(folder.path().join("shares.csv"), "0.5\n".repeat(8760)).unwrap();
    assert!(json(folder.path(), import).is_object());
    // The engine reads it from wherever the command runs.
    let model = folder.path().join("m.idf").display().to_string();
    let weather = folder.path().join("w.epw").display().to_string();
    assert!(json(Path::new("/"), &format!("import {model} --weather {weather}")).is_object());
    // Its content is part of the prepared model, so that a changed file is not mistaken for the old one.
    std::fs::write(folder.path().join("shares.csv"), "no number\n".repeat(8760)).unwrap();
    assert!(!b2b(folder.path(), import).status.success());

    let folder = folder_with(&schedule(&elsewhere.path().display().to_string()));
    assert_rejected(folder.path(), import, &["`Shares`", "is outside the folder of the model"]);
    assert!(json(folder.path(), &format!("{import} --allow-external")).is_object());
}

/// Runs a command, which fails because the engine crashes, and returns its output. It leaves no files.
fn assert_crash(folder: &Path, arguments: &str, crashed: impl FnOnce(&mut Child)) -> String {
    let (files, temporary) = (names(folder), tempfile::tempdir().unwrap());
    let mut command = command(folder, arguments);
    command.env("TMPDIR", temporary.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    crashed(&mut child);
    let output = child.wait_with_output().unwrap();
    let said = both_outputs(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_eq!(names(folder), files, "{said}");
    assert_eq!(names(temporary.path()), Vec::<PathBuf>::new(), "{said}");
    said
}

#[test]
fn a_crash_while_sizing_is_an_error_and_leaves_nothing() {
    let folder = folder_with("");
    let weather = std::fs::read_to_string(folder.path().join("w.epw")).unwrap();
    let line = weather.lines().find(|line| line.starts_with("HOLIDAYS")).unwrap();
    let crashes = weather.replace(line, "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0");
    std::fs::write(folder.path().join("w.epw"), crashes).unwrap();
    std::fs::write(folder.path().join("e.csv"), "month,electricity_kwh\n1,2\n2,3\n3,1\n4,5\n").unwrap();
    for (arguments, doing) in [
        ("run m.idf --weather w.epw --out out", "sizing m"),
        ("import m.idf --weather w.epw", "sizing m"),
        ("show m.idf --weather w.epw", "sizing m"),
        ("calibrate m.idf --weather w.epw --energy e.csv --out c.epJSON", "simulating a year of m"),
    ] {
        let said = assert_crash(folder.path(), arguments, |_| {});
        let crash = format!("EnergyPlus crashed (signal 11, a segmentation fault) while {doing}");
        assert!(said.contains(&crash), "{arguments}: {said}");
    }
    std::fs::copy(folder.path().join("m.idf"), folder.path().join("n.idf")).unwrap();
    let all = b2b(folder.path(), "import . --weather w.epw");
    assert_eq!(both_outputs(&all).matches("EnergyPlus crashed").count(), 2, "{}", both_outputs(&all));
}

/// A program that calls itself without an end, on a day in January.
const RECURSION: &str = "\nEnergyManagementSystem:Program,Recurse,IF DayOfYear == 10,RUN Recurse,ENDIF;\n\
                         EnergyManagementSystem:ProgramCallingManager,Call,BeginTimestepBeforePredictor,Recurse;\n";

#[test]
fn a_crash_in_the_trial_is_an_error_that_names_the_model() {
    let folder = folder_with(RECURSION);
    assert!(b2b(folder.path(), "import m.idf --weather w.epw").status.success(), "it is sized");
    let said = assert_crash(folder.path(), "import m.idf --weather w.epw --run 01-10..01-10", |_| {});
    assert!(said.contains("the template of m was lost") && said.contains("signal: 11 (SIGSEGV)"), "{said}");
}

#[test]
fn a_crash_of_the_converter_is_an_error_that_names_the_model_and_the_signal() {
    let zones: String = (0..200_000).map(|zone| format!("Zone,Zone {zone};\n")).collect();
    let folder = folder_with(&zones);
    for arguments in ["edit m.idf --lights 2 --out e.epJSON", "import m.idf --weather w.epw"] {
        let said = assert_crash(folder.path(), arguments, |child| {
            let mut workers = Vec::new();
            wait_until(|| {
                workers = workers_of(child.id());
                !workers.is_empty()
            });
            kill_process(Pid::from_raw(workers[0] as i32).unwrap(), Signal::ABORT).unwrap();
        });
        assert!(said.contains("EnergyPlus crashed (signal 6, an abort) while converting m.idf"), "{said}");
    }
}

#[test]
fn a_model_that_the_engine_refuses_is_an_error_with_its_messages_alone() {
    let folder =
        folder_with("\nSchedule:Compact,Half a day,Fraction,Through: 12/31,For: AllDays,Until: 12:00,0.5;\n");
    for arguments in ["run m.idf --weather w.epw --out out", "import m.idf --weather w.epw"] {
        let output = b2b(folder.path(), arguments);
        let said = both_outputs(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("error: cannot prepare m"), "{said}");
        assert!(said.contains("fatal: ProcessScheduleInput"), "{said}");
        assert!(!said.contains("Program terminated"), "{said}");
    }
}

#[test]
fn a_damaged_trajectory_is_never_scored() {
    let folder = tempfile::tempdir().unwrap();
    let out = b2b(folder.path(), "run SingleFamilyHouse --period 01-01..01-01 --out out");
    assert!(out.status.success(), "{}", stderr(&out));
    let path = folder.path().join("out/trajectory.parquet");
    let whole = std::fs::read(&path).unwrap();
    let honest: Value = json(folder.path(), "score out/trajectory.parquet");
    let mut refused = 0;
    let positions: Vec<usize> = (0..40).map(|n| n * (whole.len() - 1) / 39).collect();
    for at in positions {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x55;
        std::fs::write(&path, damaged).unwrap();
        let output = b2b(folder.path(), "score out/trajectory.parquet --json");
        let said = stderr(&output);
        assert!(!said.contains("panicked"), "byte {at}: {said}");
        match output.status.code() {
            Some(0) => {
                assert_eq!(serde_json::from_slice::<Value>(&output.stdout).unwrap(), honest, "byte {at}")
            }
            code => {
                assert_eq!(code, Some(1), "byte {at}: {said}");
                assert!(said.contains("trajectory.parquet"), "{said}");
                refused += 1;
            }
        }
    }
    // The others are not read.
    assert!(refused > 25, "{refused}");
}

#[test]
fn an_output_folder_that_results_cannot_name_is_refused_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let mut run = command(folder.path(), "run SingleFamilyHouse --period 01-01..01-01 --out");
    let output = run.arg(OsStr::from_bytes(b"out-\xff")).output().unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("--out") && said.contains("UTF-8"), "{said}");
    assert_eq!(names(folder.path()), Vec::<PathBuf>::new());
}

#[test]
fn a_temporary_folder_that_cannot_be_used_is_named_with_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let mut run = command(folder.path(), "run SingleFamilyHouse --period 01-01..01-01");
    let output = run.env("TMPDIR", folder.path().join("none")).output().unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    for word in ["temporary folder", "/none", "TMPDIR"] {
        assert!(said.contains(word), "`{word}` is not in: {said}");
    }
}

#[test]
fn a_limit_of_the_shell_is_an_error_that_names_it_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for (limit, value, arguments) in [
        ("ulimit -f", 100, "run SingleFamilyHouse --period 01-01..01-02 --out o"),
        ("ulimit -f", 100, "evaluate SingleFamilyHouse --policy constant --period 01-01..01-01 --out o"),
        // Its prototype is an IDF, whose conversion writes more.
        ("ulimit -f", 100, "evaluate Warehouse-0001 --policy constant --period 01-01..01-01 --out w"),
        ("ulimit -f", 10, "generate SingleFamilyHouse --count 1 --out o"),
        ("ulimit -v", 6_000_000, "run SingleFamilyHouse --period 01-01..01-02 --out r"),
    ] {
        let temporary = tempfile::tempdir().unwrap();
        let mut limited = std::process::Command::new("bash");
        let command = format!("{limit} {value}; exec {} {arguments}", env!("CARGO_BIN_EXE_b2b"));
        limited.args(["-c", &command]).current_dir(folder.path()).env("TMPDIR", temporary.path());
        let output = limited.output().unwrap();
        let said = both_outputs(&output);
        assert_eq!(output.status.code(), Some(1), "{arguments}: {said}");
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains(limit) && said.contains("raise the limit"), "{arguments}: {said}");
        assert_eq!(names(temporary.path()), Vec::<PathBuf>::new(), "{arguments}: {said}");
    }
}

#[test]
fn a_network_that_never_ends_ends_the_command_and_a_signal_does_within_10_s() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("p.onnx"), endless_policy()).unwrap();
    let problem = "dynamics-house --test SingleFamilyHouse-0018 --train SingleFamilyHouse-0001 --period 01-10..01-10 --seed 0";
    for arguments in [
        "evaluate RestaurantFastFood --policy p.onnx --period 01-01..01-01 --out e".to_owned(),
        format!("benchmark run {problem} --policy p.onnx --out b"),
        "collect b2b/endless-v0 RestaurantFastFood --policy p.onnx --period 01-01..01-01 --out .".to_owned(),
    ] {
        let output = b2b(folder.path(), &arguments);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{arguments}: {said}");
        assert!(said.contains("p.onnx") && said.contains("not finished within 5 s"), "{arguments}: {said}");

        let mut child = command(folder.path(), &arguments).spawn().unwrap();
        std::thread::sleep(Duration::from_secs(4));
        let begun = Instant::now();
        // It has ended if the machine is fast.
        let _ = kill_process(Pid::from_child(&child), Signal::TERM);
        child.wait().unwrap();
        assert!(begun.elapsed() < Duration::from_secs(12), "{arguments}: {:?}", begun.elapsed());
    }
}

#[test]
fn commands_with_controllers_of_their_own_do_not_run_a_network_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("p.onnx"), endless_policy()).unwrap();
    for command in ["run", "serve"] {
        let output = b2b(folder.path(), &format!("{command} SingleFamilyHouse --controller p.onnx"));
        assert_eq!(output.status.code(), Some(2), "{command}: {}", both_outputs(&output));
        assert!(stderr(&output).contains("invalid value 'p.onnx'"), "{command}: {}", stderr(&output));
    }
}

#[test]
fn a_configuration_file_does_not_permit_a_model_to_run_code() {
    let folder = folder_with("\nPythonPlugin:Instance,Plugin,Yes,module,Class;\n");
    let config = "buildings = ['m.idf']\nweather = 'w.epw'\nsteps = 400\nallow_external = true\n";
    std::fs::write(folder.path().join("c.toml"), config).unwrap();
    assert_rejected(
        folder.path(),
        "train --config c.toml --out run",
        &["c.toml", "`allow_external` cannot be set"],
    );
    std::fs::create_dir(folder.path().join("earlier")).unwrap();
    std::fs::write(folder.path().join("earlier/config.toml"), config).unwrap();
    assert_rejected(
        folder.path(),
        "train --resume earlier",
        &["PythonPlugin:Instance `Plugin`", "--allow-external"],
    );
}

#[test]
fn commands_that_begin_at_once_in_a_new_folder_do_not_mix() {
    let folder = tempfile::tempdir().unwrap();
    let evaluate =
        |policy| format!("evaluate RestaurantFastFood --policy {policy} --period 01-01..01-01 --out e");
    let short = "window_days = 1\n[evaluation]\nevery = 0\nwhole_period = false\n";
    std::fs::write(folder.path().join("c.toml"), short).unwrap();
    let train = |seed| {
        let options = "--period 01-01..01-02 --steps 2000 --environments 2";
        format!("train RestaurantFastFood --config c.toml {options} --seed {seed} --out t")
    };
    // A year, so that the first has not ended when the second begins.
    let run = |controller| {
        format!("run SingleFamilyHouse --controller {controller} --period full_year --out r --json")
    };
    for commands in
        [[evaluate("constant"), evaluate("random")], [train(1), train(2)], [run("hold"), run("off")]]
    {
        let start = |arguments: &String| {
            let mut command = command(folder.path(), arguments);
            command.stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap()
        };
        let ended: Vec<_> =
            commands.each_ref().map(start).map(|child| child.wait_with_output().unwrap()).into();
        let (succeeded, failed): (Vec<_>, Vec<_>) = ended.iter().partition(|output| output.status.success());
        let said: Vec<_> = ended.iter().map(stderr).collect();
        assert_eq!((succeeded.len(), failed.len()), (1, 1), "{said:?}");
        let said = stderr(failed[0]);
        let other = ["in use", "another evaluation", "differs"];
        assert!(other.iter().any(|word| said.contains(word)), "{said}");
    }
}

#[test]
fn a_flipped_bit_of_an_evaluation_is_an_error_when_it_is_compared() {
    let folder = tempfile::tempdir().unwrap();
    for policy in ["constant", "random"] {
        let evaluate =
            format!("evaluate RestaurantFastFood --policy {policy} --period 01-01..01-01 --out {policy}");
        let output = b2b(folder.path(), &evaluate);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    let compare = "evaluate compare constant random";
    assert!(b2b(folder.path(), compare).status.success());
    let path = folder.path().join("random/episodes.parquet");
    let whole = std::fs::read(&path).unwrap();
    for place in 0..60 {
        let mut damaged = whole.clone();
        damaged[place * (whole.len() - 1) / 59] ^= 1 << (place % 8);
        std::fs::write(&path, damaged).unwrap();
        assert_rejected(folder.path(), compare, &["episodes.parquet", "SHA256SUMS"]);
    }
    // One of an earlier version has no digests.
    std::fs::write(&path, whole).unwrap();
    std::fs::remove_file(folder.path().join("random/SHA256SUMS")).unwrap();
    assert!(b2b(folder.path(), compare).status.success());
}
