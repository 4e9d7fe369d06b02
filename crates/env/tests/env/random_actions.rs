//! With any action of an agent, the engine continues and its values stay finite.

use crate::case::{Case, random_episode};
use b2b_building::BuildingType;
use b2b_energyplus::Level;

/// A random episode: all values finite, no severe message.
fn random_actions_do_no_harm(case: &Case, period: &str) {
    let mut env = case.env(period);
    let trajectory = random_episode(&mut env, 1);
    assert_eq!(trajectory.len(), env.episode_steps());
    let penalties = trajectory.penalties.iter().flatten();
    assert!(trajectory.observations.iter().chain(penalties).all(|value| value.is_finite()));
    let slots = env.observation_space().slots();
    for row in trajectory.observations.chunks_exact(slots.len()) {
        for (slot, value) in slots.iter().zip(row) {
            assert!((slot.low..=slot.high).contains(value), "{}: {value} {}", slot.name, slot.unit);
        }
    }
    let name = &case.building.name;
    assert_eq!(env.message_count(Level::Severe), 0, "{name} {period}: {}", env.messages());
    assert_eq!(env.message_count(Level::Fatal), 0, "{name} {period}: {}", env.messages());
}

/// A winter and a summer month at the default place, and a week of each in a hot and in a cold place.
fn random_actions_do_no_harm_to(building_type: BuildingType) {
    let home = Case::at_home(building_type);
    for period in ["01-01..01-30", "07-01..07-30"] {
        random_actions_do_no_harm(&home, period);
    }
    for place in ["Miami", "Fairbanks"] {
        let away = Case::at(building_type, place);
        for period in ["01-01..01-07", "07-01..07-07"] {
            random_actions_do_no_harm(&away, period);
        }
    }
}

#[test]
fn random_actions_do_no_harm_to_the_house() {
    random_actions_do_no_harm_to(BuildingType::SingleFamilyHouse);
}

#[test]
fn random_actions_do_no_harm_to_the_small_office() {
    random_actions_do_no_harm_to(BuildingType::OfficeSmall);
}

#[test]
fn random_actions_do_no_harm_to_the_medium_office() {
    random_actions_do_no_harm_to(BuildingType::OfficeMedium);
}

#[test]
fn random_actions_do_no_harm_to_the_shop() {
    random_actions_do_no_harm_to(BuildingType::RetailStandalone);
}

#[test]
fn random_actions_do_no_harm_to_the_restaurant() {
    random_actions_do_no_harm_to(BuildingType::RestaurantFastFood);
}

#[test]
fn random_actions_do_no_harm_to_the_warehouse() {
    random_actions_do_no_harm_to(BuildingType::Warehouse);
}
