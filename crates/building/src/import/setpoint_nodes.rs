//! Nodes whose setpoint nothing in a model gives.

use std::collections::HashSet;

use crate::model::{Fields, Model, begins, items, text};

/// The field of a setpoint manager that takes another node's setpoint.
const REFERENCE: &str = "reference_setpoint_node_name";
/// End of the fields that name the nodes that a manager sets.
const TARGET: &str = "setpoint_node_or_nodelist_name";

/// Returns a problem for every node from which a setpoint manager takes a setpoint that neither a manager nor an EMS actuator
/// gives. Another program may have set it while the engine ran.
pub(super) fn without_setpoint(model: &Model) -> Vec<String> {
    let given = given(model);
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

/// Returns the nodes that get a setpoint, in lower case.
fn given(model: &Model) -> HashSet<String> {
    let mut given = HashSet::new();
    for class in model.classes().filter(|class| begins(class, "SetpointManager:")) {
        for (_, fields) in model.objects(class) {
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
}
