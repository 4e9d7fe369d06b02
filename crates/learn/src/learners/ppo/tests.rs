use b2b_agent::network::Activation;

use super::config::{LogStd, PpoConfig};
use super::learner::Ppo;
use super::worker::{Minibatch, Worker};
use crate::learner::Learner as _;
use crate::nn::reference::{self, assert_gradients, wide};
use crate::policy::RecurrentPolicy;
use crate::random::RandomStream;
use crate::rollout::{End, Rollout};
use crate::state::State;
use crate::widths::Widths;

const WIDTHS: Widths = Widths { observation: 4, action: 2, parts: 2, nodes: 1 };

fn config(log_std: LogStd) -> PpoConfig {
    PpoConfig {
        actor_hidden: vec![12],
        critic_hidden: vec![10],
        batch_size: 32,
        epochs: 2,
        entropy_coefficient: 0.02,
        actor_gain: 0.5,
        log_std,
        credit: Some(vec![vec![1.0, 0.0], vec![0.3, 1.0]]),
        ..PpoConfig::default()
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
    Rollout {
        environments: 2,
        steps,
        observations: draw(2 * steps * 4),
        actions: draw(2 * steps * 2),
        rewards: draw(2 * steps * 2),
        next: draw(2 * 4),
        ends: vec![end(0, 5, draw(4)), end(1, steps - 1, draw(4))],
        ..Rollout::default()
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let run = |threads: usize| {
        let wide = PpoConfig { actor_hidden: vec![80, 80], batch_size: 150, ..config(LogStd::Free) };
        let mut ppo = Ppo::new(WIDTHS, wide, 3).unwrap();
        ppo.set_threads(threads);
        let update = (0..2).map(|seed| ppo.update(&rollout(150, seed)).unwrap()).last().unwrap();
        (ppo.state(), update)
    };
    let first = run(1);
    assert_eq!(first, run(1));
    assert_eq!(first, run(2));
    assert_eq!(first, run(4));
}

#[test]
fn a_restored_learner_continues_bit_for_bit() {
    for log_std in [LogStd::Free, LogStd::OfState] {
        let config = || PpoConfig { critic_epochs: 1, ..config(log_std) };
        let mut ppo = Ppo::new(WIDTHS, config(), 3).unwrap();
        ppo.update(&rollout(40, 0)).unwrap();
        let bytes = ppo.state().to_bytes();
        let mut restored = Ppo::new(WIDTHS, config(), 8).unwrap();
        restored.restore(&State::from_bytes(&bytes).unwrap()).unwrap();
        assert_eq!(ppo.update(&rollout(40, 1)).unwrap(), restored.update(&rollout(40, 1)).unwrap());
        assert_eq!(ppo.state(), restored.state());
        assert_eq!(ppo.actor(), restored.actor());
    }
}

#[test]
fn the_averaged_actor_has_the_running_average_of_the_parameters() {
    let mut ppo = Ppo::new(WIDTHS, PpoConfig { average_rate: 0.25, ..config(LogStd::Free) }, 3).unwrap();
    let mut expected = ppo.actor().parameters;
    assert_eq!(ppo.averaged_actor(), ppo.actor());
    // Updates have equal weights until one of them has a quarter.
    for (number, rate) in [1.0, 1.0 / 2.0, 1.0 / 3.0, 0.25, 0.25].into_iter().enumerate() {
        ppo.update(&rollout(40, number as u64)).unwrap();
        let (newest, average) = (ppo.actor().parameters, ppo.averaged_actor().parameters);
        expected.iter_mut().zip(&newest).for_each(|(mean, newest)| *mean += rate * (newest - *mean));
        assert!(average.iter().zip(&expected).all(|(average, mean)| (average - mean).abs() < 1e-6));
        assert_eq!(average != newest, number > 0);
    }
    let mut restored = Ppo::new(WIDTHS, config(LogStd::Free), 8).unwrap();
    restored.restore(&ppo.state()).unwrap();
    assert_eq!(restored.averaged_actor(), ppo.averaged_actor());
    // Without an average it is the actor, bit for bit.
    restored.update(&rollout(40, 9)).unwrap();
    assert_eq!(restored.averaged_actor(), restored.actor());
}

#[test]
fn further_passes_move_the_critic_only() {
    let run = |critic_epochs, updates: u64| {
        let mut ppo = Ppo::new(WIDTHS, PpoConfig { critic_epochs, ..config(LogStd::Free) }, 3).unwrap();
        let all: Vec<_> = (0..updates).map(|_| ppo.update(&rollout(40, 0)).unwrap()).collect();
        let critic = ppo.parameters[ppo.networks.critics()].to_vec();
        (ppo, critic, all)
    };
    let ((plain, plain_critic, _), (more, more_critic, _)) = (run(0, 1), run(6, 1));
    assert_eq!(plain.actor(), more.actor());
    assert!(plain_critic != more_critic);
    let explained = |critic_epochs| run(critic_epochs, 20).2.last().unwrap().explained_variance;
    assert!(explained(6) > explained(0) + 0.1, "{} {}", explained(6), explained(0));
}

#[test]
fn actors_that_learn_from_normalized_observations_take_them_as_they_are() {
    let normalizing = |log_std| PpoConfig { normalize_observations: true, ..config(log_std) };
    let all = [
        (Ppo::new(WIDTHS, normalizing(LogStd::Free), 3).unwrap(), rollout(40, 1)),
        (
            Ppo::recurrent(
                &RecurrentPolicy { width: WIDTH, sequence: 8, ..RecurrentPolicy::default() },
                WIDTHS,
                PpoConfig { n_steps: 40, ..normalizing(LogStd::OfState) },
                3,
            )
            .unwrap(),
            recurrent_rollout(40, 1),
        ),
    ];
    for (mut ppo, mut rollout) in all {
        // Slots far from 0, of very different deviations, and a constant.
        for row in rollout.observations.chunks_exact_mut(4) {
            [row[0], row[1], row[2]] = [0.42 + 0.01 * row[0], 3.0 * row[1] - 1.0, 0.7];
        }
        ppo.update(&rollout).unwrap();
        let mut normalized = rollout.observations.clone();
        ppo.features.normalize(&mut normalized);
        for slot in [0, 1, 3] {
            let values = || normalized.iter().skip(slot).step_by(4).map(|value| f64::from(*value));
            let mean = values().sum::<f64>() / 80.0;
            let square = values().map(|value| value * value).sum::<f64>() / 80.0;
            assert!(mean.abs() < 1e-3 && (square - 1.0).abs() < 1e-3, "slot {slot}: {mean} {square}");
        }
        assert!(normalized.iter().skip(2).step_by(4).all(|value| value.abs() < 1e-3));
        // The actor has the outputs of the learner's parameters for normalized observations.
        let (actor, own) = (ppo.actor(), ppo.networks.actor(&ppo.parameters));
        let mean = |actor: &b2b_agent::network::Actor, observation: &[f32]| {
            let mut mean = [0.0; 2];
            actor.mean(observation, &mut actor.scratch(None), &mut mean);
            mean
        };
        for (row, normalized) in rollout.observations.chunks_exact(4).zip(normalized.chunks_exact(4)) {
            let (folded, expected) = (mean(&actor, row), mean(&own, normalized));
            let near = folded.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-3);
            assert!(near, "{folded:?} {expected:?}");
        }
        // Statistics are part of the state.
        let state = State::from_bytes(&ppo.state().to_bytes()).unwrap();
        let mut restored = ppo.clone();
        restored.update(&rollout).unwrap();
        restored.restore(&state).unwrap();
        assert_eq!((restored.actor(), restored.averaged_actor()), (ppo.actor(), ppo.averaged_actor()));
    }
}

#[test]
fn a_credit_of_ones_is_ordinary_ppo() {
    let run = |credit| {
        let mut ppo = Ppo::new(WIDTHS, PpoConfig { credit, ..config(LogStd::Free) }, 3).unwrap();
        (ppo.update(&rollout(40, 0)).unwrap(), ppo.state())
    };
    assert_eq!(run(None), run(Some(vec![vec![1.0; 2]; 2])));
}

#[test]
fn steps_that_are_not_finite_change_nothing_and_are_an_error_after_three_updates() {
    let mut ppo = Ppo::new(WIDTHS, PpoConfig { batch_size: 1000, ..config(LogStd::Free) }, 3).unwrap();
    let mut broken = rollout(20, 0);
    broken.rewards[7] = f32::NAN;
    let before = ppo.parameters.clone();
    assert_eq!(ppo.update(&broken).unwrap().skipped, 2);
    assert_eq!(ppo.update(&broken).unwrap().steps, 0);
    assert_eq!(ppo.parameters, before);
    assert_eq!(ppo.update(&rollout(20, 0)).unwrap().skipped, 0);
    assert!(ppo.update(&broken).is_ok() && ppo.update(&broken).is_ok());
    assert!(matches!(ppo.update(&broken), Err(crate::Error::NotFinite { updates: 3 })));
}

#[test]
fn an_update_stops_at_its_target_divergence() {
    let config = PpoConfig { target_kl: Some(1e-4), learning_rate: 1e-2, ..config(LogStd::Free) };
    let update = Ppo::new(WIDTHS, config, 3).unwrap().update(&rollout(40, 0)).unwrap();
    assert!(update.epochs == 0 && update.steps >= 1, "{update:?}");
}

#[test]
fn a_rollout_of_other_widths_is_an_error() {
    let mut ppo = Ppo::new(WIDTHS, config(LogStd::Free), 3).unwrap();
    let mut short = rollout(20, 0);
    short.rewards.pop();
    assert!(matches!(
        ppo.update(&short),
        Err(crate::Error::Rollout { name: "rewards", length: 79, expected: 80 })
    ));
    let mut swapped = rollout(20, 0);
    swapped.ends.swap(0, 1);
    let said = ppo.update(&swapped).unwrap_err().to_string();
    assert!(said.starts_with("`ends` of the rollout has step 5 of environment 0,"), "{said}");
    let outside = Rollout { starts: vec![(0, 0), (1, 40)], ..recurrent_rollout(40, 0) };
    let said = recurrent(8, LogStd::Free, 3).update(&outside).unwrap_err().to_string();
    assert!(said.starts_with("`starts` of the rollout has step 40 of environment 1,"), "{said}");
}

const WIDTH: usize = 6;

/// Returns a learner of recurrent networks with sequences of this length.
fn recurrent(sequence: usize, log_std: LogStd, seed: u64) -> Ppo {
    let policy = RecurrentPolicy { width: WIDTH, sequence, ..RecurrentPolicy::default() };
    let config = PpoConfig { n_steps: 40, ..config(log_std) };
    Ppo::recurrent(&policy, WIDTHS, config, seed).unwrap()
}

/// Returns random steps of two environments. A recurrent actor forgets after the first one's first episode, and before
/// the second one's first step.
fn recurrent_rollout(steps: usize, seed: u64) -> Rollout {
    let mut states = vec![0.0; 2 * WIDTH];
    RandomStream::new(seed, 2).normals(&mut states);
    Rollout { states, starts: vec![(0, 6), (1, 0)], ..rollout(steps, seed) }
}

#[test]
fn sequences_have_the_densities_and_values_of_single_steps() {
    let rollout = recurrent_rollout(40, 0);
    let mut ppo = recurrent(8, LogStd::Free, 3);
    ppo.samples.read(&rollout, true);
    let values = ppo.evaluate(&rollout);
    let [actor, critic] = [&ppo.networks.actor, &ppo.networks.critic]
        .map(|shape| b2b_agent::network::Actor { shape: shape.clone(), ..ppo.actor() });
    let critic =
        b2b_agent::network::Actor { parameters: ppo.parameters[ppo.networks.critics()].to_vec(), ..critic };
    let log_std = &ppo.parameters[ppo.networks.log_stds()];
    let near = |one: f32, other: f32| (one - other).abs() < 1e-4 * (1.0 + other.abs());
    for environment in 0..2 {
        let (mut of_actor, mut of_critic) = (actor.scratch(None), critic.scratch(None));
        of_actor.state_mut().copy_from_slice(&rollout.states[environment * WIDTH..][..WIDTH]);
        let (mut mean, mut value) = ([0.0; 2], [0.0; 2]);
        for step in 0..40 {
            if rollout.starts.contains(&(environment, step)) {
                of_actor.state_mut().fill(0.0);
                of_critic.state_mut().fill(0.0);
            }
            let row = environment * 40 + step;
            let observation = &rollout.observations[row * 4..][..4];
            actor.mean(observation, &mut of_actor, &mut mean);
            critic.mean(observation, &mut of_critic, &mut value);
            let action = &rollout.actions[row * 2..][..2];
            for group in 0..ppo.groups {
                let density = super::loss::group_log_density(&ppo.credits[0], group, action, &mean, log_std);
                assert!(near(ppo.samples.old[row * ppo.groups + group], density), "row {row}");
            }
            assert!(near(values.steps[row * 2], value[0]) && near(values.steps[row * 2 + 1], value[1]));
            if let Some(number) =
                rollout.ends.iter().position(|end| (end.environment, end.step) == (environment, step))
            {
                critic.mean(&rollout.ends[number].observation, &mut of_critic.clone(), &mut value);
                assert!(near(values.ends[number * 2], value[0]), "end {number}");
            }
        }
        critic.mean(&rollout.next[environment * 4..][..4], &mut of_critic.clone(), &mut value);
        assert!(near(values.next[environment * 2], value[0]));
        let kept = &ppo.critic_states[environment * WIDTH..][..WIDTH];
        assert!(kept.iter().zip(of_critic.state()).all(|(kept, state)| near(*kept, *state)));
    }
}

#[test]
fn recurrent_networks_learn_the_same_bits_on_any_number_of_threads_and_after_a_restoration() {
    let long = |seed: u64| recurrent_rollout(160, seed);
    let new = |seed: u64| {
        let policy = RecurrentPolicy { width: WIDTH, sequence: 8, ..RecurrentPolicy::default() };
        let config = PpoConfig {
            actor_hidden: vec![80, 80],
            batch_size: 320,
            n_steps: 160,
            ..config(LogStd::OfState)
        };
        Ppo::recurrent(&policy, WIDTHS, config, seed).unwrap()
    };
    let learned = |threads: usize| {
        let mut ppo = new(3);
        ppo.set_threads(threads);
        ppo.update(&long(0)).unwrap();
        ppo
    };
    let mut first = learned(1);
    assert_eq!(first.state(), learned(3).state());
    let mut restored = new(8);
    restored.restore(&State::from_bytes(&first.state().to_bytes()).unwrap()).unwrap();
    let again = |ppo: &mut Ppo| (ppo.update(&long(1)).unwrap(), ppo.state());
    assert_eq!(again(&mut first), again(&mut restored));
}

#[test]
fn gradients_of_recurrent_networks_are_slopes_of_their_losses() {
    for log_std in [LogStd::Free, LogStd::OfState] {
        let mut ppo = recurrent(20, log_std, 3);
        ppo.prepare_for_test(&recurrent_rollout(40, 0));
        let mut worker = Worker::new(&ppo.networks);
        let mut losses = |parameters: &[f32]| {
            let batch = Minibatch {
                config: &ppo.config,
                networks: &ppo.networks,
                credits: &ppo.credits,
                groups: ppo.groups,
                parameters,
                samples: &ppo.samples,
                graphs: &[],
                rows: 80,
                critic_only: false,
            };
            worker.learn(&batch, 0..80);
            let losses = worker.losses;
            let loss = losses.policy - 0.02 * losses.entropy + 0.5 * losses.value;
            (loss, worker.gradients.clone())
        };
        let (_, gradients) = losses(&ppo.parameters);
        for seed in 0..8 {
            let mut direction = vec![0.0; gradients.len()];
            RandomStream::new(seed, 5).normals(&mut direction);
            let slope: f64 = gradients.iter().zip(&direction).map(|(g, d)| f64::from(g * d)).sum();
            let moved = |step: f32| -> Vec<f32> {
                ppo.parameters.iter().zip(&direction).map(|(value, d)| value + step * d).collect()
            };
            let difference = (losses(&moved(1e-3)).0 - losses(&moved(-1e-3)).0) / 2e-3;
            assert!((slope - difference).abs() < 0.01 + 0.02 * difference.abs(), "{slope} {difference}");
        }
    }
}

/// Returns the loss of a minibatch in double precision.
fn loss(batch: &Minibatch<'_>, parameters: &[f64]) -> f64 {
    let Minibatch { networks, credits, samples, config, .. } = batch;
    let credit = &credits[0];
    let mut sum = 0.0;
    for row in 0..batch.rows {
        let input = wide(&samples.observations[row * 4..][..4]);
        let outputs =
            reference::forward(networks.actor.mlp().unwrap(), &parameters[networks.actors()], &input);
        let log_stds = if networks.of_state() { &outputs[2..] } else { &parameters[networks.log_stds()] };
        let density = |action: usize| {
            let normal =
                (f64::from(samples.actions[row * 2 + action]) - outputs[action]) / log_stds[action].exp();
            -0.5 * normal * normal - log_stds[action] - 0.5 * std::f64::consts::TAU.ln()
        };
        for group in 0..credit.groups() {
            let at = row * credit.groups() + group;
            let ratio =
                (credit.actions(group, 2).map(density).sum::<f64>() - f64::from(samples.old[at])).exp();
            let advantage = f64::from(samples.advantages[at]);
            sum -= (advantage * ratio).min(advantage * ratio.clamp(0.8, 1.2));
        }
        sum -= f64::from(config.entropy_coefficient) * log_stds.iter().sum::<f64>();
        let values =
            reference::forward(networks.critic.mlp().unwrap(), &parameters[networks.critics()], &input);
        let errors =
            values.iter().zip(&samples.returns[row * 2..]).map(|(value, target)| value - f64::from(*target));
        sum += 0.5 * errors.map(|error| error * error).sum::<f64>() / 2.0;
    }
    sum / batch.rows as f64
}

#[test]
fn gradients_of_all_parameters_match_finite_differences() {
    for (log_std, activation) in [(LogStd::Free, Activation::Tanh), (LogStd::OfState, Activation::Relu)] {
        let config = PpoConfig { activation, ..config(log_std) };
        let mut ppo = Ppo::new(WIDTHS, config, 3).unwrap();
        ppo.prepare_for_test(&rollout(16, 0));
        let parameters = ppo.parameters.clone();
        let mut worker = Worker::new(&ppo.networks);
        let batch = Minibatch {
            config: &ppo.config,
            networks: &ppo.networks,
            credits: &ppo.credits,
            groups: ppo.groups,
            parameters: &parameters,
            samples: &ppo.samples,
            graphs: &[],
            rows: 32,
            critic_only: false,
        };
        worker.learn(&batch, 0..32);
        assert_gradients(&wide(&parameters), &worker.gradients, |parameters| loss(&batch, parameters));
    }
}

impl Ppo {
    /// Prepares the steps of a rollout as if the actor had changed since it was collected.
    pub(super) fn prepare_for_test(&mut self, rollout: &Rollout) {
        self.prepare(rollout);
        let mut random = RandomStream::new(1, 0);
        self.samples.old.iter_mut().for_each(|old| *old += 0.2 * random.normal() as f32);
    }
}
