//! Outdoor air that makes up for exhaust fans, in time for the loads of thermostats.
//!
//! The engine can balance exhaust fans with infiltration (`ZoneAirMassFlowConservation`). It adds this air while it
//! simulates the equipment, after it has predicted the load of the zone. Equipment that meets the load of a thermostat
//! then holds a kitchen up to 3 K below its setpoint. Here, an infiltration object of the zone takes the flow that was
//! missing in the step before, so that the load includes it.

use serde_json::json;

use crate::Model;
use crate::hvac::references::nodes_of;
use crate::model::{Fields, begins, text};

const FAN: &str = "Fan:ZoneExhaust";
const INFILTRATION: &str = "ZoneInfiltration:DesignFlowRate";
const SCHEDULE: &str = "b2b Make-up Air";
const DENSITY: &str = "b2b_outdoor_air_density";

/// A zone with exhaust fans, and the nodes of its air.
struct Exhausted {
    zone: String,
    exhausts: Vec<String>,
    inlets: Vec<String>,
}

/// Balances the exhaust fans of a model for thermostats. Returns whether that is possible: not where zones mix, whose
/// flows only the engine knows, and not in zones of several spaces, which share infiltration.
pub(super) fn predict(model: &mut Model) -> bool {
    let zones = exhausted(model);
    let mixes = model.classes().any(|class| begins(class, "Zone") && class.ends_with("Mixing"));
    if mixes || zones.iter().any(|each| has_several_spaces(model, &each.zone)) {
        return false;
    }
    if zones.is_empty() {
        return true;
    }
    model.remove_class("ZoneAirMassFlowConservation");
    model.insert("Schedule:Constant", SCHEDULE, json!({"hourly_value": 1.0}));
    sense(model, DENSITY, "Environment", "Site Outdoor Air Density");
    for (number, zone) in zones.iter().enumerate() {
        infiltrate(model, number + 1, zone);
    }
    true
}

/// Returns the zones with exhaust fans.
fn exhausted(model: &Model) -> Vec<Exhausted> {
    let fans = model.objects(FAN).into_iter();
    let fans: Vec<String> =
        fans.filter_map(|(_, fan)| text(fan, "air_inlet_node_name").map(str::to_lowercase)).collect();
    let connections = model.objects("ZoneHVAC:EquipmentConnections").into_iter();
    let zones = connections.filter_map(|(_, fields)| {
        let nodes = |field| text(fields, field).map(|name| nodes_of(model, name)).unwrap_or_default();
        let exhausts = nodes("zone_air_exhaust_node_or_nodelist_name");
        let inlets = nodes("zone_air_inlet_node_or_nodelist_name");
        let has_fan = exhausts.iter().any(|node| fans.contains(&node.to_lowercase()));
        has_fan.then_some(())?;
        Some(Exhausted { zone: text(fields, "zone_name")?.to_owned(), exhausts, inlets })
    });
    zones.collect()
}

fn has_several_spaces(model: &Model, zone: &str) -> bool {
    let is_own =
        |fields: &Fields| text(fields, "zone_name").is_some_and(|name| name.eq_ignore_ascii_case(zone));
    model.objects("Space").into_iter().filter(|(_, fields)| is_own(fields)).count() > 1
}

