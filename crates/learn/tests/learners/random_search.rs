//! A learner from outside the crate: random search over the parameters of an actor. CONTRIBUTING.md refers to it as the
//! example of a learner.

use std::path::Path;
use std::sync::Arc;

use b2b_agent::Agent;
use b2b_agent::network::{Activation, Actor, Distribution, Mlp, Shape};
use b2b_dataset::Catalog;
use b2b_energyplus::install::Quiet;
use b2b_learn::Result;
use b2b_learn::collector::Collector as _;
use b2b_learn::learner::{Learner, LearnerOptions, LearnerSetting};
use b2b_learn::learners::{LearnerKind, register};
use b2b_learn::nn::{InitialGains, orthogonal};
use b2b_learn::random::RandomStream;
use b2b_learn::rollout::Rollout;
use b2b_learn::state::State;
use b2b_learn::train::{PolicyConfig, RunOptions, TrainConfig, read_column, train};
use b2b_workers::Launcher;
use serde::{Deserialize, Serialize};

use super::toy::{Local, Room, Toy as _, mean_return};

/// Options of random search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct RandomSearchConfig {
    /// Steps per environment for which an actor is tried.
    n_steps: usize,
    /// Standard deviation of the steps from the best parameters to the next candidates.
    deviation: f32,
}

impl Default for RandomSearchConfig {
    fn default() -> Self {
        Self { n_steps: 288, deviation: 0.3 }
    }
}

impl LearnerOptions for RandomSearchConfig {
    fn check(&self) -> Result<()> {
        match self.deviation > 0.0 {
            true => Ok(()),
            false => Err(b2b_learn::Error::Invalid("`random_search.deviation` must be above 0".into())),
        }
    }

    fn steps_per_rollout(&self) -> usize {
        self.n_steps
    }

    fn learner(&self, setting: &LearnerSetting<'_>) -> Result<Box<dyn Learner>> {
        let (observation, action) = (setting.widths.observation, setting.widths.action);
        let shape = Mlp::new(observation, &[], action, Activation::Tanh);
        let mut random = RandomStream::new(setting.seed, 0);
        let best = orthogonal(&shape, InitialGains { hidden: 1.0, last: 0.01 }, &mut random);
        let (tried, deviation) = (best.clone(), self.deviation);
        Ok(Box::new(RandomSearch { shape, deviation, best, tried, penalty: f64::INFINITY, random }))
    }
}

/// A learner by random search.
struct RandomSearch {
    shape: Mlp,
    deviation: f32,
    best: Vec<f32>,
    /// Parameters of the next rollout.
    tried: Vec<f32>,
    /// Mean penalty of a step with the best parameters.
    penalty: f64,
    random: RandomStream,
}

impl RandomSearch {
    fn actor_of(&self, parameters: &[f32]) -> Actor {
        let distribution = Distribution::Gaussian { log_std: vec![-3.0; self.shape.outputs()] };
        Actor { shape: Shape::Mlp(self.shape.clone()), parameters: parameters.to_vec(), distribution }
    }
}

impl Learner for RandomSearch {
    fn actor(&self) -> Actor {
        self.actor_of(&self.tried)
    }

    fn averaged_actor(&self) -> Actor {
        self.actor_of(&self.best)
    }

    fn columns(&self) -> Vec<&'static str> {
        vec!["best_penalty"]
    }

    fn learn(&mut self, rollout: &Rollout) -> Result<Vec<(&'static str, f64)>> {
        if rollout.mean_penalty() < self.penalty {
            self.penalty = rollout.mean_penalty();
            self.best.clone_from(&self.tried);
        }
        for (tried, best) in self.tried.iter_mut().zip(&self.best) {
            *tried = best + self.deviation * self.random.normal() as f32;
        }
        Ok(vec![("best_penalty", self.penalty)])
    }

    fn state(&self) -> State {
        let mut state = State::default();
        state.put_f32("best", &self.best);
        state.put_f32("tried", &self.tried);
        state.put_f64("penalty", &[self.penalty]);
        state.put_u64("random", &self.random.words());
        state
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        state.read_f32("best", &mut self.best)?;
        state.read_f32("tried", &mut self.tried)?;
        state.read_f64("penalty", std::slice::from_mut(&mut self.penalty))?;
        self.random = RandomStream::from_words(state.read_u64("random")?);
        Ok(())
    }
}

