//! A new kind of system, added as in CONTRIBUTING.md.

use std::path::Path;

use b2b_building::hvac::thermostat::{OUT_OF_REACH, own_thermostat};
use b2b_building::hvac::{
    Actuator, Candidate, EngineVariable, FromModel, KINDS, Kind, KindName, Quantity, Sequence, System,
    ZoneState,
};
use b2b_building::morphology::NodeType;
use b2b_building::{Conditioning, Model};
use b2b_energyplus::Level;
use serde::{Deserialize, Serialize};

use crate::case::Case;

/// A packaged terminal air conditioner that heats to the setpoint of its zone's thermostat.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct PackagedHeater {
    zone: String,
    setpoint: Actuator,
}

impl System for PackagedHeater {
    fn name(&self) -> &str {
        &self.zone
    }

    fn zones(&self) -> Vec<&str> {
        vec![&self.zone]
    }

    fn actuators(&self) -> Vec<&Actuator> {
        vec![&self.setpoint]
    }

    fn conditioning(&self) -> Conditioning {
        Conditioning::Heating
    }

    fn node_type(&self, _: usize) -> NodeType {
        NodeType::HeatingOnlyZone
    }

    fn warm_up(&self, zone: &dyn Fn(usize) -> ZoneState, action: &mut [f64]) {
        action[0] = zone(0).target;
    }

    fn sequence(&self) -> Sequence<'_> {
        Sequence::Thermostat
    }
}

impl FromModel for PackagedHeater {
    const NAME: KindName =
        KindName { id: "packaged_heater", name: "packaged heater", plural: "packaged heaters" };

    fn claims(_: &Model, candidate: Candidate<'_>) -> b2b_building::Result<bool> {
        Ok(candidate.is_equipment(&["ZoneHVAC:PackagedTerminalAirConditioner"]))
    }

    fn make_controllable(
        model: &mut Model,
        candidate: Candidate<'_>,
        _air_density: f64,
    ) -> b2b_building::Result<Self> {
        let (zone, _) = candidate.equipment()?;
        let schedule = own_thermostat(model, zone, 10.0, OUT_OF_REACH)?.heating;
        let label = format!("{zone} heating setpoint");
        let effect = EngineVariable::new("Zone Thermostat Heating Setpoint Temperature", zone);
        let bounds = [10.0, 30.0];
        let setpoint = Actuator::of_schedule(schedule, label, Quantity::HeatingSetpoint, bounds, effect);
        Ok(Self { zone: zone.to_owned(), setpoint })
    }
}

/// A small hotel whose guest rooms have packaged terminal air conditioners.
fn hotel() -> Case {
    // Ahead of the kinds that would claim these units.
    let kinds: Vec<Kind> = [Kind::of::<PackagedHeater>()].into_iter().chain(KINDS).collect();
    Case::imported_with(&kinds, "RefBldgSmallHotelNew2004_Chicago.idf", CHICAGO, |_| ())
}

const CHICAGO: &str = "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw";

#[test]
fn the_environment_sees_the_actuators_of_a_new_kind_and_its_zones_follow_them() {
    let case = hotel();
    let new: Vec<_> = case
        .building
        .laid_out_systems()
        .filter(|(system, _)| system.kind().id == "packaged_heater")
        .collect();
    assert_eq!(new.len(), 35);
    assert!(case.building.uncontrolled.iter().all(|each| !each.object.class.contains("PackagedTerminal")));
    let mut env = case.env("01-08..01-08");
    let mut action: Vec<f64> = case.building.actuators().map(|a| 0.5 * (a.low + a.high)).collect();
    assert_eq!(env.action_space().len(), action.len());
    for (system, layout) in &new {
        assert_eq!(env.action_space().names()[layout.actions.start], system.actuators()[0].name);
    }
    env.reset().unwrap();
    // Half a day at a setpoint.
    let mean_at = |setpoint: f64| {
        new.iter().for_each(|(_, layout)| action[layout.actions.start] = setpoint);
        (1..144).for_each(|_| _ = env.step(&action).unwrap());
        let last = env.step(&action).unwrap().observation;
        new.iter().map(|(_, layout)| last[layout.zones[0].index]).sum::<f64>() / new.len() as f64
    };
    let [cool, warm] = [17.0, 22.0].map(mean_at);
    // Guests and equipment may warm a room further: the example cannot cool.
    assert!((21.5..23.5).contains(&warm), "{warm}");
    assert!(warm - cool > 1.0, "{cool} and {warm}");
    assert_eq!(env.message_count(Level::Severe), 0);
}

#[test]
fn the_guide_for_contributors_shows_this_kind() {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../CONTRIBUTING.md");
    let guide = std::fs::read_to_string(guide).unwrap();
    let (_, section) = guide.split_once("## Add a system\n").unwrap();
    let (_, code) = section.split_once("```rust,ignore\n").unwrap();
    let (code, _) = code.split_once("```\n").unwrap();
    assert!(code.contains("impl System for") && code.contains("impl FromModel for"), "{code}");
    assert!(
        include_str!("example_system.rs").contains(code),
        "the code of CONTRIBUTING.md is not in this file"
    );
}
