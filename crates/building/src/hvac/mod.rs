//! HVAC systems, as an agent sees them: what can be driven, between which bounds, and how to see its effect.

pub mod air_loop;
pub mod common;
mod discovery;
pub(crate) mod distribution;
pub mod heating_only;
pub mod unitary;

pub use discovery::{Discovery, LeftAlone};
pub(crate) use discovery::{discover, has_own_controls};

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::model::Model;

/// What an actuator drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Air mass flow from a unitary system to its zone, kg/s.
    SupplyAirFlow,
    /// Air temperature at the outlet of a unitary system or of a central air handler, °C.
    SupplyAirTemperature,
    /// Outdoor air mass flow through the mixer of a central air loop, kg/s.
    OutdoorAirFlow,
    /// Opening of a zone's damper: the share of its terminal's design flow, 0 to 1.
    DamperOpening,
    /// Heating setpoint of a zone's thermostat, °C: reheat of a terminal, a unit heater.
    HeatingSetpoint,
}

impl Quantity {
    /// SI unit of the value an agent gives.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::SupplyAirFlow | Quantity::OutdoorAirFlow => "kg/s",
            Quantity::SupplyAirTemperature | Quantity::HeatingSetpoint => "°C",
            Quantity::DamperOpening => "1",
        }
    }
}

/// An engine variable: its name and its key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EngineVariable {
    /// Variable name, for example `System Node Mass Flow Rate`.
    pub name: String,
    /// Key: a zone, a node, an object.
    pub key: String,
}

impl EngineVariable {
    /// A variable of a key.
    pub fn new(name: &str, key: &str) -> Self {
        Self { name: name.to_owned(), key: key.to_owned() }
    }
}

/// One entry of the action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// Unique name for people, for example `Core_ZN supply air flow`.
    pub name: String,
    /// What it drives; gives the unit.
    pub quantity: Quantity,
    /// Lowest value an agent may give.
    pub low: f64,
    /// Highest value an agent may give.
    pub high: f64,
    /// Engine actuator: component type, for example `Schedule:Constant`.
    pub component: String,
    /// Engine actuator: control type, for example `Schedule Value`.
    pub control: String,
    /// Engine actuator: object name.
    pub key: String,
    /// Engine value per unit of the agent's value (1 / design flow where the engine takes a fraction).
    pub scale: f64,
    /// The engine variable that shows the driven quantity, in the same unit; for a damper its air flow, kg/s.
    pub effect: EngineVariable,
    /// Value of `effect` per unit of the agent's value (1, or for a damper its design flow, kg/s).
    pub effect_scale: f64,
    /// The engine variable that shows the heat, W, that a heating setpoint calls for. `None` for other quantities.
    pub heat: Option<EngineVariable>,
}

/// A group of actuators that act together on their zones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum System {
    /// One unit, one zone: flow and supply temperature.
    Unitary(Unitary),
    /// One air handler, many zones.
    AirLoop(AirLoop),
    /// A heater under a thermostat.
    HeatingOnly(HeatingOnly),
}

impl System {
    /// Its actuators, in the order of the action.
    pub fn actuators(&self) -> Vec<&Actuator> {
        match self {
            System::Unitary(unit) => vec![&unit.flow, &unit.supply_temperature],
            System::AirLoop(air_loop) => {
                let terminals = air_loop.terminals.iter().flat_map(|t| [&t.damper, &t.reheat]);
                [&air_loop.supply_temperature, &air_loop.outdoor_air].into_iter().chain(terminals).collect()
            }
            System::HeatingOnly(heater) => vec![&heater.setpoint],
        }
    }

    /// The zones it serves.
    pub fn zones(&self) -> Vec<&str> {
        match self {
            System::Unitary(unit) => vec![&unit.zone],
            System::AirLoop(air_loop) => air_loop.terminals.iter().map(|t| t.zone.as_str()).collect(),
            System::HeatingOnly(heater) => vec![&heater.zone],
        }
    }
}

/// Makes every HVAC system of a hard-sized model controllable: unitary systems and air loops in model order,
/// then heaters in the order of their zones. `air_density`, kg/m³, turns design volume flows into mass flows.
///
/// # Errors
/// [`crate::Error::Unsupported`] naming the object that cannot be driven.
pub fn make_controllable(model: &mut Model, air_density: f64) -> Result<Vec<System>> {
    let mut systems = Vec::new();
    for air_loop in model.names("AirLoopHVAC") {
        systems.push(drive_air_loop(model, &air_loop, air_density)?);
    }
    for zone in model.names("Zone") {
        let equipment = common::zone_equipment(model, &zone)?;
        refuse_unknown(&equipment, &zone)?;
        if let Some(heater) = equipment.iter().find(|e| heating_only::is_heater(&e.class)) {
            refuse_second_system(&systems, &zone, heater)?;
            systems.push(System::HeatingOnly(heating_only::make_controllable(model, &zone, heater)?));
        }
    }
    Ok(systems)
}

