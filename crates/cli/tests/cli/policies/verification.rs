//! `b2b benchmark verify` on results that were changed, on the real engine: two houses, one day.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use crate::policies::onnx_file::linear_policy;
use crate::program::{assert_rejected, b2b, both_outputs, command};
use b2b_base::digest::sha256;
use b2b_benchmark::entry::{Check, Measures, Sample, check, read_result, verify};
use b2b_benchmark::problem::Stage;
use b2b_control::Versions;
use b2b_dataset::Catalog;
use b2b_energyplus::install::Quiet;
use b2b_evaluate::{EpisodeResult, Evaluation, Scored, write_stages};
use b2b_workers::Launcher;
use serde_json::{Value, json};
use tempfile::TempDir;

/// Two test houses and two to train on, of one to three zones, for one day.
const SMALL: &str = "dynamics-house --test SingleFamilyHouse-0018 SingleFamilyHouse-0387 \
                     --train SingleFamilyHouse-0001 SingleFamilyHouse-0002 --period 01-10..01-10 --seed 0 1";

fn bytes(folder: &Path, file: &str) -> Vec<u8> {
    std::fs::read(folder.join(file)).unwrap()
}

/// A result of random actions, to be verified.
struct Judged {
    folder: TempDir,
    catalog: Catalog,
}

impl Judged {
    fn new(problem: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let output = b2b(folder.path(), &format!("benchmark run {problem} --policy random --out result"));
        assert!(output.status.success(), "{}", both_outputs(&output));
        Self { folder, catalog: Catalog::open(&mut Quiet).unwrap() }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("result")
    }

    /// Returns the failed checks of a copy with changed rows and a matching file hash, after rerunning a sample.
    fn after(&self, change: impl Fn(&mut Vec<(Stage, Vec<EpisodeResult>)>), rerun: usize) -> String {
        let copy = self.folder.path().join("copy");
        std::fs::create_dir_all(&copy).unwrap();
        let (_, mut stages) = read_result(&self.path()).unwrap();
        change(&mut stages);
        let named: Vec<_> = stages.into_iter().map(|(stage, rows)| (stage.to_string(), rows)).collect();
        let mut table = Vec::new();
        write_stages(&mut table, &named, &Versions::current()).unwrap();
        let mut result: Value = serde_json::from_slice(&bytes(&self.path(), "result.json")).unwrap();
        result["episodes_sha256"] = sha256(&table).into();
        std::fs::write(copy.join("episodes.parquet"), &table).unwrap();
        std::fs::write(copy.join("result.json"), result.to_string()).unwrap();
        self.wrong(&copy, rerun)
    }

    /// Makes the measures of the changed copy fit its rows.
    fn refit(&self) -> PathBuf {
        let copy = self.folder.path().join("copy");
        let (_, stages) = read_result(&copy).unwrap();
        let mut result: Value = serde_json::from_slice(&bytes(&copy, "result.json")).unwrap();
        result["measures"] = serde_json::to_value(Measures::of(&stages, &[]).unwrap()).unwrap();
        std::fs::write(copy.join("result.json"), result.to_string()).unwrap();
        copy
    }

    /// Returns the failed checks of a copy with a changed description, after rerunning a sample.
    fn described(&self, change: impl Fn(&mut Value), rerun: usize) -> String {
        let copy = self.folder.path().join("described");
        std::fs::create_dir_all(&copy).unwrap();
        let mut result: Value = serde_json::from_slice(&bytes(&self.path(), "result.json")).unwrap();
        change(&mut result);
        std::fs::copy(self.path().join("episodes.parquet"), copy.join("episodes.parquet")).unwrap();
        std::fs::write(copy.join("result.json"), result.to_string()).unwrap();
        self.wrong(&copy, rerun)
    }

    fn wrong(&self, folder: &Path, episodes: usize) -> String {
        let launcher = Launcher::new(env!("CARGO_BIN_EXE_b2b"));
        let evaluation = Evaluation { catalog: &self.catalog, launcher, jobs: 2, interrupted: || false };
        let checks = match NonZeroUsize::new(episodes) {
            None => check(folder).unwrap(),
            episodes => verify(folder, &evaluation, Sample { episodes, seed: 0 }, &()).unwrap(),
        };
        let wrong = |check: &Check| match &check.outcome {
            Ok(text) if check.unverified => Some(format!("unverified {}: {text}", check.name)),
            outcome => Some(format!("{}: {}", check.name, outcome.as_ref().err()?)),
        };
        checks.iter().filter_map(wrong).collect::<Vec<_>>().join("\n")
    }
}

