//! Dangling references.
//!
//! The engine stops at some dangling references and ignores others. Two patterns of field names cover the essential ones:
//! `…_object_type` with `…_name`, and `…_schedule_name`. A few more are listed by class.

use std::collections::HashSet;

use serde_json::Value;

use crate::model::{Fields, Model};

/// Maximum number of reported references; a truncated file has hundreds.
const MAX_REPORTED: usize = 5;

/// Fields that refer to an object of one class.
const BY_CLASS: [(&str, &str, &str); 9] = [
    ("BuildingSurface:Detailed", "zone_name", "Zone"),
    ("FenestrationSurface:Detailed", "building_surface_name", "BuildingSurface:Detailed"),
    ("ZoneHVAC:EquipmentConnections", "zone_name", "Zone"),
    ("ZoneHVAC:EquipmentConnections", "zone_conditioning_equipment_list_name", "ZoneHVAC:EquipmentList"),
    ("AirLoopHVAC", "branch_list_name", "BranchList"),
    ("PlantLoop", "plant_side_branch_list_name", "BranchList"),
    ("PlantLoop", "demand_side_branch_list_name", "BranchList"),
    ("BranchList", "branch_name", "Branch"),
    ("AirLoopHVAC:OutdoorAirSystem", "controller_list_name", "AirLoopHVAC:ControllerList"),
];

/// Reports the first dangling references, one per line, and the number of the others.
pub(super) fn dangling(model: &Model) -> Vec<String> {
    let mut search = Search { model, schedules: schedules(model), found: Vec::new() };
    let classes: Vec<_> = model.classes().map(str::to_owned).collect();
    for class in &classes {
        for (name, fields) in model.objects(class) {
            search.look(class, name, fields);
        }
    }
    let mut found = search.found;
    if found.len() > MAX_REPORTED {
        let others = found.len() - MAX_REPORTED;
        found.truncate(MAX_REPORTED);
        found.push(format!("… and {others} more dangling references: is the file complete?"));
    }
    found
}

struct Search<'a> {
    model: &'a Model,
    /// Names of all schedules, in lower case.
    schedules: HashSet<String>,
    found: Vec<String>,
}

impl Search<'_> {
    fn look(&mut self, class: &str, object: &str, fields: &Fields) {
        for (field, value) in fields {
            match value {
                Value::Array(items) => {
                    for item in items.iter().filter_map(Value::as_object) {
                        self.look(class, object, item);
                    }
                }
                Value::String(name) if !name.is_empty() => self.check(class, object, fields, field, name),
                _ => {}
            }
        }
    }

    fn check(&mut self, class: &str, object: &str, fields: &Fields, field: &str, name: &str) {
        let typed = || {
            let part = field.strip_suffix("_name")?;
            fields.get(&format!("{part}_object_type"))?.as_str().map(str::to_owned)
        };
        let by_class = || {
            let known = |(c, f, _): &&(&str, &str, &str)| c.eq_ignore_ascii_case(class) && *f == field;
            BY_CLASS.iter().find(known).map(|(_, _, target)| (*target).to_owned())
        };
        if field.ends_with("schedule_name") {
            if !self.schedules.contains(&name.to_lowercase()) {
                self.found.push(format!("{class} `{object}` refers to a missing schedule `{name}`"));
            }
        } else if let Some(target) = typed().or_else(by_class)
            && !self.model.contains(&target, name)
        {
            self.found.push(format!("{class} `{object}` refers to a missing {target} `{name}`"));
        }
    }
}

fn schedules(model: &Model) -> HashSet<String> {
    let classes = model.classes().filter(|class| class.to_ascii_lowercase().starts_with("schedule:"));
    let names = classes.flat_map(|class| model.objects(class)).map(|(name, _)| name.to_lowercase());
    let external = ["ExternalInterface:Schedule", "ExternalInterface:FunctionalMockupUnitImport:To:Schedule"];
    names
        .chain(external.iter().flat_map(|class| model.names(class)).map(|name| name.to_lowercase()))
        .collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::json;

    use super::*;

    fn dangling_in(model: Value) -> Vec<String> {
        dangling(&Model::from_epjson(&model.to_string(), Path::new("test.epJSON")).unwrap())
    }

    #[test]
    fn a_dangling_reference_is_reported_with_both_ends() {
        let found = dangling_in(json!({
            "Zone": {"A": {}},
            "Schedule:Constant": {"On": {}},
            "Fan:OnOff": {"F": {"availability_schedule_name": "ON"}, "G": {"availability_schedule_name": "Off"}},
            "BuildingSurface:Detailed": {"Wall": {"zone_name": "a"}, "Roof": {"zone_name": "B"}},
            "Branch": {"Main": {"components": [
                {"component_object_type": "Fan:OnOff", "component_name": "f"},
                {"component_object_type": "Coil:Heating:Fuel", "component_name": "H"}]}},
        }));
        assert_eq!(found.len(), 3, "{found:?}");
        let all = found.join("\n");
        for end in [
            "`Main` refers to a missing Coil:Heating:Fuel `H`",
            "`Roof` refers to a missing Zone `B`",
            "`G` refers to a missing schedule `Off`",
        ] {
            assert!(all.contains(end), "{all}");
        }
    }

    #[test]
    fn of_many_dangling_references_the_first_are_reported_and_the_others_counted() {
        let surfaces: serde_json::Map<_, _> =
            (0..20).map(|i| (format!("S{i}"), json!({"zone_name": "Gone"}))).collect();
        let found = dangling_in(json!({"BuildingSurface:Detailed": surfaces}));
        assert_eq!(found.len(), MAX_REPORTED + 1);
        assert!(found[MAX_REPORTED].contains("15 more"), "{found:?}");
    }
}
