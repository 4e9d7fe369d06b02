//! Energy equals the engine's meters and is counted once.

use crate::case::{Case, random_episode};
use b2b_building::BuildingType;
use b2b_env::Term;

fn energy_is_the_engine_s_own(building_type: BuildingType) {
    let case = Case::at_home(building_type);
    for period in ["01-08..01-09", "07-09..07-10"] {
        let mut env = case.env(period);
        let low = env.action_space().low().to_vec();
        env.reset().unwrap();
        env.step(&low).unwrap();
        assert!(env.engine_meters().is_err(), "the engine has not written them yet");
        let trajectory = random_episode(&mut env, 2);
        let space = env.observation_space();
        let sum = |slot: usize| -> f64 {
            trajectory.observations.chunks_exact(space.len()).map(|row| row[slot]).sum()
        };
        let reported = [space.electricity(), space.gas()].map(sum);
        let engine = env.engine_meters().unwrap();
        for (reported, engine) in reported.iter().zip(engine) {
            let error = (reported - engine).abs() / engine.max(1.0);
            assert!(error < 1e-6, "{building_type} {period}: {reported} Wh/m², the engine says {engine}");
        }
        let sum: f64 = Term::END_USES.into_iter().map(|term| env.metrics().total(term)).sum();
        let energy = env.metrics().total(Term::Energy);
        match building_type {
            // The meter has the losses of the building's transformer, which also feeds lights and plugs.
            BuildingType::OfficeMedium => {
                let hours = env.metrics().steps as f64 / 12.0;
                let losses = (energy - sum) / hours;
                assert!((0.03..0.3).contains(&losses), "{period}: {losses} W/m² are in no end use");
            }
            _ => assert!(
                (energy - sum).abs() < 1e-6 * energy,
                "{building_type} {period}: {energy} Wh/m², and {sum} in end uses"
            ),
        }
        assert!(reported[0] > 0.0, "{building_type}: fans take electricity");
        assert!((env.metrics().total(Term::Electricity) - reported[0]).abs() < 1e-9 * reported[0]);
        assert!((env.metrics().total(Term::Gas) - reported[1]).abs() <= 1e-9 * reported[1]);
    }
}

#[test]
fn energy_of_the_house_is_counted_once() {
    energy_is_the_engine_s_own(BuildingType::SingleFamilyHouse);
}

#[test]
fn energy_of_the_small_office_is_counted_once() {
    energy_is_the_engine_s_own(BuildingType::OfficeSmall);
}

#[test]
fn energy_of_the_medium_office_is_counted_once() {
    energy_is_the_engine_s_own(BuildingType::OfficeMedium);
}

#[test]
fn energy_of_the_shop_is_counted_once() {
    energy_is_the_engine_s_own(BuildingType::RetailStandalone);
}

#[test]
fn energy_of_the_restaurant_is_counted_once() {
    energy_is_the_engine_s_own(BuildingType::RestaurantFastFood);
}

#[test]
fn energy_of_the_warehouse_is_counted_once() {
    energy_is_the_engine_s_own(BuildingType::Warehouse);
}
