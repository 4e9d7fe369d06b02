//! Exhaust-air energy recovery where the code requires it.

use b2b_building::model::text;
use b2b_building::{BuildingType, Error, Model, Result};
use serde_json::{Value, json};

/// Enthalpy recovery ratio that the code requires at design conditions (ASHRAE 90.1-2019, 6.5.6.1).
const RATIO: f64 = 0.5;
/// Outdoor temperature of frost control, °C; below it, supply air bypasses the wheel part of the time.
const FROST: f64 = -23.3;

const SYSTEM: &str = "AirLoopHVAC:OutdoorAirSystem";
const LIST: &str = "AirLoopHVAC:OutdoorAirSystem:EquipmentList";
const WHEEL: &str = "HeatExchanger:AirToAir:SensibleAndLatent";
const MIXER: &str = "OutdoorAir:Mixer";

/// Returns whether the code requires recovery for a system of a type: see [`Prototype`](b2b_building::Prototype).
fn is_required(building_type: BuildingType, ashrae_zone: &str, system: &str) -> bool {
    let prototype = building_type.data().prototype.as_ref();
    ashrae_zone.starts_with(['7', '8'])
        && prototype.is_some_and(|prototype| (prototype.recovers_heat)(system))
}

/// Adds an enthalpy wheel upstream of the mixer of every system for which the code requires it.
///
/// In a central air loop, it controls to the setpoint of the mixed air; in a unit, which has no such setpoint, it
/// recovers as much as possible. Its motor and its pressure drop are neglected.
///
/// # Errors
/// [`Error::MissingObject`] and [`Error::Unsupported`] when a system is not a prototype's.
pub(super) fn add(model: &mut Model, building_type: BuildingType, ashrae_zone: &str) -> Result<()> {
    let systems = model.names(SYSTEM);
    for system in systems.iter().filter(|system| is_required(building_type, ashrae_zone, system)) {
        put_wheel(model, system)?;
    }
    Ok(())
}

fn put_wheel(model: &mut Model, system: &str) -> Result<()> {
    let field = |fields: &serde_json::Map<String, Value>, name: &str, class: &str| {
        text(fields, name).map(str::to_owned).ok_or_else(|| Error::Unsupported {
            class: class.to_owned(),
            name: system.to_owned(),
            why: format!("`{name}` is not given"),
        })
    };
    let list = field(model.require(SYSTEM, system)?, "outdoor_air_equipment_list_name", SYSTEM)?;
    let mixer = field(model.require(LIST, &list)?, "component_1_name", LIST)?;
    let fields = model.require(MIXER, &mixer)?;
    let [outdoor, relief, back, mixed] = [
        "outdoor_air_stream_node_name",
        "relief_air_stream_node_name",
        "return_air_stream_node_name",
        "mixed_air_node_name",
    ]
    .map(|name| field(fields, name, MIXER));
    let (outdoor, relief, back, mixed) = (outdoor?, relief?, back?, mixed?);

    let [wheel, recovered, exhaust] =
        ["Energy Recovery", "Recovered Air Node", "Exhaust Node"].map(|what| format!("{system} {what}"));
    // Under control, the mixed air has a setpoint in a central air loop but not in a unit.
    let has_setpoint = !model.names("AirTerminal:SingleDuct:VAV:Reheat").is_empty();
    model.insert(WHEEL, &wheel, wheel_fields([&outdoor, &recovered, &relief, &exhaust], has_setpoint));
    if has_setpoint {
        let fields = pretreat_fields([&mixed, &outdoor, &back, &recovered]);
        model.insert("SetpointManager:OutdoorAirPretreat", &wheel, fields);
    }
    model.require_mut(MIXER, &mixer)?.insert("outdoor_air_stream_node_name".into(), recovered.into());
    model.insert(
        LIST,
        &list,
        json!({
            "component_1_object_type": WHEEL, "component_1_name": wheel,
            "component_2_object_type": MIXER, "component_2_name": mixer,
        }),
    );
    Ok(())
}

/// Returns the fields of the setpoint of the recovered air: nodes of mixed, outdoor, return and recovered air.
fn pretreat_fields([mixed, outdoor, back, recovered]: [&str; 4]) -> Value {
    json!({
        "control_variable": "Temperature",
        "minimum_setpoint_temperature": -99.0,
        "maximum_setpoint_temperature": 99.0,
        "reference_setpoint_node_name": mixed,
        "mixed_air_stream_node_name": mixed,
        "outdoor_air_stream_node_name": outdoor,
        "return_air_stream_node_name": back,
        "setpoint_node_or_nodelist_name": recovered,
    })
}

/// Returns the fields of a wheel between four nodes: supply inlet and outlet, exhaust inlet and outlet.
fn wheel_fields([outdoor, recovered, relief, exhaust]: [&str; 4], has_setpoint: bool) -> Value {
    json!({
        "nominal_supply_air_flow_rate": "Autosize",
        "sensible_effectiveness_at_100_heating_air_flow": RATIO,
        "latent_effectiveness_at_100_heating_air_flow": RATIO,
        "sensible_effectiveness_at_100_cooling_air_flow": RATIO,
        "latent_effectiveness_at_100_cooling_air_flow": RATIO,
        "supply_air_inlet_node_name": outdoor,
        "supply_air_outlet_node_name": recovered,
        "exhaust_air_inlet_node_name": relief,
        "exhaust_air_outlet_node_name": exhaust,
        "nominal_electric_power": 0.0,
        "supply_air_outlet_temperature_control": if has_setpoint { "Yes" } else { "No" },
        "heat_exchanger_type": "Rotary",
        "frost_control_type": "ExhaustOnly",
        "threshold_temperature": FROST,
        "initial_defrost_time_fraction": 0.167,
        "rate_of_defrost_time_fraction_increase": 1.44,
        "economizer_lockout": "Yes",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_systems_in_cold_zones_need_recovery() {
        let (office, shop) = (BuildingType::OfficeMedium, BuildingType::RetailStandalone);
        assert!(is_required(office, "7", "PACU_VAV_top_OA") && is_required(office, "8", "PACU_VAV_bot_OA"));
        assert!(is_required(shop, "8", "PSZ-AC:2_OA") && !is_required(shop, "8", "PSZ-AC:1_OA"));
        assert!(
            !is_required(office, "6A", "PACU_VAV_top_OA")
                && !is_required(BuildingType::Warehouse, "8", "HVAC")
        );
    }
}
