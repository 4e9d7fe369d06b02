//! Policies that keep their memory over the episodes in a building, on the real engine: two houses, days.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use crate::policies::onnx_file::{linear_policy, summing_policy};
use b2b_agent::protobuf::{self, bytes};
use b2b_benchmark::Problem;
use b2b_benchmark::entry::{Entry, EntryPolicy, RunOutcome, Sample, verify};
use b2b_benchmark::problem::{Stage, WrappedPolicy};
use b2b_control::Controller;
use b2b_dataset::Catalog;
use b2b_energyplus::install::Quiet;
use b2b_env::{ActionSpace, unscale};
use b2b_evaluate::{
    ActionScale, Baselines, BuiltIn, EpisodeContext, EpisodePlan, Evaluation, Finished, OnnxPolicy, Policy,
    Progress,
};
use b2b_workers::Launcher;
use serde_json::json;

/// Width of the observations of `adapt-house` without the previous step.
const WIDTH: usize = 90;

const HOUSES: [&str; 2] = ["SingleFamilyHouse-0018", "SingleFamilyHouse-0387"];

/// Consecutive days of the test.
const DAYS: [&str; 2] = ["01-10..01-10", "01-11..01-11"];

fn problem(houses: &[&str], tasks: &[&str], memory: &str) -> Problem {
    let changes = json!({"test": houses, "test_tasks": tasks, "windows": DAYS, "memory": memory});
    Problem::named("adapt-house").unwrap().with(&serde_json::from_value(changes).unwrap()).unwrap()
}

fn evaluation(catalog: &Catalog, jobs: usize, interrupted: fn() -> bool) -> Evaluation<'_> {
    Evaluation { catalog, launcher: Launcher::new(env!("CARGO_BIN_EXE_b2b")), jobs, interrupted }
}

/// Runs the episodes of the test side with these seeds.
fn run(catalog: &Catalog, problem: &Problem, policy: &dyn Policy, seeds: &[u64]) -> Vec<Finished> {
    let episodes = problem.episodes(Stage::Test, seeds);
    let wrapped = WrappedPolicy::new(policy, problem, problem.side(Stage::Test));
    let ended = Mutex::new(BTreeMap::new());
    let numbered: Vec<(usize, &EpisodePlan)> = episodes.iter().enumerate().collect();
    let keep = |number, outcome: b2b_evaluate::Outcome| {
        ended.lock().unwrap().insert(number, outcome.unwrap());
        Ok(())
    };
    evaluation(catalog, 2, || false).run(&numbered, &wrapped, &(), &keep).unwrap();
    ended.into_inner().unwrap().into_values().collect()
}

/// Building, task and seed of a controller, and its steps by episode.
type Seen = (String, String, u64, Vec<usize>);

/// Counts its steps and acts by their number.
#[derive(Default)]
struct Counting(Arc<Mutex<Vec<Seen>>>);

impl Policy for Counting {
    fn name(&self) -> String {
        "counting".to_owned()
    }

    fn identity(&self) -> String {
        self.name()
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn controller(&self, context: EpisodeContext<'_>) -> b2b_evaluate::Result<Box<dyn Controller>> {
        let EpisodeContext { subject, spaces, interface, seed, .. } = context;
        let actuators = interface.action.names().iter().map(|name| format!("previous {name}"));
        let previous: Vec<_> = actuators.chain(["previous reward".into(), "first step".into()]).collect();
        assert_eq!(interface.observation[WIDTH..], previous);
        assert_eq!(interface.observation[WIDTH - 1], "padding");
        // The building's energy scale is not part of the problem's task.
        let task = b2b_env::Task { energy_scale: None, ..spaces.episode.task.clone() };
        let seen = (subject.label(), task.to_string(), seed, Vec::new());
        let (space, log) = (interface.action.clone(), Arc::clone(&self.0));
        Ok(Box::new(Counter { seen, space, previous: [0.0, 0.0, 0.0, 1.0], log }))
    }
}

struct Counter {
    seen: Seen,
    space: ActionSpace,
    /// The previous step as it should be observed.
    previous: [f64; 4],
    log: Arc<Mutex<Vec<Seen>>>,
}

impl Controller for Counter {
    fn reset(&mut self) {
        self.seen.3.clear();
        self.next_episode();
    }

    fn next_episode(&mut self) {
        self.seen.3.push(0);
        self.previous = [0.0, 0.0, 0.0, 1.0];
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        assert_eq!(observation[WIDTH..], self.previous);
        *self.seen.3.last_mut().unwrap() += 1;
        let share = (self.seen.3.iter().sum::<usize>() % 7) as f64 / 7.0;
        for (index, value) in action.iter_mut().enumerate() {
            let (low, high) = (self.space.low()[index], self.space.high()[index]);
            *value = low + share * (high - low);
            self.previous[index] = unscale(*value, low, high);
        }
        self.previous[3] = 0.0;
    }