#[test]
fn random_search_learns_to_heat_rooms_and_continues_from_its_state() {
    let mut collector = Local::<Room>::new(8, 0);
    let options = RandomSearchConfig { n_steps: Room::STEPS, ..RandomSearchConfig::default() };
    let setting = LearnerSetting {
        widths: collector.widths(),
        environments: 8,
        interface: TrainConfig::default().agent.interface(),
        policy: &PolicyConfig::Flat,
        credit: None,
        hold: 1,
        seed: 0,
        threads: 1,
    };
    let mut learner = options.learner(&setting).unwrap();
    let evaluate = |actor: &Actor| {
        let mut scratch = actor.scratch(None);
        mean_return::<Room>(20, |observation, action| actor.mean(observation, &mut scratch, action))
    };
    let before = evaluate(&learner.averaged_actor());
    let mut rollout = Rollout::default();
    for _ in 0..100 {
        collector.collect(&learner.actor(), options.steps_per_rollout(), &mut rollout).unwrap();
        learner.learn(&rollout).unwrap();
    }
    let after = evaluate(&learner.averaged_actor());
    println!("return {before:.0}, after 100 trials {after:.0}");
    assert!(after > before / 2.0, "{before} {after}");
    let mut restored = options.learner(&setting).unwrap();
    restored.restore(&learner.state()).unwrap();
    assert_eq!(restored.learn(&rollout).unwrap(), learner.learn(&rollout).unwrap());
    assert_eq!((restored.actor(), restored.state()), (learner.actor(), learner.state()));
}

const OPTIONS: &str = "
    algorithm = 'random_search'
    buildings = ['SingleFamilyHouse-0014']
    period = '01-10..01-10'
    environments = 2
    steps = 1152
    scale_rewards = false
    keep = 'last'
    evaluation = { every = 0, whole_period = false }
    random_search = { n_steps = 144 }";

/// Trains in a folder, or resumes its run.
pub fn run(config: &TrainConfig, folder: &Path) {
    let options = RunOptions {
        out: folder.to_owned(),
        catalog: Arc::new(Catalog::open(&mut Quiet).unwrap()),
        launcher: Launcher::new(env!("CARGO_BIN_EXE_b2b-learn-worker")),
        jobs: 1,
        interrupted: || false,
        monitor: &mut (),
    };
    train(config, options).unwrap();
}

#[test]
fn a_registered_learner_is_named_by_a_configuration_and_trains_on_the_engine() {
    register(LearnerKind::of::<RandomSearchConfig>("random_search"));
    let base = TrainConfig::default();
    let config = base.with_changes(OPTIONS).unwrap();
    assert_eq!(base.with_changes(&config.to_toml()).unwrap(), config);
    let said = config.with_changes("random_search = { deviatoin = 1 }").unwrap_err();
    assert!(said.contains("did you mean `deviation`?"), "{said}");
    let said = config.with_changes("mirrored_noise = true").unwrap().check().unwrap_err().to_string();
    assert!(said.contains("with random_search it must be false"), "{said}");

    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    run(&config, &whole);
    let half = config.with_changes("steps = 576").unwrap();
    run(&half, &parts);
    run(&config, &parts);
    let penalties = read_column(&whole, "best_penalty").unwrap();
    assert_eq!(penalties.iter().map(|(steps, _)| *steps).collect::<Vec<_>>(), [288, 576, 864, 1152]);
    assert!(penalties.is_sorted_by(|a, b| a.1 >= b.1), "{penalties:?}");
    assert_eq!(read_column(&parts, "best_penalty").unwrap(), penalties);
    let [whole, parts] = [whole, parts].map(|folder| Agent::read(&folder).unwrap());
    assert_eq!(whole.info().training.algorithm, "random_search");
    assert_eq!(whole.info().weights, parts.info().weights);
}
