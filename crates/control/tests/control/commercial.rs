//! Generated commercial buildings in EnergyPlus: the reactive controllers hold them in every climate and at the bounds
//! of the parameters.

use std::sync::Arc;

use b2b_building::{BuildingType, Conditioning, Model, PreparedBuilding, RunPeriod};
use b2b_climate::{Place, Site};
use b2b_control::{Controller, Reactive, ReactiveParameters};
use b2b_dataset::commercial::{CommercialParameters, generate};
use b2b_dataset::{Preparation, archetype};
use b2b_energyplus::install::{Engine, Quiet};
use b2b_energyplus::{Level, Library};
use b2b_env::{Env, EpisodeConfig, Task};

const STEPS_PER_HOUR: u32 = 12;
/// Climate zones 1A, 5B and 8, at bounds of the parameters: 0 is the smallest and tightest building, 1 the largest and
/// leakiest.
const CASES: [(&str, f64); 5] =
    [("Miami", 0.0), ("Miami", 1.0), ("Denver", 1.0), ("Fairbanks", 0.0), ("Fairbanks", 1.0)];
const PERIODS: [&str; 2] = ["01-08..01-09", "07-08..07-09"];
/// Lowest temperature of any zone with heating, °C.
const COLDEST: f64 = 12.0;
/// Highest temperature of any zone with cooling, °C.
const WARMEST: f64 = 32.0;

fn site(place: &Place) -> Site {
    Site::read(&place.epw(&mut Quiet).unwrap()).unwrap()
}

fn every_climate_is_held(building_type: BuildingType) {
    let engine = Engine::ensure(&mut Quiet).unwrap();
    let library = Library::load(&engine.library).unwrap();
    let home = site(Place::find("Denver").unwrap());
    let base = archetype::base_model(building_type, &engine, &library, &home).unwrap();
    for (place, corner) in CASES {
        let place = Place::find(place).unwrap();
        let building = building(&base, building_type, place, corner, &library);
        for period in PERIODS {
            let label = format!("{building_type} in {} at {corner}, {period}", place.name);
            is_held(&building, place, period, &library, &label);
        }
    }
}

fn building(
    base: &Model,
    building_type: BuildingType,
    place: &Place,
    corner: f64,
    library: &Library,
) -> Arc<PreparedBuilding> {
    let parameters = CommercialParameters::from_unit([corner; 9], building_type, place.ashrae_zone).unwrap();
    let model = generate(base, building_type, place, &site(place), &parameters).unwrap();
    let weather = place.epw(&mut Quiet).unwrap();
    Arc::new(Preparation::new(building_type.name(), model).run(&weather, library).unwrap())
}

fn is_held(building: &Arc<PreparedBuilding>, place: &Place, period: &str, library: &Library, label: &str) {
    let period: RunPeriod = period.parse().unwrap();
    let weather = place.epw(&mut Quiet).unwrap();
    let episode = EpisodeConfig { weather, period, steps_per_hour: STEPS_PER_HOUR, task: Task::default() };
    let mut env = Env::new(library.clone(), building.clone(), episode).unwrap();
    let mut controller =
        Reactive::new(building, env.observation_space(), STEPS_PER_HOUR, &ReactiveParameters::default());
    let mut observation = env.reset().unwrap().to_vec();
    let mut action = vec![0.0; env.action_space().len()];
    loop {
        controller.act(&observation, &mut action);
        let step = env.step(&action).unwrap();
        observation.copy_from_slice(step.observation);
        let truncated = step.truncated;
        for (zone, temperature) in building.zones.iter().zip(&observation) {
            let heated = zone.conditioning != Conditioning::None;
            let cooled = zone.conditioning == Conditioning::HeatingAndCooling;
            assert!(!heated || *temperature > COLDEST, "{label}: {} is at {temperature}", zone.name);
            assert!(!cooled || *temperature < WARMEST, "{label}: {} is at {temperature}", zone.name);
        }
        if truncated {
            break;
        }
    }
    assert_eq!(env.message_count(Level::Severe), 0, "{label}");
}

#[test]
fn small_offices_are_held_in_every_climate() {
    every_climate_is_held(BuildingType::OfficeSmall);
}

#[test]
fn medium_offices_are_held_in_every_climate() {
    every_climate_is_held(BuildingType::OfficeMedium);
}

#[test]
fn shops_are_held_in_every_climate() {
    every_climate_is_held(BuildingType::RetailStandalone);
}

#[test]
fn restaurants_are_held_in_every_climate() {
    every_climate_is_held(BuildingType::RestaurantFastFood);
}

#[test]
fn warehouses_are_held_in_every_climate() {
    every_climate_is_held(BuildingType::Warehouse);
}
