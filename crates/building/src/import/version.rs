//! The version of EnergyPlus that a model was written for.
//!
//! The engine simulates a model of another version with a warning, although the meaning of fields changes between versions.
//! By comparison of the engine's schemas, the classes with fields that were moved, renamed or given a default with another
//! effect between 25.1 and 25.2 are those of [`CHANGED`], and outputs, which are removed. Output variables were renamed as
//! well.

use serde_json::json;

use crate::model::{Fields, Model, text};

/// The version before the engine's, whose models are updated.
const PREVIOUS: &str = "25.1";
/// Beginnings of the classes whose fields changed after it.
const CHANGED: [&str; 9] = [
    "AirLoopHVAC:UnitaryHeatPump:AirToAir:MultiSpeed",
    "Coil:Cooling:DX:VariableSpeed",
    "Coil:Heating:DX:VariableSpeed",
    "Coil:Cooling:WaterToAirHeatPump:",
    "Coil:Heating:WaterToAirHeatPump:",
    "Coil:WaterHeating:AirToWaterHeatPump:",
    "ComfortViewFactorAngles",
    "GroundHeatExchanger:System",
    "HeatExchanger:Desiccant:BalancedFlow",
];
/// Parts of the names of output variables that changed after it, which EMS sensors refer to.
const RENAMED: [(&str, &str); 3] = [
    ("Inside Faces Total Conduction Heat", "Inside Faces Conduction Heat"),
    ("Chilled Water Thermal Storage ", "Chilled Water Thermal Storage Tank "),
    ("Hot Water Thermal Storage ", "Hot Water Thermal Storage Tank "),
];

/// Makes a model of the previous version one of the engine's, and returns the problem with any other.
pub(super) fn update(model: &mut Model, engine: &str) -> Result<(), String> {
    let expected = engine.split('.').take(2).collect::<Vec<_>>().join(".");
    let is = |version: &str, of: &str| version == of || version.starts_with(&format!("{of}."));
    let version = model.objects("Version").first().and_then(|(_, fields)| text(fields, "version_identifier"));
    let Some(version) = version.map(str::to_owned) else { return Ok(()) };
    if is(&version, &expected) {
        return Ok(());
    }
    const REMEDY: &str = "Convert it with the IDFVersionUpdater of an EnergyPlus installation \
                          (github.com/NREL/EnergyPlus/releases)";
    if !is(&version, PREVIOUS) {
        return Err(format!(
            "it is a model of EnergyPlus {version}; expected {expected} or {PREVIOUS}. {REMEDY}"
        ));
    }
    if let Some(class) = model.classes().find(|class| CHANGED.iter().any(|begin| class.starts_with(begin))) {
        return Err(format!(
            "it is a model of EnergyPlus {version} with {class}, whose fields are different in {expected}. {REMEDY}"
        ));
    }
    for (class, _, fields) in model.objects_mut() {
        if class == "Version" {
            fields.insert("version_identifier".into(), json!(expected));
        } else if class == "EnergyManagementSystem:Sensor" {
            rename(fields, "output_variable_or_output_meter_name");
        }
    }
    Ok(())
}

fn rename(fields: &mut Fields, field: &str) {
    let Some(name) = text(fields, field) else { return };
    let renamed = RENAMED.iter().find(|(from, to)| name.contains(from) && !name.contains(to));
    if let Some((from, to)) = renamed {
        let name = name.replace(from, to);
        fields.insert(field.to_owned(), json!(name));
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::Value;

    use super::*;

    fn updated(version: &str, model: Value) -> Result<Model, String> {
        let mut model = Model::from_epjson(&model.to_string(), Path::new("test.epJSON")).unwrap();
        model.insert("Version", "Version 1", json!({"version_identifier": version}));
        update(&mut model, "25.2.0-cf7368216c").map(|()| model)
    }

    #[test]
    fn the_previous_version_becomes_the_engines() {
        let field = "output_variable_or_output_meter_name";
        for version in ["25.1", "25.1.0"] {
            let storage = json!({field: "Hot Water Thermal Storage Final Tank Temperature"});
            let model =
                updated(version, json!({"EnergyManagementSystem:Sensor": {"Tank": storage}})).unwrap();
            let value = |class, name, field| text(model.get(class, name).unwrap(), field).unwrap().to_owned();
            assert_eq!(value("Version", "Version 1", "version_identifier"), "25.2");
            let sensor = value("EnergyManagementSystem:Sensor", "Tank", field);
            assert_eq!(sensor, "Hot Water Thermal Storage Tank Final Tank Temperature");
        }
        assert!(updated("25.2", json!({})).is_ok());
    }

    #[test]
    fn other_versions_and_changed_classes_are_rejected_with_a_remedy() {
        let said = updated("9.4", json!({})).unwrap_err();
        assert!(
            said.contains("9.4") && said.contains("25.2") && said.contains("IDFVersionUpdater"),
            "{said}"
        );
        let said = updated("25.1", json!({"Coil:Heating:DX:VariableSpeed": {"Coil": {}}})).unwrap_err();
        assert!(
            said.contains("Coil:Heating:DX:VariableSpeed") && said.contains("IDFVersionUpdater"),
            "{said}"
        );
    }
}
