//! Infiltration through the envelope.

use crate::Model;
use crate::description::leakage::is_door;
use crate::edit::geometry::multiply;

/// The infiltration objects of the engine with their flow fields.
const LEAKAGE: &[(&str, &[&str])] = &[
    (
        "ZoneInfiltration:DesignFlowRate",
        &[
            "design_flow_rate",
            "flow_rate_per_floor_area",
            "flow_rate_per_exterior_surface_area",
            "air_changes_per_hour",
        ],
    ),
    ("ZoneInfiltration:EffectiveLeakageArea", &["effective_air_leakage_area"]),
    ("ZoneInfiltration:FlowCoefficient", &["flow_coefficient"]),
];

/// Multiplies all infiltration, including in attics. Infiltration through opened doors, which the prototypes mark by
/// `Door` in the name, and ventilation are not changed. Returns the number of objects.
pub fn scale(model: &mut Model, multiplier: f64) -> usize {
    let mut count = 0;
    for (class, fields_of_form) in LEAKAGE {
        for name in model.names(class).into_iter().filter(|name| !is_door(name)) {
            if let Some(fields) = model.get_mut(class, &name) {
                fields_of_form.iter().for_each(|field| multiply(fields, field, multiplier));
                count += 1;
            }
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn every_form_scales_and_doors_do_not() {
        let mut model = Model::default();
        for (class, fields) in LEAKAGE {
            for field in *fields {
                model.insert(class, field, json!({*field: 2.0}));
                model.insert(class, &format!("{field} Door"), json!({*field: 2.0}));
            }
        }
        assert_eq!(scale(&mut model, 1.5), 6);
        for (class, fields) in LEAKAGE {
            for field in *fields {
                assert_eq!(model.get(class, field).unwrap()[*field], 3.0);
                assert_eq!(model.get(class, &format!("{field} Door")).unwrap()[*field], 2.0);
            }
        }
    }
}
