//! Design flows and capacities of systems.

use std::collections::HashSet;

use serde::Serialize;

use crate::hvac::air_loop_graph::supply_components;
use crate::hvac::distribution::served_zones;
use crate::hvac::references::Reference;
use crate::hvac::zone_equipment::zone_equipment;
use crate::hvac::{AirLoop, Quantity, System};
use crate::model::{Fields, number, text};
use crate::{Model, Result};

/// The equipment of a zone: its unit, its terminal or its heater.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Equipment {
    /// Design air flow into the zone, kg/s; 0 for a heater of the zone.
    pub design_flow: f64,
    /// Heating capacity of its coils, W.
    pub heating_capacity: f64,
    /// Cooling capacity of its coils, W.
    pub cooling_capacity: f64,
}

/// A system with its capacities.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SystemDescription {
    /// Name of its air loop, or of the heater's zone.
    pub name: String,
    /// Its kind.
    pub kind: SystemKind,
    /// The zones it serves, by number.
    pub zones: Vec<usize>,
    /// Design flow of its fan, kg/s; 0 for a heater of the zone.
    pub design_flow: f64,
    /// Heating capacity of its central coils, W, without reheat.
    pub heating_capacity: f64,
    /// Cooling capacity of its coils, W.
    pub cooling_capacity: f64,
    /// Capacity of the reheat coils of its terminals, W.
    pub reheat_capacity: f64,
}

/// Kinds of systems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SystemKind {
    /// One unit, one zone.
    Unitary,
    /// One air handler, many zones.
    AirLoop,
    /// A heater under a thermostat.
    HeatingOnly,
}

impl SystemKind {
    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unitary => "unitary",
            Self::AirLoop => "air loop",
            Self::HeatingOnly => "heater",
        }
    }
}

/// Heating and cooling capacity of coils, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Capacity {
    heating: f64,
    cooling: f64,
}

/// Describes the systems of a model and the equipment of each of its `zones`.
///
/// # Errors
/// [`crate::Error::MissingObject`] for a dangling reference.
pub(super) fn describe(
    model: &Model,
    systems: &[System],
    zones: &[String],
) -> Result<(Vec<SystemDescription>, Vec<Option<Equipment>>)> {
    let mut described = Vec::with_capacity(systems.len());
    let mut of_zones = vec![None; zones.len()];
    for system in systems {
        let mut description = describe_system(model, system, zones)?;
        for zone in description.zones.clone() {
            let equipment = match system {
                System::AirLoop(air_loop) => terminal(model, air_loop, &zones[zone])?,
                System::Unitary(_) | System::HeatingOnly(_) => Equipment {
                    design_flow: description.design_flow,
                    heating_capacity: description.heating_capacity,
                    cooling_capacity: description.cooling_capacity,
                },
            };
            if description.kind == SystemKind::AirLoop {
                description.reheat_capacity += equipment.heating_capacity;
            }
            of_zones[zone] = Some(equipment);
        }
        described.push(description);
    }
    Ok((described, of_zones))
}

/// Describes a system without the reheat of its terminals.
fn describe_system(model: &Model, system: &System, zones: &[String]) -> Result<SystemDescription> {
    let (kind, name, design_flow) = match system {
        System::Unitary(unit) => {
            let name = air_loop_of(model, &unit.zone)?.unwrap_or_else(|| unit.zone.clone());
            (SystemKind::Unitary, name, greatest_flow(system))
        }
        System::AirLoop(air_loop) => (SystemKind::AirLoop, air_loop.name.clone(), air_loop.fan_flow),
        System::HeatingOnly(heater) => (SystemKind::HeatingOnly, heater.zone.clone(), 0.0),
    };
    let central = match kind {
        SystemKind::HeatingOnly => of_zone_equipment(model, &name)?,
        SystemKind::Unitary | SystemKind::AirLoop => of_air_loop(model, &name)?,
    };
    Ok(SystemDescription {
        name,
        kind,
        zones: system.zones().into_iter().filter_map(|zone| crate::shape::position(zones, zone)).collect(),
        design_flow,
        heating_capacity: central.heating,
        cooling_capacity: central.cooling,
        reheat_capacity: 0.0,
    })
}

/// The terminal of a zone on an air loop.
fn terminal(model: &Model, air_loop: &AirLoop, zone: &str) -> Result<Equipment> {
    let terminal = air_loop.terminals.iter().find(|terminal| terminal.zone.eq_ignore_ascii_case(zone));
    Ok(Equipment {
        design_flow: terminal.map_or(0.0, |terminal| terminal.design_flow),
        heating_capacity: of_zone_equipment(model, zone)?.heating,
        cooling_capacity: 0.0,
    })
}

fn greatest_flow(system: &System) -> f64 {
    let flows =
        system.actuators().into_iter().filter(|actuator| actuator.quantity == Quantity::SupplyAirFlow);
    flows.map(|actuator| actuator.high).fold(0.0, f64::max)
}

