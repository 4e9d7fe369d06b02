//! `b2b train` from the outside, on the real engine.

use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::program::{assert_rejected, b2b, both_outputs, command, json, stderr, wait_until};
use b2b_energyplus::install::{Engine, Quiet};
use b2b_learn::train::read_column;
use rustix::process::{Pid, Resource, Rlimit, Signal, kill_process_group, prlimit};
use serde_json::Value;

/// A small run: two environments, episodes of a day, an evaluation and a checkpoint at every other update.
const SMALL: &str = "\
preset = \"residual\"
task = \"occupancy\"
period = \"01-10..01-12\"
steps = 2304
environments = 2
window_days = 1
window_starts = 2
checkpoint_every = 384
stage_every = 1152
evaluation = { every = 768, days = 1 }
ppo = { n_steps = 96, batch_size = 64, epochs = 2 }
";

fn train(out: &str) -> String {
    format!("train SingleFamilyHouse-0014 --config small.toml --out {out}")
}

fn folder_with_config() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    folder
}

fn weights(folder: &Path, run: &str) -> [Vec<u8>; 2] {
    ["weights.safetensors", "last/weights.safetensors"]
        .map(|file| std::fs::read(folder.join(run).join(file)).unwrap())
}

/// A column of a run's table.
fn column(folder: &Path, run: &str, name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join(run).join("progress.csv")).unwrap();
    let mut rows = text.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let index = rows.next().unwrap().iter().position(|each| *each == name).unwrap();
    rows.map(|row| row[index].to_owned()).collect()
}

/// The columns of a run's table that do not depend on time.
fn course(folder: &Path, run: &str) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join(run).join("progress.csv")).unwrap();
    let timeless = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        [&cells[..1], &cells[4..]].concat().join(",")
    };
    text.lines().map(timeless).collect()
}

#[test]
fn a_users_model_is_trained_with_its_weather_file() {
    let folder = folder_with_config();
    let path = folder.path();
    let models = Engine::ensure(&mut Quiet).unwrap().models.unwrap();
    let weather = models.parent().unwrap().join("weather/USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw");
    let model = models.join("RefBldgWarehouseNew2004_Chicago.idf");
    let building = format!("{} --weather {}", model.display(), weather.display());
    let summary = json(path, &format!("train {building} --config small.toml --steps 384 --out run"));
    assert!(summary["buildings"].as_str().unwrap().contains("in USA_IL_Chicago"), "{summary}");
    let evaluate =
        format!("evaluate {building} --policy run --task occupancy --period 01-10..01-12 --out evaluated");
    let evaluated = json(path, &evaluate);
    let score = &evaluated["windows"][0]["all"]["scores"]["interquartile_mean"]["value"];
    assert_eq!(score, &summary["score"]);
    assert_rejected(path, "train --type OfficeSmall --place Miami --out x", &["`place`", "for `buildings`"]);
}

#[test]
fn a_run_is_an_agent_that_evaluations_take_as_a_policy() {
    let folder = folder_with_config();
    let path = folder.path();
    let summary = json(path, &train("run"));
    assert_eq!((summary["steps"].as_u64(), summary["lost_episodes"].as_u64()), (Some(2304), Some(0)));
    assert_eq!(summary["out"], "run");
    let number = |name: &str| summary[name].as_f64().unwrap();
    assert!(number("score") > 0.0 && number("energy_ratio") > 0.0 && number("steps_per_s") > 0.0);
    for file in ["agent.json", "config.toml", "progress.csv", "curve.html", "summary.json", "last/agent.json"]
    {
        assert!(path.join("run").join(file).is_file(), "{file}");
    }
    let of = |folder: &str| std::fs::read(path.join("run").join(folder).join("weights.safetensors")).unwrap();
    assert_eq!(of("stages/2"), of("last"));
    assert_ne!(of("stages/1"), of("last"));
    assert!(!path.join("run/stages/3").exists());
    assert_eq!(course(path, "run").len(), 14, "a header, the first evaluation and twelve updates");
    let scores = read_column(&path.join("run"), "score").unwrap();
    assert_eq!(scores.iter().map(|(steps, _)| *steps).collect::<Vec<_>>(), [0, 768, 1536, 2304]);
    assert!((scores[0].1 - 1.0).abs() < 0.05, "the first agent hardly corrects the baseline: {scores:?}");
    assert!(number("relative_travel") > 0.0 && number("oscillating_share") <= 1.0);

    let evaluate = "evaluate SingleFamilyHouse-0014 --policy run --task occupancy --period 01-10..01-12";
    let evaluated = json(path, &format!("{evaluate} --out evaluated"));
    let score = &evaluated["windows"][0]["all"]["scores"]["interquartile_mean"]["value"];
    assert_eq!(score.as_f64().unwrap(), number("score"), "the run's own score");
    let run = json(path, "run SingleFamilyHouse-0014 --controller run --period 01-10..01-12");
    assert_eq!(run["task"], "occupancy", "the task that it was trained for");
    assert_rejected(
        path,
        "run OfficeSmall-0042 --controller run --period 01-10..01-10",
        &["OfficeSmall-0042", "trained on SingleFamilyHouse-0014"],
    );
}