/// One test, because a test is a process and would make the result again.
#[test]
fn a_result_is_checked_by_what_it_says_of_itself_and_by_a_sample() {
    let judged = Judged::new(SMALL);
    what_a_result_says_of_itself_is_checked_and_a_policy_that_cannot_run_again_is_unverified(&judged);
    a_sample_is_redrawn_unless_its_seed_is_given_and_is_never_empty(&judged);
}

fn what_a_result_says_of_itself_is_checked_and_a_policy_that_cannot_run_again_is_unverified(judged: &Judged) {
    assert_eq!(judged.described(|_| {}, 0), "");
    let said = judged.described(|result| result["seeds"]["test"] = json!([0, 7]), 0);
    assert!(said.contains("episodes: the stated seeds are"), "{said}");
    let said = judged.described(|result| result["episodes"]["test"] = json!(3), 0);
    assert!(said.contains("episodes: the numbers of episodes are stated as"), "{said}");
    let said = judged.described(|result| result["problem"]["question"] = json!("Is it best?"), 0);
    assert!(said.contains("problem: its question is not dynamics-house's: Is it best?"), "{said}");

    // A program whose episodes nobody can run again.
    let relabel = |result: &mut Value| {
        for stage in ["test", "train"] {
            result["policies"][stage] =
                json!({"kind": "external", "name": "random", "identity": "mine", "by_seed": true});
        }
    };
    let said = judged.described(relabel, 1);
    assert!(said.starts_with("unverified episodes run again: not run again: the policy `random`"), "{said}");
    let verify = "benchmark verify described --episodes 1";
    let output = b2b(judged.folder.path(), verify);
    let said = both_outputs(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("UNVERIFIED  episodes run again"), "{said}");
    let page = judged.folder.path().join("leaderboard.html");
    let report = b2b(judged.folder.path(), "benchmark report described");
    assert!(report.status.success(), "{}", both_outputs(&report));
    assert!(std::fs::read_to_string(page).unwrap().contains("(own program, unverified)"));

    // A page shows only measures that the episodes give.
    let forge = |result: &mut Value| {
        *result.pointer_mut("/measures/test/resolved/interquartile_mean/value").unwrap() = json!(0.1);
    };
    let said = judged.described(forge, 0);
    assert!(said.contains("measures: they differ"), "{said}");
    assert_rejected(judged.folder.path(), "benchmark report described", &["`measures` in result.json"]);
}

fn scored(row: &mut EpisodeResult) -> &mut Scored {
    row.outcome.as_mut().unwrap()
}

