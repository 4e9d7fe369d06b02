//! `b2b experiment` from the outside, on the real engine.

use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::program::{assert_rejected, b2b, both_outputs, command, json, stderr};
use serde_json::Value;

/// Two specialists and the reactive controllers in two houses, over two days.
const SMALL: &str = "\
title = \"Small\"
question = \"Does it run?\"
paper = \"not in it\"
report = \"adaptation\"
types = [\"SingleFamilyHouse\"]
tasks = [\"occupancy\"]
periods = [\"01-10..01-11\"]
reactive = true
quick = { steps = 1152, seeds = 1, buildings = 2 }
full = { steps = 2304, seeds = 2, buildings = 2 }

[[agents]]
name = \"specialist\"
trains = \"building\"
options = { preset = \"residual\", environments = 2, window_days = 1, window_starts = 1, checkpoint_every = 192, \
ppo = { n_steps = 96, batch_size = 64, epochs = 2 } }
";

fn folder_with(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("small.toml"), text).unwrap();
    folder
}

fn results(folder: &Path, out: &str) -> String {
    std::fs::read_to_string(folder.join(out).join("results.json")).unwrap()
}

#[test]
fn shards_and_an_interrupted_run_give_the_results_of_one_run() {
    let folder = folder_with(SMALL);
    let path = folder.path();
    let summary = json(path, "experiment run small.toml --out whole");
    assert_eq!((summary["done"].as_u64(), summary["failed"].as_u64()), (Some(3), Some(0)), "{summary}");
    let whole: Value = serde_json::from_str(&results(path, "whole")).unwrap();
    let episodes = whole["episodes"].as_array().unwrap();
    assert_eq!(episodes.len(), 4, "two episodes of the reactive controllers and one of each specialist");
    assert!(episodes.iter().all(|episode| episode["score"].as_f64().is_some_and(|score| score > 0.0)));
    assert_eq!(episodes[0]["score"].as_f64(), Some(1.0), "the reactive controllers score 1");
    assert!(path.join("whole/report.html").is_file());

    for shard in ["2/3", "0/3", "1/3"] {
        let output = b2b(path, &format!("experiment run small.toml --out parts --shard {shard}"));
        assert!(output.status.success(), "{}", stderr(&output));
    }
    assert_eq!(results(path, "parts"), results(path, "whole"));

    // The results are still known without the jobs' folders.
    let agents = path.join("whole/jobs/specialist");
    std::fs::rename(path.join("whole/jobs/reactive"), path.join("reactive")).unwrap();
    let output = b2b(path, "experiment run small.toml --out whole");
    assert!(both_outputs(&output).contains("0 of 3 jobs left"), "{}", both_outputs(&output));
    assert_eq!(results(path, "whole"), results(path, "parts"));

    // Another experiment with the same jobs takes them over.
    std::fs::write(path.join("other.toml"), SMALL.replace("adaptation", "scores").replace("1152", "2304"))
        .unwrap();
    let said = both_outputs(&b2b(path, "experiment run other.toml --out other --reuse whole --dry-run"));
    assert!(said.contains("jobs to take over from whole: 1") && said.contains("2 of 3 jobs left"), "{said}");
    std::fs::write(path.join("other.toml"), SMALL.replace("adaptation", "scores")).unwrap();
    let output = b2b(path, "experiment run other.toml --out other --reuse whole");
    assert!(both_outputs(&output).contains("0 of 3 jobs left"), "{}", both_outputs(&output));
    assert_eq!(results(path, "other"), results(path, "whole"));
    assert_rejected(path, "experiment run other.toml --out x --reuse nowhere", &["nowhere has no results"]);

    // Agents reproduce their results, unless they or the results were changed.
    let checked = json(path, "experiment check whole");
    assert_eq!((checked["checked"].as_u64(), checked["agree"].as_u64()), (Some(2), Some(2)), "{checked}");
    let jobs: Vec<_> = std::fs::read_dir(&agents).unwrap().map(|job| job.unwrap().path()).collect();
    let weights = ["agent/weights.safetensors", "agent/agent.json"];
    for file in weights {
        std::fs::copy(jobs[0].join(file), jobs[1].join(file)).unwrap();
    }
    let output = b2b(path, "experiment check whole");
    assert_eq!(output.status.code(), Some(1));
    assert!(both_outputs(&output).contains("is not the agent of the results"));
    assert!(both_outputs(&output).contains("1 of 2 agents agree"), "{}", both_outputs(&output));
    std::fs::remove_dir_all(path.join("whole/jobs")).unwrap();
    assert_rejected(path, "experiment check whole", &["whole has no agents to check"]);

    // Killed in the middle of the first training: its command stops by itself, and a second run continues.
    let mut process = command(path, "experiment run small.toml --out killed --jobs 1");
    let mut process = process.stderr(Stdio::null()).stdout(Stdio::null()).spawn().unwrap();
    let progress = || {
        let jobs = std::fs::read_dir(path.join("killed/jobs/specialist")).ok()?;
        jobs.flatten().find_map(|job| std::fs::read_to_string(job.path().join("agent/progress.csv")).ok())
    };
    let deadline = Instant::now() + Duration::from_secs(300);
    while progress().is_none_or(|text| text.lines().count() < 3) && process.try_wait().unwrap().is_none() {
        assert!(Instant::now() < deadline, "no update");
        std::thread::sleep(Duration::from_millis(5));
    }
    process.kill().unwrap();
    process.wait().unwrap();
    let output = b2b(path, "experiment run small.toml --out killed");
    assert!(output.status.success(), "{}", both_outputs(&output));
    assert_eq!(results(path, "killed"), results(path, "whole"));
}

#[test]
fn a_failed_job_is_shown_with_its_log_and_does_not_stop_the_others() {
    let broken = "\n[[agents]]\nname = \"broken\"\ntrains = \"building\"\noptions = { environments = 0 }\n";
    let folder = folder_with(&(SMALL.to_owned() + broken));
    let path = folder.path();
    let output = b2b(path, "experiment run small.toml --out out");
    assert_eq!(output.status.code(), Some(1));
    let said = both_outputs(&output);
    for word in ["3 jobs done, 2 failed", "broken/SingleFamilyHouse", "`environments` is 0", "log.txt"] {
        assert!(said.contains(word), "`{word}` is not in: {said}");
    }
    let page = std::fs::read_to_string(path.join("out/report.html")).unwrap();
    assert!(page.contains("broken/SingleFamilyHouse"));
    // A report needs no run.
    let summary = json(path, "experiment report out");
    assert_eq!((summary["done"].as_u64(), summary["failed"].as_u64()), (Some(3), Some(2)));
}

#[test]
fn an_invalid_request_is_an_error_that_names_the_fault() {
    let folder = folder_with(SMALL);
    let path = folder.path();
    assert_rejected(
        path,
        "experiment run dynamic",
        &["unknown experiment `dynamic`", "did you mean `dynamics`"],
    );
    assert_rejected(path, "experiment report nowhere", &["nowhere has no results"]);
    let output = b2b(path, "experiment run small.toml --out out --dry-run");
    assert!(stderr(&output).is_empty() && both_outputs(&output).contains("3 of 3 jobs left"));
    let dry = json(path, "experiment run small.toml --out out --dry-run");
    assert_eq!((dry["jobs"].as_u64(), dry["left"].as_array().map(Vec::len)), (Some(3), Some(3)));
    assert!(!path.join("out").exists(), "a dry run writes nothing");
    std::fs::create_dir(path.join("out")).unwrap();
    let identity = serde_json::json!({"experiment": path.join("small.toml"), "budget": "quick"});
    std::fs::write(path.join("out/experiment.json"), identity.to_string()).unwrap();
    assert_rejected(
        path,
        "experiment run small.toml --budget full --out out",
        &["budget quick", "another folder"],
    );
    for shard in ["3/3", "x"] {
        assert!(!b2b(path, &format!("experiment run small.toml --shard {shard}")).status.success());
    }
}

#[test]
fn one_agent_for_all_tasks_is_scored_on_each_beside_the_reactive_controllers() {
    let weights = SMALL
        .replace("\"adaptation\"", "\"weights\"")
        .replace("[\"occupancy\"]", "[\"occupancy\", \"occupancy+energy5\"]")
        .replace("trains = \"building\"", "trains = \"building\"\nall_tasks = true")
        .replace(
            "preset = \"residual\",",
            "preset = \"residual\", observation = { form = \"features\", attributes = true },",
        );
    let folder = folder_with(&weights);
    let path = folder.path();
    let summary = json(path, "experiment run small.toml --out out");
    assert_eq!((summary["done"].as_u64(), summary["failed"].as_u64()), (Some(3), Some(0)), "{summary}");
    let results: Value = serde_json::from_str(&results(path, "out")).unwrap();
    let of_agent = |episode: &&Value| episode["agent"] == "specialist";
    let episodes: Vec<&Value> = results["episodes"].as_array().unwrap().iter().filter(of_agent).collect();
    assert_eq!(episodes.len(), 4, "two houses, two weights");
    let log = path.join("out/jobs/specialist");
    let jobs: Vec<_> = std::fs::read_dir(log).unwrap().map(|job| job.unwrap().file_name()).collect();
    assert!(jobs.iter().all(|name| name.to_string_lossy().contains("_all-tasks_")), "{jobs:?}");
    let page = std::fs::read_to_string(path.join("out/report.html")).unwrap();
    assert!(page.contains("\"reactive\"") && page.contains("HVAC energy (kWh/m²)"));
}

#[test]
fn an_agent_is_entered_on_a_benchmark_problem() {
    let folder = folder_with(
        "title = \"Board\"\nquestion = \"Which?\"\npaper = \"not in it\"\nreport = \"board\"\n\
         problems = [\"goal-energy-weight\"]\n\
         quick = { steps = 1152, seeds = 1, buildings = 1 }\nfull = { steps = 1152, seeds = 3, buildings = 1 }\n\
         [[agents]]\nname = \"residual\"\ntrains = \"problem\"\nproblems = [\"goal-energy-weight\"]\n\
         options = { preset = \"residual\", environments = 2, window_days = 1, window_starts = 1, \
         ppo = { n_steps = 96, batch_size = 64, epochs = 2 } }\n",
    );
    let path = folder.path();
    let summary = json(path, "experiment run small.toml --out out");
    assert_eq!((summary["done"].as_u64(), summary["failed"].as_u64()), (Some(1), Some(0)), "{summary}");
    let results: Value = serde_json::from_str(&results(path, "out")).unwrap();
    let tasks: Vec<&Value> =
        results["episodes"].as_array().unwrap().iter().map(|episode| &episode["task"]).collect();
    assert_eq!(tasks, ["constant+energy0.5", "occupancy+energy0.5", "random+energy0.5"]);
    let result = std::fs::read_to_string(path.join("out/jobs/residual/goal-energy-weight/entry/result.json"));
    let result: Value = serde_json::from_str(&result.unwrap()).unwrap();
    assert_eq!((&result["name"], result["training_steps"].as_u64()), (&"residual".into(), Some(1152)));
    let page = std::fs::read_to_string(path.join("out/report.html")).unwrap();
    assert!(page.contains("goal-energy-weight"));
    let jobs = std::fs::read_to_string(path.join("out/jobs.json")).unwrap();
    let hash = results["episodes"][0]["trajectory_hash"].as_str().unwrap();
    std::fs::write(path.join("out/jobs.json"), jobs.replace(hash, "0")).unwrap();
    let output = b2b(path, "experiment check out");
    let said = both_outputs(&output);
    assert!(!output.status.success() && said.contains("residual/goal-energy-weight"), "{said}");
}

/// Agents that keep their best, in an experiment that evaluates nothing else.
fn with_best_kept() -> String {
    SMALL.replace("epochs = 2 } }", "epochs = 2 }, keep = \"best\" }")
}

/// The same agents in a budget that evaluates the last one, too.
fn with_both() -> String {
    let budget =
        "[budgets.part]\nsteps = 1152\nseeds = 1\nbuildings = { SingleFamilyHouse = 2 }\nwith_best = true\n";
    SMALL.replace("\n[[agents]]", &format!("\n{budget}\n[[agents]]"))
}

#[test]
fn a_budget_with_two_policies_of_a_training_takes_over_trainings_that_were_evaluated_once() {
    let folder = folder_with(&with_best_kept());
    let path = folder.path();
    std::fs::write(path.join("both.toml"), with_both()).unwrap();
    assert_rejected(
        path,
        "experiment run both.toml --budget prat",
        &["no budget `prat`", "did you mean `part`?"],
    );
    let summary = json(path, "experiment run small.toml --out once");
    assert_eq!(summary["done"].as_u64(), Some(3), "{summary}");
    std::fs::create_dir(path.join("both")).unwrap();
    std::fs::rename(path.join("once/jobs"), path.join("both/jobs")).unwrap();
    let mut jobs: Vec<_> = std::fs::read_dir(path.join("both/jobs/specialist"))
        .unwrap()
        .map(|job| job.unwrap().path())
        .collect();
    jobs.sort();
    // One training has ended, and its evaluation has not.
    std::fs::remove_file(jobs[0].join("job.json")).unwrap();
    std::fs::remove_dir_all(jobs[0].join("evaluation")).unwrap();
    let dry = json(path, "experiment run both.toml --budget part --out both --dry-run");
    assert_eq!(dry["left"].as_array().map(Vec::len), Some(2), "{dry}");
    let summary = json(path, "experiment run both.toml --budget part --out both");
    assert_eq!((summary["done"].as_u64(), summary["failed"].as_u64()), (Some(3), Some(0)), "{summary}");
    for job in &jobs {
        let log = std::fs::read_to_string(job.join("log.txt")).unwrap();
        assert_eq!(log.matches("$ b2b train").count(), 1, "{log}");
        assert_eq!(log.matches("$ b2b evaluate --policy agent/last").count(), 1, "{log}");
    }
    let all: Value = serde_json::from_str(&results(path, "both")).unwrap();
    let agents: Vec<&str> = all["episodes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|episode| episode["agent"].as_str().unwrap())
        .collect();
    let count = |name: &str| agents.iter().filter(|agent| **agent == name).count();
    assert_eq!((count("specialist"), count("specialist, best"), count("reactive")), (2, 2, 2));
    let checked = json(path, "experiment check both");
    assert_eq!((checked["checked"].as_u64(), checked["agree"].as_u64()), (Some(4), Some(4)), "{checked}");
    let page = std::fs::read_to_string(path.join("both/report.html")).unwrap();
    assert!(page.contains("specialist, best") && page.contains("HVAC energy (kWh/m²)"));
    let rates = both_outputs(&b2b(path, "experiment rates both"));
    assert!(rates.contains("SingleFamilyHouse,residual,") && rates.contains(",2,training"), "{rates}");

    // A training that has ended with other options is not taken over.
    std::fs::remove_file(jobs[0].join("job.json")).unwrap();
    std::fs::remove_file(path.join("both/jobs.json")).unwrap();
    let config = std::fs::read_to_string(jobs[0].join("config.toml")).unwrap();
    std::fs::write(jobs[0].join("config.toml"), config.replace("occupancy", "constant")).unwrap();
    let output = b2b(path, "experiment run both.toml --budget part --out both");
    assert_eq!(output.status.code(), Some(1));
    assert!(both_outputs(&output).contains("has ended with other options"), "{}", both_outputs(&output));
}
