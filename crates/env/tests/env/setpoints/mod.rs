//! Zones that are controlled through the setpoints of their thermostats.

use b2b_building::hvac::Quantity;
use b2b_building::hvac::setpoints::LEAST_GAP;
use b2b_building::{BuildingType, Conditioning, Controls};
use b2b_energyplus::{Event, Level, Run};
use b2b_env::Term;
use b2b_env::authority::{Limit, Verdict, measure};
use serde_json::Value;

use crate::case::{Case, Dice, energy_is_the_engines};
use crate::models::room::{autosized, room};

const DAY: &str = "01-09..01-09";

/// Runs half a day in which every actuator of a quantity has this value, and the others call for nothing. Returns the
/// mean zone temperatures from 8 to 12 h, °C.
fn held(case: &Case, day: &str, quantity: Quantity, value: f64) -> Vec<f64> {
    let mut env = case.env(day);
    let of = |actuator: &b2b_building::hvac::Actuator| match actuator.quantity {
        tested if tested == quantity => value,
        Quantity::CoolingSetpoint => actuator.high,
        _ => actuator.low,
    };
    let action: Vec<f64> = case.building.actuators().map(of).collect();
    env.reset().unwrap();
    let zones = env.observation_space().zone_temperatures();
    let mut means = vec![0.0; zones.len()];
    for step in 0..144 {
        let observation = env.step(&action).unwrap().observation;
        if step >= 96 {
            let temperatures = &observation[zones.clone()];
            means.iter_mut().zip(temperatures).for_each(|(mean, value)| *mean += value / 48.0);
        }
    }
    assert_eq!(env.message_count(Level::Severe), 0);
    means
}

#[test]
fn a_model_with_a_thermostat_only_is_controlled_through_both_setpoints_whatever_its_author_uses() {
    let case = Case::of_user(&room(), Controls::default());
    let names: Vec<&str> = case.building.actuators().map(|actuator| actuator.name.as_str()).collect();
    assert_eq!(names, ["Room heating setpoint", "Room cooling setpoint"]);
    assert_eq!(case.building.zones[0].conditioning, Conditioning::HeatingAndCooling);
    for (quantity, setpoint) in [(Quantity::HeatingSetpoint, 24.0), (Quantity::CoolingSetpoint, 16.0)] {
        let day = if setpoint > 20.0 { DAY } else { "07-10..07-10" };
        let [temperature] = held(&case, day, quantity, setpoint)[..] else { panic!("one zone") };
        assert!((temperature - setpoint).abs() < 0.05, "{temperature} °C at a setpoint of {setpoint} °C");
    }
    let report = measure(&case.library, &case.building, &case.weather).unwrap();
    let at_rest = |verdict| matches!(verdict, Verdict::Follows | Verdict::AtCapacity(Limit::CoolZone));
    assert!(report.rows.len() == 4 && report.rows.iter().all(|row| at_rest(row.verdict)), "{report}");
}

#[test]
fn crossing_setpoints_are_kept_apart_and_energy_equals_the_meters() {
    let case = Case::of_user(&room(), Controls::default());
    let mut env = case.env(DAY).observe_effects();
    let mut dice = Dice::new(env.action_space(), 3);
    env.reset().unwrap();
    let mut crossed = 0;
    for _ in 0..env.episode_steps() - 1 {
        let given = dice.roll().to_vec();
        let applied = env.step(&given).unwrap().action.to_vec();
        crossed += usize::from(given[1] < given[0] + LEAST_GAP);
        assert_eq!(applied, [given[0], given[1].max(given[0] + LEAST_GAP)]);
        assert_eq!([0, 1].map(|actuator| env.effect(actuator).unwrap()).to_vec(), applied);
    }
    assert!(crossed > 50, "{crossed} steps");
    env.step(dice.roll()).unwrap();
    assert_eq!(env.message_count(Level::Severe), 0);
    energy_is_the_engines(&env);
}

