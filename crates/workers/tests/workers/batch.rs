//! Batches of environments.

use b2b_building::BuildingType;
use b2b_env::{Environment, Error};
use b2b_workers::{AnyOf, Autoreset, Episode, VecEnv, VecEnvOptions, Windows, Workers, step_all};
use rustix::process::Signal;

use crate::case::{Case, Dice};
use crate::workers::{DAY, dice, options, setting, signal, started, vec_env, whole};

/// Random rows of actions of a batch, with one stream per environment.
fn roll(vec: &VecEnv, dice: &mut [Dice]) -> Vec<f64> {
    let width = vec.widths().0;
    let mut actions = vec![0.0; width * vec.len()];
    for (row, dice) in actions.chunks_exact_mut(width).zip(dice) {
        let action = dice.roll();
        row[..action.len()].copy_from_slice(action);
    }
    actions
}

#[test]
fn the_next_episode_begins_with_the_step_after_the_last_and_is_bit_identical() {
    const TYPES: [BuildingType; 2] = [BuildingType::SingleFamilyHouse, BuildingType::RestaurantFastFood];
    let cases = TYPES.map(Case::at_home);
    let mut envs = cases.each_ref().map(|case| case.env(DAY));
    let expected = envs.each_mut().map(|env| {
        let mut dice = dice(env.action_space());
        whole(env, &mut dice)
    });
    let settings = cases.iter().map(|case| setting(case, DAY)).collect();
    let mut vec = vec_env(&cases[0], settings, Autoreset::NextStep);
    vec.reset(0).unwrap();
    let width = vec.widths().1;
    for episode in 0..2 {
        if episode > 0 {
            vec.step(&vec![f64::NAN; vec.widths().0 * vec.len()]).unwrap();
            assert_eq!(vec.truncated(), [false; 2]);
        }
        let mut dice: Vec<Dice> = envs.iter().map(|env| dice(env.action_space())).collect();
        let mut traces = envs.each_ref().map(|_| Vec::new());
        for _ in 0..288 {
            let actions = roll(&vec, &mut dice);
            vec.step(&actions).unwrap();
            for (index, (env, trace)) in envs.iter().zip(&mut traces).enumerate() {
                let row = &vec.observations()[index * width..][..width];
                let (observation, padding) = row.split_at(env.observation_space().len());
                assert!(padding.iter().all(|value| *value == 0.0));
                let reward = vec.rewards()[index];
                let penalties = [reward.temperature_penalty, reward.energy_penalty];
                trace.extend(observation.iter().chain(&penalties).map(|value| value.to_bits()));
            }
        }
        assert_eq!(vec.truncated(), [true; 2]);
        for (index, env) in envs.iter().enumerate() {
            assert!(traces[index] == expected[index], "{:?} in episode {episode}", TYPES[index]);
            assert_eq!(vec.final_metrics(index), Some(env.metrics()));
        }
    }
}

#[test]
fn the_next_episode_may_begin_within_the_last_step() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut vec = vec_env(&case, vec![setting(&case, DAY)], Autoreset::SameStep);
    vec.reset(0).unwrap();
    let first = vec.observations().to_vec();
    let mut dice = [dice(&vec.spaces(0).unwrap().action)];
    for _ in 0..288 {
        let actions = roll(&vec, &mut dice);
        vec.step(&actions).unwrap();
    }
    assert_eq!(vec.truncated(), [true]);
    assert_eq!(vec.observations(), first);
    assert_ne!(vec.final_observation(0), first);
    assert_eq!(vec.final_metrics(0).unwrap().steps, 288);
    let actions = roll(&vec, &mut dice);
    vec.step(&actions).unwrap();
    assert_eq!(vec.truncated(), [false]);
}

