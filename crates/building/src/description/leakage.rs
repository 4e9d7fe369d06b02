//! Infiltration of zones.
//!
//! Models specify leakage as a design flow with coefficients, an effective leakage area or a flow coefficient. To
//! compare them, all are evaluated at [`TEMPERATURE_DIFFERENCE`] and [`WIND`] with schedules at 1. Infiltration through
//! opened doors is excluded; the prototypes mark it by name.

use crate::Model;
use crate::model::{Fields, number, text};
use crate::zone::{Space, Zone, covered, place};

/// Reference temperature difference between zone and outdoors, K.
pub const TEMPERATURE_DIFFERENCE: f64 = 20.0;
/// Reference wind speed at the zone, m/s.
pub const WIND: f64 = 3.0;

/// Measures of a zone or a space to which a design flow may be normalized.
pub(super) struct Measures {
    /// m².
    pub(super) floor: f64,
    /// Surfaces to the outdoors, m².
    pub(super) exterior: f64,
    /// m².
    pub(super) exterior_walls: f64,
    /// m³.
    pub(super) volume: f64,
}

/// Evaluates the flow of an object of a class, m³/s.
type Form = fn(&Fields, &Measures) -> f64;

/// Returns the leakage of a zone, m³/s. `measures` are the zone's, or those of a space in it.
pub(super) fn flow(model: &Model, zone: &Zone, measures: impl Fn(Option<&Space>) -> Measures) -> f64 {
    const FORMS: [(&str, Form); 3] = [
        ("ZoneInfiltration:DesignFlowRate", design_flow),
        ("ZoneInfiltration:EffectiveLeakageArea", effective_leakage_area),
        ("ZoneInfiltration:FlowCoefficient", flow_coefficient),
    ];
    let of_object = |form: Form, fields: &Fields| -> f64 {
        let Some(place) = place(fields) else { return 0.0 };
        let parts = covered(model, place, &zone.name);
        parts.iter().map(|space| form(fields, &measures(space.as_ref()))).sum()
    };
    let of_form = |(class, form): (&str, Form)| -> f64 {
        let leaks = model.objects(class).into_iter().filter(|(name, _)| !is_door(name));
        leaks.map(|(_, fields)| of_object(form, fields)).sum()
    };
    FORMS.into_iter().map(of_form).sum()
}

/// Returns whether an infiltration object represents doors opened by people, by its name. `Outdoor` and `indoor` do not
/// count as doors.
pub fn is_door(name: &str) -> bool {
    name.to_ascii_lowercase().replace("outdoor", "").replace("indoor", "").contains("door")
}

fn design_flow(fields: &Fields, measures: &Measures) -> f64 {
    let read = |field: &str| number(fields, field).unwrap_or(0.0);
    let method = text(fields, "design_flow_rate_calculation_method").unwrap_or("Flow/Zone");
    let design = match method.to_ascii_lowercase().as_str() {
        "flow/area" => read("flow_rate_per_floor_area") * measures.floor,
        "flow/exteriorarea" => read("flow_rate_per_exterior_surface_area") * measures.exterior,
        "flow/exteriorwallarea" => read("flow_rate_per_exterior_surface_area") * measures.exterior_walls,
        "airchanges/hour" => read("air_changes_per_hour") * measures.volume / 3600.0,
        _ => read("design_flow_rate"),
    };
    let weather = number(fields, "constant_term_coefficient").unwrap_or(1.0)
        + read("temperature_term_coefficient") * TEMPERATURE_DIFFERENCE
        + read("velocity_term_coefficient") * WIND
        + read("velocity_squared_term_coefficient") * WIND * WIND;
    design * weather
}

/// Sherman-Grimsrud model, as in EnergyPlus: area in cm², coefficients in (L/s)²/(cm⁴·K) and (L/s)²/(cm⁴·(m/s)²).
fn effective_leakage_area(fields: &Fields, _: &Measures) -> f64 {
    let read = |field: &str| number(fields, field).unwrap_or(0.0);
    let pressure =
        read("stack_coefficient") * TEMPERATURE_DIFFERENCE + read("wind_coefficient") * WIND * WIND;
    read("effective_air_leakage_area") / 1000.0 * pressure.sqrt()
}