#[test]
fn a_task_from_a_file_is_part_of_the_run() {
    let folder = folder_with_config();
    let path = folder.path();
    std::fs::write(path.join("mine.json"), r#"{"comfort_band": 0.5, "energy_weight": 0.1}"#).unwrap();
    let summary = json(path, &format!("{} --task mine.json,random --steps 384", train("run")));
    let tasks: Vec<_> = summary["by_building"].as_array().unwrap().iter().map(|each| &each["task"]).collect();
    assert!(
        tasks[0].as_str().unwrap().starts_with("constant+energy0.1#") && tasks[1] == "random",
        "{tasks:?}"
    );
    std::fs::remove_file(path.join("mine.json")).unwrap();
    let summary = json(path, "train --resume run --steps 768");
    assert_eq!(summary["steps"], 768);
}

#[test]
fn flat_and_recurrent_networks_export_to_onnx_and_score_alike() {
    let folder = folder_with_config();
    let path = folder.path();
    let memory = "policy = { kind = \"recurrent\", width = 16, sequence = 48 }";
    std::fs::write(path.join("recurrent.toml"), format!("{SMALL}{memory}\n")).unwrap();
    let score = |policy: &str| {
        let evaluate = format!(
            "evaluate SingleFamilyHouse-0014 --policy {policy} --task occupancy --period 01-10..01-10"
        );
        let evaluated = json(path, &format!("{evaluate} --out of-{policy}"));
        evaluated["windows"][0]["all"]["scores"]["interquartile_mean"]["value"].as_f64().unwrap()
    };
    for name in ["small", "recurrent"] {
        let run = "train SingleFamilyHouse-0014 --steps 192 --direct --observation roles";
        assert!(b2b(path, &format!("{run} --config {name}.toml --out {name}")).status.success());
        let output = b2b(path, &format!("export {name} --out {name}.onnx"));
        assert!(output.status.success(), "{}", stderr(&output));
        let [agent, network] = [score(name), score(&format!("{name}.onnx"))];
        assert!((agent / network - 1.0).abs() < 1e-4, "{name}: {agent} {network}");
        let file = std::fs::read(path.join(format!("{name}.onnx"))).unwrap();
        let states_span_an_episode = file.ends_with(b"\n\x0fmemory_episodes\x12\x011");
        assert_eq!(states_span_an_episode, name == "recurrent");
    }
    assert!(b2b(path, &format!("{} --steps 192", train("corrected"))).status.success());
    assert_rejected(
        path,
        "export corrected --out other.onnx",
        &["cannot export the agent corrected", "its features depend on earlier steps", "raw or roles"],
    );
}

#[test]
fn a_graph_network_exports_to_onnx_for_a_building_and_scores_alike() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for edges in ["bias", "mixed", "memory"] {
        let config = match edges {
            "memory" => GRAPH.replace("layers = 1", "layers = 1, memory = 12"),
            _ => GRAPH.replace("bias", edges).replace("layers = 1", "layers = 2"),
        };
        std::fs::write(path.join("graph.toml"), config).unwrap();
        let run = format!("train --config graph.toml --steps 192 --direct --observation raw --out {edges}");
        let output = b2b(path, &run);
        assert!(output.status.success(), "{}", stderr(&output));
        for building in ["SingleFamilyHouse-0064", "OfficeSmall-0011"] {
            let file = format!("{edges}-{building}.onnx");
            let output = b2b(path, &format!("export {edges} --building {building} --out {file}"));
            assert!(output.status.success(), "{}", stderr(&output));
            let returns = [edges, &file].map(|policy| {
                let evaluate =
                    format!("evaluate {building} --policy {policy} --task occupancy --period 01-10..01-10");
                let evaluated = json(path, &format!("{evaluate} --out {building}-of-{policy}"));
                evaluated["windows"][0]["all"]["scores"]["interquartile_mean"]["value"].as_f64().unwrap()
            });
            assert!((returns[0] / returns[1] - 1.0).abs() < 1e-4, "{edges} in {building}: {returns:?}");
        }
    }
}