/// The air loop that serves a zone.
fn air_loop_of(model: &Model, zone: &str) -> Result<Option<String>> {
    for air_loop in model.names("AirLoopHVAC") {
        if served_zones(model, &air_loop)?.iter().any(|served| served.zone.eq_ignore_ascii_case(zone)) {
            return Ok(Some(air_loop));
        }
    }
    Ok(None)
}

fn of_air_loop(model: &Model, air_loop: &str) -> Result<Capacity> {
    if !model.contains("AirLoopHVAC", air_loop) {
        return Ok(Capacity::default());
    }
    Ok(of_components(model, supply_components(model, air_loop)?))
}

/// Capacity of the zone's terminal coil or heater.
fn of_zone_equipment(model: &Model, zone: &str) -> Result<Capacity> {
    Ok(of_components(model, zone_equipment(model, zone)?))
}

/// Capacity of every coil among components and what they refer to, each counted once.
fn of_components(model: &Model, mut components: Vec<Reference>) -> Capacity {
    let (mut seen, mut sum) = (HashSet::new(), Capacity::default());
    while let Some(Reference { class, name }) = components.pop() {
        let Some(fields) = model.get(&class, &name) else { continue };
        if !seen.insert((class.to_lowercase(), name.to_lowercase())) {
            continue;
        }
        components.extend(referred(fields));
        let capacity = capacity(fields);
        match class.to_ascii_lowercase() {
            class if class.starts_with("coil:cooling") => sum.cooling += capacity,
            class if class.starts_with("coil:heating") || class.contains("baseboard") => {
                sum.heating += capacity
            }
            _ => {}
        }
    }
    sum
}

/// Referenced objects that may contain coils: `…_object_type` with `…_name`.
fn referred(fields: &Fields) -> Vec<Reference> {
    let parts = fields.keys().filter_map(|key| key.strip_suffix("_object_type"));
    let parts = parts.filter(|part| part.contains("coil") || part.contains("terminal"));
    let reference = |part: &str| {
        Some(Reference {
            class: text(fields, &format!("{part}_object_type"))?.to_owned(),
            name: text(fields, &format!("{part}_name"))?.to_owned(),
        })
    };
    parts.filter_map(reference).collect()
}

/// The maximum capacity among the speeds of a coil, W; 0 if autosized.
fn capacity(fields: &Fields) -> f64 {
    const NAMES: [&str; 6] = [
        "nominal_capacity",
        "rated_capacity",
        "gross_rated_heating_capacity",
        "gross_rated_total_cooling_capacity",
        "heating_design_capacity",
        "high_speed_gross_rated_total_cooling_capacity",
    ];
    let speeds =
        fields.values().filter_map(|value| value.as_array()).flatten().filter_map(|item| item.as_object());
    let own = fields.keys().filter(|key| NAMES.iter().any(|name| key.ends_with(name)));
    let own = own.filter_map(|key| number(fields, key));
    speeds.map(capacity).chain(own).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn the_capacity_of_a_coil_is_that_of_its_highest_speed() {
        let coil = json!({"speed_1_gross_rated_total_cooling_capacity": 5e3, "rated_air_flow_rate": 9e9,
            "speed_2_gross_rated_total_cooling_capacity": 8e3});
        assert_eq!(capacity(coil.as_object().unwrap()), 8e3);
        let staged = json!({"stages": [{"stage_nominal_capacity": 2e3}, {"stage_nominal_capacity": 4e3}]});
        assert_eq!(capacity(staged.as_object().unwrap()), 4e3);
        assert_eq!(capacity(json!({"nominal_capacity": "Autosize"}).as_object().unwrap()), 0.0);
    }

    #[test]
    fn nested_coils_are_counted_once() {
        let mut model = Model::default();
        let unit = json!({"heating_coil_object_type": "Coil:Heating:Fuel", "heating_coil_name": "H",
            "supplemental_heating_coil_object_type": "Coil:Heating:Fuel", "supplemental_heating_coil_name": "h",
            "cooling_coil_object_type": "CoilSystem:Cooling:DX", "cooling_coil_name": "S"});
        model.insert("AirLoopHVAC:UnitarySystem", "U", unit);
        let system =
            json!({"cooling_coil_object_type": "Coil:Cooling:DX:TwoSpeed", "cooling_coil_name": "C"});
        model.insert("CoilSystem:Cooling:DX", "S", system);
        model.insert("Coil:Heating:Fuel", "H", json!({"nominal_capacity": 100}));
        let cooling = json!({"high_speed_gross_rated_total_cooling_capacity": 70,
            "low_speed_gross_rated_total_cooling_capacity": 30});
        model.insert("Coil:Cooling:DX:TwoSpeed", "C", cooling);
        let unit = Reference { class: "AirLoopHVAC:UnitarySystem".into(), name: "U".into() };
        assert_eq!(of_components(&model, vec![unit]), Capacity { heating: 100.0, cooling: 70.0 });
    }
}
