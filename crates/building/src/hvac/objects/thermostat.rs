//! The thermostats of zones.

use serde_json::json;

use super::energy_management::{acts_on, read_instead, remove_ems_programs};
use super::given_thermostat::{controls, thermostat};
use super::schedules::constant_schedule;
use super::zone_controls;
use crate::model::{Fields, text};
use crate::{Error, Model, Result};

/// Schedule of the control type of a thermostat with a heating and a cooling setpoint.
const DUAL_SETPOINT: &str = "B2B Dual Setpoint";
/// A cooling setpoint that no zone reaches, °C: cooling is controlled through the supply air. Random actions have
/// reached 46 °C.
pub const OUT_OF_REACH: f64 = 90.0;
/// A heating setpoint that no zone reaches, °C: heating is controlled through the supply air.
pub const OUT_OF_REACH_BELOW: f64 = 0.0;

/// The setpoint schedules of a zone's thermostat.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setpoints {
    /// Name of the `Schedule:Constant` of the heating setpoint.
    pub heating: String,
    /// Name of the `Schedule:Constant` of the cooling setpoint.
    pub cooling: String,
}

/// Gives a zone a thermostat of its own: a heating and a cooling setpoint that no other zone shares, in the
/// schedules `<zone> Heating Setpoint` and `<zone> Cooling Setpoint`, at these values (°C). A name that is taken gets a
/// suffix.
///
/// What else sets or shifts its setpoints is removed ([`zone_controls`], EMS programs). EMS sensors that read the schedule
/// of a setpoint read its new one, unless it is out of reach.
///
/// # Errors
/// [`Error::Unsupported`] when the zone has no thermostat, or one that controls a list of zones.
pub fn own_thermostat(model: &mut Model, zone: &str, heating: f64, cooling: f64) -> Result<Setpoints> {
    zone_controls::remove(model, zone)?;
    remove_ems_programs(model, |actuator| sets_setpoint_of(actuator, zone));
    let thermostat = match thermostat(model, zone) {
        None => {
            return Err(Error::unsupported("Zone", zone, "it has no thermostat"));
        }
        Some((name, None)) => name,
        Some((name, Some(list))) => {
            let why = format!("it controls the zone list `{list}`; give each zone a thermostat");
            return Err(Error::unsupported("ZoneControl:Thermostat", &name, &why));
        }
    };
    let free = |name: String| free_name(model, name);
    let setpoints =
        Setpoints { heating: free(heating_setpoint(zone)), cooling: free(cooling_setpoint(zone)) };
    constant_schedule(model, &setpoints.heating, heating);
    constant_schedule(model, &setpoints.cooling, cooling);
    constant_schedule(model, DUAL_SETPOINT, 4.0);
    for control in controls(model, model.require("ZoneControl:Thermostat", &thermostat)?) {
        if let Some(old) = control.heating.filter(|_| heating > OUT_OF_REACH_BELOW) {
            read_instead(model, &old, &setpoints.heating);
        }
        if let Some(old) = control.cooling.filter(|_| cooling < OUT_OF_REACH) {
            read_instead(model, &old, &setpoints.cooling);
        }
    }
    let dual = format!("{zone} Dual Setpoint");
    model.insert(
        "ThermostatSetpoint:DualSetpoint",
        &dual,
        json!({
            "heating_setpoint_temperature_schedule_name": setpoints.heating,
            "cooling_setpoint_temperature_schedule_name": setpoints.cooling,
        }),
    );
    let fields = model.require_mut("ZoneControl:Thermostat", &thermostat)?;
    fields.retain(|field, _| matches!(field.as_str(), "idf_order" | "zone_or_zonelist_name"));
    fields.insert("control_type_schedule_name".into(), DUAL_SETPOINT.into());
    fields.insert("control_1_object_type".into(), "ThermostatSetpoint:DualSetpoint".into());
    fields.insert("control_1_name".into(), dual.into());
    Ok(setpoints)
}

/// Returns whether an EMS actuator sets a setpoint of a zone's temperature.
fn sets_setpoint_of(actuator: &Fields, zone: &str) -> bool {
    const SETPOINTS: [&str; 2] = ["Heating Setpoint", "Cooling Setpoint"];
    let set = text(actuator, "actuated_component_control_type").unwrap_or_default();
    acts_on(actuator, zone) && SETPOINTS.iter().any(|setpoint| set.eq_ignore_ascii_case(setpoint))
}

/// Returns a name for a `Schedule:Constant` that may be replaced.
fn free_name(model: &Model, mut name: String) -> String {
    while is_taken(model, &name) {
        name.push_str(" in Use");
    }
    name
}