#[test]
fn agents_enter_a_benchmark_problem_one_for_each_seed() {
    let folder = folder_with_config();
    let path = folder.path();
    for seed in [0, 1] {
        let run = format!("{} --steps 192 --seed {seed}", train(&format!("runs/x-{seed}")));
        assert!(b2b(path, &run).status.success());
    }
    let problem = "dynamics-house --test SingleFamilyHouse-0018 SingleFamilyHouse-0387 \
                   --train SingleFamilyHouse-0001 --period 01-10..01-10 --seed 0 1";
    let output = b2b(path, &format!("benchmark run {problem} --policy runs/x-{{seed}} --out entered"));
    assert!(output.status.success(), "{}", stderr(&output));
    let result: Value =
        serde_json::from_slice(&std::fs::read(path.join("entered/result.json")).unwrap()).unwrap();
    let policy = &result["policies"]["test"];
    assert_eq!((&policy["kind"], &policy["pattern"]), (&"agents".into(), &"x-{seed}".into()));
    assert_eq!(policy["base"], "reactive controllers, authority 0.5");
    assert_eq!(policy["files"].as_object().unwrap().len(), 2, "an agent for each seed");
    let output = b2b(path, "benchmark verify entered");
    assert!(output.status.success(), "{}", stderr(&output));
    assert_rejected(path, &format!("benchmark run {problem} --policy runs/y-{{seed}} --out other"), &["y-0"]);
    let restricted = "benchmark run unitary-10-5 --policy runs/x-0 --out other";
    assert_rejected(path, restricted, &["x-0"]);
}

/// A problem that asks for other targets in the same house.
const PROBLEM: &str = r#"{
    "name": "house-random", "version": 1, "family": "goal_adaptation", "question": "Does it follow random targets?",
    "train": {"buildings": {"ids": ["SingleFamilyHouse-0001"]}, "tasks": ["constant", "occupancy+energy0.5"]},
    "test": {"buildings": {"ids": ["SingleFamilyHouse-0001"]}, "tasks": ["random"]},
    "protocol": {
        "training_steps": 4000, "training_period": "01-10..01-12", "windows": ["01-10..01-10"], "steps_per_hour": 12,
        "seeds": [0], "train_sample": 1, "adaptation": [], "attributes": "given"
    }
}"#;

#[test]
fn a_run_for_a_problem_trains_on_its_side_and_enters_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let own = |line: &&str| !line.starts_with("task") && !line.starts_with("period");
    let config: Vec<&str> = SMALL.lines().filter(own).collect();
    let text = config.join("\n") + "\nproblem = \"dynamics-house\"";
    std::fs::write(path.join("small.toml"), &text).unwrap();
    std::fs::write(path.join("knows.toml"), text + "\nobservation = { forecast = 3 }").unwrap();
    std::fs::write(path.join("mine.json"), PROBLEM).unwrap();
    // The argument takes precedence over the file's problem.
    let train = "train --problem mine.json --config small.toml --out run";
    let knowing = train.replace("small", "knows");
    assert_rejected(path, &knowing, &["forecast", "3 h", "house-random"]);
    let summary = json(path, &format!("{train} --steps 768"));
    let scores = summary["by_building"].as_array().unwrap();
    let tasks: Vec<_> = scores.iter().map(|each| each["task"].as_str().unwrap()).collect();
    assert_eq!(tasks, ["constant", "occupancy+energy0.5"]);
    let agent: Value = serde_json::from_slice(&std::fs::read(path.join("run/agent.json")).unwrap()).unwrap();
    assert_eq!(agent["training"]["problem"], "mine.json");
    for slot in ["building floor_area", "task energy weight"] {
        assert!(agent["slots"].as_array().unwrap().iter().any(|each| each == slot), "{slot}");
    }
    let output = b2b(path, "train --resume run --steps 1536");
    assert!(output.status.success(), "{}", stderr(&output));
    let output = b2b(path, "benchmark run mine.json --policy run --out entered");
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(path.join("entered/result.json").is_file());
    let withheld = "benchmark run mine.json --attributes withheld --policy run --out withheld";
    assert_rejected(path, withheld, &["the agent `run` observes attributes", "withheld"]);
    assert_rejected(path, &format!("{train} --steps 5000"), &["5000", "house-random", "at most 4000"]);
    let house = "SingleFamilyHouse-0001 --task random --period 01-10..01-10 --out other";
    for (command, words) in [
        ("run --controller run --parameters default", ["--parameters is for controllers", "agent"]),
        ("evaluate --policy run --actions physical", ["--actions is for ONNX policies", "remove it"]),
    ] {
        assert_rejected(path, &format!("{command} {house}"), &words);
    }
}

