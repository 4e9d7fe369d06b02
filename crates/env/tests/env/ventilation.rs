//! The ventilation interlock on the engine: people get the design minimum of outdoor air even under the lowest action.

use crate::case::Case;
use crate::models::office;
use b2b_building::BuildingType;
use b2b_env::Env;

/// Tolerated relative difference, because the engine's density of standard air differs from ours.
const TOLERANCE: f64 = 1e-4;

/// People and outdoor air of a system at the end of a step.
struct Air {
    people: f64,
    flow: f64,
    minimum: f64,
}

/// Runs some days with every actuator at its lower bound. Returns the people and outdoor air of each system, step by
/// step.
fn starve(case: &Case, task: &str, days: &str) -> (Vec<Vec<Air>>, Env) {
    let mut env = case.env_for(days, task);
    env.reset().unwrap();
    let lowest = env.action_space().low().to_vec();
    let mut steps = Vec::new();
    loop {
        let truncated = env.step(&lowest).unwrap().truncated;
        steps.push(airs(&env));
        if truncated {
            return (steps, env);
        }
    }
}

fn airs(env: &Env) -> Vec<Air> {
    let minimum = env.building().systems.iter().map(|system| system.ventilation());
    let systems = minimum.zip(env.outdoor_air());
    systems
        .filter_map(|(ventilation, air)| {
            let (ventilation, [flow, people]) = (ventilation?, air?);
            Some(Air { people, flow, minimum: ventilation.min_outdoor_air })
        })
        .collect()
}

/// Asserts that outdoor air is at least the design minimum from the second occupied step on, and that the interlock
/// does not act at every step.
fn people_get_their_outdoor_air(building_type: BuildingType, place: &str) {
    let per_person = people_of_a_case_get_their_outdoor_air(&Case::at(building_type, place));
    eprintln!("{building_type} in {place}: {per_person:.1} L/s per person");
}

/// Asserts the same for a case. Returns the outdoor air with the interlock, L/s per person.
fn people_of_a_case_get_their_outdoor_air(case: &Case) -> f64 {
    let (steps, env) = starve(case, "constant", "01-13..01-13");
    let mut occupied = 0;
    for pair in steps.windows(2) {
        for (before, now) in pair[0].iter().zip(&pair[1]) {
            if before.people > 0.0 {
                occupied += 1;
                let minimum = now.minimum * (1.0 - TOLERANCE);
                assert!(now.flow >= minimum, "{} kg/s of outdoor air; minimum {}", now.flow, now.minimum);
            }
        }
    }
    assert!(occupied > 50, "{occupied} occupied steps");
    let metrics = env.metrics();
    assert!(metrics.ventilation_overrides > 50 && metrics.ventilation_overrides < metrics.steps);
    let per_person = metrics.outdoor_air_per_person();
    let (free, free_env) = starve(case, "constant+free-ventilation", "01-13..01-13");
    assert_eq!(free_env.metrics().ventilation_overrides, 0);
    let starved = |steps: &[Vec<Air>]| {
        steps.iter().flatten().any(|air| air.people > 0.0 && air.flow < 0.1 * air.minimum)
    };
    assert!(starved(&free), "without the interlock the same commands bring no outdoor air");
    assert!(per_person > free_env.metrics().outdoor_air_per_person());
    per_person
}

#[test]
fn people_in_an_office_of_terminals_without_reheat_get_their_outdoor_air() {
    people_of_a_case_get_their_outdoor_air(&office::with_bare_terminals());
}

#[test]
fn people_in_the_small_office_get_their_outdoor_air() {
    people_get_their_outdoor_air(BuildingType::OfficeSmall, "Fairbanks");
}

#[test]
fn people_in_the_medium_office_get_their_outdoor_air() {
    people_get_their_outdoor_air(BuildingType::OfficeMedium, "Denver");
}

#[test]
fn people_in_the_shop_get_their_outdoor_air() {
    people_get_their_outdoor_air(BuildingType::RetailStandalone, "Denver");
}

#[test]
fn people_in_the_restaurant_get_their_outdoor_air() {
    people_get_their_outdoor_air(BuildingType::RestaurantFastFood, "Denver");
}

#[test]
fn people_in_the_warehouse_get_their_outdoor_air() {
    people_get_their_outdoor_air(BuildingType::Warehouse, "Denver");
}
