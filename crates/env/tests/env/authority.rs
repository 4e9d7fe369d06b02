//! The building responds to every actuator, for every building type.

use std::sync::Arc;

use crate::case::Case;
use b2b_building::BuildingType;
use b2b_building::hvac::{Quantity, Unitary};
use b2b_env::authority::{Condition, Level, Report, Row, Verdict, measure};

/// Measures a building at its default place: every row follows or is at capacity, and capacity is the exception.
fn assert_every_actuator_responds(building_type: BuildingType) -> Report {
    let case = Case::at_home(building_type);
    let report = measure(&case.library, &case.building, &case.weather).unwrap();
    assert_eq!(report.failures().count(), 0, "{report}");
    for actuator in case.building.actuators() {
        assert!(report.rows.iter().any(|row| row.actuator == actuator.name), "{} is untested", actuator.name);
    }
    // No heater reaches 30 °C in a hold of two hours under cool supply air.
    let is_extreme = |row: &Row| row.quantity == Quantity::HeatingSetpoint && row.level == Level::High;
    let at_capacity = report.rows.iter().filter(|row| row.verdict != Verdict::Follows && !is_extreme(row));
    assert!(at_capacity.count() * 5 < report.rows.len(), "{report}");
    moderate_commands_are_followed(&report);
    report
}

fn moderate_commands_are_followed(report: &Report) {
    let moderate = |quantity| match quantity {
        // The whole range: a cap in the controls would show at any flow, a coil's capacity only at full flow.
        Quantity::SupplyAirTemperature => {
            [Level::Low, Level::Middle, Level::High].map(|level| (Condition::MiddleFlow, level)).to_vec()
        }
        Quantity::SupplyAirFlow | Quantity::DamperOpening | Quantity::OutdoorAirFlow => {
            [Level::Zero, Level::Low, Level::Middle].map(|level| (Condition::NeutralSupply, level)).to_vec()
        }
        Quantity::HeatingSetpoint | Quantity::CoolingSetpoint => vec![],
    };
    for row in &report.rows {
        if moderate(row.quantity).contains(&(row.condition, row.level)) {
            assert_eq!(row.verdict, Verdict::Follows, "{} {row}", row.actuator);
        }
    }
}

#[test]
fn every_actuator_of_the_house_responds() {
    assert_every_actuator_responds(BuildingType::SingleFamilyHouse);
}

#[test]
fn every_actuator_of_the_small_office_responds() {
    assert_every_actuator_responds(BuildingType::OfficeSmall);
}

#[test]
fn every_actuator_of_the_medium_office_responds() {
    assert_every_actuator_responds(BuildingType::OfficeMedium);
}

#[test]
fn every_actuator_of_the_shop_responds() {
    assert_every_actuator_responds(BuildingType::RetailStandalone);
}

#[test]
fn every_actuator_of_the_restaurant_responds() {
    assert_every_actuator_responds(BuildingType::RestaurantFastFood);
}

#[test]
fn every_actuator_of_the_warehouse_responds() {
    let report = assert_every_actuator_responds(BuildingType::Warehouse);
    let winter = report.rows.iter().filter(|row| row.quantity == Quantity::HeatingSetpoint);
    assert!(winter.clone().any(|row| row.heat.is_some_and(|heat| heat > 50e3)), "the bulk storage is heated");
}

/// No actuator of an imported building fails, but many air handlers are at the capacity of their coils, which keep the
/// sizes of the model. At least a share of the commands is followed.
fn no_actuator_of_an_import_fails(model: &str, share: f64) {
    let case = Case::imported(model, "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw");
    let report = measure(&case.library, &case.building, &case.weather).unwrap();
    assert_eq!(report.failures().count(), 0, "{report}");
    let follows = report.rows.iter().filter(|row| row.verdict == Verdict::Follows);
    assert!(follows.count() as f64 > share * report.rows.len() as f64, "{report}");
}

