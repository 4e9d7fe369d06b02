//! Equipment whose sizes the model gives.

use serde_json::Value;

use crate::Model;

/// Prefixes of the classes of equipment that the engine can size.
const EQUIPMENT: [&str; 10] = [
    "AirConditioner:",
    "AirLoopHVAC",
    "AirTerminal:",
    "Boiler:",
    "Chiller:",
    "Coil:",
    "CoolingTower:",
    "Fan:",
    "Pump:",
    "ZoneHVAC:",
];

/// Returns a warning if equipment has sizes that do not follow the loads.
pub(super) fn keeps_sizes(model: &Model) -> Option<String> {
    let mut sized = Vec::new();
    for class in model.classes().filter(|class| is_equipment(class)) {
        for (name, fields) in model.objects(class) {
            let size = fields.iter().find(|(field, value)| is_size(field) && is_positive(value));
            sized.extend(size.map(|(field, _)| format!("{class} `{name}` ({field})")));
        }
    }
    let first = sized.first()?;
    let objects = if sized.len() == 1 { "1 object keeps its size" } else { "objects keep their sizes" };
    let count = if sized.len() == 1 { String::new() } else { format!("{} ", sized.len()) };
    Some(format!(
        "{count}{objects} although the loads change, for example {first}; set them to Autosize to size them anew"
    ))
}

fn is_equipment(class: &str) -> bool {
    // Exhaust fans are scaled with the floor area.
    class != "Fan:ZoneExhaust" && EQUIPMENT.iter().any(|prefix| class.starts_with(prefix))
}

/// Returns whether a field is a size that the loads determine. Crankcase heaters are not.
fn is_size(field: &str) -> bool {
    let is_other = ["minimum", "fraction", "_per_", "crankcase"].iter().any(|word| field.contains(word));
    !is_other && (field.ends_with("flow_rate") || field.ends_with("capacity"))
}

fn is_positive(value: &Value) -> bool {
    value.as_f64().is_some_and(|size| size > 0.0)
}
