//! Edits that every kind of system needs before an agent can drive it.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::model::{Fields, number, text};
use crate::{Error, Model, Result};

/// Schedule that is always 1.
pub const ALWAYS_ON: &str = "B2B Always On";
/// Type limits of the schedules that an agent drives: any number, because bounds are the agent's.
const ANY_NUMBER: &str = "B2B Any Number";
/// Control type of a thermostat with a heating and a cooling setpoint, as a schedule.
const DUAL_SETPOINT: &str = "B2B Dual Setpoint";
/// Schedules that switch a component, in every class that has them.
const SWITCHES: [&str; 2] = ["availability_schedule_name", "supply_air_fan_operating_mode_schedule_name"];

/// A cooling setpoint that no zone reaches, °C: cooling is the agent's, through air it commands. Random play has
/// reached 46 °C.
pub const OUT_OF_REACH: f64 = 90.0;

/// A class and the name of one of its objects.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reference {
    /// EnergyPlus class.
    pub class: String,
    /// Object name.
    pub name: String,
}

/// The schedules behind a zone's thermostat.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setpoints {
    /// Name of the `Schedule:Constant` of the heating setpoint.
    pub heating: String,
    /// Name of the `Schedule:Constant` of the cooling setpoint.
    pub cooling: String,
}

/// Puts a `Schedule:Constant` in: the kind of schedule that an actuator sets.
pub fn constant_schedule(model: &mut Model, name: &str, value: f64) {
    model.insert("ScheduleTypeLimits", ANY_NUMBER, json!({}));
    let fields = json!({"hourly_value": value, "schedule_type_limits_name": ANY_NUMBER});
    model.insert("Schedule:Constant", name, fields);
}

/// Lets an air loop run at every hour: without its availability managers, and with every fan, unit and coil
/// switched on by schedule. Otherwise the fan delivers nothing at night, whatever is commanded.
///
/// # Errors
/// [`Error::MissingObject`] when the loop or one of its components is not in the model.
pub fn always_on(model: &mut Model, air_loop: &str) -> Result<()> {
    remove_availability_managers(model, air_loop)?;
    for component in supply_components(model, air_loop)? {
        switch_on(model, &component)?;
    }
    Ok(())
}

/// The components on the supply side of an air loop, in the order of its branches.
///
/// # Errors
/// [`Error::MissingObject`] when the loop, its branch list or a branch is not in the model.
pub fn supply_components(model: &Model, air_loop: &str) -> Result<Vec<Reference>> {
    let fields = model.require("AirLoopHVAC", air_loop)?;
    let list = text(fields, "branch_list_name").unwrap_or_default();
    let branches = model.require("BranchList", list)?;
    let mut components = Vec::new();
    for branch in items(branches, "branches").filter_map(|item| text(item, "branch_name")) {
        components.extend(
            items(model.require("Branch", branch)?, "components")
                .filter_map(|item| reference(item, "component_object_type", "component_name")),
        );
    }
    Ok(components)
}

/// The one branch of an air loop's supply side.
///
/// # Errors
/// [`Error::Unsupported`] when there are several; [`Error::MissingObject`] for a dangling reference.
pub fn only_branch(model: &Model, air_loop: &str) -> Result<String> {
    let list = text(model.require("AirLoopHVAC", air_loop)?, "branch_list_name").unwrap_or_default();
    let branches: Vec<_> = items(model.require("BranchList", list)?, "branches")
        .filter_map(|item| text(item, "branch_name"))
        .collect();
    match branches[..] {
        [branch] => Ok(branch.to_owned()),
        _ => Err(unsupported("BranchList", list, "its air handler has several branches, known is one")),
    }
}

/// Switches a component on for good, and the fans and coils that it refers to.
///
/// # Errors
/// [`Error::MissingObject`] when it, or one that it refers to, is not in the model.
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

/// The fans and coils that an object refers to, as `…_object_type` with `…_name`.
pub fn parts(fields: &Fields) -> Vec<Reference> {
    fields
        .keys()
        .filter_map(|key| key.strip_suffix("_object_type"))
        .filter(|part| part.contains("fan") || part.contains("coil"))
        .filter_map(|part| reference(fields, &format!("{part}_object_type"), &format!("{part}_name")))
        .collect()
}

