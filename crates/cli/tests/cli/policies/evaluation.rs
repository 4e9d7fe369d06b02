//! Evaluations on the real engine: two houses, one or two days.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::policies::onnx_file::linear_policy;
use b2b_control::{Controller, Reactive, ReactiveParameters, Versions};
use b2b_dataset::Catalog;
use b2b_energyplus::install::Quiet;
use b2b_env::{Env, RoleObservation, Trajectory};
use b2b_evaluate::{
    ActionScale, Baselines, BuiltIn, EpisodeContext, EpisodePlan, EpisodeResult, Evaluation, Folder,
    OnnxPolicy, Policy, Progress, Results, Scored, Subject, write_episodes,
};
use b2b_workers::Launcher;
use tempfile::TempDir;

const HOUSES: [&str; 2] = ["SingleFamilyHouse-0014", "SingleFamilyHouse-0042"];

/// The engine, and a folder to work in.
struct Case {
    catalog: Catalog,
    root: TempDir,
}

impl Case {
    fn new() -> Self {
        Self { catalog: Catalog::open(&mut Quiet).unwrap(), root: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.root.path().join(name)
    }

    fn evaluation(&self, interrupted: fn() -> bool) -> Evaluation<'_> {
        let launcher = Launcher::new(env!("CARGO_BIN_EXE_b2b"));
        Evaluation { catalog: &self.catalog, launcher, jobs: 2, interrupted }
    }

    fn run(
        &self,
        name: &str,
        policy: &dyn Policy,
        episodes: &[EpisodePlan],
        progress: &dyn Progress,
    ) -> Results {
        self.try_run(name, policy, episodes, progress, || false).unwrap()
    }

    fn try_run(
        &self,
        name: &str,
        policy: &dyn Policy,
        episodes: &[EpisodePlan],
        progress: &dyn Progress,
        interrupted: fn() -> bool,
    ) -> b2b_evaluate::Result<Results> {
        let folder = Folder::open(&self.path(name), policy, episodes)?;
        let baselines = Baselines::without_shipped(&self.path("baselines"));
        Results::of(&self.evaluation(interrupted), &folder, episodes, policy, &baselines, progress)
    }
}

fn episodes(buildings: &[&str], tasks: &[&str], period: &str) -> Vec<EpisodePlan> {
    let mut episodes = Vec::new();
    for building in buildings {
        for task in tasks {
            episodes.push(EpisodePlan {
                subject: Subject::at_home(building.parse().unwrap()),
                task: task.parse().unwrap(),
                period: period.parse().unwrap(),
                seed: 3,
                steps_per_hour: 12,
            });
        }
    }
    episodes
}

fn scored(row: &EpisodeResult) -> &Scored {
    row.outcome.as_ref().unwrap()
}

fn table(results: &Results) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_episodes(&mut bytes, &results.rows, &Versions::current()).unwrap();
    bytes
}

/// Counts episodes that were run, without baselines.
#[derive(Default)]
struct Count {
    episodes: AtomicUsize,
    scoring: AtomicBool,
}

impl Progress for Count {
    fn begin(&self, what: &str, _: usize, _: u64) {
        self.scoring.store(what == "baselines", Ordering::Relaxed);
    }

    fn episode(&self) {
        let counts = !self.scoring.load(Ordering::Relaxed);
        self.episodes.fetch_add(usize::from(counts), Ordering::Relaxed);
    }
}

#[test]
fn two_runs_and_an_interrupted_one_give_the_same_bytes_and_repeat_nothing() {
    let case = Case::new();
    let episodes = episodes(&HOUSES, &["constant", "occupancy+energy0.5"], "01-10..01-10");
    let first = case.run("first", &BuiltIn::random(), &episodes, &());
    assert!(first.rows.iter().all(|row| row.score().is_some_and(|score| score > 1.0)), "{first:?}");
    assert_eq!(table(&case.run("second", &BuiltIn::random(), &episodes, &())), table(&first));

    // Interrupts once two episodes are kept.
    static KEPT: AtomicUsize = AtomicUsize::new(0);
    struct Kept;
    impl Progress for Kept {
        fn episode(&self) {
            KEPT.fetch_add(1, Ordering::Relaxed);
        }
    }
    let interrupted = || KEPT.load(Ordering::Relaxed) >= 2;
    let stopped = case.try_run("third", &BuiltIn::random(), &episodes, &Kept, interrupted).unwrap_err();
    assert_eq!(stopped.to_string(), "interrupted");
    let kept = std::fs::read_dir(case.path("third/episodes")).unwrap().count();
    assert!((2..4).contains(&kept), "{kept}");
    let count = Count::default();
    let resumed = case.run("third", &BuiltIn::random(), &episodes, &count);
    assert_eq!(count.episodes.load(Ordering::Relaxed), 4 - kept);
    assert_eq!(table(&resumed), table(&first));
}