fn drive_air_loop(model: &mut Model, air_loop: &str, air_density: f64) -> Result<System> {
    if unitary::has_unit(model, air_loop)? {
        Ok(System::Unitary(unitary::make_controllable(model, air_loop, air_density)?))
    } else {
        Ok(System::AirLoop(air_loop::make_controllable(model, air_loop, air_density)?))
    }
}

/// Zone equipment that is left as it is: exhaust fans follow their schedules, and the warehouse's radiant heater
/// is switched off in the prototype.
const LEFT_ALONE: [&str; 2] = ["Fan:ZoneExhaust", "ZoneHVAC:HighTemperatureRadiant"];

/// Equipment that no kind of system covers would heat or cool behind the agent's back.
fn refuse_unknown(equipment: &[common::Reference], zone: &str) -> Result<()> {
    let known = |class: &str| {
        class.eq_ignore_ascii_case("ZoneHVAC:AirDistributionUnit")
            || heating_only::is_heater(class)
            || common::is_one_of(class, &LEFT_ALONE)
    };
    match equipment.iter().find(|e| !known(&e.class)) {
        None => Ok(()),
        Some(unknown) => {
            let why = format!("zone `{zone}` is conditioned by it, and no way to drive it is known");
            Err(common::unsupported(&unknown.class, &unknown.name, &why))
        }
    }
}

/// Two systems in one zone would need one thermostat each.
fn refuse_second_system(systems: &[System], zone: &str, heater: &common::Reference) -> Result<()> {
    if systems.iter().any(|s| s.zones().iter().any(|z| z.eq_ignore_ascii_case(zone))) {
        let why = format!("zone `{zone}` has an air system too, and one thermostat cannot drive both");
        return Err(common::unsupported(&heater.class, &heater.name, &why));
    }
    Ok(())
}

/// A unitary system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unitary {
    /// Zone it serves.
    pub zone: String,
    /// [`Quantity::SupplyAirFlow`].
    pub flow: Actuator,
    /// [`Quantity::SupplyAirTemperature`].
    pub supply_temperature: Actuator,
}

/// A central air loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AirLoop {
    /// Name of the `AirLoopHVAC`.
    pub name: String,
    /// [`Quantity::SupplyAirTemperature`], of the air handler.
    pub supply_temperature: Actuator,
    /// [`Quantity::OutdoorAirFlow`].
    pub outdoor_air: Actuator,
    /// Design flow of the supply fan, kg/s. All dampers open may ask for more: the fan limits.
    pub fan_flow: f64,
    /// Design flow of the exhaust fans in its zones, kg/s. Outdoor air makes up for what they take, whatever is
    /// commanded.
    pub exhaust_flow: f64,
    /// The terminals, in model order of their zones.
    pub terminals: Vec<Terminal>,
}

/// The terminal of one zone on a central air loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Terminal {
    /// Zone it serves.
    pub zone: String,
    /// [`Quantity::DamperOpening`].
    pub damper: Actuator,
    /// [`Quantity::HeatingSetpoint`], of the reheat coil.
    pub reheat: Actuator,
    /// Design flow, kg/s.
    pub design_flow: f64,
    /// Opening up to which more air brings more heat, 0 to 1: beyond it a hot-water coil has too little for the air.
    /// 1 for other coils.
    pub heating_opening: f64,
}

/// A zone heater without cooling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatingOnly {
    /// Zone it serves.
    pub zone: String,
    /// [`Quantity::HeatingSetpoint`].
    pub setpoint: Actuator,
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn zone_with(class: &str) -> Model {
        let model = serde_json::json!({
            "Zone": {"Z": {}},
            "ZoneHVAC:EquipmentConnections": {"C": {
                "zone_name": "Z", "zone_conditioning_equipment_list_name": "L"}},
            "ZoneHVAC:EquipmentList": {"L": {"equipment": [
                {"zone_equipment_object_type": class, "zone_equipment_name": "The unit"}]}},
        });
        Model::from_epjson(&model.to_string(), Path::new("zone.epJSON")).unwrap()
    }

    #[test]
    fn equipment_that_no_system_covers_is_refused_by_name() {
        let mut model = zone_with("ZoneHVAC:PackagedTerminalHeatPump");
        let error = make_controllable(&mut model, 1.2).unwrap_err().to_string();
        for word in ["ZoneHVAC:PackagedTerminalHeatPump", "`The unit`", "`Z`"] {
            assert!(error.contains(word), "{error}");
        }
    }

    #[test]
    fn an_exhaust_fan_is_left_alone() {
        let mut model = zone_with("Fan:ZoneExhaust");
        assert_eq!(make_controllable(&mut model, 1.2).unwrap(), []);
    }
}
