//! Tanks on a branch that do not name its nodes: the engine, for which the nodes of a tank are optional, ends the run.

use crate::model::{Model, items, text};
use crate::schema::Schema;

/// The field that only tanks have: the inlet node of the use side.
const USE: &str = "use_side_inlet_node_name";
/// The end of the fields with the nodes where water enters a tank.
const INLET: &str = "_side_inlet_node_name";

/// Returns a problem for every tank on a branch whose node it does not name.
pub(super) fn unconnected(model: &Model, schema: &Schema) -> Vec<String> {
    let mut problems = Vec::new();
    for (branch, fields) in model.objects("Branch") {
        for component in items(fields, "components") {
            let part = |field: &str| text(component, field).unwrap_or_default();
            let [class, name] = ["component_object_type", "component_name"].map(part);
            let [inlet, outlet] = ["component_inlet_node_name", "component_outlet_node_name"].map(part);
            let Some(tank) = model.get(class, name).filter(|_| schema.field(class, USE).is_some()) else {
                continue;
            };
            let named =
                |field: &String| text(tank, field).is_some_and(|node| node.eq_ignore_ascii_case(inlet));
            if !tank.keys().filter(|field| field.ends_with(INLET)).any(named) {
                problems.push(format!(
                    "{class} `{name}` is on Branch `{branch}` between the nodes `{inlet}` and `{outlet}`, but names neither: \
                     enter them as its use side nodes if the branch draws hot water, as its source side nodes if it heats the \
                     tank"
                ));
            }
        }
    }
    problems
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_tank_on_a_branch_names_its_nodes() {
        let fields = json!({"properties": {USE: {}, "source_side_inlet_node_name": {}}});
        let schema = Schema::of_json(&json!({"properties": {
            "WaterHeater:Mixed": {"patternProperties": {".*": fields}}, "Pipe:Adiabatic": {},
        }}));
        let tank = |inlet: &str| {
            let branch = json!({"component_object_type": "WaterHeater:Mixed", "component_name": "Tank",
                "component_inlet_node_name": "Cold", "component_outlet_node_name": "Hot"});
            let pipe = json!({"component_object_type": "Pipe:Adiabatic", "component_name": "Pipe"});
            let model = json!({
                "Branch": {"Equipment": {"components": [branch, pipe]}}, "Pipe:Adiabatic": {"Pipe": {}},
                "WaterHeater:Mixed": {"Tank": {"use_side_inlet_node_name": inlet, "tank_volume": 0.1}},
            });
            unconnected(&Model::from_epjson(&model.to_string(), "tank.epJSON".as_ref()).unwrap(), &schema)
        };
        assert_eq!(tank("COLD"), Vec::<String>::new());
        let problem = &tank("")[0];
        assert!(
            problem.contains("`Tank` is on Branch `Equipment` between the nodes `Cold` and `Hot`"),
            "{problem}"
        );
    }
}