#[test]
fn the_reactive_controllers_score_one_and_match_a_single_environment() {
    let case = Case::new();
    let episodes = episodes(&HOUSES[..1], &["constant", "occupancy+energy0.5"], "01-10..01-10");
    let results = case.run("reactive", &BuiltIn::reactive(), &episodes, &());
    for (row, episode) in results.rows.iter().zip(&episodes) {
        assert!((row.score().unwrap() - 1.0).abs() < 1e-12, "{row:?}");
        let (hash, episode_return) = alone(&case.catalog, episode);
        assert_eq!(
            (scored(row).trajectory_hash.as_str(), scored(row).metrics.episode_return),
            (hash.as_str(), episode_return)
        );
    }
    // Its episodes are the baseline of others, so the baseline is not run again.
    struct NoBaseline;
    impl Progress for NoBaseline {
        fn begin(&self, what: &str, episodes: usize, _: u64) {
            assert!(what == "episodes" || episodes == 0);
        }
    }
    let constant = case.run("constant", &BuiltIn::constant(), &episodes, &NoBaseline);
    let episode_return = |results: &Results| results.rows[0].metrics().unwrap().episode_return;
    assert_eq!(constant.rows[0].score(), Some(episode_return(&constant) / episode_return(&results)));
}

/// The hash and the return of an episode in this process.
fn alone(catalog: &Catalog, episode: &EpisodePlan) -> (String, f64) {
    let found = catalog.find(&episode.subject.name, &episode.subject.placement, &mut Quiet).unwrap();
    let setting = b2b_env::EpisodeConfig {
        weather: found.weather.clone(),
        period: episode.period.in_weather(&found.weather).unwrap(),
        steps_per_hour: episode.steps_per_hour,
        task: episode.task.clone(),
    };
    let building = found.prepare(catalog.library()).unwrap();
    let mut env = Env::new(catalog.library().clone(), building.into(), setting).unwrap();
    let parameters = ReactiveParameters::tuned_for(env.building(), &episode.task);
    let mut controller = Reactive::new(env.building(), env.observation_space(), 12, &parameters);
    let mut trajectory = Trajectory::for_episode(env.spaces());
    let mut action = vec![0.0; env.action_space().len()];
    let mut observation = env.reset().unwrap().to_vec();
    loop {
        controller.act(&observation, &mut action);
        let step = env.step(&action).unwrap();
        trajectory.push(&step);
        observation = step.observation.to_vec();
        if step.truncated {
            break;
        }
    }
    (trajectory.hash(), env.metrics().episode_return)
}

/// Kills the process of every episode in one building.
struct Killer;

/// Acts until it kills.
struct Kills {
    process: Option<u32>,
    inner: Box<dyn Controller>,
    step: usize,
}

impl Policy for Killer {
    fn name(&self) -> String {
        "killer".into()
    }

    fn identity(&self) -> String {
        "killer".into()
    }

    fn controller(&self, context: EpisodeContext<'_>) -> b2b_evaluate::Result<Box<dyn Controller>> {
        let process = context.subject.name.to_string().ends_with("0014");
        let process = process.then(|| context.episode.workers().template_processes()[0]);
        Ok(Box::new(Kills { process, inner: BuiltIn::constant().controller(context)?, step: 0 }))
    }
}

impl Controller for Kills {
    fn reset(&mut self) {}

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        self.step += 1;
        self.inner.act(observation, action);
        if let Some(template) = self.process.filter(|_| self.step == 20) {
            // The episode is the child of its template.
            let children =
                std::fs::read_to_string(format!("/proc/{template}/task/{template}/children")).unwrap();
            for child in children.split_whitespace() {
                let killed = std::process::Command::new("kill").args(["-9", child]).status().unwrap();
                assert!(killed.success());
            }
        }
    }
}

