use b2b_agent::network::{Activation, LOG_STD};

use super::config::SacConfig;
use super::learner::Sac;
use super::loss::temperature_gradient;
use super::networks::SacNetworks;
use super::worker::SacMinibatch;
use crate::learner::Learner as _;
use crate::nn::reference::{self, assert_gradients, wide};
use crate::random::RandomStream;
use crate::rollout::{End, Rollout};
use crate::state::State;
use crate::widths::Widths;

const WIDTHS: Widths = Widths { observation: 3, action: 2, parts: 1, nodes: 1 };

fn config() -> SacConfig {
    SacConfig {
        actor_hidden: vec![12],
        critic_hidden: vec![10],
        batch_size: 40,
        learning_starts: 50,
        return_steps: 3,
        actor_gain: 0.7,
        initial_temperature: 0.3,
        activation: Activation::Tanh,
        ..SacConfig::default()
    }
}

/// Returns random steps of two environments, with an end in each.
fn rollout(steps: usize, seed: u64) -> Rollout {
    let mut random = RandomStream::new(seed, 1);
    let mut draw = |count: usize| {
        let mut values = vec![0.0; count];
        random.normals(&mut values);
        values
    };
    let end = |environment, step, observation| End { environment, step, observation };
    let actions = draw(2 * steps * 2).iter().map(|value| value.tanh()).collect();
    Rollout {
        environments: 2,
        steps,
        observations: draw(2 * steps * 3),
        actions,
        rewards: draw(2 * steps),
        next: draw(2 * 3),
        ends: vec![end(0, 5, draw(3)), end(1, steps - 1, draw(3))],
        ..Rollout::default()
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let run = |threads: usize| {
        let config = SacConfig { actor_hidden: vec![80, 80], batch_size: 200, ..config() };
        let mut sac = Sac::new(WIDTHS, 2, config, 3).unwrap();
        sac.set_threads(threads);
        let update = (0..3).map(|seed| sac.update(&rollout(30, seed)).unwrap()).last().unwrap();
        assert!(update.steps > 0);
        (sac.state(), update)
    };
    let first = run(1);
    assert_eq!(first, run(1));
    assert_eq!(first, run(2));
    assert_eq!(first, run(4));
}

#[test]
fn a_restored_learner_continues_bit_for_bit() {
    let mut sac = Sac::new(WIDTHS, 2, config(), 3).unwrap();
    sac.update(&rollout(33, 0)).unwrap();
    let bytes = sac.state().to_bytes();
    let mut restored = Sac::new(WIDTHS, 2, config(), 8).unwrap();
    restored.restore(&State::from_bytes(&bytes).unwrap()).unwrap();
    assert_eq!(sac.update(&rollout(33, 1)).unwrap(), restored.update(&rollout(33, 1)).unwrap());
    assert_eq!(sac.state(), restored.state());
    assert_eq!(sac.actor(), restored.actor());
}

#[test]
fn minibatches_are_a_share_of_collected_steps() {
    let mut sac = Sac::new(WIDTHS, 2, config(), 3).unwrap();
    let steps: Vec<usize> = (0..4).map(|seed| sac.update(&rollout(13, seed)).unwrap().steps).collect();
    // 26 steps earn 2.6 minibatches, from the second rollout on.
    assert_eq!(steps, [0, 2, 3, 2]);
}

#[test]
fn rollouts_that_are_not_finite_are_left_out_and_are_an_error_after_three_updates() {
    let mut sac = Sac::new(WIDTHS, 2, config(), 3).unwrap();
    sac.update(&rollout(40, 0)).unwrap();
    let mut broken = rollout(40, 1);
    broken.observations[9] = f32::NAN;
    assert_eq!(sac.update(&broken).unwrap().skipped, 1);
    assert_eq!(sac.replay.len(), 80);
    assert_eq!(sac.update(&rollout(40, 2)).unwrap().skipped, 0);
    assert!(sac.parameters.actor.iter().chain(&sac.parameters.critics).all(|value| value.is_finite()));
    assert!(sac.update(&broken).is_ok() && sac.update(&broken).is_ok());
    assert!(matches!(sac.update(&broken), Err(crate::Error::NotFinite { updates: 3 })));
}

#[test]
fn minibatches_that_are_not_finite_change_nothing() {
    let mut sac = Sac::new(WIDTHS, 2, config(), 3).unwrap();
    let mut huge = rollout(40, 0);
    huge.rewards.fill(f32::MAX);
    let before = (sac.parameters.actor.clone(), sac.parameters.critics.clone());
    let update = sac.update(&huge).unwrap();
    assert_eq!((update.steps, update.skipped), (0, 8));
    assert_eq!((&sac.parameters.actor, &sac.parameters.critics), (&before.0, &before.1));
}

#[test]
fn targets_follow_the_critics_when_the_actor_gives_up_its_step() {
    let mut sac = Sac::new(WIDTHS, 2, SacConfig { gamma: 0.0, ..config() }, 3).unwrap();
    // Only the loss of the actor has a temperature at a discount of zero.
    sac.parameters.log_temperature = 60.0;
    let before = sac.parameters.clone();
    let update = sac.update(&rollout(40, 0)).unwrap();
    assert_eq!((update.steps, update.skipped), (0, 8));
    assert_eq!(sac.parameters.actor, before.actor);
    assert_ne!(sac.parameters.critics, before.critics);
    assert_ne!(sac.parameters.targets, before.targets);
}

/// Returns actions and log density for an observation in double precision.
fn act(networks: &SacNetworks, actor: &[f64], observation: &[f64], normals: &[f32]) -> (Vec<f64>, f64) {
    let outputs = reference::forward(&networks.actor, actor, observation);
    let mut log_density = 0.0;
    let action = |(index, normal): (usize, &f32)| {
        let log_std = outputs[2 + index].clamp(f64::from(*LOG_STD.start()), f64::from(*LOG_STD.end()));
        let normal = f64::from(*normal);
        let action = (outputs[index] + log_std.exp() * normal).tanh();
        log_density -= 0.5 * normal * normal + log_std + 0.5 * std::f64::consts::TAU.ln();
        log_density -= (1.0 - action * action).ln();
        action
    };
    let actions = normals.iter().enumerate().map(action).collect();
    (actions, log_density)
}

/// Returns the values of both critics for an observation and an action.
fn values(networks: &SacNetworks, critics: &[f64], observation: &[f64], action: &[f64]) -> [f64; 2] {
    let (input, size) = ([observation, action].concat(), networks.critic.parameters());
    [0, 1].map(|critic: usize| {
        reference::forward(&networks.critic, &critics[critic * size..(critic + 1) * size], &input)[0]
    })
}

fn critic_loss(minibatch: &SacMinibatch<'_>, critics: &[f64]) -> f64 {
    let SacMinibatch { networks, parameters, batch } = minibatch;
    let (actor, targets) = (wide(&parameters.actor), wide(&parameters.targets));
    let temperature = f64::from(parameters.log_temperature.exp());
    let mut sum = 0.0;
    for row in 0..batch.rows {
        let next = wide(&batch.next[row * 3..][..3]);
        let (action, log_density) = act(networks, &actor, &next, &batch.next_normals[row * 2..][..2]);
        let [first, second] = values(networks, &targets, &next, &action);
        let rest = first.min(second) - temperature * log_density;
        let target = f64::from(batch.returns[row]) + f64::from(batch.discounts[row]) * rest;
        let (observation, action) =
            (wide(&batch.observations[row * 3..][..3]), wide(&batch.actions[row * 2..][..2]));
        let both = values(networks, critics, &observation, &action);
        sum += both.iter().map(|value| 0.5 * (value - target).powi(2)).sum::<f64>();
    }
    sum / batch.rows as f64
}

/// Returns the loss of the actor and the mean log density.
fn actor_loss(minibatch: &SacMinibatch<'_>, actor: &[f64]) -> (f64, f64) {
    let SacMinibatch { networks, parameters, batch } = minibatch;
    let (critics, temperature) = (wide(&parameters.critics), f64::from(parameters.log_temperature.exp()));
    let (mut loss, mut density) = (0.0, 0.0);
    for row in 0..batch.rows {
        let observation = wide(&batch.observations[row * 3..][..3]);
        let (action, log_density) = act(networks, actor, &observation, &batch.normals[row * 2..][..2]);
        let [first, second] = values(networks, &critics, &observation, &action);
        loss += temperature * log_density - first.min(second);
        density += log_density;
    }
    (loss / batch.rows as f64, density / batch.rows as f64)
}

#[test]
fn gradients_match_finite_differences() {
    for activation in [Activation::Tanh, Activation::Relu] {
        let mut sac = Sac::new(WIDTHS, 2, SacConfig { activation, ..config() }, 3).unwrap();
        sac.replay.add(&rollout(30, 0));
        sac.replay.sample(40, 3, 0.9, &mut sac.random, &mut sac.batch);
        // Target critics that differ from the critics.
        sac.parameters.targets.iter_mut().for_each(|value| *value *= 1.1);
        let minibatch =
            SacMinibatch { networks: &sac.networks, parameters: &sac.parameters, batch: &sac.batch };
        let worker = &mut sac.workers[0];
        worker.learn_critics(&minibatch, 0..40);
        let critics = wide(&sac.parameters.critics);
        assert!((worker.losses.critics - critic_loss(&minibatch, &critics)).abs() < 1e-5);
        assert_gradients(&critics, &worker.critic_gradients, |critics| critic_loss(&minibatch, critics));
        worker.learn_actor(&minibatch, 0..40);
        let actor = wide(&sac.parameters.actor);
        let (loss, log_density) = actor_loss(&minibatch, &actor);
        assert!((worker.losses.actor - loss).abs() < 1e-5);
        assert!((worker.losses.log_density - log_density).abs() < 1e-5);
        assert_gradients(&actor, &worker.actor_gradients, |actor| actor_loss(&minibatch, actor).0);
    }
}

#[test]
fn the_gradient_of_the_temperature_matches_finite_differences() {
    let (log_density, target) = (1.7, -2.0);
    let gradient = temperature_gradient(log_density, target) as f32;
    assert_gradients(&[-0.4], &[gradient], |log_temperature| -log_temperature[0] * (log_density + target));
}

#[test]
fn the_temperature_falls_while_the_entropy_is_above_its_target() {
    let mut sac = Sac::new(WIDTHS, 2, SacConfig { target_entropy_factor: 5.0, ..config() }, 3).unwrap();
    let temperature = sac.update(&rollout(40, 0)).unwrap().temperature;
    assert!(temperature < 0.3, "{temperature}");
}