#[test]
fn a_run_that_was_killed_anywhere_and_resumed_ends_with_the_same_weights() {
    let folder = folder_with_config();
    let path = folder.path();
    assert!(b2b(path, &train("whole")).status.success());
    // The times at which it is killed differ from machine to machine, and need not be the same.
    for (run, updates) in [("first", 1), ("second", 4), ("third", 9)] {
        let mut process = started(&mut command(path, &train(run)), path, run, updates);
        process.kill().unwrap();
        process.wait().unwrap();
        assert_resumes_as(path, run, "whole");
        let stage = |run: &str| std::fs::read(path.join(run).join("stages/1/weights.safetensors")).unwrap();
        assert_eq!(stage(run), stage("whole"));
    }
}

/// A small run of one policy for two building types.
const GRAPH: &str = "\
preset = \"graph\"
buildings = [\"SingleFamilyHouse-0014\", \"OfficeSmall-0042\"]
task = \"occupancy\"
period = \"01-10..01-12\"
steps = 1152
environments = 2
window_days = 1
window_starts = 2
checkpoint_every = 384
evaluation = { every = 768, days = 1 }
policy = { kind = \"graph\", embedding = 16, heads = 2, layers = 1, feed_forward = 16, edges = \"bias\" }
ppo = { n_steps = 96, batch_size = 64, epochs = 2 }
";

#[test]
fn one_policy_for_two_types_is_an_agent_that_is_resumed_entered_and_verified() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("graph.toml"), GRAPH).unwrap();
    let summary = json(path, "train --config graph.toml --out run");
    assert_eq!((summary["steps"].as_u64(), summary["lost_episodes"].as_u64()), (Some(1152), Some(0)));
    assert_eq!(summary["buildings"], "SingleFamilyHouse-0014, OfficeSmall-0042");
    assert_eq!(summary["by_building"].as_array().map(Vec::len), Some(2));
    let info: Value = serde_json::from_slice(&std::fs::read(path.join("run/agent.json")).unwrap()).unwrap();
    let known = ["weather", "calendar", "energy", "unitary zone", "uncontrolled zone"];
    assert_eq!(info["node_types"], serde_json::json!(known));
    // The first agent, which makes no corrections, is evaluated before the first step.
    let [steps, score] = ["steps", "score"].map(|name| column(path, "run", name).swap_remove(0));
    assert_eq!((&steps[..], &score[..]), ("0", "1"));

    // Stopped at a checkpoint and continued.
    assert!(b2b(path, "train --config graph.toml --steps 768 --out parts").status.success());
    assert!(b2b(path, "train --resume parts --steps 1152").status.success());
    assert_eq!(weights(path, "parts")[1], weights(path, "run")[1]);

    // Buildings that it was not trained on, one of another type.
    let evaluate =
        "evaluate OfficeSmall-0011 --policy run --task occupancy --period 01-10..01-10 --out unseen";
    let score = json(path, evaluate)["windows"][0]["all"]["scores"]["interquartile_mean"]["value"].as_f64();
    assert!(score.unwrap() > 0.0);
    let output = b2b(path, "run OfficeMedium-0007 --controller run --period 01-10..01-10");
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("acts on 0 of the 36 actuators"), "{said}");
    let problem = "cross-domain --train-type SingleFamilyHouse --test-type OfficeSmall --test OfficeSmall-0011 \
                   --train SingleFamilyHouse-0001 --period 01-10..01-10 --seed 0";
    let output = b2b(path, &format!("benchmark run {problem} --policy run --out entered"));
    assert!(output.status.success(), "{}", stderr(&output));
    let output = b2b(path, "benchmark verify entered");
    assert!(output.status.success(), "{}", stderr(&output));
    assert_rejected(
        path,
        "export run --building OfficeSmall-0042 --out agent.onnx",
        &["cannot export the agent run", "its features depend on earlier steps"],
    );
}

