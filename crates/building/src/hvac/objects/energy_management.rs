//! Energy management system (EMS) programs.

use std::collections::HashSet;

use serde_json::json;

use crate::Model;
use crate::model::{Fields, items, text};

/// Class of the programs.
pub const PROGRAM: &str = "EnergyManagementSystem:Program";
const ACTUATOR: &str = "EnergyManagementSystem:Actuator";
/// Field of the component or the zone on which an actuator acts.
const UNIQUE_NAME: &str = "actuated_component_unique_name";
const SENSOR: &str = "EnergyManagementSystem:Sensor";
/// Field of the object that a sensor reads.
const KEY: &str = "output_variable_or_output_meter_index_key_name";
/// Field of the variable that a sensor reads.
const VARIABLE: &str = "output_variable_or_output_meter_name";
/// The schedule that the sensors of removed equipment read.
const ZERO: &str = "b2b Zero";
/// The variable of a schedule.
const SCHEDULE_VALUE: &str = "Schedule Value";

/// Removes the EMS actuators whose fields satisfy `unwanted`, with every program that mentions one of them and the
/// calls of these programs. They would override controlled actuators.
pub fn remove_ems_programs(model: &mut Model, unwanted: impl Fn(&Fields) -> bool) {
    let actuators: Vec<String> = model
        .objects(ACTUATOR)
        .into_iter()
        .filter(|(_, fields)| unwanted(fields))
        .map(|(name, _)| name.to_owned())
        .collect();
    let programs: Vec<String> = model
        .objects(PROGRAM)
        .into_iter()
        .filter(|(_, fields)| actuators.iter().any(|actuator| mentions(fields, actuator)))
        .map(|(name, _)| name.to_owned())
        .collect();
    for program in &programs {
        remove_calls(model, program);
        model.remove(PROGRAM, program);
    }
    for actuator in &actuators {
        model.remove(ACTUATOR, actuator);
    }
}

/// Returns class and name of every object, the name in lower case.
pub fn objects(model: &Model) -> HashSet<(String, String)> {
    let of_class = |class: &str| {
        let names = model.names(class).into_iter();
        names.map(|name| (class.to_owned(), name.to_lowercase())).collect::<Vec<_>>()
    };
    model.classes().flat_map(of_class).collect()
}

/// Makes the EMS sensors of equipment that was removed, or replaced by another class, read zero: a variable that the
/// new equipment does not have would end the run, and a program without its sensor as well.
pub fn silence_sensors(model: &mut Model, before: &HashSet<(String, String)>) {
    let after = objects(model);
    let gone: HashSet<&str> = before.difference(&after).map(|(_, name)| name.as_str()).collect();
    let reads_gone =
        |fields: &Fields| text(fields, KEY).is_some_and(|key| gone.contains(key.to_lowercase().as_str()));
    let sensors = model.objects(SENSOR).into_iter().filter(|(_, fields)| reads_gone(fields));
    let sensors: Vec<String> = sensors.map(|(name, _)| name.to_owned()).collect();
    if sensors.is_empty() {
        return;
    }
    model.insert("Schedule:Constant", ZERO, json!({"hourly_value": 0.0}));
    for sensor in sensors {
        tracing::info!("{SENSOR} `{sensor}`: reads 0, its equipment was replaced");
        model.insert(SENSOR, &sensor, json!({(KEY): ZERO, (VARIABLE): SCHEDULE_VALUE}));
    }
}

/// Returns the EMS sensors whose equipment was removed or replaced, by [`silence_sensors`].
pub fn silenced_sensors(model: &Model) -> Vec<String> {
    schedule_sensors(model).into_iter().filter(|(_, read)| read == ZERO).map(|(sensor, _)| sensor).collect()
}

/// An EMS actuator: its name, and what it sets.
pub struct Setting {
    /// Name of the actuator.
    pub actuator: String,
    /// The quantity and the component or the zone.
    pub what: String,
}