/// The enhanced model of Walker and Wilson (AIM-2), as in EnergyPlus.
fn flow_coefficient(fields: &Fields, _: &Measures) -> f64 {
    let read = |field: &str| number(fields, field).unwrap_or(0.0);
    let exponent = number(fields, "pressure_exponent").unwrap_or(0.67);
    let stack = read("stack_coefficient") * libm::pow(TEMPERATURE_DIFFERENCE, exponent);
    let wind = read("wind_coefficient") * libm::pow(read("shelter_factor") * WIND, 2.0 * exponent);
    read("flow_coefficient") * libm::hypot(stack, wind)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn leak(class: &str, mut fields: serde_json::Value) -> f64 {
        let mut model = Model::default();
        let place = if class.ends_with("Rate") {
            "zone_or_zonelist_or_space_or_spacelist_name"
        } else {
            "zone_or_space_name"
        };
        fields[place] = json!("room");
        model.insert(class, "Leak", fields.clone());
        assert_eq!(of(&model, "Hall"), 0.0);
        let flow = of(&model, "Room");
        // The same in each half of the room: once the amount, and half a density.
        for space in ["North", "South"] {
            model.insert("Space", space, json!({"zone_name": "Room", "floor_area": 10.0}));
        }
        assert_eq!(of(&model, "Room"), flow, "{class} in an object for the whole zone");
        fields[place] = json!("south");
        model.insert(class, "Leak", fields.clone());
        let is_density =
            fields["design_flow_rate_calculation_method"].as_str().is_some_and(|m| m != "Flow/Zone");
        let expected = if is_density { flow / 2.0 } else { flow };
        assert!((of(&model, "Room") - expected).abs() < 1e-12, "{class} in a space");
        flow
    }

    /// The leakage of a zone of 20 m², or a space in it with half of everything.
    fn of(model: &Model, zone: &str) -> f64 {
        let zone = Zone { name: zone.to_owned(), floor_area: 20.0, multiplier: 1.0 };
        flow(model, &zone, |space| {
            let floor = space.map_or(zone.floor_area, |space| space.floor_area);
            Measures { floor, exterior: 2.5 * floor, exterior_walls: 1.5 * floor, volume: 3.0 * floor }
        })
    }

    #[test]
    fn doors_are_told_from_the_outdoors() {
        assert!(is_door("Dock Door_Infil") && is_door("Outdoor air at the DOOR"));
        assert!(!is_door("Outdoor air infiltration") && !is_door("Indoor leak"));
    }

    #[test]
    fn every_method_of_a_design_flow_is_supported() {
        for (method, field, value) in [
            ("Flow/Zone", "design_flow_rate", 0.12),
            ("Flow/Area", "flow_rate_per_floor_area", 0.006),
            ("Flow/ExteriorArea", "flow_rate_per_exterior_surface_area", 0.0024),
            ("Flow/ExteriorWallArea", "flow_rate_per_exterior_surface_area", 0.004),
            ("AirChanges/Hour", "air_changes_per_hour", 7.2),
        ] {
            let fields = json!({"design_flow_rate_calculation_method": method, field: value});
            let flow = leak("ZoneInfiltration:DesignFlowRate", fields);
            assert!((flow - 0.12).abs() < 1e-12, "{method}: {flow}");
        }
    }

    #[test]
    fn wind_and_temperature_have_coefficients() {
        let fields = json!({"design_flow_rate": 1.0, "constant_term_coefficient": 0, "velocity_term_coefficient": 0.224});
        assert!((leak("ZoneInfiltration:DesignFlowRate", fields) - 0.672).abs() < 1e-12);
        let fields = json!({"effective_air_leakage_area": 500, "stack_coefficient": 0.000145, "wind_coefficient": 0.000174});
        let flow = leak("ZoneInfiltration:EffectiveLeakageArea", fields);
        assert!((flow - 0.5 * (0.0029_f64 + 0.001566).sqrt()).abs() < 1e-12, "{flow}");
    }

    #[test]
    fn stack_and_wind_add_in_quadrature() {
        let fields = json!({"flow_coefficient": 0.05, "pressure_exponent": 0.5, "stack_coefficient": 0.1,
            "wind_coefficient": 0.2, "shelter_factor": 0.5});
        let flow = leak("ZoneInfiltration:FlowCoefficient", fields);
        assert!((flow - 0.05 * (0.2_f64 + 0.09).sqrt()).abs() < 1e-12, "{flow}");
    }
}