#[test]
fn several_types_without_a_graph_network_are_an_error() {
    let folder = folder_with_config();
    let path = folder.path();
    let several = "train --type OfficeSmall SingleFamilyHouse";
    assert_rejected(path, several, &["several building types are for graph networks"]);
    std::fs::write(path.join("wrong.toml"), "[policy]\nheads = 5").unwrap();
    assert_rejected(
        path,
        &format!("{several} --preset graph --config wrong.toml"),
        &["`policy.heads` is 5; expected a divisor of the embedding, 64"],
    );
    assert_rejected(
        path,
        &format!("{several} --preset graph --algorithm sac"),
        &["`algorithm` with graph networks: it must be ppo"],
    );
}

#[test]
fn a_signal_to_all_processes_of_a_run_does_not_reach_its_episodes() {
    let folder = folder_with_config();
    let path = folder.path();
    assert!(b2b(path, &train("whole")).status.success());
    // Ctrl-C in a terminal, the end of a job, and a terminal that is closed.
    for (run, signal) in [("first", Signal::INT), ("second", Signal::TERM), ("third", Signal::HUP)] {
        let process = started(command(path, &train(run)).process_group(0), path, run, 4);
        kill_process_group(Pid::from_child(&process), signal).unwrap();
        let output = process.wait_with_output().unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(130), "{said}");
        assert!(said.contains(&format!("resume with `b2b train --resume {run}`")), "{said}");
        assert_resumes_as(path, run, "whole");
    }
}

#[test]
fn a_full_disk_is_reported_and_leaves_the_last_checkpoint_intact() {
    let folder = folder_with_config();
    let path = folder.path();
    assert!(b2b(path, &train("whole")).status.success());
    // The checkpoint has 400 kB, a row of the table 300 bytes.
    for (run, bytes, lost) in
        [("first", 200_000, "checkpoint.safetensors"), ("second", 1_500, "the progress of this update")]
    {
        let mut ignoring = Command::new("bash");
        let arguments = train(run);
        ignoring.args(["-c", &format!("trap '' XFSZ; exec {} {arguments}", env!("CARGO_BIN_EXE_b2b"))]);
        let process = started(ignoring.current_dir(path), path, run, 3);
        let limit = Rlimit { current: Some(bytes), maximum: Some(bytes) };
        prlimit(Some(Pid::from_child(&process)), Resource::Fsize, limit).unwrap();
        let output = process.wait_with_output().unwrap();
        let said = both_outputs(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        let warning = said.lines().find(|line| line.starts_with("warning: ") && line.contains(lost));
        let warning = warning.unwrap_or_else(|| panic!("no warning of {lost}: {said}"));
        assert!(warning.contains("could not be saved") && warning.contains("File too large"), "{said}");
        assert_eq!(said.matches(warning).count(), 1, "it is said once: {said}");
        assert!(said.lines().any(|line| line.starts_with("error: ")), "{said}");
        let table = std::fs::read_to_string(path.join(run).join("progress.csv")).unwrap();
        let cells: Vec<usize> = table.lines().map(|line| line.split(',').count()).collect();
        assert!(cells.iter().all(|count| *count == cells[0]), "no row is cut: {table}");
        let litter = |folder: &Path| {
            let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
            names.filter(|name| name.to_string_lossy().starts_with('.')).count()
        };
        assert_eq!([litter(&path.join(run)), litter(&path.join(run).join("last"))], [0, 0]);
        assert_resumes_as(path, run, "whole");
    }
}

/// Starts a run and returns its process after this many updates, or when it has ended.
fn started(command: &mut Command, folder: &Path, run: &str, updates: usize) -> Child {
    let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let table = folder.join(run).join("progress.csv");
    let rows = || std::fs::read_to_string(&table).unwrap_or_default().lines().count();
    wait_until(|| rows() > updates || process.try_wait().unwrap().is_some());
    process
}

/// Asserts that a run that was stopped continues to the agents and the course of another.
fn assert_resumes_as(folder: &Path, run: &str, whole: &str) {
    let output = b2b(folder, &format!("train --resume {run}"));
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(weights(folder, run), weights(folder, whole), "{run}");
    assert_eq!(course(folder, run), course(folder, whole), "{run}");
}

/// An agent whose random corrections move its actuators back and forth all day, and which hardly learns.
const HUNTING: &str = "\
preset = \"residual\"
buildings = [\"SingleFamilyHouse-0042\"]
task = \"occupancy\"
period = \"01-10..01-20\"
steps = 1152
seed = 1
environments = 2
window_days = 1
window_starts = 1
mirrored_noise = false
noise_cost = 0.0
travel_cost_growth = 3.0
evaluation = { every = 576, days = 1, whole_period = false }
ppo = { n_steps = 144, batch_size = 64, actor_gain = 4.0, learning_rate = 1e-5 }
";

#[test]
fn the_cost_of_travel_grows_while_actuators_hunt_also_after_resuming() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("hunting.toml"), HUNTING).unwrap();
    let costs = |run: &str| column(path, run, "travel_cost");
    json(path, "train --config hunting.toml --out whole");
    // 2 by default; the first agent and the one after 576 steps hunt.
    assert_eq!(costs("whole"), ["", "6", "6", "18", "18"]);
    json(path, "train --config hunting.toml --steps 576 --out parts");
    json(path, "train --resume parts --steps 1152");
    assert_eq!(costs("parts"), costs("whole"));
    assert_eq!(weights(path, "parts"), weights(path, "whole"));
}

