//! Every actuator of every building type bites.

mod common;

use b2b_building::BuildingType;
use b2b_building::hvac::Quantity;
use b2b_env::authority::{Condition, Level, Report, Verdict, measure};
use common::Case;

/// Measures a building at home: every row follows or is at capacity, and capacity is the exception.
fn every_actuator_bites(building_type: BuildingType) -> Report {
    let case = Case::at_home(building_type);
    let report = measure(&case.library, &case.building, &case.weather).unwrap();
    assert_eq!(report.failures().count(), 0, "{report}");
    for actuator in case.building.actuators() {
        assert!(report.rows.iter().any(|row| row.actuator == actuator.name), "{} is untested", actuator.name);
    }
    let at_capacity = report.rows.iter().filter(|row| row.verdict != Verdict::Follows);
    assert!(at_capacity.count() * 5 < report.rows.len(), "{report}");
    moderate_commands_are_followed(&report);
    report
}

fn moderate_commands_are_followed(report: &Report) {
    let moderate = |quantity| match quantity {
        Quantity::SupplyAirTemperature => vec![(Condition::MiddleFlow, Level::Middle)],
        Quantity::SupplyAirFlow | Quantity::DamperOpening | Quantity::OutdoorAirFlow => {
            [Level::Zero, Level::Low, Level::Middle].map(|level| (Condition::NeutralSupply, level)).to_vec()
        }
        Quantity::HeatingSetpoint => vec![],
    };
    for row in &report.rows {
        if moderate(row.quantity).contains(&(row.condition, row.level)) {
            assert_eq!(row.verdict, Verdict::Follows, "{} {row}", row.actuator);
        }
    }
}

#[test]
fn every_actuator_of_the_house_bites() {
    every_actuator_bites(BuildingType::SingleFamilyHouse);
}

#[test]
fn every_actuator_of_the_small_office_bites() {
    every_actuator_bites(BuildingType::OfficeSmall);
}

#[test]
fn every_actuator_of_the_medium_office_bites() {
    every_actuator_bites(BuildingType::OfficeMedium);
}

#[test]
fn every_actuator_of_the_shop_bites() {
    every_actuator_bites(BuildingType::RetailStandalone);
}

#[test]
fn every_actuator_of_the_restaurant_bites() {
    every_actuator_bites(BuildingType::RestaurantFastFood);
}

#[test]
fn every_actuator_of_the_warehouse_bites() {
    let report = every_actuator_bites(BuildingType::Warehouse);
    let winter = report.rows.iter().filter(|row| row.quantity == Quantity::HeatingSetpoint);
    assert!(winter.clone().any(|row| row.heat.is_some_and(|heat| heat > 50e3)), "the bulk storage is heated");
}

#[test]
fn a_report_is_a_table_for_people_and_json_for_machines() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let report = measure(&case.library, &case.building, &case.weather).unwrap();
    let table = report.to_string();
    assert_eq!(table.lines().count(), report.rows.len() + 2);
    assert!(table.ends_with(" 0 fail"), "{table}");
    let json = serde_json::to_string(&report).unwrap();
    assert!(json.contains(r#""season":"winter""#), "{json}");
    assert!(json.contains(r#""verdict":"follows""#), "{json}");
    assert!(json.contains(r#""verdict":{"at_capacity":"coil"}"#), "{json}");
}
