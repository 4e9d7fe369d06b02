//! Exchange of data with another program, which an environment does not have: its initial values replace it.

use serde_json::{Value, json};

use crate::model::{Fields, Model, begins, text};

/// Root of the classes.
const ROOT: &str = "ExternalInterface";
/// The kind of interface that runs native code in the engine.
const IMPORT: &str = "FunctionalMockupUnitImport";
/// Schedules, and variables of EMS programs, that the other program sets.
const SCHEDULES: [&str; 2] =
    ["ExternalInterface:Schedule", "ExternalInterface:FunctionalMockupUnitExport:To:Schedule"];
const VARIABLES: [&str; 2] =
    ["ExternalInterface:Variable", "ExternalInterface:FunctionalMockupUnitExport:To:Variable"];

/// Replaces the objects through which another program would control a model with their initial values, unless the model
/// runs native code. Returns a note if there are any.
///
/// Schedules are constant, variables of EMS programs keep their values, and actuators are left to the model.
pub(super) fn replace(model: &mut Model) -> Option<String> {
    let names_import = |fields: &Fields| {
        text(fields, "name_of_external_interface").is_some_and(|kind| kind.eq_ignore_ascii_case(IMPORT))
    };
    let is_import = model.objects(ROOT).into_iter().any(|(_, fields)| names_import(fields));
    let classes: Vec<String> =
        model.classes().filter(|class| begins(class, ROOT)).map(str::to_owned).collect();
    if is_import || classes.is_empty() {
        return None;
    }
    let schedules = SCHEDULES.map(|class| replace_schedules(model, class)).iter().sum::<usize>();
    let variables = VARIABLES.map(|class| replace_variables(model, class)).iter().sum::<usize>();
    let others: usize = classes
        .iter()
        .filter(|class| class.contains("ctuator"))
        .map(|class| model.objects(class).len())
        .sum();
    classes.iter().for_each(|class| model.remove_class(class));
    Some(format!(
        "another program would control this model: its {schedules} schedules and {variables} variables keep their initial \
         values, and its {others} actuators are left to the model"
    ))
}

fn replace_schedules(model: &mut Model, class: &str) -> usize {
    let names = model.names(class);
    for name in &names {
        let Some(fields) = model.remove(class, name) else { continue };
        // The classes of co-simulation name the schedule in a field.
        let schedule = text(&fields, "schedule_name").unwrap_or(name).to_owned();
        let limits = ["schedule_type_limits_name", "schedule_type_limits_names"];
        let mut constant = json!({"hourly_value": initial(&fields)});
        if let Some(limits) = limits.iter().find_map(|field| text(&fields, field)) {
            constant["schedule_type_limits_name"] = json!(limits);
        }
        model.insert("Schedule:Constant", &schedule, constant);
    }
    names.len()
}

fn replace_variables(model: &mut Model, class: &str) -> usize {
    let names = model.names(class);
    for (number, name) in (1..).zip(&names) {
        let Some(fields) = model.remove(class, name) else { continue };
        let variable = text(&fields, "variable_name").unwrap_or(name).to_owned();
        let object = free(model, format!("Initial value {number} of {class}").replace(':', " "));
        model.insert(
            "EnergyManagementSystem:GlobalVariable",
            &object,
            json!({"variables": [{"erl_variable_name": variable}]}),
        );
        let program = free(model, format!("Set_{variable}"));
        let line = format!("SET {variable} = {}", initial(&fields));
        model.insert("EnergyManagementSystem:Program", &program, json!({"lines": [{"program_line": line}]}));
        let manager = json!({
            "energyplus_model_calling_point": "BeginNewEnvironment",
            "programs": [{"program_name": program}],
        });
        model.insert("EnergyManagementSystem:ProgramCallingManager", &object, manager);
    }
    names.len()
}

/// Returns a name that no object of the EMS has: programs and subroutines share theirs.
fn free(model: &Model, mut name: String) -> String {
    let is_taken = |name: &str| {
        model.classes().any(|class| begins(class, "EnergyManagementSystem:") && model.contains(class, name))
    };
    while is_taken(&name) {
        name.push_str("_initially");
    }
    name
}

fn initial(fields: &Fields) -> Value {
    fields.get("initial_value").filter(|value| value.is_number()).cloned().unwrap_or(json!(0.0))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn replaced(model: Value) -> (Model, Option<String>) {
        let mut model = Model::from_epjson(&model.to_string(), Path::new("test.epJSON")).unwrap();
        let note = replace(&mut model);
        (model, note)
    }

    #[test]
    fn schedules_and_variables_of_another_program_keep_their_initial_values() {
        let (model, note) = replaced(json!({
            "ExternalInterface": {"I": {"name_of_external_interface": "PtolemyServer"}},
            "ExternalInterface:Schedule": {"Heat": {"schedule_type_limits_name": "Any", "initial_value": 21}},
            "ExternalInterface:FunctionalMockupUnitExport:To:Schedule": {
                "To 1": {"schedule_name": "Cool", "schedule_type_limits_names": "Any", "initial_value": 26.5},
            },
            "ExternalInterface:Variable": {"fan": {"initial_value": 0.5}},
            "ExternalInterface:Actuator": {"A": {}},
        }));
        let value =
            |name| model.get("Schedule:Constant", name).unwrap().get("hourly_value").unwrap().as_f64();
        assert_eq!((value("Heat"), value("Cool")), (Some(21.0), Some(26.5)));
        let program = model.get("EnergyManagementSystem:Program", "Set_fan").unwrap();
        assert_eq!(program["lines"][0]["program_line"], "SET fan = 0.5");
        assert!(!model.classes().any(|class| class.starts_with("ExternalInterface")));
        assert!(note.unwrap().contains("2 schedules and 1 variables"));
    }

    #[test]
    fn objects_of_the_model_are_not_replaced() {
        const INITIAL: &str = "Initial value 1 of ExternalInterface Variable";
        let theirs = json!({"lines": [{"program_line": "SET Fan = 1"}]});
        let (model, _) = replaced(json!({
            "ExternalInterface:Variable": {"fan": {"initial_value": 0.5}},
            "EnergyManagementSystem:Program": {"SET_Fan": theirs.clone()},
            "EnergyManagementSystem:Subroutine": {"Set_fan_initially": {}},
            "EnergyManagementSystem:ProgramCallingManager": {(INITIAL): {"programs": []}},
        }));
        let program = |name| model.get("EnergyManagementSystem:Program", name);
        assert_eq!(program("Set_fan").unwrap()["lines"], theirs["lines"]);
        assert!(program("Set_fan_initially_initially").is_some());
        let managers = model.objects("EnergyManagementSystem:ProgramCallingManager");
        let calls: Vec<_> = managers.iter().map(|(_, fields)| &fields["programs"]).collect();
        assert_eq!(calls, [&json!([]), &json!([{"program_name": "Set_fan_initially_initially"}])]);
    }

    #[test]
    fn a_model_with_native_code_is_not_changed() {
        let native = json!({
            "ExternalInterface": {"I": {"name_of_external_interface": "FunctionalMockupUnitImport"}},
            "ExternalInterface:Schedule": {"Heat": {"initial_value": 21}},
        });
        assert_eq!(replaced(native.clone()).1, None);
        assert!(replaced(native).0.contains("ExternalInterface:Schedule", "Heat"));
    }
}
