//! Setpoint managers of air loops.

use std::collections::HashSet;

use super::references::nodes_of;
use crate::Model;
use crate::model::text;

/// Removes the setpoint managers of these nodes (in lower case), which would override controlled setpoints.
pub fn remove_setpoint_managers(model: &mut Model, nodes: &HashSet<String>) {
    let classes: Vec<String> =
        model.classes().filter(|class| class.starts_with("SetpointManager:")).map(str::to_owned).collect();
    for class in &classes {
        for manager in model.names(class) {
            let fields = model.get(class, &manager);
            let target = fields.and_then(|f| text(f, "setpoint_node_or_nodelist_name"));
            let mut set = target.into_iter().flat_map(|target| nodes_of(model, target));
            if set.any(|node| nodes.contains(&node.to_lowercase())) {
                model.remove(class, &manager);
            }
        }
    }
}

/// Returns whether a setpoint manager refers to the setpoint of a node.
pub fn is_referred_to(model: &Model, node: &str) -> bool {
    let classes = model.classes().filter(|class| class.starts_with("SetpointManager:"));
    classes.flat_map(|class| model.objects(class)).any(|(_, fields)| {
        text(fields, "reference_setpoint_node_name").is_some_and(|other| other.eq_ignore_ascii_case(node))
    })
}
