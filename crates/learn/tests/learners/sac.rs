//! Learning of toy environments by SAC.

use std::time::Instant;

use b2b_learn::collector::Collector;
use b2b_learn::learner::Learner as _;
use b2b_learn::nn::RateSchedule;
use b2b_learn::rollout::Rollout;
use b2b_learn::sac::{Sac, SacConfig};

use super::toy::{Local, Pendulum, Room, Toy, mean_return};

const SEEDS: [u64; 2] = [0, 1];

/// Trains on this number of environments, and returns the mean return without exploration.
fn train<T: Toy>(config: &SacConfig, environments: usize, updates: usize, seed: u64) -> f64 {
    let mut collector = Local::<T>::new(environments, seed);
    let mut sac = Sac::new(collector.widths(), environments, config.clone(), seed).unwrap();
    let mut rollout = Rollout::default();
    for update in 0..updates {
        sac.set_done(update as f64 / updates as f64);
        collector.collect(&sac.actor(), config.n_steps, &mut rollout).unwrap();
        assert_eq!(sac.update(&rollout).unwrap().skipped, 0);
    }
    let actor = sac.actor();
    let mut scratch = actor.scratch(None);
    mean_return::<T>(20, |observation, action| actor.mean(observation, &mut scratch, action))
}

/// Trains with three seeds and asserts that all reach a return.
fn assert_learns<T: Toy>(
    name: &str,
    config: &SacConfig,
    environments: usize,
    updates: usize,
    threshold: f64,
) {
    let start = Instant::now();
    let returns = SEEDS.map(|seed| train::<T>(config, environments, updates, seed));
    println!("{name}: {returns:.1?} in {:.1} s", start.elapsed().as_secs_f64());
    assert!(
        returns.iter().all(|value| *value > threshold),
        "{name}: {returns:?}, expected above {threshold}"
    );
}

fn config() -> SacConfig {
    SacConfig {
        learning_rate: 2e-3,
        n_steps: 16,
        batch_size: 256,
        updates_per_step: 0.25,
        gamma: 0.95,
        return_steps: 3,
        tau: 0.02,
        actor_hidden: vec![48, 48],
        critic_hidden: vec![48, 48],
        initial_temperature: 0.1,
        ..SacConfig::default()
    }
}

#[test]
fn sac_swings_a_pendulum_up() {
    assert_learns::<Pendulum>("pendulum", &config(), 4, 200, -200.0);
}

/// Proportional heating has a return of -76.
#[test]
fn sac_heats_rooms() {
    let config = SacConfig {
        schedule: RateSchedule::Linear,
        updates_per_step: 0.5,
        gamma: 0.9,
        return_steps: 1,
        max_grad_norm: Some(1.0),
        target_entropy_factor: 2.0,
        ..config()
    };
    assert_learns::<Room>("rooms", &config, 4, 300, -63.0);
}
