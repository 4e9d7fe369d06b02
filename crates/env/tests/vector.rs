//! Environments in processes of their own, on the real engine.

mod common;

use std::sync::Arc;

use b2b_building::BuildingType;
use b2b_env::vector::{Launcher, Live, Pool, PoolOptions, Setting, Source, Start};
use common::{Case, Dice};

fn pool(case: &Case) -> Pool {
    let launcher = Launcher::new(env!("CARGO_BIN_EXE_b2b-worker"));
    Pool::new(PoolOptions::new(launcher, case.library.path())).unwrap()
}

fn setting(case: &Case, period: &str) -> Setting {
    Setting {
        source: Arc::new(Source::Prepared(Box::new((*case.building).clone()))),
        episode: case.env(period).episode().clone(),
    }
}

/// Observations and penalties of so many steps, or to the end, under random actions.
fn steps(pool: &mut Pool, live: &mut Live, dice: &mut Dice, steps: usize) -> Vec<f64> {
    let mut trace = Vec::new();
    let mut observation = vec![0.0; live.spaces().observation.len()];
    for _ in 0..steps {
        pool.send(live, dice.roll()).unwrap();
        pool.wait(std::slice::from_mut(live), 1).unwrap();
        assert_eq!(live.lost(), None);
        pool.observation(live, &mut observation);
        let reward = pool.reward(live);
        trace.extend_from_slice(&observation);
        trace.extend([reward.temperature_penalty, reward.energy_penalty]);
        if live.is_truncated() {
            break;
        }
    }
    trace
}

/// The same of an environment in this process.
fn fresh(case: &Case, period: &str, seed: u64) -> Vec<f64> {
    let mut env = case.env(period);
    let mut dice = Dice::new(env.action_space(), seed);
    let mut trace = Vec::new();
    env.reset().unwrap();
    loop {
        let step = env.step(dice.roll()).unwrap();
        trace.extend_from_slice(step.observation);
        trace.extend([step.reward.temperature_penalty, step.reward.energy_penalty]);
        if step.truncated {
            return trace;
        }
    }
}

fn bits(trace: &[f64]) -> Vec<u64> {
    trace.iter().map(|value| value.to_bits()).collect()
}

fn copies_continue_bit_for_bit(building_type: BuildingType) {
    let period = "01-10..01-12";
    let case = Case::at_home(building_type);
    let expected = fresh(&case, period, 1);
    let mut pool = pool(&case);
    let template = pool.prepare(&setting(&case, period)).unwrap();

    let mut live = pool.begin(template, Start::default()).unwrap();
    pool.wait(std::slice::from_mut(&mut live), 1).unwrap();
    let mut dice = Dice::new(&live.spaces().action.clone(), 1);
    let mut trace = steps(&mut pool, &mut live, &mut dice, 400);
    let mut snapshot = pool.snapshot(&live).unwrap();
    pool.wait(std::slice::from_mut(&mut snapshot), 1).unwrap();
    trace.extend(steps(&mut pool, &mut live, &mut dice, usize::MAX));
    assert!(bits(&trace) == bits(&expected), "an episode copied from a template differs");

    let mut again = pool.branch(&snapshot, 2).unwrap();
    pool.wait(&mut again, 2).unwrap();
    for live in &mut again {
        let mut dice = Dice::new(&live.spaces().action.clone(), 1);
        (0..400).for_each(|_| _ = dice.roll());
        let rest = steps(&mut pool, live, &mut dice, usize::MAX);
        assert!(bits(&rest) == bits(&expected[expected.len() - rest.len()..]), "a snapshot differs");
    }
}

#[test]
fn copies_of_the_small_office_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::OfficeSmall);
}