#[test]
fn a_tampered_result_fails_verification() {
    let judged = Judged::new(SMALL);
    assert_eq!(judged.wrong(&judged.path(), 2), "");
    assert_eq!(judged.after(|_| {}, 0), "");

    let said = judged.after(|stages| scored(&mut stages[0].1[1]).metrics.episode_return *= 0.5, 0);
    assert!(
        said.contains("scores: test: SingleFamilyHouse-0018, constant, 01-10..01-10, seed 1: the return"),
        "{said}"
    );
    let said = judged.after(|stages| stages[0].1[1].info.seed = 7, 0);
    assert!(said.contains("seed 1, found") && said.contains("seed 7"), "{said}");
    let missing = |stages: &mut Vec<(Stage, Vec<EpisodeResult>)>| drop(stages[0].1.pop());
    let said = judged.after(missing, 0);
    assert!(said.contains("SingleFamilyHouse-0387, constant, 01-10..01-10, seed 1 is missing"), "{said}");
    let said = judged.after(|stages| drop(stages.pop()), 0);
    assert!(said.contains("stage train is missing"), "{said}");

    // A baseline that was lowered together with the score that follows from it.
    let lower = |stages: &mut Vec<(Stage, Vec<EpisodeResult>)>| {
        let scored = scored(&mut stages[0].1[1]);
        let (episode_return, steps) = (scored.metrics.episode_return, scored.metrics.steps);
        let baseline = scored.baseline_return.unwrap() * 2.0;
        scored.baseline_return = Some(baseline);
        scored.score = b2b_evaluate::normalized_score(episode_return, baseline);
        scored.resolved_score = b2b_evaluate::resolved_score(episode_return, baseline, steps);
    };
    let said = judged.after(lower, 0);
    assert!(said.contains("baselines: test: SingleFamilyHouse-0018"), "{said}");
    let said = judged.after(|stages| scored(&mut stages[0].1[1]).step_rewards.counts[0] += 1, 0);
    assert!(said.contains("step rewards; the episode has"), "{said}");
    let said = judged.after(|stages| scored(&mut stages[0].1[1]).trajectory_hash = "é".repeat(32), 0);
    assert!(said.contains("is not a trajectory hash"), "{said}");
    let said = judged.after(|stages| stages[0].1[1].info.place = "Miami".into(), 0);
    assert!(said.contains("episodes: test: expected"), "{said}");

    // A return that adds up, with score and measures made to fit, is found out by running it again.
    let halve = |stages: &mut Vec<(Stage, Vec<EpisodeResult>)>| {
        for row in stages.iter_mut().flat_map(|(_, rows)| rows) {
            let scored = scored(row);
            scored.metrics.episode_return /= 2.0;
            scored.metrics.temperature_penalty /= 2.0;
            let (episode_return, steps) = (scored.metrics.episode_return, scored.metrics.steps);
            scored.score = scored.baseline_return.map(|baseline| episode_return / baseline);
            scored.resolved_score = scored
                .baseline_return
                .and_then(|baseline| b2b_evaluate::resolved_score(episode_return, baseline, steps));
        }
    };
    let said = judged.after(halve, 0);
    assert_eq!(said, "measures: they differ from what the episodes give");
    let copy = judged.refit();
    let edit = |name: &str, value: Value| {
        let mut result: Value = serde_json::from_slice(&bytes(&copy, "result.json")).unwrap();
        *result.pointer_mut(name).unwrap() = value;
        std::fs::write(copy.join("result.json"), result.to_string()).unwrap();
    };
    assert_eq!(judged.wrong(&copy, 0), "");
    let said = judged.wrong(&copy, 1);
    assert!(said.contains("episodes run again") && said.contains("its metrics differ"), "{said}");

    // Policies are read and hashed without any sample.
    let honest = json!({"kind": "built_in", "name": "random"});
    let network = linear_policy(3, 2, 0.0);
    let [hash, other] = [sha256(&network), sha256(b"another")];
    std::fs::create_dir_all(copy.join("policy")).unwrap();
    std::fs::write(copy.join(format!("policy/{}.onnx", &other[..16])), &network).unwrap();
    let missing = "is missing";
    for (name, hash, words) in [
        ("p.onnx", "é".repeat(32), "is not a SHA-256"),
        ("p.onnx", "../".repeat(20), "is not a SHA-256"),
        ("p.onnx", other, "is not the file that was run"),
        ("p.onnx", hash.clone(), &hash[..16]),
    ] {
        let onnx = json!({"kind": "onnx", "pattern": "p.onnx", "actions": "rescaled", "files": {name: hash}});
        edit("/policies/test", onnx);
        let said = judged.wrong(&copy, 0);
        assert!(said.contains("policies: ") && said.contains(words), "{said}");
    }
    edit("/policies/test", json!({"kind": "onnx", "pattern": "p.onnx", "actions": "rescaled", "files": {}}));
    let said = judged.wrong(&copy, 0);
    assert!(said.contains(missing), "{said}");
    edit("/policies/test", honest);
    let untrained = |name: &str| {
        let mut result: Value = serde_json::from_slice(&bytes(&copy, "result.json")).unwrap();
        result["policies"]["untrained"] = json!({"kind": "built_in", "name": name});
        std::fs::write(copy.join("result.json"), result.to_string()).unwrap();
        judged.wrong(&copy, 0)
    };
    assert!(untrained("constant").contains("untrained: the policy does not act at random"));
    // Its seeds are not stated.
    let said = untrained("random");
    assert!(said.contains("the stated seeds are") && !said.contains("at random"), "{said}");

    edit("/versions/generator", json!("v0"));
    assert!(judged.wrong(&copy, 0).contains("dataset v0 (v1 in this program)"));
    edit("/versions/generator", json!("v1"));
    edit("/problem/protocol/training_steps", json!(1));
    assert!(judged.wrong(&copy, 0).contains("does not match its hash"));
    // The table alone.
    std::fs::write(copy.join("episodes.parquet"), bytes(&judged.path(), "episodes.parquet")).unwrap();
    assert!(judged.wrong(&copy, 0).contains("episodes.parquet is not the table"));
}