/// Gives a zone a thermostat of its own: a heating and a cooling setpoint that no other zone shares, in the
/// schedules `<zone> Heating Setpoint` and `<zone> Cooling Setpoint`, at these values (°C).
///
/// # Errors
/// [`Error::Unsupported`] when the zone has no thermostat, or one that controls a list of zones.
pub fn own_thermostat(model: &mut Model, zone: &str, heating: f64, cooling: f64) -> Result<Setpoints> {
    let thermostat = match thermostat(model, zone) {
        None => {
            return Err(unsupported(
                "Zone",
                zone,
                "it has no thermostat, whose setpoints an agent would give",
            ));
        }
        Some((name, None)) => name,
        Some((name, Some(list))) => {
            let why = format!("it controls the list `{list}`; give each zone a thermostat");
            return Err(unsupported("ZoneControl:Thermostat", &name, &why));
        }
    };
    let setpoints = Setpoints { heating: heating_setpoint(zone), cooling: cooling_setpoint(zone) };
    constant_schedule(model, &setpoints.heating, heating);
    constant_schedule(model, &setpoints.cooling, cooling);
    constant_schedule(model, DUAL_SETPOINT, 4.0);
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

/// Removes the EMS actuators that are unwanted, given their fields, with every program that sets one of them
/// and the calls of these programs. They would take from the agent what it drives.
pub fn remove_ems_programs(model: &mut Model, unwanted: impl Fn(&Fields) -> bool) {
    let actuators: Vec<String> = model
        .objects("EnergyManagementSystem:Actuator")
        .into_iter()
        .filter(|(_, fields)| unwanted(fields))
        .map(|(name, _)| name.to_owned())
        .collect();
    let programs: Vec<String> = model
        .objects("EnergyManagementSystem:Program")
        .into_iter()
        .filter(|(_, fields)| actuators.iter().any(|actuator| mentions(fields, actuator)))
        .map(|(name, _)| name.to_owned())
        .collect();
    for program in &programs {
        remove_calls(model, program);
        model.remove("EnergyManagementSystem:Program", program);
    }
    for actuator in &actuators {
        model.remove("EnergyManagementSystem:Actuator", actuator);
    }
}

/// Whether an EMS actuator sets a schedule: thermostats and availability are schedules, lights are not.
pub fn sets_a_schedule(actuator: &Fields) -> bool {
    text(actuator, "actuated_component_type").is_some_and(|class| class.starts_with("Schedule:"))
}

/// The objects in an array field.
pub fn items<'a>(fields: &'a Fields, array: &str) -> impl Iterator<Item = &'a Fields> {
    fields.get(array).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_object)
}

/// The object that two fields, class and name, refer to.
pub fn reference(fields: &Fields, class: &str, name: &str) -> Option<Reference> {
    Some(Reference { class: text(fields, class)?.to_owned(), name: text(fields, name)?.to_owned() })
}

/// Takes out the setpoint managers on any of these nodes (in lower case): each would write over the setpoint
/// that an agent gives.
pub fn remove_setpoint_managers(model: &mut Model, nodes: &HashSet<String>) {
    let classes: Vec<String> =
        model.classes().filter(|class| class.starts_with("SetpointManager:")).map(str::to_owned).collect();
    for class in &classes {
        for manager in model.names(class) {
            let fields = model.get(class, &manager);
            let target = fields.and_then(|f| text(f, "setpoint_node_or_nodelist_name"));
            let mut set = target.into_iter().flat_map(|target| nodes_of(model, target));
            if set.any(|node| nodes.contains(&node.to_lowercase())) {
                model.remove(class, &manager);
            }
        }
    }
}

/// Whether a setpoint manager takes the setpoint of a node for its own.
pub fn is_referred_to(model: &Model, node: &str) -> bool {
    let classes = model.classes().filter(|class| class.starts_with("SetpointManager:"));
    classes.flat_map(|class| model.objects(class)).any(|(_, fields)| {
        text(fields, "reference_setpoint_node_name").is_some_and(|other| other.eq_ignore_ascii_case(node))
    })
}

