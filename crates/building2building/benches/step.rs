//! A step of the environment, and the observation and reward in it.
//!
//! `cargo bench -p building2building --bench step`

use std::hint::black_box;
use std::time::{Duration, Instant};

use building2building::building::description::Origin;
use building2building::building::{Description, Morphology};
use building2building::env::Decomposition;
use building2building::{BuildingType, Env, Reward, RewardFunction, StepView, make};
use criterion::{Criterion, criterion_group, criterion_main};

/// The types whose steps are measured: a house with one system, and an office with five.
const TYPES: [BuildingType; 2] = [BuildingType::SingleFamilyHouse, BuildingType::OfficeSmall];

/// An environment, its middle action, and whether an episode is in progress.
struct Stepped {
    env: Env,
    action: Vec<f64>,
    in_progress: bool,
}

impl Stepped {
    fn new(env: Env) -> Self {
        let action = env.action_space().middle();
        Self { env, action, in_progress: false }
    }

    /// The time that some steps take, without the resets between episodes.
    fn time(&mut self, steps: u64) -> Duration {
        let mut time = Duration::ZERO;
        for _ in 0..steps {
            if !self.in_progress {
                self.env.reset().expect("an episode");
            }
            let begin = Instant::now();
            let step = self.env.step(&self.action).expect("a step");
            time += begin.elapsed();
            self.in_progress = !black_box(step).truncated;
        }
        time
    }
}

/// A reward that costs nothing to compute, to measure the cost of the task's reward by the difference.
#[derive(Debug)]
struct NoReward;

impl RewardFunction for NoReward {
    fn reward(&mut self, _: &StepView<'_>) -> Reward {
        Reward::default()
    }
}

fn step(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step");
    for building_type in TYPES {
        let build = || make(building_type.name())?.task("occupancy+energy0.5").period("01-01..01-31").build();
        let mut stepped = Stepped::new(build().expect("an environment"));
        group.bench_function(building_type.name(), |bench| bench.iter_custom(|steps| stepped.time(steps)));
        drop(stepped);
        let mut stepped = Stepped::new(build().expect("an environment").with_reward(NoReward));
        let name = format!("{building_type} without reward");
        group.bench_function(name, |bench| bench.iter_custom(|steps| stepped.time(steps)));
    }
    group.finish();
}

/// The per-step work of a policy for any building: splitting the observation into nodes and joining their actions.
fn nodes(criterion: &mut Criterion) {
    let env = make("OfficeSmall").and_then(|office| office.period("01-01..01-01").build());
    let env = env.expect("an environment");
    let spaces = env.spaces();
    let description = Description::of(&spaces.building, &spaces.episode.weather, Origin::default());
    let morphology = Morphology::of(&spaces.building, &description.expect("a description"));
    let decomposition = Decomposition::new(&morphology, &spaces.observation, &spaces.action).expect("nodes");
    let observation = vec![20.0; spaces.observation.len()];
    let mut nodes = vec![0.0; decomposition.observation_layout().len()];
    criterion.bench_function("split an observation into nodes", |bench| {
        bench.iter(|| decomposition.split(black_box(&observation), black_box(&mut nodes)));
    });
    let actions = vec![0.5; decomposition.action_layout().len()];
    let mut action = vec![0.0; spaces.action.len()];
    criterion.bench_function("join the actions of nodes", |bench| {
        bench.iter(|| decomposition.join(black_box(&actions), black_box(&mut action)));
    });
}

criterion_group!(benches, step, nodes);
criterion_main!(benches);
