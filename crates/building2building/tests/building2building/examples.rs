//! The examples run, and print the promised output.

use std::path::PathBuf;
use std::process::Command;

/// Runs an example, which cargo builds along with the tests, and returns its output.
fn output_of(example: &str, arguments: &[&str]) -> String {
    let test = std::env::current_exe().expect("this test is a file");
    let release = test.parent().and_then(|deps| deps.parent()).expect("tests are in target/release/deps");
    let program: PathBuf = release.join("examples").join(example);
    let output = Command::new(&program).args(arguments).output();
    let output = output.unwrap_or_else(|error| panic!("{}: {error}", program.display()));
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{example}: {stdout}{stderr}");
    stdout.into_owned()
}

#[test]
fn one_episode_runs_to_its_end() {
    let output = output_of("one_episode", &["SingleFamilyHouse", "01-01..01-01"]);
    assert!(output.contains("288 steps, return -"), "{output}");
}

#[test]
fn a_batch_gives_every_environment_the_same_episode() {
    let output = output_of("vector_batch", &["2", "01-01..01-01"]);
    let ends: Vec<_> = output.lines().filter_map(|line| line.split_once(": ")).collect();
    assert!(
        matches!(ends[..], [("environment 0", one), ("environment 1", other)] if one == other),
        "{output}"
    );
}

#[test]
fn the_return_sums_a_custom_reward() {
    assert!(output_of("own_reward", &[]).starts_with("return -"));
}

#[test]
fn a_custom_controller_is_compared_with_the_built_in_ones() {
    let output = output_of("own_controller", &[]);
    assert_eq!(output.lines().count(), 3, "{output}");
}

#[test]
fn a_restored_episode_continues_bit_for_bit() {
    let output = output_of("snapshots", &[]);
    assert!(output.contains("the same bits"), "{output}");
}

#[test]
fn a_trained_agents_score_is_its_return_divided_by_the_reactive_controllers() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let arguments = [run.to_str().unwrap(), "SingleFamilyHouse-0014", "01-10..01-12", "2304"];
    let output = output_of("train", &arguments);
    let after = |words: &str| {
        let (_, rest) = output.split_once(words).unwrap_or_else(|| panic!("no `{words}`: {output}"));
        rest.split([',', '\n']).next().unwrap().parse::<f64>().unwrap()
    };
    let [score, reactive, agent] = ["score ", "reactive: return ", "agent: return "].map(after);
    assert!((score - agent / reactive).abs() < 1e-3, "{output}");
    assert!(run.join("agent.json").is_file());
}