/// Bits of some steps of mixed buildings in random windows.
fn mixed(seed: u64, steps: usize) -> Vec<u64> {
    let cases = [BuildingType::SingleFamilyHouse, BuildingType::RestaurantFastFood].map(Case::at_home);
    let settings = cases.iter().map(|case| setting(case, "01-10..01-20")).collect();
    let sampler = Windows { of: AnyOf(settings), days: (1, 2), starts: 2 };
    let options =
        VecEnvOptions { workers: options(&cases[0]), autoreset: Autoreset::NextStep, widths: Some((8, 16)) };
    let mut vec = VecEnv::new(3, Box::new(sampler), options).unwrap();
    vec.reset(seed).unwrap();
    let mut trace: Vec<u64> = Vec::new();
    for _ in 0..steps {
        let middle = |index| {
            let space = &vec.spaces(index).unwrap().action;
            let mut row: Vec<f64> =
                space.low().iter().zip(space.high()).map(|(l, h)| 0.5 * (l + h)).collect();
            row.resize(8, 0.0);
            row
        };
        let actions: Vec<f64> = (0..3).flat_map(middle).collect();
        vec.step(&actions).unwrap();
        trace.extend(vec.observations().iter().map(|value| value.to_bits()));
    }
    trace
}

#[test]
fn draws_depend_only_on_the_seed() {
    let first = mixed(3, 600);
    assert!(first == mixed(3, 600));
    let other = mixed(4, 10);
    assert!(first[..other.len()] != other);
}

#[test]
fn ready_environments_are_received_while_another_is_stopped() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut vec = vec_env(&case, vec![setting(&case, DAY); 3], Autoreset::NextStep);
    vec.reset(0).unwrap();
    let action = vec.spaces(0).unwrap().action.low().to_vec();
    signal(vec.process(1).unwrap(), Signal::STOP);
    (0..3).for_each(|index| vec.send(index, &action).unwrap());
    let mut back = Vec::new();
    vec.recv(2, &mut back).unwrap();
    assert_eq!(back, [0, 2]);
    assert!(vec.send(1, &action).unwrap_err().to_string().contains("still in progress"));
    signal(vec.process(1).unwrap(), Signal::CONT);
    vec.recv(1, &mut back).unwrap();
    assert_eq!(back, [1]);
}

#[test]
fn a_nan_action_is_rejected_before_any_environment_steps() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut vec = vec_env(&case, vec![setting(&case, DAY); 2], Autoreset::NextStep);
    vec.reset(0).unwrap();
    let width = vec.widths().0;
    let mut actions = [vec.spaces(0).unwrap().action.low(), vec.spaces(1).unwrap().action.low()].concat();
    actions[width] = f64::NAN;
    assert!(matches!(vec.step(&actions), Err(Error::ActionNotFinite { .. })));
    assert!(matches!(vec.step(&actions[1..]), Err(Error::ActionLength { .. })));
    actions[width] = 0.0;
    vec.step(&actions).unwrap();
}

#[test]
fn a_step_before_the_first_reset_is_an_error() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut vec = vec_env(&case, vec![setting(&case, DAY); 2], Autoreset::NextStep);
    assert!(matches!(vec.step(&[]), Err(Error::NotReset)));
    assert!(matches!(vec.step(&[0.1, 20.0]), Err(Error::NotReset)));
}

#[test]
fn all_actions_are_checked_before_any_episode_steps() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let mut episodes: Vec<Episode> = (0..2).map(|_| started(&workers, &setting(&case, DAY))).collect();
    let low = episodes[0].spaces().action.low().to_vec();
    let actions = [low.clone(), low].concat();
    let mut wrong = actions.clone();
    *wrong.last_mut().unwrap() = f64::NAN;
    assert!(matches!(step_all(&mut episodes, &wrong), Err(Error::ActionNotFinite { .. })));
    let surplus = [&actions[..], &[0.0]].concat();
    for wrong in [&surplus[..], &actions[1..]] {
        assert!(matches!(step_all(&mut episodes, wrong), Err(Error::ActionLength { .. })));
    }
    assert!(episodes.iter().all(|episode| !episode.is_busy()));
    step_all(&mut episodes, &actions).unwrap();
}
