//! Availability of equipment: availability managers and schedules.

use serde_json::Value;

use super::air_loop_graph::supply_components;
use super::references::{Reference, parts, reference};
use super::schedules::{ALWAYS_ON, constant_schedule};
use crate::model::{Fields, items, text};
use crate::{Model, Result};

/// Fields of the schedules that switch a component on and off.
const SWITCHES: [&str; 2] = ["availability_schedule_name", "supply_air_fan_operating_mode_schedule_name"];

/// Makes an air loop available at every hour: removes its availability managers and switches on every fan, unit and
/// coil. Otherwise, the fan would stop at night regardless of its command.
///
/// # Errors
/// [`crate::Error::MissingObject`] when the loop or one of its components is not in the model.
pub fn always_on(model: &mut Model, air_loop: &str) -> Result<()> {
    remove_availability_managers(model, air_loop)?;
    for component in supply_components(model, air_loop)? {
        switch_on(model, &component)?;
    }
    Ok(())
}

/// Makes a component, and the fans and coils that it refers to, always available.
///
/// # Errors
/// [`crate::Error::MissingObject`] when it, or one that it refers to, is not in the model.
pub fn switch_on(model: &mut Model, component: &Reference) -> Result<()> {
    constant_schedule(model, ALWAYS_ON, 1.0);
    let fields = model.require_mut(&component.class, &component.name)?;
    for switch in SWITCHES {
        if fields.contains_key(switch) {
            fields.insert(switch.into(), ALWAYS_ON.into());
        }
    }
    for part in parts(fields) {
        switch_on(model, &part)?;
    }
    Ok(())
}

fn remove_availability_managers(model: &mut Model, air_loop: &str) -> Result<()> {
    let fields = model.require_mut("AirLoopHVAC", air_loop)?;
    let Some(Value::String(list)) = fields.remove("availability_manager_list_name") else {
        return Ok(());
    };
    let shared = |fields: &Fields| {
        text(fields, "availability_manager_list_name").is_some_and(|other| other.eq_ignore_ascii_case(&list))
    };
    if model.objects("AirLoopHVAC").into_iter().any(|(_, fields)| shared(fields)) {
        return Ok(());
    }
    let Some(list) = model.remove("AvailabilityManagerAssignmentList", &list) else {
        return Ok(());
    };
    let managers = items(&list, "managers")
        .filter_map(|item| reference(item, "availability_manager_object_type", "availability_manager_name"));
    for manager in managers {
        model.remove(&manager.class, &manager.name);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::json;

    use super::*;

    fn model(text: Value) -> Model {
        Model::from_epjson(&text.to_string(), Path::new("test.epJSON")).unwrap()
    }

    fn night_cycling_loop() -> Model {
        model(json!({
            "AirLoopHVAC": {"L": {
                "availability_manager_list_name": "L List", "branch_list_name": "L Branches"}},
            "AvailabilityManagerAssignmentList": {"L List": {"managers": [{
                "availability_manager_object_type": "AvailabilityManager:NightCycle",
                "availability_manager_name": "L Night"}]}},
            "AvailabilityManager:NightCycle": {"L Night": {}, "Other Night": {}},
            "BranchList": {"L Branches": {"branches": [{"branch_name": "L Main"}]}},
            "Branch": {"L Main": {"components": [
                {"component_object_type": "AirLoopHVAC:UnitarySystem", "component_name": "U"}]}},
            "AirLoopHVAC:UnitarySystem": {"U": {
                "supply_air_fan_operating_mode_schedule_name": "Day",
                "supply_fan_object_type": "Fan:OnOff", "supply_fan_name": "F"}},
            "Fan:OnOff": {"F": {"availability_schedule_name": "Day"}},
        }))
    }

    #[test]
    fn a_loop_that_is_always_on_has_no_managers_and_no_availability_schedules() {
        let mut model = night_cycling_loop();
        always_on(&mut model, "l").unwrap();
        assert_eq!(model.names("AvailabilityManager:NightCycle"), ["Other Night"]);
        assert!(!model.require("AirLoopHVAC", "L").unwrap().contains_key("availability_manager_list_name"));
        let unit = model.require("AirLoopHVAC:UnitarySystem", "U").unwrap();
        assert_eq!(unit["supply_air_fan_operating_mode_schedule_name"], ALWAYS_ON);
        let fan = model.require("Fan:OnOff", "F").unwrap();
        assert_eq!(fan["availability_schedule_name"], ALWAYS_ON);
        assert_eq!(model.require("Schedule:Constant", ALWAYS_ON).unwrap()["hourly_value"], 1.0);
    }

    #[test]
    fn availability_managers_that_another_loop_shares_stay_with_it() {
        let mut model = night_cycling_loop();
        model.insert("AirLoopHVAC", "Other", json!({"availability_manager_list_name": "l list"}));
        always_on(&mut model, "L").unwrap();
        assert!(model.contains("AvailabilityManagerAssignmentList", "L List"));
        assert!(model.contains("AvailabilityManager:NightCycle", "L Night"));
        assert!(!model.require("AirLoopHVAC", "L").unwrap().contains_key("availability_manager_list_name"));
    }
}