/// Returns what the EMS actuators that a program mentions set.
pub fn settings(model: &Model, program: &Fields) -> Vec<Setting> {
    let mut actuators = model.objects(ACTUATOR);
    actuators.retain(|(name, _)| mentions(program, name));
    let setting = |(name, fields): (&str, &Fields)| {
        let field = |field| text(fields, field).unwrap_or_default();
        let what = format!("{} of `{}`", field("actuated_component_control_type"), field(UNIQUE_NAME));
        Setting { actuator: name.to_owned(), what }
    };
    actuators.into_iter().map(setting).collect()
}

/// Returns whether a model has an EMS actuator by this name.
pub fn has_actuator(model: &Model, name: &str) -> bool {
    model.contains(ACTUATOR, name)
}

/// Returns the EMS sensors that read the value of a schedule, each with the schedule.
pub fn schedule_sensors(model: &Model) -> Vec<(String, String)> {
    let read = |(name, fields): (&str, &Fields)| {
        let is_value = text(fields, VARIABLE)?.eq_ignore_ascii_case(SCHEDULE_VALUE);
        is_value.then_some((name.to_owned(), text(fields, KEY)?.to_owned()))
    };
    model.objects(SENSOR).into_iter().filter_map(read).collect()
}

/// Makes the EMS sensors that read the value of a schedule read another one's.
pub fn read_instead(model: &mut Model, schedule: &str, other: &str) {
    for (sensor, read) in schedule_sensors(model) {
        if read.eq_ignore_ascii_case(schedule)
            && let Some(fields) = model.get_mut(SENSOR, &sensor)
        {
            fields.insert(KEY.into(), other.into());
        }
    }
}

/// Returns whether an EMS actuator sets a schedule: thermostats and availability are schedules, lights are not.
pub fn sets_a_schedule(actuator: &Fields) -> bool {
    text(actuator, "actuated_component_type").is_some_and(|class| class.starts_with("Schedule:"))
}

/// Returns whether an EMS actuator acts on a component or a zone by this name.
pub fn acts_on(actuator: &Fields, name: &str) -> bool {
    text(actuator, UNIQUE_NAME).is_some_and(|acted_on| acted_on.eq_ignore_ascii_case(name))
}

/// Returns whether an EMS actuator sets a schedule by this name.
pub fn sets(model: &Model, schedule: &str) -> bool {
    let sets = |(_, fields): (&str, &Fields)| sets_a_schedule(fields) && acts_on(fields, schedule);
    model.objects(ACTUATOR).into_iter().any(sets)
}

/// Returns whether an EMS program uses a variable.
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

    use serde_json::{Value, json};

    use super::*;

    fn model(text: Value) -> Model {
        Model::from_epjson(&text.to_string(), Path::new("test.epJSON")).unwrap()
    }

    #[test]
    fn sensors_of_replaced_equipment_read_zero_and_others_are_kept() {
        let sensor = |key: &str| json!({(KEY): key, (VARIABLE): "Fan Runtime Fraction"});
        let mut model = model(json!({
            "Fan:OnOff": {"Supply": {}, "Exhaust": {}},
            (SENSOR): {"S": sensor("SUPPLY"), "E": sensor("Exhaust"), "O": sensor("Node 1")},
        }));
        let before = objects(&model);
        model.remove("Fan:OnOff", "Supply");
        model.insert("Fan:SystemModel", "Supply", json!({}));
        silence_sensors(&mut model, &before);
        let key = |name| &model.require(SENSOR, name).unwrap()[KEY];
        assert_eq!([key("S"), key("E"), key("O")], [ZERO, "Exhaust", "Node 1"]);
        assert_eq!(model.require("Schedule:Constant", ZERO).unwrap()["hourly_value"], 0.0);
    }

    #[test]
    fn programs_that_set_schedules_are_removed() {
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
