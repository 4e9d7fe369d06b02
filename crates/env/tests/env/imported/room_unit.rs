//! Units in the room that they serve, driven by air flow and supply air temperature.

use b2b_building::hvac::Quantity;
use b2b_building::{Conditioning, Controls};
use b2b_energyplus::Level;
use b2b_env::authority::{Verdict, measure};
use serde_json::Value;

use crate::case::{Case, energy_is_the_engines, random_episode};
use crate::models::fan_coil::fan_coil;
use crate::models::packaged::{FLOW, OUTDOOR_AIR, air_conditioner, heat_pump, unitary_system};

const CHICAGO: &str = "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw";
const DAY: &str = "01-09..01-09";

fn kinds(case: &Case, id: &str) -> usize {
    case.building.systems.iter().filter(|system| system.kind().id == id).count()
}

/// A room with one unit, driven as a room unit: every command is followed and energy is the meters'. `outdoor_air`,
/// m³/s, is supplied to the four people whatever the commands are.
fn a_unit_follows_its_commands(model: &Value, outdoor_air: Option<f64>) {
    let case = Case::of_user(model, Controls::default());
    assert_eq!(kinds(&case, "room_unit"), 1, "{:?}", case.building.uncontrolled);
    assert_eq!(case.building.zones[0].conditioning, Conditioning::HeatingAndCooling);
    let report = measure(&case.library, &case.building, &case.weather).unwrap();
    assert_eq!(report.failures().count(), 0, "{report}");
    let mut flows = report.rows.iter().filter(|row| row.quantity == Quantity::SupplyAirFlow);
    assert!(flows.all(|row| row.verdict == Verdict::Follows), "{report}");
    match outdoor_air {
        Some(outdoor_air) => people_get_their_outdoor_air(&case, outdoor_air),
        None => assert!(case.building.systems[0].ventilation().is_none()),
    }
    let mut env = case.env(DAY);
    random_episode(&mut env, 1);
    assert_eq!(env.message_count(Level::Severe), 0);
    energy_is_the_engines(&env);
}

fn people_get_their_outdoor_air(case: &Case, outdoor_air: f64) {
    let mut env = case.env(DAY);
    env.reset().unwrap();
    let lowest = env.action_space().low().to_vec();
    let system = &case.building.systems[0];
    let minimum = system.ventilation().unwrap().min_outdoor_air;
    let density = system.actuators()[0].high / FLOW;
    assert!((minimum / density - outdoor_air).abs() < 1e-9);
    for step in 0..12 {
        let flow = env.step(&lowest).unwrap().action[0];
        let [outdoor_air, people] = env.outdoor_air()[0].unwrap();
        assert_eq!(people, 4.0);
        let least = minimum * (1.0 - 1e-4);
        assert!(
            step == 0 || flow >= minimum && outdoor_air >= least,
            "{outdoor_air} kg/s; minimum {minimum}"
        );
    }
}

#[test]
fn a_packaged_heat_pump_follows_its_commands_and_ventilates_whatever_they_are() {
    a_unit_follows_its_commands(&heat_pump(), Some(OUTDOOR_AIR));
}

#[test]
fn a_packaged_air_conditioner_follows_its_commands_and_ventilates_whatever_they_are() {
    a_unit_follows_its_commands(&air_conditioner(), Some(OUTDOOR_AIR));
}

#[test]
fn a_fan_coil_follows_its_commands_and_ventilates_whatever_they_are() {
    a_unit_follows_its_commands(&fan_coil(), Some(OUTDOOR_AIR));
}

#[test]
fn a_unitary_system_in_its_room_follows_its_commands() {
    a_unit_follows_its_commands(&unitary_system(), None);
}

#[test]
fn fan_coils_beside_dedicated_outdoor_air_are_driven_and_their_energy_equals_the_meters() {
    let case = Case::imported("RefBldgLargeHotelNew2004_Chicago.idf", CHICAGO);
    assert_eq!(kinds(&case, "room_unit"), 9);
    let outdoor_air =
        case.building.uncontrolled.iter().find(|item| item.object.class == "AirLoopHVAC").unwrap();
    assert!(outdoor_air.reason.contains("dedicated outdoor air"), "{}", outdoor_air.reason);
    let follows = case.building.uncontrolled.iter().filter(|item| item.follows_setpoints).count();
    assert_eq!(follows, 0, "{:?}", case.building.uncontrolled);
    let mut env = case.env("07-10..07-10");
    random_episode(&mut env, 1);
    assert_eq!(env.message_count(Level::Severe), 0);
    energy_is_the_engines(&env);
}
