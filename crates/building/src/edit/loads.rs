//! Loads that a model gives per zone or building but that depend on the floor area.

use super::geometry::multiply;
use crate::Model;

/// Fields that scale with floor area. Values per area (W/m², m²/person, m³/s·m²) are not changed; autosized equipment
/// follows its loads.
///
/// A larger shop has more doors and visitors: flows through doors scale too. The refrigerated cases of a restaurant do
/// not.
const ABSOLUTE: &[(&str, &str)] = &[
    ("People", "number_of_people"),
    ("Lights", "lighting_level"),
    ("ElectricEquipment", "design_level"),
    ("ElectricEquipment:ITE:AirCooled", "number_of_units"),
    ("GasEquipment", "design_level"),
    ("HotWaterEquipment", "design_level"),
    ("SteamEquipment", "design_level"),
    ("OtherEquipment", "design_level"),
    ("InternalMass", "surface_area"),
    // Parking, façade and entrance lighting.
    ("Exterior:Lights", "design_level"),
    // Elevators.
    ("Exterior:FuelEquipment", "design_level"),
    ("ElectricLoadCenter:Transformer", "rated_capacity"),
    // Kitchen hoods, dining exhaust and the make-up air that goes with them.
    ("Fan:ZoneExhaust", "maximum_flow_rate"),
    ("ZoneMixing", "design_flow_rate"),
    ("ZoneCrossMixing", "design_flow_rate"),
    ("DesignSpecification:OutdoorAir", "outdoor_air_flow_per_zone"),
    ("Sizing:Zone", "cooling_design_air_flow_rate"),
    ("Sizing:Zone", "cooling_minimum_air_flow"),
    ("Sizing:Zone", "heating_design_air_flow_rate"),
    ("Sizing:Zone", "heating_maximum_air_flow"),
    ("Sizing:System", "design_outdoor_air_flow_rate"),
    ("ZoneVentilation:DesignFlowRate", "design_flow_rate"),
    ("ZoneVentilation:WindandStackOpenArea", "opening_area"),
    ("ZoneInfiltration:DesignFlowRate", "design_flow_rate"),
    ("ZoneInfiltration:EffectiveLeakageArea", "effective_air_leakage_area"),
    ("ZoneInfiltration:FlowCoefficient", "flow_coefficient"),
    ("WaterUse:Equipment", "peak_flow_rate"),
    ("WaterHeater:Mixed", "peak_use_flow_rate"),
    ("WaterHeater:Mixed", "heater_maximum_capacity"),
    ("WaterHeater:Mixed", "tank_volume"),
];

/// Multiplies loads per zone or building by the ratio of floor areas.
pub fn scale(model: &mut Model, floor_area_ratio: f64) {
    for (class, field) in ABSOLUTE {
        for name in model.names(class) {
            if let Some(fields) = model.get_mut(class, &name) {
                multiply(fields, field, floor_area_ratio);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn watts_grow_with_the_floor_and_watts_per_area_do_not() {
        let mut model = Model::default();
        model.insert("ElectricEquipment", "E", json!({"design_level": 100, "watts_per_floor_area": 5}));
        model.insert("Sizing:System", "S", json!({"design_outdoor_air_flow_rate": "Autosize"}));
        scale(&mut model, 1.5);
        let equipment = model.get("ElectricEquipment", "E").unwrap();
        assert_eq!(
            (&equipment["design_level"], &equipment["watts_per_floor_area"]),
            (&json!(150.0), &json!(5))
        );
        assert_eq!(model.get("Sizing:System", "S").unwrap()["design_outdoor_air_flow_rate"], "Autosize");
    }
}