#[test]
fn an_environment_that_dies_is_reported_and_does_not_stop_the_others() {
    let case = Case::new();
    let episodes = episodes(&HOUSES, &["constant"], "01-10..01-10");
    let results = case.run("killed", &Killer, &episodes, &());
    let [lost, other] = &results.rows[..] else { panic!("{results:?}") };
    assert!(lost.outcome.as_ref().unwrap_err().reason.contains("killed or crashed"), "{lost:?}");
    assert!(other.score().is_some(), "{other:?}");
    let summary = results.summary(&Killer);
    assert_eq!((summary.lost.len(), summary.windows[0].all.scores.as_ref().unwrap().episodes), (1, 1));
    // It is not kept, so the next start runs only this episode again.
    let count = Count::default();
    case.run("killed", &Killer, &episodes, &count);
    assert_eq!(count.episodes.load(Ordering::Relaxed), 1);
}

fn onnx(case: &Case, observation: usize, action: usize, bias: f32, scale: ActionScale) -> OnnxPolicy {
    let path = case.path(&format!("{observation}-{action}.onnx"));
    std::fs::write(&path, linear_policy(observation, action, bias)).unwrap();
    OnnxPolicy::read(&path, scale).unwrap()
}

#[test]
fn an_onnx_policy_of_zeros_is_the_middle_of_every_bound() {
    let case = Case::new();
    let episodes = episodes(&HOUSES[..1], &["constant"], "01-10..01-10");
    let policy = onnx(&case, 9, 2, 0.0, ActionScale::Rescaled);
    let zeros = case.run("onnx", &policy, &episodes, &());
    let middle = case.run("constant", &BuiltIn::constant(), &episodes, &());
    assert_eq!(scored(&zeros.rows[0]).trajectory_hash, scored(&middle.rows[0]).trajectory_hash);
    let physical = onnx(&case, 9, 2, 1e4, ActionScale::Physical);
    let clamped = case.run("physical", &physical, &episodes, &());
    assert_eq!(clamped.rows[0].metrics().unwrap().clamped_actions, 2 * 24 * 12);
    assert_ne!(physical.identity(), policy.identity());
}

/// These houses have 9 and 10 slots.
#[test]
fn one_onnx_policy_controls_houses_with_other_zones_by_roles_or_with_zeros_behind() {
    let case = Case::new();
    let houses = ["SingleFamilyHouse-0064", "SingleFamilyHouse-0318"];
    let episodes = episodes(&houses, &["constant"], "01-10..01-10");
    let middle = case.run("constant", &BuiltIn::constant(), &episodes, &());
    for width in [RoleObservation::WIDTH, 20] {
        let policy = onnx(&case, width, 2, 0.0, ActionScale::Rescaled);
        let zeros = case.run(&format!("zeros-{width}"), &policy, &episodes, &());
        for (zeros, middle) in zeros.rows.iter().zip(&middle.rows) {
            assert_eq!(scored(zeros).trajectory_hash, scored(middle).trajectory_hash, "{width}");
        }
    }
}

#[test]
fn a_policy_of_other_shapes_is_refused_with_sizes_and_slots() {
    let case = Case::new();
    let episodes = episodes(&HOUSES[..1], &["occupancy"], "01-10..01-10");
    let refused = |name: &str, policy: &dyn Policy| {
        case.try_run(name, policy, &episodes, &(), || false).unwrap_err().to_string()
    };
    let said = refused("observation", &onnx(&case, 9, 2, 0.0, ActionScale::Rescaled));
    for word in ["takes 9 values", "SingleFamilyHouse-0014", "occupancy", "has 11", "target", "time of day"] {
        assert!(said.contains(word), "`{word}` is not in: {said}");
    }
    let said = refused("action", &onnx(&case, 11, 5, 0.0, ActionScale::Rescaled));
    for word in ["returns 5 values", "has 2", "supply air flow"] {
        assert!(said.contains(word), "`{word}` is not in: {said}");
    }
    assert_eq!(files(&case.path("action/episodes")), 0);
}

fn files(folder: &Path) -> usize {
    std::fs::read_dir(folder).unwrap().count()
}
