//! Learning of toy environments by PPO, and the time of an update.

use std::sync::Arc;
use std::time::Instant;

use b2b_agent::network::{Actor, Graph};
use b2b_learn::collector::Collector;
use b2b_learn::learner::Learner as _;
use b2b_learn::ppo::{LogStd, Ppo, PpoConfig};
use b2b_learn::random::RandomStream;
use b2b_learn::rollout::{Rollout, Widths};

use super::toy::{Local, Pendulum, Room, Toy, mean_return};

const SEEDS: [u64; 2] = [0, 1];

/// Returns the mean return of the actor without exploration.
pub fn evaluate<T: Toy>(actor: &Actor) -> f64 {
    evaluate_in::<T>(actor, None)
}

/// Like [`evaluate`], with the building of a graph network.
pub fn evaluate_in<T: Toy>(actor: &Actor, graph: Option<&Arc<Graph>>) -> f64 {
    let (mut scratch, mut steps) = (actor.scratch(graph), 0);
    mean_return::<T>(20, |observation, action| {
        if steps % T::STEPS == 0 {
            scratch.state_mut().fill(0.0);
        }
        steps += 1;
        actor.mean(observation, &mut scratch, action);
    })
}

/// Trains on this number of environments, and returns the mean return without exploration.
fn train<T: Toy>(config: &PpoConfig, environments: usize, updates: usize, seed: u64) -> f64 {
    let mut collector = Local::<T>::new(environments, seed);
    let mut ppo = Ppo::new(collector.widths(), config.clone(), seed).unwrap();
    let mut rollout = Rollout::default();
    for _ in 0..updates {
        collector.collect(&ppo.actor(), config.n_steps, &mut rollout).unwrap();
        let update = ppo.update(&rollout).unwrap();
        assert_eq!(update.skipped, 0);
    }
    evaluate::<T>(&ppo.actor())
}

/// Trains with three seeds and asserts that all reach a return.
fn assert_learns<T: Toy>(
    name: &str,
    config: &PpoConfig,
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

fn pendulum() -> PpoConfig {
    PpoConfig {
        learning_rate: 1e-3,
        n_steps: 256,
        batch_size: 256,
        gamma: 0.95,
        gae_lambda: 0.95,
        actor_hidden: vec![32, 32],
        critic_hidden: vec![32, 32],
        ..PpoConfig::default()
    }
}

fn room() -> PpoConfig {
    PpoConfig {
        learning_rate: 1e-3,
        n_steps: 96,
        batch_size: 192,
        gamma: 0.95,
        actor_hidden: vec![32, 32],
        critic_hidden: vec![32, 32],
        initial_log_std: -0.5,
        ..PpoConfig::default()
    }
}

#[test]
fn ppo_swings_a_pendulum_up() {
    assert_learns::<Pendulum>("pendulum", &pendulum(), 8, 60, -200.0);
}

/// Proportional heating has a return of -76.
#[test]
fn ppo_heats_rooms_with_free_standard_deviations() {
    assert_learns::<Room>("rooms", &room(), 8, 60, -60.0);
}

#[test]
fn ppo_heats_rooms_with_standard_deviations_of_the_observation() {
    let config = PpoConfig { log_std: LogStd::OfState, ..room() };
    assert_learns::<Room>("rooms, deviations of the observation", &config, 8, 60, -60.0);
}

#[test]
fn ppo_heats_rooms_with_the_credit_of_each_room() {
    let config = PpoConfig { credit: Some(vec![vec![1.0, 0.2], vec![0.2, 1.0]]), ..room() };
    assert_learns::<Room>("rooms, credit", &config, 8, 60, -60.0);
}

#[test]
fn constant_and_proportional_heating_are_the_reference_of_the_rooms() {
    let off = mean_return::<Room>(20, |_, action| action.fill(-1.0));
    let proportional = mean_return::<Room>(20, |observation, action| {
        action.iter_mut().enumerate().for_each(|(room, power)| *power = -10.0 * observation[2 * room]);
    });
    println!("rooms: off {off:.1}, proportional {proportional:.1}");
    assert!(off < -2000.0 && (-80.0..-70.0).contains(&proportional), "{off} {proportional}");
}

/// Prints the times of updates with 336 steps and hidden layers of 256 and 256, on 1 and 2 threads, for 1 and 10
/// epochs.
#[test]
#[ignore = "measures time"]
fn time_of_an_update() {
    let widths = Widths { observation: 11, action: 2, parts: 1, nodes: 1 };
    let hidden = vec![256, 256];
    let config = PpoConfig {
        actor_hidden: hidden.clone(),
        critic_hidden: hidden,
        batch_size: 336,
        ..PpoConfig::default()
    };
    let mut random = RandomStream::new(0, 0);
    let mut draw = |count: usize| {
        let mut values = vec![0.0; count];
        random.normals(&mut values);
        values
    };
    let rollout = Rollout {
        environments: 1,
        steps: 336,
        observations: draw(336 * 11),
        actions: draw(336 * 2),
        rewards: draw(336),
        next: draw(11),
        ends: vec![],
        ..Rollout::default()
    };
    for (threads, epochs) in [(1, 1), (2, 1), (1, 10), (2, 10)] {
        let mut ppo = Ppo::new(widths, PpoConfig { epochs, ..config.clone() }, 0).unwrap();
        ppo.set_threads(threads);
        let mut times: Vec<u128> = (0..101)
            .map(|_| {
                let start = Instant::now();
                ppo.update(&rollout).unwrap();
                start.elapsed().as_micros()
            })
            .collect();
        times.sort_unstable();
        println!("{threads} threads, {epochs} epochs: median {} µs, best {} µs", times[50], times[0]);
    }
}
