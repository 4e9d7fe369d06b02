//! Conversion of every system of a model to a controllable form.

use super::references::{Reference, is_one_of};
use super::system::System;
use super::zone_equipment::zone_equipment;
use super::{air_loop, heating_only, unitary};
use crate::model::Model;
use crate::{Error, Result};

/// Makes every HVAC system of a hard-sized model controllable: unitary systems and air loops in model order,
/// then heaters in the order of their zones. `air_density`, kg/m³, turns design volume flows into mass flows.
///
/// # Errors
/// [`crate::Error::Unsupported`] naming the object that cannot be made controllable.
pub fn make_controllable(model: &mut Model, air_density: f64) -> Result<Vec<System>> {
    let mut systems = Vec::new();
    for air_loop in model.names("AirLoopHVAC") {
        systems.push(drive_air_loop(model, &air_loop, air_density)?);
    }
    for zone in model.names("Zone") {
        let equipment = zone_equipment(model, &zone)?;
        refuse_unknown(&equipment, &zone)?;
        if let Some(heater) = equipment.iter().find(|e| heating_only::is_heater(&e.class)) {
            refuse_second_system(&systems, &zone, heater)?;
            systems.push(System::HeatingOnly(heating_only::make_controllable(model, &zone, heater)?));
        }
    }
    Ok(systems)
}

pub(super) fn drive_air_loop(model: &mut Model, air_loop: &str, air_density: f64) -> Result<System> {
    if unitary::has_unit(model, air_loop)? {
        Ok(System::Unitary(unitary::make_controllable(model, air_loop, air_density)?))
    } else {
        Ok(System::AirLoop(air_loop::make_controllable(model, air_loop, air_density)?))
    }
}

/// Zone equipment that is not controlled: exhaust fans follow their schedules, and the radiant heater of the warehouse is
/// switched off in the prototype.
pub(super) const UNCONTROLLED_EQUIPMENT: [&str; 2] = ["Fan:ZoneExhaust", "ZoneHVAC:HighTemperatureRadiant"];

/// Rejects unsupported equipment, which would heat or cool under its own controls.
fn refuse_unknown(equipment: &[Reference], zone: &str) -> Result<()> {
    let known = |class: &str| {
        class.eq_ignore_ascii_case("ZoneHVAC:AirDistributionUnit")
            || heating_only::is_heater(class)
            || is_one_of(class, &UNCONTROLLED_EQUIPMENT)
    };
    match equipment.iter().find(|e| !known(&e.class)) {
        None => Ok(()),
        Some(unknown) => {
            let why = format!("unsupported component that conditions zone `{zone}`");
            Err(Error::unsupported(&unknown.class, &unknown.name, &why))
        }
    }
}

/// Rejects a second system in a zone, which would need a thermostat of its own.
fn refuse_second_system(systems: &[System], zone: &str, heater: &Reference) -> Result<()> {
    if systems.iter().any(|s| s.zones().iter().any(|z| z.eq_ignore_ascii_case(zone))) {
        let why = format!("zone `{zone}` also has an air system, and one thermostat cannot control both");
        return Err(Error::unsupported(&heater.class, &heater.name, &why));
    }
    Ok(())
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
    fn unsupported_equipment_is_rejected_by_name() {
        let mut model = zone_with("ZoneHVAC:PackagedTerminalHeatPump");
        let error = make_controllable(&mut model, 1.2).unwrap_err().to_string();
        for word in ["ZoneHVAC:PackagedTerminalHeatPump", "`The unit`", "`Z`"] {
            assert!(error.contains(word), "{error}");
        }
    }

    #[test]
    fn an_exhaust_fan_is_not_controlled() {
        let mut model = zone_with("Fan:ZoneExhaust");
        assert_eq!(make_controllable(&mut model, 1.2).unwrap(), []);
    }
}
