//! The features of an agent's observation.

use b2b_building::Conditioning;
use b2b_building::ZoneRole;
use b2b_env::{Spaces, Target};

use super::feature::{Feature, HOURS_OF_WEEK, Source};
use super::outdoor::OUTDOOR;

/// Temperature around which zones and targets are scaled, °C.
const COMFORTABLE: f64 = 21.0;
/// Days of the week, as the calendar counts them.
const WEEKDAYS: [&str; 7] = ["Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun"];
/// Scale of HVAC power, W/m².
const POWER: f64 = 20.0;

/// Returns the features of a building: controlled zones, other zones, weather, calendar, energy, and actions.
pub(super) fn features(spaces: &Spaces, actions: &[String], has_base: bool) -> Vec<Feature> {
    let mut features = Vec::new();
    let space = &spaces.observation;
    for (zone, temperature) in spaces.controlled_zones().enumerate() {
        let (target, occupancy) = (space.target(zone), space.occupancy(zone));
        let name = &spaces.building.zones[temperature].name;
        let of_zone = ControlledZone { zone, temperature, target, occupancy }.features();
        features.extend(of_zone.map(|(what, source)| Feature::new(format!("{name} {what}"), source)));
    }
    other_zones(spaces, &mut features);
    let of_weather = weather(space.outdoor_temperature(), space.outdoor_humidity());
    features.extend(of_weather.map(|(name, source)| Feature::new(name, source)));
    let of_calendar = calendar(space.time_of_day(), space.day_of_week(), space.day_of_year());
    features.extend(of_calendar.into_iter().map(|(name, source)| Feature::new(name, source)));
    let of_energy = energy(space.electricity(), space.gas(), spaces.episode.steps_per_hour);
    features.extend(of_energy.map(|(name, source)| Feature::new(name, source)));
    for (action, name) in actions.iter().enumerate() {
        features.push(Feature::new(format!("{name} previous"), Source::Previous(action)));
        if has_base {
            features.push(Feature::new(format!("{name} base"), Source::Base(action)));
        }
    }
    features
}

/// Slots of a controlled zone.
pub(super) struct ControlledZone {
    /// Its index among the controlled zones.
    pub(super) zone: usize,
    /// Slot of its temperature.
    pub(super) temperature: usize,
    pub(super) target: Target,
    /// Slot of its occupancy, if it varies.
    pub(super) occupancy: Option<usize>,
}

impl ControlledZone {
    /// Returns its features. Errors are relative to the target of the next step.
    pub(super) fn features(&self) -> [(&'static str, Source); 8] {
        let Self { zone, temperature, target, occupancy } = *self;
        let (occupancy, target_change) = match (occupancy, target) {
            (Some(occupancy), Target::Slot(target)) => (
                Source::Bounded { slot: occupancy, low: 0.0, high: 1.0 },
                Source::Change { slot: target, scale: 1.0, limit: 5.0 },
            ),
            _ => (Source::Constant(1.0), Source::Constant(0.0)),
        };
        [
            ("error/5K", Source::Error { zone, scale: 5.0, limit: 2.0 }),
            ("error/1K", Source::Error { zone, scale: 1.0, limit: 2.0 }),
            ("error/0.2K", Source::Error { zone, scale: 0.2, limit: 2.0 }),
            ("change/0.1K", Source::Change { slot: temperature, scale: 0.1, limit: 3.0 }),
            ("recent error/0.2K", Source::RecentError { zone, scale: 0.2, limit: 3.0 }),
            ("target", Source::Target { target, center: COMFORTABLE, scale: 3.0 }),
            ("occupancy", occupancy),
            ("target change/1K", target_change),
        ]
    }
}

/// The temperature of a zone, for one without a target that varies.
pub(super) fn temperature(slot: usize) -> Source {
    Source::Deviation { slot, center: COMFORTABLE, scale: 10.0, limit: 5.0 }
}

/// Temperatures of the uncontrolled zones; in houses by role, with a flag for presence.
fn other_zones(spaces: &Spaces, features: &mut Vec<Feature>) {
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

/// Outdoor temperature and humidity, from their slots.
pub(super) fn weather(outdoor: usize, humidity: usize) -> [(&'static str, Source); 3] {
    let (center, scale) = OUTDOOR;
    [
        ("outdoor temperature", Source::Deviation { slot: outdoor, center, scale, limit: 4.0 }),
        ("outdoor temperature change/1K", Source::Change { slot: outdoor, scale: 1.0, limit: 3.0 }),
        ("outdoor humidity", Source::Bounded { slot: humidity, low: 0.0, high: 100.0 }),
    ]
}

/// Sines and cosines of the time and the hours of the week, from the slots of hour, day of the week and day of the
/// year.
pub(super) fn calendar(hour: usize, day: usize, date: usize) -> Vec<(String, Source)> {
    let mut features = hours_and_seasons(hour, day, date);
    for at in 0..HOURS_OF_WEEK as u32 {
        let (weekday, clock) = (WEEKDAYS[at as usize / 24], at % 24);
        features.push((format!("{weekday} {clock} h"), Source::HourOfWeek { day, hour, at: at.into() }));
    }
    features
}

/// Sines and cosines of the time, from the slots of hour, day of the week and day of the year.
pub(super) fn hours_and_seasons(hour: usize, day: usize, date: usize) -> Vec<(String, Source)> {
    let mut features = Vec::new();
    for (name, cosine) in [("sine", false), ("cosine", true)] {
        features.extend([
            (format!("day, {name}"), Source::Day { slot: hour, periods: 1.0, cosine }),
            (format!("half day, {name}"), Source::Day { slot: hour, periods: 2.0, cosine }),
            (format!("week, {name}"), Source::Week { day, hour, cosine }),
            (format!("year, {name}"), Source::Year { slot: date, cosine }),
        ]);
    }
    features
}

/// HVAC power, from the slots of the energy of a step.
pub(super) fn energy(electricity: usize, gas: usize, steps_per_hour: u32) -> [(&'static str, Source); 2] {
    let scale = POWER / f64::from(steps_per_hour);
    let power = |slot| Source::Deviation { slot, center: 0.0, scale, limit: 5.0 };
    [("electricity", power(electricity)), ("gas", power(gas))]
}

fn is_house(spaces: &Spaces) -> bool {
    let class = spaces.building.class;
    class.is_some_and(|class| class.building_type.is_house())
}