#[test]
fn a_finished_run_continues_to_more_steps() {
    let folder = folder_with_config();
    let path = folder.path();
    assert!(b2b(path, &format!("{} --steps 768", train("run"))).status.success());
    let summary = json(path, "train --resume run --steps 1536");
    assert_eq!(summary["steps"].as_u64(), Some(1536));
    let config = std::fs::read_to_string(path.join("run/config.toml")).unwrap();
    assert!(config.contains("steps = 1536"), "{config}");
}

#[test]
fn an_invalid_request_is_an_error_that_names_the_fault() {
    let folder = folder_with_config();
    let path = folder.path();
    assert_rejected(path, "train", &["expected either `buildings` or `building_type`"]);
    assert_rejected(path, "train OfficeSmall-0042 --preset papper", &["unknown preset `papper`", "paper"]);
    assert_rejected(path, "train OfficeSmall-0042 --authority 2", &["`acting.authority` is 2"]);
    assert_rejected(path, "train --resume nowhere", &["nowhere has no run to resume"]);
    std::fs::write(path.join("wrong.toml"), "enviroments = 3").unwrap();
    assert_rejected(
        path,
        "train OfficeSmall-0042 --config wrong.toml",
        &["wrong.toml", "unknown field `enviroments`", "did you mean `environments`?"],
    );
    assert!(!path.join("b2b-out").exists(), "nothing is left behind");
    let acting = "acting = { kind = 'supervisory', every = 60, setpoints = false }";
    std::fs::write(path.join("nothing.toml"), format!("{acting}\ncomfort_rate = 0\nevaluation.every = 0"))
        .unwrap();
    assert_rejected(
        path,
        "train SingleFamilyHouse-0042 --control setpoints --task operate --config nothing.toml --out thermostats",
        &["nothing to set in SingleFamilyHouse-0042+setpoints", "`acting.setpoints` = true"],
    );
}

#[test]
fn a_folder_of_another_run_and_a_damaged_agent_are_errors() {
    let folder = folder_with_config();
    let path = folder.path();
    assert!(b2b(path, &format!("{} --steps 192", train("run"))).status.success());
    assert_rejected(
        path,
        &format!("{} --seed 1", train("run")),
        &["cannot resume run", "choose another folder"],
    );
    let evaluate = "evaluate SingleFamilyHouse-0014 --policy run --period 01-10..01-10 --out evaluated";
    let weights = path.join("run/weights.safetensors");
    let mut bytes = std::fs::read(&weights).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&weights, bytes).unwrap();
    assert_rejected(path, evaluate, &["run is damaged", "weights.safetensors"]);
    std::fs::write(path.join("run/agent.json"), "{}").unwrap();
    assert_rejected(path, evaluate, &["run is damaged", "agent.json"]);
    std::fs::write(path.join("run/checkpoint.safetensors"), "short").unwrap();
    assert_rejected(path, "train --resume run --steps 400", &["cannot resume", "checkpoint.safetensors"]);
}
