//! The features of an agent's observation.

use b2b_building::{BuildingType, Conditioning};
use b2b_dataset::house::ZoneRole;
use b2b_env::{Spaces, Target};

use super::feature::{Feature, HOURS_OF_WEEK, Source};

/// Temperature about which zones and targets are scaled, °C.
const COMFORTABLE: f64 = 21.0;
/// Days of the week, as the calendar counts them.
const WEEKDAYS: [&str; 7] = ["Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun"];
/// HVAC power that counts as one, W/m².
const POWER: f64 = 20.0;

/// Returns the features of a building: of its controlled zones, of the others, of weather, calendar and energy, and of its
/// actuators.
pub(super) fn features(spaces: &Spaces, has_base: bool) -> Vec<Feature> {
    let mut features = Vec::new();
    for (index, slot) in spaces.controlled_zones().enumerate() {
        controlled_zone(spaces, index, slot, &mut features);
    }
    other_zones(spaces, &mut features);
    surroundings(spaces, &mut features);
    for (actuator, name) in spaces.action.names().iter().enumerate() {
        features.push(Feature::new(format!("{name} previous"), Source::Previous(actuator)));
        if has_base {
            features.push(Feature::new(format!("{name} base"), Source::Base(actuator)));
        }
    }
    features
}

/// The features of a controlled zone. Errors are those against the target of the step to come.
fn controlled_zone(spaces: &Spaces, zone: usize, slot: usize, features: &mut Vec<Feature>) {
    let (space, name) = (&spaces.observation, &spaces.building.zones[slot].name);
    let mut add = |what: &str, source| features.push(Feature::new(format!("{name} {what}"), source));
    add("error/5K", Source::Error { zone, scale: 5.0, limit: 2.0 });
    add("error/1K", Source::Error { zone, scale: 1.0, limit: 2.0 });
    add("error/0.2K", Source::Error { zone, scale: 0.2, limit: 2.0 });
    add("change/0.1K", Source::Change { slot, scale: 0.1, limit: 3.0 });
    add("recent error/0.2K", Source::RecentError { zone, scale: 0.2, limit: 3.0 });
    add("target", Source::Target { target: space.target(zone), center: COMFORTABLE, scale: 3.0 });
    match (space.occupancy(zone), space.target(zone)) {
        (Some(occupancy), Target::Slot(target)) => {
            add("occupancy", Source::Bounded { slot: occupancy, low: 0.0, high: 1.0 });
            add("target change/1K", Source::Change { slot: target, scale: 1.0, limit: 5.0 });
        }
        _ => {
            add("occupancy", Source::Constant(1.0));
            add("target change/1K", Source::Constant(0.0));
        }
    }
}

/// Temperatures of the zones that are not controlled: of a house by role, with a flag of presence.
fn other_zones(spaces: &Spaces, features: &mut Vec<Feature>) {
    let temperature = |slot| Source::Deviation { slot, center: COMFORTABLE, scale: 10.0, limit: 5.0 };
    let zones = &spaces.building.zones;
    if !is_house(spaces) {
        for slot in (0..zones.len()).filter(|slot| zones[*slot].conditioning == Conditioning::None) {
            features.push(Feature::new(format!("{} temperature", zones[slot].name), temperature(slot)));
        }
        return;
    }
    for role in ZoneRole::ALL.into_iter().filter(|role| *role != ZoneRole::Living) {
        let slot = zones.iter().position(|zone| ZoneRole::of_zone(&zone.name) == Some(role));
        let value = slot.map_or(Source::Constant(0.0), temperature);
        features.push(Feature::new(format!("{} temperature", role.name()), value));
        let presence = Source::Constant(f64::from(u8::from(slot.is_some())));
        features.push(Feature::new(format!("{} present", role.name()), presence));
    }
}

/// Weather, calendar and energy.
fn surroundings(spaces: &Spaces, features: &mut Vec<Feature>) {
    let space = &spaces.observation;
    let (outdoor, humidity) = (space.outdoor_temperature(), space.outdoor_humidity());
    let (hour, day, date) = (space.time_of_day(), space.day_of_week(), space.day_of_year());
    let mut add = |name: &str, source| features.push(Feature::new(name, source));
    add("outdoor temperature", Source::Deviation { slot: outdoor, center: 10.0, scale: 15.0, limit: 4.0 });
    add("outdoor temperature change/1K", Source::Change { slot: outdoor, scale: 1.0, limit: 3.0 });
    add("outdoor humidity", Source::Bounded { slot: humidity, low: 0.0, high: 100.0 });
    for (name, cosine) in [("sine", false), ("cosine", true)] {
        add(&format!("day, {name}"), Source::Day { slot: hour, periods: 1.0, cosine });
        add(&format!("half day, {name}"), Source::Day { slot: hour, periods: 2.0, cosine });
        add(&format!("week, {name}"), Source::Week { day, hour, cosine });
        add(&format!("year, {name}"), Source::Year { slot: date, cosine });
    }
    for at in 0..HOURS_OF_WEEK as u32 {
        let (weekday, clock) = (WEEKDAYS[at as usize / 24], at % 24);
        add(&format!("{weekday} {clock} h"), Source::HourOfWeek { day, hour, at: at.into() });
    }
    let scale = POWER / f64::from(spaces.episode.steps_per_hour);
    for (name, slot) in [("electricity", space.electricity()), ("gas", space.gas())] {
        add(name, Source::Deviation { slot, center: 0.0, scale, limit: 5.0 });
    }
}

fn is_house(spaces: &Spaces) -> bool {
    let class = spaces.building.class;
    class.is_some_and(|class| class.building_type == BuildingType::SingleFamilyHouse)
}
