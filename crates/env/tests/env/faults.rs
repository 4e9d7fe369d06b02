//! Faults on the engine: sensors err without changing the reward, and faulty equipment does not follow.

use std::sync::Arc;

use crate::case::{Case, random_episode, random_episode_from};
use b2b_building::hvac::Quantity;
use b2b_building::{BuildingType, Conditioning};
use b2b_env::{Env, Faults, Task, Trajectory};

const DAY: &str = "01-03..01-03";

fn office() -> Case {
    Case::at_home(BuildingType::OfficeSmall)
}

#[test]
fn sensors_have_the_given_noise_and_bias_and_rewards_do_not() {
    let office = office();
    let sound = random_episode(&mut office.env_for(DAY, "constant"), 3);
    let mut env = office.env_for(DAY, "constant+noise0.2");
    let noisy = random_episode(&mut env, 3);
    assert_eq!(noisy.penalties, sound.penalties);
    let (width, zones) = (env.observation().len(), env.building().zones.len());
    let errors = |trajectory: &Trajectory| -> Vec<Vec<f64>> {
        let rows = trajectory.observations.chunks_exact(width).zip(sound.observations.chunks_exact(width));
        rows.map(|(noisy, sound)| {
            assert_eq!(noisy[zones..], sound[zones..], "only zone temperatures have errors");
            (0..zones).map(|zone| noisy[zone] - sound[zone]).collect()
        })
        .collect()
    };
    let all = errors(&noisy).concat();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let deviation = (all.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / all.len() as f64).sqrt();
    assert!(mean.abs() < 0.02 && (deviation - 0.2).abs() < 0.01, "{mean} {deviation}");

    let biased = errors(&random_episode(&mut office.env_for(DAY, "constant+bias0.5"), 3));
    for zone in 0..zones {
        let first = biased[0][zone];
        assert!(first != 0.0 && biased.iter().all(|row| (row[zone] - first).abs() < 1e-9));
    }
}

#[test]
fn observations_without_sensor_errors_have_the_true_temperatures() {
    let office = office();
    let episode = |env: &mut Env| {
        let (first, trajectory) = random_episode_from(env, 3);
        [first, trajectory.observations].concat()
    };
    let truth = episode(&mut office.env_for(DAY, "constant"));
    let mut faulty = office.env_for(DAY, "constant+noise0.2+bias0.5");
    let mut observed = episode(&mut faulty);
    faulty.spaces().remove_sensor_errors(observed.chunks_exact_mut(faulty.observation().len()));
    let farthest = truth.iter().zip(&observed).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(farthest < 1e-9, "{farthest}");
}

/// EnergyPlus's thermostats know the true temperature.
#[test]
fn thermostats_hold_what_their_sensors_read() {
    let office = Case::under_setpoints(BuildingType::OfficeSmall);
    let zones = office.building.zones.len();
    let mut env = office.env_for(DAY, "constant+bias2");
    let setpoint = |quantity: &Quantity| if *quantity == Quantity::HeatingSetpoint { 20.0 } else { 28.0 };
    let action: Vec<f64> = env.action_space().quantities().iter().map(setpoint).collect();
    env.reset().unwrap();
    // Means of the evening.
    let mut observed = vec![0.0; zones];
    for step in 0..288 {
        let observation = env.step(&action).unwrap().observation;
        let of_evening = if step >= 216 { 1.0 / 72.0 } else { 0.0 };
        observed.iter_mut().zip(observation).for_each(|(mean, now)| *mean += of_evening * now);
    }
    let mut truth = observed.clone();
    env.spaces().remove_sensor_errors(std::iter::once(&mut truth[..]));
    let heated =
        office.building.zones.iter().enumerate().filter(|(_, zone)| zone.conditioning != Conditioning::None);
    let heated: Vec<[f64; 2]> = heated.map(|(zone, _)| [observed[zone], truth[zone]]).collect();
    // None reads less than its setpoint, also where the sensor reads 1 K too little or less.
    assert!(heated.iter().all(|[observed, _]| *observed > 19.7), "{heated:?}");
    assert!(heated.iter().any(|[observed, truth]| *observed < 20.2 && *truth > 21.0), "{heated:?}");
}

#[test]
fn equal_tasks_have_equal_faults_and_seeds_differ() {
    let office = office();
    let task = |seed| {
        let faults = Faults { seed, own: false, noise: 0.1, bias: 0.3, stuck: 0.3, fouling: 0.2 };
        Task { faults, ..Task::default() }
    };
    let mut env = office.env_with(DAY, task(1));
    let first = random_episode(&mut env, 3).hash();
    assert_eq!(random_episode(&mut env, 3).hash(), first, "after a reset");
    let run = |seed| random_episode(&mut office.env_with(DAY, task(seed)), 3).hash();
    assert_eq!(run(1), first);
    assert_ne!(run(2), first);
}

#[test]
fn own_faults_follow_the_building_s_name() {
    let mut house = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut run = |name: &str, task: &str| {
        Arc::make_mut(&mut house.building).name = name.into();
        random_episode(&mut house.env_for(DAY, task), 3).hash()
    };
    let (own, same) = ("constant+bias0.5+fouling0.5+own-faults", "constant+bias0.5+fouling0.5");
    let [first, second] = ["SingleFamilyHouse-0001", "SingleFamilyHouse-0002"].map(|name| run(name, own));
    assert_ne!(first, second);
    assert_eq!(run("SingleFamilyHouse-0001", own), first, "in every episode");
    assert_eq!(run("SingleFamilyHouse-0001", same), run("SingleFamilyHouse-0002", same));
}

#[test]
fn stuck_actuators_do_not_move_and_fouled_coils_lose_range() {
    let office = office();
    let mut env = office.env_for(DAY, "constant+stuck1");
    let stuck = random_episode(&mut env, 3);
    let actuators = env.action_space().len();
    assert!(stuck.actions.chunks_exact(actuators).all(|action| action == &stuck.actions[..actuators]));

    let mut env = office.env_for(DAY, "constant+fouling0.5");
    let fouled = random_episode(&mut env, 3);
    for (index, actuator) in env.building().actuators().enumerate() {
        let values = fouled.actions.chunks_exact(actuators).map(|action| action[index]);
        let (low, high) =
            values.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
        let half = |bound: f64| 20.0 + 0.5 * (bound - 20.0);
        match actuator.quantity {
            Quantity::SupplyAirTemperature => {
                assert!(low >= half(actuator.low) && high <= half(actuator.high), "{low} {high}");
                assert!(high - low > 0.4 * (actuator.high - actuator.low), "{low} {high}");
            }
            _ => assert!(high - low > 0.8 * (actuator.high - actuator.low), "{low} {high}"),
        }
    }
}