    fn reward(&mut self, reward: f64) {
        self.previous[2] = reward;
    }
}

impl Drop for Counter {
    fn drop(&mut self) {
        self.log.lock().unwrap().push(self.seen.clone());
    }
}

#[test]
fn memory_is_kept_in_a_building_under_a_task_with_a_seed_and_nowhere_else() {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let problem = problem(&HOUSES, &["occupancy", "random"], "building");
    let policy = Counting::default();
    let ended = run(&catalog, &problem, &policy, &[0, 1]);
    assert_eq!(ended.len(), 2 * 2 * 2 * 2);
    let mut seen = policy.0.lock().unwrap().clone();
    seen.sort();
    let mut expected = Vec::new();
    for house in HOUSES {
        for task in ["occupancy", "random"] {
            for seed in [0, 1] {
                expected.push((house.to_owned(), task.to_owned(), seed, vec![288; 2]));
            }
        }
    }
    assert_eq!(seen, expected);
    // Actions do not depend on the seed.
    for pair in ended.chunks(2) {
        assert_eq!(pair[0].record.trajectory_hash, pair[1].record.trajectory_hash);
    }
}

#[test]
fn a_policy_without_memory_sees_no_difference() {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("network.onnx");
    std::fs::write(&path, linear_policy(WIDTH, 2, 0.3)).unwrap();
    let network = OnnxPolicy::read(&path, ActionScale::Rescaled).unwrap();
    let policies: [&dyn Policy; 2] = [&BuiltIn::random(), &network];
    for policy in policies {
        let [kept, reset] = ["building", "episode"]
            .map(|memory| run(&catalog, &problem(&HOUSES[..1], &["random"], memory), policy, &[5]));
        assert_eq!(kept, reset, "{}", policy.name());
    }
}

#[test]
fn the_states_of_a_network_are_kept_for_as_many_episodes_as_its_metadata_says() {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("network.onnx");
    let read = |metadata: &[u8]| {
        std::fs::write(&path, [&summing_policy(WIDTH, 2), metadata].concat()).unwrap();
        OnnxPolicy::read(&path, ActionScale::Rescaled)
    };
    let episodes =
        |text: &str| bytes(14, &[protobuf::text(1, "memory_episodes"), protobuf::text(2, text)].concat());
    let days = |network: &OnnxPolicy, memory| {
        run(&catalog, &problem(&HOUSES[..1], &["random"], memory), network, &[5])
    };
    let reset = days(&read(&[]).unwrap(), "episode");
    for (metadata, expected) in
        [(vec![], [true, false]), (episodes("1"), [true, true]), (episodes("2"), [true, false])]
    {
        let kept = days(&read(&metadata).unwrap(), "building");
        let same: Vec<_> = kept.iter().zip(&reset).map(|(kept, reset)| kept == reset).collect();
        assert_eq!(same, expected, "days that begin with an empty memory");
    }
    for text in ["0", "two"] {
        let said = read(&episodes(text)).unwrap_err().to_string();
        let expected = format!("its metadata `memory_episodes` is `{text}`; expected a whole number from 1");
        assert!(said.contains(&expected), "{said}");
    }
}

/// Counts the episodes that ended.
static ENDED: AtomicUsize = AtomicUsize::new(0);

struct Counted;

impl Progress for Counted {
    fn episode(&self) {
        ENDED.fetch_add(1, Ordering::Relaxed);
    }
}

fn result(folder: &Path) -> [Vec<u8>; 2] {
    ["result.json", "episodes.parquet"].map(|file| std::fs::read(folder.join(file)).unwrap())
}

#[test]
fn an_entry_with_memory_resumes_in_the_middle_of_a_building_and_is_verified_bit_for_bit() {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recurrent.onnx");
    // It observes the previous step.
    std::fs::write(&path, summing_policy(WIDTH + 4, 2)).unwrap();
    let problem = problem(&HOUSES, &["random"], "building");
    let policy = || {
        let episodes = problem.episodes(Stage::Test, &[0]);
        EntryPolicy::read(path.to_str().unwrap(), ActionScale::Rescaled, &[0], &episodes).unwrap()
    };
    let entry = Entry {
        problem: problem.clone(),
        name: "recurrent".into(),
        description: None,
        training_steps: None,
        policy: policy(),
        train_policy: None,
        adapted: BTreeMap::new(),
        upper_bound: None,
    };
    let baselines = Baselines::without_shipped(&folder.path().join("baselines"));
    let run = |name: &str, interrupted: fn() -> bool, progress: &dyn Progress| {
        entry.run(&folder.path().join(name), &evaluation(&catalog, 1, interrupted), &baselines, progress)
    };
    let RunOutcome::Complete(whole, _) = run("whole", || false, &()).unwrap() else {
        panic!("it is complete")
    };
    let curve = whole.measures.by_episode.unwrap();
    assert_eq!(curve.points.iter().map(|point| point.days_before).collect::<Vec<_>>(), [0, 1]);

    let stopped = run("parts", || ENDED.load(Ordering::Relaxed) >= 1, &Counted).unwrap_err();
    assert_eq!(stopped.to_string(), "interrupted");
    let kept = std::fs::read_dir(folder.path().join("parts/unfinished/test/episodes")).unwrap().count();
    assert_eq!(kept, 1, "of two days in the first house");
    ENDED.store(0, Ordering::Relaxed);
    run("parts", || false, &Counted).unwrap();
    assert_eq!(ENDED.load(Ordering::Relaxed), 4, "the first house was run again, whole");
    assert_eq!(result(&folder.path().join("parts")), result(&folder.path().join("whole")));

    let sample = Sample { episodes: NonZeroUsize::new(1), seed: 0 };
    let checks =
        verify(&folder.path().join("parts"), &evaluation(&catalog, 2, || false), sample, &()).unwrap();
    assert!(checks.iter().all(b2b_benchmark::entry::Check::passed), "{checks:?}");
    let last = checks.last().unwrap().outcome.clone().unwrap();
    assert!(last.contains("1 of 2 sequences of episodes agree bit for bit"), "{last}");
}
