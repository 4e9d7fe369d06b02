//! Properties of every episode: clock, length, reproducibility and rejected actions.

use crate::case::{Case, Dice, random_episode};
use b2b_building::{BuildingType, PreparedBuilding};
use b2b_energyplus::Level;
use b2b_env::{Env, Error, Task, Trajectory};

fn house() -> Case {
    Case::at_home(BuildingType::SingleFamilyHouse)
}

fn slot(env: &Env, name: &str) -> usize {
    env.observation_space().slots().iter().position(|slot| slot.name == name).unwrap()
}

/// Ten days that begin on a Saturday and cross into another month.
const ACROSS_MONTHS: &str = "02-25..03-06";

#[test]
fn the_clock_of_the_observation_is_the_engine_s() {
    let mut env = house().env(ACROSS_MONTHS);
    let slots = ["time of day", "day of week", "day of year"].map(|name| slot(&env, name));
    let mut dice = Dice::new(env.action_space(), 3);
    let start = env.reset().unwrap();
    assert_eq!(slots.map(|slot| start[slot]), [0.0, 5.0, 56.0], "midnight of Saturday, 25 February");
    let mut before = 0.0;
    for done in 1..env.episode_steps() {
        let step = env.step(dice.roll()).unwrap();
        let [hour, weekday, day] = slots.map(|slot| step.observation[slot]);
        let engine = env.engine_clock().unwrap();
        let engine_hours = (f64::from(engine.day_of_year) - 1.0) * 24.0 + engine.hour_of_day;
        assert!(((day - 1.0) * 24.0 + hour - engine_hours).abs() < 1e-6, "step {done}: {engine:?}");
        // The engine reports the day of the step; at midnight, the observation is already in the next day.
        let engine_weekday = (f64::from(engine.day_of_week) + 5.0) % 7.0;
        assert_eq!(weekday, if hour == 0.0 { (engine_weekday + 1.0) % 7.0 } else { engine_weekday });
        assert!(engine_hours > before, "the clock goes forward");
        before = engine_hours;
    }
}

#[test]
fn an_episode_has_the_steps_of_its_days() {
    let case = house();
    let mut env = case.env(ACROSS_MONTHS);
    assert_eq!(env.episode_steps(), 10 * 288);
    assert_eq!(random_episode(&mut env, 4).len(), 10 * 288);
    assert_eq!(env.metrics().steps, 10 * 288);
}

#[test]
fn the_same_inputs_give_the_same_bits_alone_after_and_beside_another_episode() {
    let (house, warehouse) = (house(), Case::at_home(BuildingType::Warehouse));
    let mut env = house.env("01-20..01-22");
    let alone = random_episode(&mut env, 5).hash();
    assert_ne!(random_episode(&mut env, 6).hash(), alone, "other actions, other episode");
    assert_eq!(random_episode(&mut env, 5).hash(), alone, "the same environment again");
    let mut other = warehouse.env("07-20..07-22");
    let other_alone = random_episode(&mut other, 7).hash();
    assert_eq!(random_episode(&mut house.env("01-20..01-22"), 5).hash(), alone, "after another building");
    assert_eq!(interleaved([(&mut env, 5), (&mut other, 7)]), [alone, other_alone]);
}

/// Two episodes of the same length, a step of each in turn.
fn interleaved(envs: [(&mut Env, u64); 2]) -> [String; 2] {
    let mut running = envs.map(|(env, seed)| {
        env.reset().unwrap();
        let dice = Dice::new(env.action_space(), seed);
        let trajectory = Trajectory::for_episode(env.spaces());
        (env, dice, trajectory)
    });
    let mut truncated = false;
    while !truncated {
        for (env, dice, trajectory) in &mut running {
            let step = env.step(dice.roll()).unwrap();
            trajectory.push(&step);
            truncated = step.truncated;
        }
    }
    running.map(|(_, _, trajectory)| trajectory.hash())
}

#[test]
fn an_episode_is_not_changed_by_a_rejected_action() {
    let case = house();
    let mut env = case.env("01-20..01-20");
    let expected = random_episode(&mut env, 8).hash();
    let mut dice = Dice::new(env.action_space(), 8);
    let mut trajectory = Trajectory::for_episode(env.spaces());
    env.reset().unwrap();
    for done in 0..env.episode_steps() {
        if done % 50 == 7 {
            let refused = env.step(&[0.1, f64::NAN]).unwrap_err();
            assert!(matches!(refused, Error::ActionNotFinite { .. }), "{refused}");
            let refused = env.step(&[0.1, 20.0, 0.0]).unwrap_err();
            assert!(matches!(refused, Error::ActionLength { given: 3, expected: 2 }), "{refused}");
            assert_eq!(env.metrics().steps, done, "nothing was done");
        }
        trajectory.push(&env.step(dice.roll()).unwrap());
    }
    assert_eq!(trajectory.hash(), expected);
}

