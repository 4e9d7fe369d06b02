//! The reactive controllers follow targets that vary.

use std::sync::Arc;

use b2b_building::BuildingType;
use b2b_climate::{Place, Site};
use b2b_control::{Controller, Reactive, ReactiveParameters};
use b2b_dataset::{Preparation, archetype};
use b2b_energyplus::install::{Engine, Quiet};
use b2b_energyplus::{Level, Library};
use b2b_env::{Env, EpisodeConfig, Target, Task};

fn env(building_type: BuildingType, task: &str, period: &str) -> Env {
    let engine = Engine::ensure(&mut Quiet).unwrap();
    let library = Library::load(&engine.library).unwrap();
    let weather = Place::find(building_type.home()).unwrap().epw(&mut Quiet).unwrap();
    let model =
        archetype::base_model(building_type, &engine, &library, &Site::read(&weather).unwrap()).unwrap();
    let building = Preparation::new(building_type.name(), model).run(&weather, &library).unwrap();
    let task: Task = task.parse().unwrap();
    let episode = EpisodeConfig { weather, period: period.parse().unwrap(), steps_per_hour: 12, task };
    Env::new(library, Arc::new(building), episode).unwrap()
}

/// Runs an episode. Returns the largest deviation from target in each step, over the zones with heating and cooling
/// whose name starts with `name`.
fn deviations(env: &mut Env, name: &str) -> Vec<f64> {
    let (building, space) = (env.building(), env.observation_space());
    let mut controller = Reactive::new(building, space, 12, &ReactiveParameters::default());
    let zones = env.metrics().zones.iter().enumerate();
    let judged = zones
        .filter(|(_, zone)| zone.fully_conditioned && building.zones[zone.slot].name.starts_with(name))
        .map(|(index, zone)| (zone.slot, space.target(index)));
    let judged: Vec<(usize, Target)> = judged.collect();
    let mut action = vec![0.0; env.action_space().len()];
    let mut observation = env.reset().unwrap().to_vec();
    let mut worst = Vec::new();
    loop {
        controller.act(&observation, &mut action);
        let step = env.step(&action).unwrap();
        let deviation =
            |&(zone, target): &(usize, Target)| (step.observation[zone] - target.of(&observation)).abs();
        worst.push(judged.iter().map(deviation).fold(0.0, f64::max));
        observation.copy_from_slice(step.observation);
        if step.truncated {
            return worst;
        }
    }
}

/// Two winter and two summer days of each type: no severe message, no value out of bounds, no NaN.
fn every_type_follows(task: &str) {
    for building_type in BuildingType::ALL {
        for period in ["01-03..01-04", "07-04..07-05"] {
            let mut env = env(building_type, task, period);
            let worst = deviations(&mut env, "");
            let label = format!("{building_type} {task} {period}");
            assert_eq!(env.message_count(Level::Severe), 0, "{label}");
            assert_eq!(env.metrics().clamped_actions, 0, "{label}");
            // A target step of 8 K takes hours: the median shows the steady state.
            let mut sorted = worst.clone();
            sorted.sort_by(f64::total_cmp);
            let median = sorted[sorted.len() / 2];
            println!("{label}: median {median:.2} K, max {:.1} K", sorted[sorted.len() - 1]);
            assert!(median < 3.0, "{label}: {median}");
        }
    }
}

#[test]
fn targets_by_occupancy_are_followed() {
    every_type_follows("occupancy");
}

#[test]
fn random_targets_are_followed() {
    every_type_follows("random:5");
}

/// The core of the office is at its target during working hours; at night it is set back.
#[test]
fn a_small_office_is_at_its_target_during_working_hours() {
    let mut env = env(BuildingType::OfficeSmall, "occupancy", "01-03..01-05");
    let worst = deviations(&mut env, "Core");
    for day in 1..3 {
        let hours = &worst[day * 288 + 9 * 12..day * 288 + 17 * 12];
        assert!(hours.iter().all(|deviation| *deviation < 1.0), "{hours:.1?}");
    }
}