/// Adds the infiltration of a zone and the program that sets it.
fn infiltrate(model: &mut Model, number: usize, Exhausted { zone, exhausts, inlets }: &Exhausted) {
    let flow = format!("b2b_make_up_air_{number}");
    let mut balance = String::new();
    for (sign, nodes) in [('+', exhausts), ('-', inlets)] {
        for node in nodes {
            let sensor = format!("{flow}_node_{}", balance.matches("node").count() + 1);
            sense(model, &sensor, node, "System Node Mass Flow Rate");
            balance += &format!(" {sign} {sensor}");
        }
    }
    let object = format!("{zone} {SCHEDULE}");
    let infiltration = json!({
        "zone_or_zonelist_or_space_or_spacelist_name": zone,
        "schedule_name": SCHEDULE,
        "design_flow_rate_calculation_method": "Flow/Zone",
        "design_flow_rate": 0.0,
        "constant_term_coefficient": 1.0,
        "temperature_term_coefficient": 0.0,
        "velocity_term_coefficient": 0.0,
        "velocity_squared_term_coefficient": 0.0,
    });
    model.insert(INFILTRATION, &object, infiltration);
    let actuator = json!({
        "actuated_component_unique_name": object,
        "actuated_component_type": "Zone Infiltration",
        "actuated_component_control_type": "Air Exchange Flow Rate",
    });
    model.insert("EnergyManagementSystem:Actuator", &flow, actuator);
    let program = format!("{flow}_program");
    let lines = [format!("SET {flow} = 0{balance}"), format!("SET {flow} = (@MAX 0 {flow}) / {DENSITY}")];
    let lines: Vec<_> = lines.iter().map(|line| json!({"program_line": line})).collect();
    model.insert("EnergyManagementSystem:Program", &program, json!({"lines": lines}));
    let call = json!({
        "energyplus_model_calling_point": "BeginTimestepBeforePredictor",
        "programs": [{"program_name": program}],
    });
    model.insert("EnergyManagementSystem:ProgramCallingManager", &format!("{flow}_manager"), call);
}

fn sense(model: &mut Model, sensor: &str, key: &str, variable: &str) {
    let fields = json!({
        "output_variable_or_output_meter_index_key_name": key,
        "output_variable_or_output_meter_name": variable,
    });
    model.insert("EnergyManagementSystem:Sensor", sensor, fields);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kitchen() -> Model {
        let mut model = Model::default();
        model.insert(FAN, "Hood", json!({"air_inlet_node_name": "hood in"}));
        let nodes = json!({"nodes": [{"node_name": "Hood In"}, {"node_name": "Coil In"}]});
        model.insert("NodeList", "Out", nodes);
        for (zone, exhausts) in [("Kitchen", "Out"), ("Dining", "Coil")] {
            let connections = json!({
                "zone_name": zone,
                "zone_air_exhaust_node_or_nodelist_name": exhausts,
                "zone_air_inlet_node_or_nodelist_name": format!("{zone} In"),
            });
            model.insert("ZoneHVAC:EquipmentConnections", zone, connections);
        }
        model
    }

    #[test]
    fn the_air_that_leaves_through_a_hood_and_is_not_supplied_infiltrates() {
        let mut model = kitchen();
        assert!(predict(&mut model));
        assert_eq!(model.names(INFILTRATION), ["Kitchen b2b Make-up Air"]);
        let program = model.require("EnergyManagementSystem:Program", "b2b_make_up_air_1_program").unwrap();
        let line = |number: usize| program["lines"][number]["program_line"].as_str().unwrap();
        assert_eq!(
            line(0),
            "SET b2b_make_up_air_1 = 0 + b2b_make_up_air_1_node_1 + b2b_make_up_air_1_node_2 - b2b_make_up_air_1_node_3"
        );
        assert_eq!(line(1), "SET b2b_make_up_air_1 = (@MAX 0 b2b_make_up_air_1) / b2b_outdoor_air_density");
        let sensor = model.require("EnergyManagementSystem:Sensor", "b2b_make_up_air_1_node_3").unwrap();
        assert_eq!(text(sensor, "output_variable_or_output_meter_index_key_name"), Some("Kitchen In"));
    }

    #[test]
    fn flows_that_only_the_engine_knows_are_left_to_it() {
        let mut mixing = kitchen();
        mixing.insert("ZoneMixing", "Door", json!({}));
        assert!(!predict(&mut mixing) && mixing.names(INFILTRATION).is_empty());
        let mut spaces = kitchen();
        for space in ["Hot", "Cold"] {
            spaces.insert("Space", space, json!({"zone_name": "kitchen"}));
        }
        assert!(!predict(&mut spaces));
        let mut model = Model::default();
        assert!(predict(&mut model) && model.classes().next().is_none());
    }
}
