//! Heat of people, lights and appliances.

use b2b_building::Model;
use serde_json::json;

use super::hvac::schedules;
use super::parameters::House;
use super::zones::LIVING;

/// Heat of a seated adult, W (ASHRAE Fundamentals: seated, light activity).
const ACTIVITY: f64 = 120.0;
/// Lighting, kWh per day and m²: 2.6 kWh a day in a house of 160 m² (EnerGuide standard operating conditions).
const LIGHTING: f64 = 2.6 / 160.0;
/// Appliances, kWh per day of a house and of each occupant: 16 kWh a day for three (EnerGuide standard operating
/// conditions; the split is engineering judgment).
const APPLIANCES: [f64; 2] = [7.0, 3.0];
/// Share of appliance energy that leaves with dryer and range exhaust, and that becomes vapor (engineering
/// judgment).
const APPLIANCES_LOST: f64 = 0.2;
const APPLIANCES_LATENT: f64 = 0.1;

/// Lighting over its daily mean (engineering judgment, as is the shape below).
const LIGHTS: [f64; 24] = [
    0.2, 0.1, 0.1, 0.1, 0.1, 0.4, 1.0, 1.2, 0.8, 0.5, 0.4, 0.4, 0.4, 0.4, 0.4, 0.6, 1.3, 2.2, 2.6, 2.9, 3.0,
    2.6, 1.6, 0.7,
];
/// Appliances over their daily mean.
const APPLIANCE_USE: [f64; 24] = [
    0.6, 0.5, 0.5, 0.5, 0.5, 0.6, 0.9, 1.1, 1.0, 0.9, 0.9, 1.0, 1.1, 1.0, 0.9, 1.0, 1.3, 1.8, 1.9, 1.6, 1.4,
    1.2, 1.0, 0.8,
];

pub(super) fn add(model: &mut Model, house: &House) {
    people(model, house);
    lights(model, house);
    appliances(model, house);
}

/// Mean heat gain of the room with everyone at home, W.
pub(super) fn mean(house: &House) -> f64 {
    house.occupants * ACTIVITY + lighting_power(house) + appliance_power(house) * (1.0 - APPLIANCES_LOST)
}

fn people(model: &mut Model, house: &House) {
    let household = house.draw_household();
    schedules::occupancy(model, "Occupancy", &household);
    schedules::constant(model, "Activity", ACTIVITY);
    let people = json!({
        "zone_or_zonelist_or_space_or_spacelist_name": LIVING,
        "number_of_people_calculation_method": "People",
        "number_of_people": household.people(),
        "number_of_people_schedule_name": "Occupancy",
        "activity_level_schedule_name": "Activity",
    });
    model.insert("People", "Living People", people);
}

fn lights(model: &mut Model, house: &House) {
    schedules::daily(model, "Lighting", &LIGHTS);
    let lights = json!({
        "zone_or_zonelist_or_space_or_spacelist_name": LIVING,
        "schedule_name": "Lighting",
        "design_level_calculation_method": "LightingLevel",
        "lighting_level": lighting_power(house),
        "fraction_radiant": 0.4,
        "fraction_visible": 0.2,
    });
    model.insert("Lights", "Living Lights", lights);
}

fn appliances(model: &mut Model, house: &House) {
    schedules::daily(model, "Appliances", &APPLIANCE_USE);
    let appliances = json!({
        "zone_or_zonelist_or_space_or_spacelist_name": LIVING,
        "schedule_name": "Appliances",
        "design_level_calculation_method": "EquipmentLevel",
        "design_level": appliance_power(house),
        "fraction_latent": APPLIANCES_LATENT,
        "fraction_radiant": 0.3,
        "fraction_lost": APPLIANCES_LOST,
    });
    model.insert("ElectricEquipment", "Living Appliances", appliances);
}

fn lighting_power(house: &House) -> f64 {
    house.appliance_use * LIGHTING * house.floor_area * 1000.0 / 24.0
}

fn appliance_power(house: &House) -> f64 {
    house.appliance_use * (APPLIANCES[0] + APPLIANCES[1] * house.occupants) * 1000.0 / 24.0
}