/// Returns whether another kind of schedule has a name, or a constant one that is used for more than setpoints of
/// thermostats.
fn is_taken(model: &Model, name: &str) -> bool {
    const CONSTANT: &str = "Schedule:Constant";
    let is_other = |class: &str| class.starts_with("Schedule:") && class != CONSTANT;
    let names = |fields: &Fields| {
        fields.values().any(|value| value.as_str().is_some_and(|text| text.eq_ignore_ascii_case(name)))
    };
    let uses = |class: &str| {
        !class.starts_with("ThermostatSetpoint:")
            && model.objects(class).into_iter().any(|(_, fields)| names(fields))
    };
    model.classes().any(|class| is_other(class) && model.contains(class, name))
        || model.contains(CONSTANT, name) && model.classes().any(uses)
}

/// Name of the schedule of a zone's heating setpoint, °C.
pub fn heating_setpoint(zone: &str) -> String {
    format!("{zone} Heating Setpoint")
}

/// Name of the schedule of a zone's cooling setpoint, °C.
pub fn cooling_setpoint(zone: &str) -> String {
    format!("{zone} Cooling Setpoint")
}

/// Returns whether a unit or a setpoint manager is controlled by the thermostat of a zone.
pub(in crate::hvac) fn governs(model: &Model, zone: &str) -> bool {
    let is_control = |field: &str| field.contains("control") && field.contains("zone");
    let names = |fields: &Fields| {
        fields.iter().any(|(field, value)| {
            is_control(field) && value.as_str().is_some_and(|name| name.eq_ignore_ascii_case(zone))
        })
    };
    let mut classes = model.classes().filter(|class| !class.starts_with("AvailabilityManager"));
    classes.any(|class| model.objects(class).into_iter().any(|(_, fields)| names(fields)))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::Value;

    use super::*;

    fn model(text: Value) -> Model {
        Model::from_epjson(&text.to_string(), Path::new("test.epJSON")).unwrap()
    }

    #[test]
    fn a_thermostat_that_two_zones_shared_is_split() {
        let mut model = model(json!({"ZoneControl:Thermostat": {
            "A": {"zone_or_zonelist_name": "ZA", "control_1_name": "Shared", "control_2_name": "X"},
            "B": {"zone_or_zonelist_name": "ZB", "control_1_name": "Shared"},
        }}));
        let setpoints = own_thermostat(&mut model, "ZA", 21.0, 90.0).unwrap();
        let thermostat = model.require("ZoneControl:Thermostat", "A").unwrap();
        let dual = model.require("ThermostatSetpoint:DualSetpoint", "ZA Dual Setpoint").unwrap();
        assert_eq!(thermostat["control_1_name"], "ZA Dual Setpoint");
        assert!(!thermostat.contains_key("control_2_name"));
        assert_eq!(dual["heating_setpoint_temperature_schedule_name"], setpoints.heating);
        assert_eq!(model.require("Schedule:Constant", &setpoints.cooling).unwrap()["hourly_value"], 90.0);
        assert_eq!(model.require("ZoneControl:Thermostat", "B").unwrap()["control_1_name"], "Shared");
    }

    #[test]
    fn a_schedule_that_another_object_uses_is_not_replaced() {
        let mut model = model(json!({
            "ZoneControl:Thermostat": {"T": {"zone_or_zonelist_name": "ZA"}},
            "Schedule:Constant": {"ZA Heating Setpoint": {"hourly_value": 18.0},
                                  "ZA Cooling Setpoint": {"hourly_value": 25.0}},
            "SetpointManager:Scheduled": {"M": {"schedule_name": "za heating setpoint"}},
            "ThermostatSetpoint:SingleCooling": {"S": {"setpoint_temperature_schedule_name": "ZA Cooling Setpoint"}},
        }));
        let setpoints = own_thermostat(&mut model, "ZA", 21.0, 90.0).unwrap();
        assert_eq!(setpoints.heating, "ZA Heating Setpoint in Use");
        assert_eq!(setpoints.cooling, "ZA Cooling Setpoint");
        assert_eq!(model.require("Schedule:Constant", "ZA Heating Setpoint").unwrap()["hourly_value"], 18.0);
    }

    #[test]
    fn a_thermostat_of_a_zone_list_is_rejected_by_name() {
        let mut model = model(json!({
            "ZoneControl:Thermostat": {"T": {"zone_or_zonelist_name": "All"}},
            "ZoneList": {"All": {"zones": [{"zone_name": "ZA"}]}},
        }));
        let error = own_thermostat(&mut model, "ZA", 21.0, 90.0).unwrap_err();
        assert!(error.to_string().contains("`T`"), "{error}");
    }
}