#[test]
fn an_action_out_of_bounds_is_clamped_and_counted() {
    let mut env = house().env("01-20..01-20");
    let (low, high) = (env.action_space().low().to_vec(), env.action_space().high().to_vec());
    env.reset().unwrap();
    assert_eq!(env.step(&[-1.0, -1e300]).unwrap().action, low);
    assert_eq!(env.step(&[1e300, 1e3]).unwrap().action, high);
    assert_eq!(env.step(&high).unwrap().action, high);
    assert_eq!(env.metrics().clamped_actions, 4);
}

#[test]
fn a_step_outside_an_episode_is_an_error() {
    let mut env = house().env("01-20..01-20");
    assert!(matches!(env.step(&[0.1, 20.0]), Err(Error::NotReset)), "before reset");
    random_episode(&mut env, 9);
    assert!(matches!(env.step(&[0.1, 20.0]), Err(Error::NotReset)), "after the end");
    assert!(env.engine_clock().is_none());
    random_episode(&mut env, 9);
}

#[test]
fn a_failed_step_has_the_messages_of_its_episode() {
    let mut case = Case::at_home(BuildingType::OfficeMedium);
    // A heating setpoint above the cooling setpoint ends the engine's run.
    let text = serde_json::to_string(&*case.building).unwrap().replace("\"high\":30.0", "\"high\":95.0");
    case.building = serde_json::from_str::<PreparedBuilding>(&text).unwrap().into();
    let mut env = case.env("01-20..01-20");
    let highest = env.action_space().high().to_vec();
    let names_the_cause = |env: &Env| {
        let messages = env.messages();
        messages.at_least(Level::Severe).any(|message| message.text.contains("DualSetPointWithDeadBand"))
    };
    env.reset().unwrap();
    assert!((0..2).any(|_| env.step(&highest).is_err()));
    assert!(names_the_cause(&env), "{:?}", env.messages());
    env.reset().unwrap();
    assert!(!names_the_cause(&env));
}

#[test]
fn the_error_for_a_missing_weather_file_names_it() {
    let mut case = house();
    case.weather = "no such weather.epw".into();
    let error = case.try_env("01-20..01-20", Task::default()).unwrap_err().to_string();
    assert!(error.contains("no such weather.epw"), "{error}");
}

#[test]
fn an_episode_returns_to_a_snapshot() {
    let mut env = house().env("01-10..01-11").keep_history();
    let mut dice = Dice::new(env.action_space(), 5);
    assert_eq!(env.snapshot(), None);
    env.reset().unwrap();
    let mut play = |env: &mut Env, steps: usize| -> Vec<f64> {
        (0..steps).flat_map(|_| env.step(dice.roll()).unwrap().observation.to_vec()).collect()
    };
    play(&mut env, 200);
    let (snapshot, metrics) = (env.snapshot().unwrap(), env.metrics().clone());
    let actions: Vec<Vec<f64>> = (0..100).map(|_| Dice::new(env.action_space(), 9).roll().to_vec()).collect();
    let follow = |env: &mut Env| -> Vec<f64> {
        actions.iter().flat_map(|action| env.step(action).unwrap().observation.to_vec()).collect()
    };
    let first = follow(&mut env);
    env.restore(&snapshot).unwrap();
    assert_eq!(env.metrics(), &metrics);
    assert_eq!(follow(&mut env), first);
    let mut other = house().env("01-10..01-12").keep_history();
    let said = other.restore(&snapshot).unwrap_err().to_string();
    assert!(said.contains("SingleFamilyHouse"), "{said}");
}

#[test]
fn the_engine_s_output_is_kept_and_changes_no_result() {
    let (house, kept) = (house(), tempfile::tempdir().unwrap());
    let without = random_episode(&mut house.env("01-20..01-21"), 8).hash();
    let folder = kept.path().join("output/of the engine");
    let mut env = house.env("01-20..01-21").keep_engine_output(&folder).unwrap();
    assert_eq!(random_episode(&mut env, 8).hash(), without);
    let meters = env.engine_meters().unwrap();
    drop(env);
    for file in [
        "model.epJSON",
        "eplusout.err",
        "eplusout.eio",
        "eplusout.mtr",
        "eplusout.sql",
        "eplusout.rdd",
        "eplustbl.htm",
    ] {
        let length = folder.join(file).metadata().unwrap_or_else(|error| panic!("{file}: {error}")).len();
        assert!(length > 0, "{file} is empty");
    }
    let series = std::fs::read_to_string(folder.join("eplusout.eso")).unwrap();
    assert!(series.contains("Zone Mean Air Temperature [C] !TimeStep"));
    assert!(meters[0] > 0.0, "{meters:?}");

    let file = kept.path().join("file");
    std::fs::write(&file, "").unwrap();
    let error = house.env("01-20..01-21").keep_engine_output(&file.join("below")).unwrap_err();
    assert!(error.to_string().contains("file/below"), "{error}");
}