/// The nodes of a list, or the one node of this name.
pub fn nodes_of(model: &Model, name: &str) -> Vec<String> {
    match model.get("NodeList", name) {
        Some(list) => {
            items(list, "nodes").filter_map(|item| text(item, "node_name")).map(str::to_owned).collect()
        }
        None => vec![name.to_owned()],
    }
}

/// A size that the model must carry.
///
/// # Errors
/// [`Error::Unsupported`] when the field is not a number.
pub fn size(model: &Model, class: &str, name: &str, field: &str) -> Result<f64> {
    number(model.require(class, name)?, field)
        .ok_or_else(|| unsupported(class, name, &format!("`{field}` must be a number: size the model first")))
}

/// Whether a class is among these: the engine names classes without regard to case.
pub fn is_one_of(class: &str, classes: &[&str]) -> bool {
    classes.iter().any(|known| known.eq_ignore_ascii_case(class))
}

/// Name of the schedule of a zone's heating setpoint, °C.
pub fn heating_setpoint(zone: &str) -> String {
    format!("{zone} Heating Setpoint")
}

/// Name of the schedule of a zone's cooling setpoint, °C.
pub fn cooling_setpoint(zone: &str) -> String {
    format!("{zone} Cooling Setpoint")
}

/// The error for an object that the edits do not know.
pub fn unsupported(class: &str, name: &str, why: &str) -> Error {
    Error::Unsupported { class: class.to_owned(), name: name.to_owned(), why: why.to_owned() }
}