#[test]
fn forged_amounts_behind_a_score_at_comfort_fail_verification() {
    let judged = Judged::new(&format!("{SMALL} --test-task operate+preview --train-task operate+preview"));
    assert_eq!(judged.wrong(&judged.path(), 1), "");
    let forged = |change: fn(&mut Scored)| {
        let change = |stages: &mut Vec<(Stage, Vec<EpisodeResult>)>| {
            for row in stages.iter_mut().flat_map(|(_, rows)| rows) {
                let scored = scored(row);
                change(scored);
                let scores = scored.baseline().unwrap().scores(&scored.metrics, scored.resource, 12);
                (scored.score, scored.resolved_score) = (scores.score, scores.resolved);
            }
        };
        judged.after(change, 0);
        judged.wrong(&judged.refit(), 1)
    };
    let said = forged(|scored| scored.resource = scored.resource.map(|used| used / 2.0));
    assert!(said.contains("seed 0: its resource is") && said.contains("; expected"), "{said}");
    let said = forged(|scored| scored.baseline_resource = scored.baseline_resource.map(|used| used * 2.0));
    assert!(said.contains("seed 0: the resource of its baseline is"), "{said}");
    let said = forged(|scored| scored.baseline_discomfort = scored.baseline_discomfort.map(|d| d + 50.0));
    assert!(said.contains("seed 0: the discomfort of its baseline is"), "{said}");
    let said = forged(|scored| scored.metrics.tdis_tot = scored.metrics.tdis_tot.map(|tdis| tdis / 2.0));
    assert!(said.contains("its metrics differ: thermal discomfort is"), "{said}");
}

#[test]
fn a_result_of_a_machine_that_rounds_differently_agrees_within_the_tolerance() {
    let folder = tempfile::tempdir().unwrap();
    // glibc chooses other functions, as on a CPU without these instructions.
    let tunables = "glibc.cpu.hwcaps=-FMA,-FMA_Usable,-AVX2,-AVX2_Usable";
    let mut command = command(folder.path(), &format!("benchmark run {SMALL} --policy random --out result"));
    let output = command.env("GLIBC_TUNABLES", tunables).output().unwrap();
    assert!(output.status.success(), "{}", both_outputs(&output));
    let result: Value = serde_json::from_slice(&bytes(folder.path(), "result/result.json")).unwrap();
    let same = result["machine"] == b2b_base::machine::fingerprint();
    let output = b2b(folder.path(), "benchmark verify result");
    assert!(output.status.success(), "{}", both_outputs(&output));
    let words = if same { "agree bit for bit" } else { "agree within a relative 1e-6" };
    assert!(both_outputs(&output).contains(words), "{}", both_outputs(&output));
}

fn a_sample_is_redrawn_unless_its_seed_is_given_and_is_never_empty(judged: &Judged) {
    let seed = |arguments: &str| {
        let output =
            b2b(judged.folder.path(), &format!("benchmark verify result --episodes 1 --json {arguments}"));
        assert!(output.status.success(), "{}", both_outputs(&output));
        let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(
            printed.to_string().contains("if 1 of the 8 were forged, 12.5 % of such samples"),
            "{printed}"
        );
        printed["sample_seed"].as_u64().unwrap()
    };
    assert_ne!(seed(""), seed(""));
    assert_eq!(seed("--sample-seed 7"), 7);
    let none = b2b(judged.folder.path(), "benchmark verify result --episodes 0");
    assert_eq!(none.status.code(), Some(2));
    assert!(both_outputs(&none).contains("at least 1"), "{}", both_outputs(&none));
}