/// Classes of a prepared model that define an episode: its days, its steps and its warm-up.
const OF_EPISODE: [&str; 5] = ["Timestep", "RunPeriod", "ConvergenceLimits", "Building", "SimulationControl"];

#[test]
fn under_its_own_controls_a_model_is_simulated_as_by_the_bare_engine() {
    own_is_the_bare_engine(room());
}

#[test]
fn under_its_own_controls_an_autosized_model_with_an_exhaust_fan_is_simulated_as_by_the_bare_engine() {
    own_is_the_bare_engine(autosized());
    let balanced = Case::of_user(&autosized(), Controls::default());
    let note = balanced.building.notes.changed.join("; ");
    assert!(note.contains("exhaust fans"), "{note}");
}

/// Of the prepared model, the user's file gets only the classes that define an episode.
fn own_is_the_bare_engine(mut user: Value) {
    let own = Case::of_user(&user, Controls::Own);
    assert_eq!(own.building.notes.changed, [""; 0]);
    let mut env = own.env(DAY);
    env.reset().unwrap();
    let ours: Vec<u64> =
        (0..env.episode_steps()).map(|_| env.step(&[]).unwrap().observation[0].to_bits()).collect();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bare.epJSON");
    let prepared = own.building.model_for(DAY.parse().unwrap(), 12).to_epjson();
    let prepared: Value = serde_json::from_str(&prepared).unwrap();
    for class in OF_EPISODE {
        // A model that wants its equipment sized says so in its own object.
        if class != "SimulationControl" || user.get(class).is_none() {
            user[class] = prepared[class].clone();
        }
    }
    std::fs::write(&file, user.to_string()).unwrap();
    let run =
        Run::new(&file, &own.weather).output(folder.path()).request("Zone Mean Air Temperature", "Room");
    let mut bare = run.start(&own.library).unwrap();
    let variable = bare.variable("Zone Mean Air Temperature", "Room").unwrap();
    let meter = bare.meter("DistrictHeatingWater:Facility").unwrap();
    let (mut theirs, mut heat) = (Vec::new(), 0.0);
    while let Some(event) = bare.advance().unwrap() {
        if event == Event::Step {
            theirs.push(bare.read(variable).to_bits());
            heat += bare.read_meter(meter) / 3600.0 / own.building.conditioned_floor_area;
        }
    }
    assert_eq!(ours, theirs);
    let counted = env.metrics().total(Term::Gas);
    assert!(heat > 0.0 && (counted / heat - 1.0).abs() < 1e-9, "{counted} and {heat} Wh/m²");
    let temperature = f64::from_bits(ours[143]);
    assert!((temperature - 21.0).abs() < 0.05, "the model holds 21 °C, not {temperature} °C");
}

/// A type under setpoint control: no setpoint fails, and a day at a higher setpoint is warmer.
fn setpoints_bite(building_type: BuildingType) {
    let case = Case::under_setpoints(building_type);
    let is_setpoint = |quantity| matches!(quantity, Quantity::HeatingSetpoint | Quantity::CoolingSetpoint);
    assert!(case.building.actuators().all(|actuator| is_setpoint(actuator.quantity)));
    let report = measure(&case.library, &case.building, &case.weather).unwrap();
    assert_eq!(report.failures().count(), 0, "{report}");
    let [cool, warm] = [16.0, 26.0].map(|setpoint| held(&case, DAY, Quantity::HeatingSetpoint, setpoint));
    for ((zone, cool), warm) in case.building.zones.iter().zip(cool).zip(warm) {
        if zone.conditioning != Conditioning::None {
            assert!(warm - cool > 1.0, "{building_type}: {} is at {cool} and {warm} °C", zone.name);
        }
    }
}

#[test]
fn every_setpoint_of_the_small_office_bites() {
    setpoints_bite(BuildingType::OfficeSmall);
}

#[test]
fn every_setpoint_of_the_warehouse_bites() {
    setpoints_bite(BuildingType::Warehouse);
}

#[test]
fn every_setpoint_of_the_house_bites() {
    setpoints_bite(BuildingType::SingleFamilyHouse);
}