/// The equipment of a zone, in the order of its equipment list. Empty for a zone without any.
///
/// # Errors
/// [`Error::MissingObject`] when the equipment list that the zone names is not in the model.
pub fn zone_equipment(model: &Model, zone: &str) -> Result<Vec<Reference>> {
    let connections = model
        .objects("ZoneHVAC:EquipmentConnections")
        .into_iter()
        .find(|(_, fields)| text(fields, "zone_name").is_some_and(|z| z.eq_ignore_ascii_case(zone)));
    let Some((_, connections)) = connections else { return Ok(Vec::new()) };
    let list = text(connections, "zone_conditioning_equipment_list_name").unwrap_or_default();
    Ok(items(model.require("ZoneHVAC:EquipmentList", list)?, "equipment")
        .filter_map(|item| reference(item, "zone_equipment_object_type", "zone_equipment_name"))
        .collect())
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

/// Gives each zone of a list a thermostat of its own, in the place of one that controls the list. A thermostat that
/// another object refers to stays.
pub(super) fn split_thermostats(model: &mut Model) {
    const CLASS: &str = "ZoneControl:Thermostat";
    for name in model.names(CLASS) {
        let Some(fields) = model.get(CLASS, &name).cloned() else { continue };
        let list = text(&fields, "zone_or_zonelist_name").and_then(|list| model.get("ZoneList", list));
        let Some(list) = list else { continue };
        let zones: Vec<_> =
            items(list, "zones").filter_map(|item| text(item, "zone_name")).map(str::to_owned).collect();
        let refers = |(_, fields): (&str, &Fields)| {
            text(fields, "thermostat_name").is_some_and(|other| other.eq_ignore_ascii_case(&name))
        };
        let extensions: Vec<_> =
            model.classes().filter(|class| class.starts_with("ZoneControl:Thermostat:")).collect();
        if extensions.iter().any(|class| model.objects(class).into_iter().any(refers)) {
            continue;
        }
        model.remove(CLASS, &name);
        for zone in zones {
            let mut own = fields.clone();
            own.insert("zone_or_zonelist_name".into(), zone.clone().into());
            model.insert(CLASS, &format!("{zone} {name}"), Value::Object(own));
        }
    }
}

/// The thermostat of a zone, with the zone list where it controls one.
pub(super) fn thermostat(model: &Model, zone: &str) -> Option<(String, Option<String>)> {
    model.objects("ZoneControl:Thermostat").into_iter().find_map(|(name, fields)| {
        let zones = text(fields, "zone_or_zonelist_name").unwrap_or_default();
        if zones.eq_ignore_ascii_case(zone) {
            return Some((name.to_owned(), None));
        }
        let list = model.get("ZoneList", zones).filter(|list| lists(list, zone));
        list.map(|_| (name.to_owned(), Some(zones.to_owned())))
    })
}

fn lists(zone_list: &Fields, zone: &str) -> bool {
    items(zone_list, "zones")
        .filter_map(|item| text(item, "zone_name"))
        .any(|name| name.eq_ignore_ascii_case(zone))
}

/// Whether a line of an EMS program has this variable as a word.
fn mentions(program: &Fields, variable: &str) -> bool {
    items(program, "lines")
        .filter_map(|item| text(item, "program_line"))
        .flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_'))
        .any(|word| word.eq_ignore_ascii_case(variable))
}

fn remove_calls(model: &mut Model, program: &str) {
    let class = "EnergyManagementSystem:ProgramCallingManager";
    for manager in model.names(class) {
        let Some(calls) = model.get_mut(class, &manager).and_then(|f| f.get_mut("programs")) else {
            continue;
        };
        let Some(calls) = calls.as_array_mut() else { continue };
        calls.retain(|call| {
            !call["program_name"].as_str().is_some_and(|name| name.eq_ignore_ascii_case(program))
        });
        if calls.is_empty() {
            model.remove(class, &manager);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

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
    fn a_loop_that_is_always_on_has_no_managers_and_no_switched_component() {
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
    fn a_thermostat_over_a_list_of_zones_is_named_as_unsupported() {
        let mut model = model(json!({
            "ZoneControl:Thermostat": {"T": {"zone_or_zonelist_name": "All"}},
            "ZoneList": {"All": {"zones": [{"zone_name": "ZA"}]}},
        }));
        let error = own_thermostat(&mut model, "ZA", 21.0, 90.0).unwrap_err();
        assert!(error.to_string().contains("`T`"), "{error}");
    }

    #[test]
    fn a_thermostat_over_a_list_becomes_one_for_each_zone() {
        let mut model = model(json!({
            "ZoneControl:Thermostat": {"T": {"zone_or_zonelist_name": "ALL", "control_1_name": "Shared"}},
            "ZoneList": {"All": {"zones": [{"zone_name": "ZA"}, {"zone_name": "ZB"}]}},
        }));
        split_thermostats(&mut model);
        assert_eq!(model.names("ZoneControl:Thermostat"), ["ZA T", "ZB T"]);
        own_thermostat(&mut model, "ZA", 21.0, 90.0).unwrap();
        assert_eq!(model.require("ZoneControl:Thermostat", "ZB T").unwrap()["control_1_name"], "Shared");
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

    #[test]
    fn programs_that_set_schedules_go_and_the_others_stay() {
        let mut model = model(json!({
            "EnergyManagementSystem:Actuator": {
                "Heat": {"actuated_component_type": "Schedule:Compact"},
                "Lamp": {"actuated_component_type": "Lights"}},
            "EnergyManagementSystem:Program": {
                "Start": {"lines": [{"program_line": "IF Hour==5"}, {"program_line": "SET HEAT=15.6"}]},
                "Dim": {"lines": [{"program_line": "SET Lamp = Heat_Of_Lamp"}]}},
            "EnergyManagementSystem:ProgramCallingManager": {
                "Start Manager": {"programs": [{"program_name": "start"}]},
                "Both": {"programs": [{"program_name": "Start"}, {"program_name": "Dim"}]}},
        }));
        remove_ems_programs(&mut model, sets_a_schedule);
        assert_eq!(model.names("EnergyManagementSystem:Program"), ["Dim"]);
        assert_eq!(model.names("EnergyManagementSystem:Actuator"), ["Lamp"]);
        assert_eq!(model.names("EnergyManagementSystem:ProgramCallingManager"), ["Both"]);
    }
}