#[test]
fn every_actuator_of_imported_units_in_parts_responds() {
    no_actuator_of_an_import_fails("RefBldgSmallOfficeNew2004_Chicago.idf", 0.8);
}

#[test]
fn every_actuator_of_an_imported_office_with_chilled_and_hot_water_responds() {
    no_actuator_of_an_import_fails("RefBldgLargeOfficeNew2004_Chicago.idf", 0.8);
}

#[test]
fn every_actuator_of_an_imported_school_of_mixed_systems_with_exhaust_fans_responds() {
    no_actuator_of_an_import_fails("RefBldgPrimarySchoolNew2004_Chicago.idf", 0.8);
}

/// The coils of its packaged units reach neither 10 °C in summer nor 45 °C: 183 of the 223 commands at capacity, of
/// 1018.
#[test]
fn every_actuator_of_an_imported_hotel_of_packaged_units_responds() {
    no_actuator_of_an_import_fails("RefBldgSmallHotelNew2004_Chicago.idf", 0.75);
}

/// Another air loop gives outdoor air to its rooms.
#[test]
fn every_actuator_of_an_imported_hotel_with_a_loop_of_outdoor_air_responds() {
    no_actuator_of_an_import_fails("RefBldgLargeHotelNew2004_Chicago.idf", 0.65);
}

/// Its fan coils share hot water for less than the highest supply temperature of all at once in winter.
#[test]
fn every_actuator_of_an_imported_hotel_of_fan_coils_responds() {
    no_actuator_of_an_import_fails("ASHRAE901_HotelLarge_STD2019_Denver.idf", 0.55);
}

/// The house with its actuators tampered with, measured: verdicts of the rows of a quantity.
fn verdicts_of_a_tampered_house(quantity: Quantity, tamper: impl Fn(&mut Unitary)) -> Vec<(Level, Verdict)> {
    let mut case = Case::at_home(BuildingType::SingleFamilyHouse);
    for system in &mut Arc::make_mut(&mut case.building).systems {
        if let Some(unit) = system.as_any_mut().downcast_mut::<Unitary>() {
            tamper(unit);
        }
    }
    let report = measure(&case.library, &case.building, &case.weather).unwrap();
    let rows = report.rows.iter().filter(|row| row.quantity == quantity && row.level != Level::Zero);
    rows.map(|row| (row.level, row.verdict)).collect()
}

fn all_fail(verdicts: &[(Level, Verdict)]) -> bool {
    verdicts.iter().all(|(_, verdict)| *verdict == Verdict::Fails)
}

#[test]
fn an_actuator_without_effect_fails_and_is_not_at_capacity() {
    let dead = |unit: &mut Unitary| unit.supply_temperature.key = "Living Heating Setpoint".into();
    let verdicts = verdicts_of_a_tampered_house(Quantity::SupplyAirTemperature, dead);
    assert!(all_fail(&verdicts), "{verdicts:?}");
}

#[test]
fn a_supply_temperature_that_is_off_by_a_twentieth_fails_and_is_not_at_capacity() {
    let off = |unit: &mut Unitary| unit.supply_temperature.scale = 0.95;
    let verdicts = verdicts_of_a_tampered_house(Quantity::SupplyAirTemperature, off);
    let passed = verdicts.iter().filter(|(_, verdict)| *verdict != Verdict::Fails).count();
    // At the true capacity of the coil, an offset cannot be distinguished from capacity.
    assert!(passed <= 2, "{verdicts:?}");
    assert!(verdicts.iter().filter(|(level, _)| *level == Level::Middle).all(|(_, v)| *v == Verdict::Fails));
}

#[test]
fn a_flow_that_is_off_by_a_twentieth_fails() {
    let off = |unit: &mut Unitary| unit.flow.scale *= 0.95;
    let verdicts = verdicts_of_a_tampered_house(Quantity::SupplyAirFlow, off);
    assert!(all_fail(&verdicts), "{verdicts:?}");
}

#[test]
fn a_report_prints_as_a_table_and_serializes_to_json() {
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
