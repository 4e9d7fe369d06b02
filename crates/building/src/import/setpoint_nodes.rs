//! Nodes that need a setpoint and get none.

use std::collections::HashSet;

use crate::model::{Fields, Model, begins, items, text};

/// The field of a setpoint manager that takes another node's setpoint.
const REFERENCE: &str = "reference_setpoint_node_name";
/// End of the fields that name the nodes that a manager sets.
const TARGET: &str = "setpoint_node_or_nodelist_name";

/// The controllers that hold the setpoint of a node.
const CONTROLLER: &str = "Controller:WaterCoil";
/// The word in classes and control variables of humidity.
const HUMIDITY: &str = "humidity";

/// Returns a problem for every node whose setpoint is used, and neither a setpoint manager nor an EMS actuator gives
/// it. Another program may have set it while the engine ran.
pub(super) fn without_setpoint(model: &Model) -> Vec<String> {
    [without_reference(model), without_humidity(model)].concat()
}

/// Returns a problem for every node from which a setpoint manager takes a setpoint that nothing gives it.
fn without_reference(model: &Model) -> Vec<String> {
    let given = given(model, |_, _| true);
    let mut told = HashSet::new();
    let mut problems = Vec::new();
    for class in model.classes().filter(|class| begins(class, "SetpointManager:")) {
        for (name, fields) in model.objects(class) {
            let Some(node) = text(fields, REFERENCE) else { continue };
            let has_setpoint = nodes(model, node).iter().any(|node| given.contains(node));
            if !has_setpoint && told.insert(node.to_lowercase()) {
                problems.push(format!(
                    "{class} `{name}` takes the setpoint of node `{node}`, and neither a setpoint manager nor an EMS actuator \
                     gives it one: add a SetpointManager:Scheduled for `{node}`"
                ));
            }
        }
    }
    problems
}

/// Returns a problem for every water coil that holds a humidity ratio at a node that gets no humidity setpoint. The
/// engine ends the run and names the nodes only in warnings.
fn without_humidity(model: &Model) -> Vec<String> {
    let is_of_humidity = |class: &str, fields: &Fields| {
        is_about_humidity(class) || text(fields, "control_variable").is_some_and(is_about_humidity)
    };
    let given = given(model, is_of_humidity);
    let problem = |(name, fields): (&str, &Fields)| {
        let variable = text(fields, "control_variable").filter(|variable| is_about_humidity(variable))?;
        let node = text(fields, "sensor_node_name").filter(|node| !given.contains(&node.to_lowercase()))?;
        Some(format!(
            "{CONTROLLER} `{name}` controls {variable} at node `{node}`, and neither a setpoint manager nor an EMS actuator \
             gives it a humidity: add a SetpointManager:Scheduled with the control variable MaximumHumidityRatio for `{node}`, \
             or control Temperature"
        ))
    };
    model.objects(CONTROLLER).into_iter().filter_map(problem).collect()
}

fn is_about_humidity(word: &str) -> bool {
    word.to_lowercase().contains(HUMIDITY)
}

/// Returns the nodes that get a setpoint from managers that count, given their class and fields, or from an EMS
/// actuator, in lower case.
fn given(model: &Model, counts: impl Fn(&str, &Fields) -> bool) -> HashSet<String> {
    let mut given = HashSet::new();
    for class in model.classes().filter(|class| begins(class, "SetpointManager:")) {
        for (_, fields) in model.objects(class).into_iter().filter(|(_, fields)| counts(class, fields)) {
            let targets = fields.iter().filter(|(field, _)| field.ends_with(TARGET));
            for node in targets.filter_map(|(_, value)| value.as_str()) {
                given.extend(nodes(model, node));
            }
        }
    }
    for (_, fields) in model.objects("EnergyManagementSystem:Actuator") {
        given.extend(text(fields, "actuated_component_unique_name").map(str::to_lowercase));
    }
    given
}

/// Returns the nodes of a list, or a node itself.
fn nodes(model: &Model, name: &str) -> Vec<String> {
    let of_list = |list: &Fields| {
        items(list, "nodes").filter_map(|item| text(item, "node_name")).map(str::to_lowercase).collect()
    };
    model.get("NodeList", name).map_or_else(|| vec![name.to_lowercase()], of_list)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::{Value, json};

    use super::*;

    fn of(model: Value) -> Vec<String> {
        without_setpoint(&Model::from_epjson(&model.to_string(), Path::new("test.epJSON")).unwrap())
    }

    #[test]
    fn a_reference_without_a_setpoint_is_named_with_the_remedy() {
        let mixed = json!({"A": {"reference_setpoint_node_name": "Supply", "setpoint_node_or_nodelist_name": "Mixed"}});
        let said = of(json!({"SetpointManager:MixedAir": mixed}));
        assert!(
            said[0].contains("node `Supply`") && said[0].contains("SetpointManager:Scheduled"),
            "{said:?}"
        );
        let scheduled = json!({"S": {"setpoint_node_or_nodelist_name": "List"}});
        let list = json!({"List": {"nodes": [{"node_name": "SUPPLY"}]}});
        let model = json!({"SetpointManager:MixedAir": mixed, "SetpointManager:Scheduled": scheduled, "NodeList": list});
        assert_eq!(of(model), Vec::<String>::new());
        let mixed_as_listed =
            json!({"A": {"reference_setpoint_node_name": "List", "setpoint_node_or_nodelist_name": "Mixed"}});
        let model = json!({"SetpointManager:MixedAir": mixed_as_listed, "SetpointManager:Scheduled": scheduled, "NodeList": list});
        assert_eq!(of(model), Vec::<String>::new());
        let ems = json!({"E": {"actuated_component_unique_name": "supply"}});
        let model = json!({"SetpointManager:MixedAir": mixed, "EnergyManagementSystem:Actuator": ems});
        assert_eq!(of(model), Vec::<String>::new());
    }
    #[test]
    fn a_humidity_that_a_coil_holds_needs_a_setpoint_of_humidity() {
        let coil = json!({"C": {"control_variable": "HumidityRatio", "sensor_node_name": "Cold"}});
        let scheduled = |variable: &str| json!({"S": {"control_variable": variable, "setpoint_node_or_nodelist_name": "COLD"}});
        let with = |variable: &str| {
            of(json!({(CONTROLLER): coil, "SetpointManager:Scheduled": scheduled(variable)}))
        };
        let said = with("Temperature");
        assert!(said[0].contains("`Cold`") && said[0].contains("MaximumHumidityRatio"), "{said:?}");
        assert_eq!(with("MaximumHumidityRatio"), Vec::<String>::new());
        let zone = json!({"S": {"setpoint_node_or_nodelist_name": "Cold"}});
        let model = json!({(CONTROLLER): coil, "SetpointManager:SingleZone:Humidity:Maximum": zone});
        assert_eq!(of(model), Vec::<String>::new());
    }
}
