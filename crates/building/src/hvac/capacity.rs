//! Design flows and capacities of equipment.

use std::collections::HashSet;

use serde::Serialize;

use super::air_loop_graph::supply_components;
use super::distribution::served_zones;
use super::references::Reference;
use super::zone_equipment::zone_equipment;
use crate::model::{Fields, number, text};
use crate::{Error, Model, Result};

/// The equipment of a zone or a system: its unit, its terminal, its air handler or its heater.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Equipment {
    /// Design air flow, kg/s; 0 for a heater and for a zone controlled through its setpoints.
    pub design_flow: f64,
    /// Heating capacity of its coils, W.
    pub heating_capacity: f64,
    /// Cooling capacity of its coils, W.
    pub cooling_capacity: f64,
}

/// The equipment of a system.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemEquipment {
    /// Display name: of the air loop, the unit or the zone.
    pub name: String,
    /// The unit, the air handler or the heater, without the terminals of the zones.
    pub central: Equipment,
    /// The equipment of each of its zones.
    pub zones: Vec<Equipment>,
}

impl SystemEquipment {
    /// The equipment of a system for a single zone.
    pub fn of_one(name: &str, equipment: Equipment) -> Self {
        Self { name: name.to_owned(), central: equipment, zones: vec![equipment] }
    }

    /// The equipment in the equipment list of a zone, without air flow.
    ///
    /// # Errors
    /// [`crate::Error::MissingObject`] for a dangling reference.
    pub fn of_zone(model: &Model, zone: &str) -> Result<Self> {
        Ok(Self::of_one(zone, Capacity::of_zone_equipment(model, zone)?.with_flow(0.0)))
    }
}

/// Heating and cooling capacity of coils, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Capacity {
    pub(super) heating: f64,
    pub(super) cooling: f64,
}

impl Capacity {
    /// Capacity of the coils on the supply side of an air loop; none if the model has no such loop.
    pub(super) fn of_air_loop(model: &Model, air_loop: &str) -> Result<Self> {
        if !model.contains("AirLoopHVAC", air_loop) {
            return Ok(Self::default());
        }
        Ok(of_components(model, supply_components(model, air_loop)?))
    }

    /// Capacity of all equipment of a zone.
    pub(super) fn of_zone_equipment(model: &Model, zone: &str) -> Result<Self> {
        Ok(of_components(model, zone_equipment(model, zone)?))
    }

    /// Equipment of this capacity with a design flow, kg/s.
    pub(super) fn with_flow(self, design_flow: f64) -> Equipment {
        Equipment { design_flow, heating_capacity: self.heating, cooling_capacity: self.cooling }
    }
}

/// Returns the air loop that serves a zone.
pub(super) fn air_loop_of(model: &Model, zone: &str) -> Result<Option<String>> {
    for air_loop in model.names("AirLoopHVAC") {
        let served = match served_zones(model, &air_loop) {
            // It has no terminals, or one of a kind whose zone is unknown.
            Err(Error::Unsupported { .. }) => continue,
            served => served?,
        };
        if served.iter().any(|served| served.zone.eq_ignore_ascii_case(zone)) {
            return Ok(Some(air_loop));
        }
    }
    Ok(None)
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
    fn a_coil_has_the_capacity_of_its_highest_speed() {
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
