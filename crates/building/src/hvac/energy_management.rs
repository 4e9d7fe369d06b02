//! Energy management system (EMS) programs.

use crate::Model;
use crate::model::{Fields, items, text};

/// Removes the EMS actuators whose fields satisfy `unwanted`, with every program that sets one of them and the calls of
/// these programs. They would override controlled actuators.
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

/// Returns whether an EMS actuator sets a schedule: thermostats and availability are schedules, lights are not.
pub fn sets_a_schedule(actuator: &Fields) -> bool {
    text(actuator, "actuated_component_type").is_some_and(|class| class.starts_with("Schedule:"))
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
