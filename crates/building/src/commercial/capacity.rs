//! Equipment that the prototype sizes for Denver, left to the sizing of each building.

use serde_json::{Value, json};

use crate::Model;
use crate::model::{Fields, number};

/// Sizing factors of the whole building, heating and cooling: the 25 % and 15 % of ASHRAE 90.1 appendix G (G3.1.2.2)
/// where the prototype has less. An agent must be able to warm up a building that it let cool down.
const SIZING_FACTORS: [(&str, f64); 2] = [("heating_sizing_factor", 1.25), ("cooling_sizing_factor", 1.15)];

/// What the prototypes give as numbers for each speed of a cooling coil.
const SPEED_SIZES: [&str; 3] =
    ["gross_rated_total_cooling_capacity", "rated_air_flow_rate", "gross_rated_sensible_heat_ratio"];

/// Puts every size that was computed for Denver back on `Autosize`, and makes the sizing factors enough.
pub(super) fn leave_to_sizing(model: &mut Model) {
    each(model, "Sizing:Parameters", |fields| {
        for (field, least) in SIZING_FACTORS {
            let factor = number(fields, field).unwrap_or(1.0).max(least);
            fields.insert(field.into(), json!(factor));
        }
    });
    each(model, "Coil:Cooling:DX:MultiSpeed", |fields| {
        let speeds = number(fields, "number_of_speeds").unwrap_or_default() as u32;
        for field in (1..=speeds).flat_map(|n| SPEED_SIZES.map(|size| format!("speed_{n}_{size}"))) {
            fields.insert(field, Value::from("Autosize"));
        }
    });
}

fn each(model: &mut Model, class: &str, edit: impl Fn(&mut Fields)) {
    for name in model.names(class) {
        if let Some(fields) = model.get_mut(class, &name) {
            edit(fields);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_speed_of_a_coil_is_sized_anew() {
        let mut model = Model::default();
        model.insert(
            "Coil:Cooling:DX:MultiSpeed",
            "C",
            json!({"number_of_speeds": 2, "speed_1_rated_air_flow_rate": 1.0, "speed_2_gross_rated_cooling_cop": 3.0}),
        );
        leave_to_sizing(&mut model);
        let coil = model.get("Coil:Cooling:DX:MultiSpeed", "C").unwrap();
        assert_eq!(coil["speed_1_rated_air_flow_rate"], "Autosize");
        assert_eq!(coil["speed_2_gross_rated_total_cooling_capacity"], "Autosize");
        assert_eq!(coil["speed_2_gross_rated_cooling_cop"], 3.0);
    }

    #[test]
    fn sizing_factors_are_raised_and_never_lowered() {
        let mut model = Model::default();
        let shipped = json!({"heating_sizing_factor": 1.0, "cooling_sizing_factor": 1.2});
        model.insert("Sizing:Parameters", "P", shipped);
        leave_to_sizing(&mut model);
        let parameters = model.get("Sizing:Parameters", "P").unwrap();
        assert_eq!(parameters["heating_sizing_factor"], 1.25);
        assert_eq!(parameters["cooling_sizing_factor"], 1.2);
    }
}
