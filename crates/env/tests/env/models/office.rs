//! The medium office of 2004.

use crate::case::Case;

const REHEAT: &str = "AirTerminal:SingleDuct:VAV:Reheat";
const NO_REHEAT: &str = "AirTerminal:SingleDuct:VAV:NoReheat";
const CHICAGO: &str = "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw";

/// Returns the office with terminals without reheat in its core zones.
pub fn with_bare_terminals() -> Case {
    Case::imported_after("RefBldgMediumOfficeNew2004_Chicago.idf", CHICAGO, |model| {
        for name in model.names(REHEAT).into_iter().filter(|name| name.to_lowercase().contains("core")) {
            let mut fields = model.remove(REHEAT, &name).unwrap();
            let coil = ["reheat_coil_object_type", "reheat_coil_name"].map(|field| fields[field].clone());
            model.remove(coil[0].as_str().unwrap(), coil[1].as_str().unwrap());
            fields.retain(|field, _| {
                !field.contains("reheat") && !field.contains("damper") && !field.contains("maximum_flow")
            });
            model.insert(NO_REHEAT, &name, fields.into());
        }
        for (_, _, unit) in model.objects_mut().filter(|(class, ..)| *class == "ZoneHVAC:AirDistributionUnit")
        {
            if unit["air_terminal_name"].as_str().unwrap().to_lowercase().contains("core") {
                unit.insert("air_terminal_object_type".into(), NO_REHEAT.into());
            }
        }
    })
}
