//! Dangling references.
//!
//! The engine stops at some dangling references and ignores others. The check covers `…_object_type` with `…_name`,
//! schedules, and required fields, except those of `Sizing:…` objects. The engine's schema gives the groups of
//! references that a field may name, such as the surfaces that a window may be in.

use std::collections::{HashMap, HashSet};

use serde_json::Value;

use crate::model::{Fields, Model, begins};
use crate::schema::Schema;

/// Maximum number of reported references; a truncated file has hundreds.
const MAX_REPORTED: usize = 5;

/// Reports the first dangling references, one per line, and the number of the others.
pub(super) fn dangling(model: &Model, schema: &Schema) -> Vec<String> {
    let mut search = Search { model, schema, members: members(model, schema), found: Vec::new() };
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
    schema: &'a Schema,
    /// Names in each group of references, in lower case.
    members: HashMap<&'a str, HashSet<String>>,
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
        if let Some(target) = typed() {
            if !self.model.contains(&target, name) {
                self.found.push(format!("{class} `{object}` refers to a missing {target} `{name}`"));
            }
        } else if self.is_missing(class, field, name) {
            let kind = if field.ends_with("schedule_name") { "schedule" } else { "object" };
            self.found.push(format!("{class} `{object}` refers to a missing {kind} `{name}` ({field})"));
        }
    }

    /// Returns whether a field must name a member of a group and does not.
    fn is_missing(&self, class: &str, field: &str, name: &str) -> bool {
        let Some(known) = self.schema.field(class, field) else { return false };
        let is_for_sizing = begins(class, "Sizing:");
        let is_essential = (known.required && !is_for_sizing) || field.ends_with("schedule_name");
        let is_of_objects =
            !known.names.is_empty() && known.names.iter().all(|group| self.schema.has_group(group));
        let name = name.to_lowercase();
        let is_member =
            |group: &String| self.members.get(group.as_str()).is_some_and(|names| names.contains(&name));
        is_essential && is_of_objects && !known.names.iter().any(is_member)
    }
}

/// Returns the names in each group of references, in lower case.
fn members<'a>(model: &Model, schema: &'a Schema) -> HashMap<&'a str, HashSet<String>> {
    let mut members = HashMap::new();
    for class in model.classes() {
        for (name, fields) in model.objects(class) {
            add(&mut members, schema.groups(class), name);
            add_fields(&mut members, schema, class, fields);
        }
    }
    members
}

fn add_fields<'a>(
    members: &mut HashMap<&'a str, HashSet<String>>,
    schema: &'a Schema,
    class: &str,
    fields: &Fields,
) {
    for (field, value) in fields {
        match value {
            Value::Array(items) => {
                items
                    .iter()
                    .filter_map(Value::as_object)
                    .for_each(|item| add_fields(members, schema, class, item));
            }
            Value::String(name) => {
                let groups = schema.field(class, field).map_or(&[][..], |known| &known.groups);
                add(members, groups, name);
            }
            _ => {}
        }
    }
}

fn add<'a>(members: &mut HashMap<&'a str, HashSet<String>>, groups: &'a [String], name: &str) {
    for group in groups {
        members.entry(group.as_str()).or_default().insert(name.to_lowercase());
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::json;

    use super::*;

    /// Zones, schedules and surfaces of two classes, as in the engine's schema.
    fn schema() -> Schema {
        let class = |groups: Value, fields: Value, required: Value| {
            json!({"name": {"reference": groups},
                   "patternProperties": {".*": {"properties": fields, "required": required}}})
        };
        let names = |group: &str| json!({"object_list": [group]});
        let fan = json!({"availability_schedule_name": names("ScheduleNames")});
        let surface = json!({"zone_name": names("ZoneNames")});
        let window = json!({"building_surface_name": names("SurfaceNames")});
        Schema::of_json(&json!({"properties": {
            "Zone": class(json!(["ZoneNames"]), json!({}), json!([])),
            "Schedule:Constant": class(json!(["ScheduleNames"]), json!({}), json!([])),
            "Fan:OnOff": class(json!([]), fan, json!([])),
            "BuildingSurface:Detailed": class(json!(["SurfaceNames"]), surface.clone(), json!(["zone_name"])),
            "Wall:Detailed": class(json!(["SurfaceNames"]), surface, json!(["zone_name"])),
            "Window": class(json!([]), window, json!(["building_surface_name"])),
        }}))
    }

    fn dangling_in(model: Value) -> Vec<String> {
        let model = Model::from_epjson(&model.to_string(), Path::new("test.epJSON")).unwrap();
        dangling(&model, &schema())
    }

    #[test]
    fn a_window_may_be_in_a_wall_of_any_class_of_surfaces() {
        let with = |wall: &str| {
            json!({"Zone": {"A": {}}, "Wall:Detailed": {"South": {"zone_name": "A"}},
                   "Window": {"Pane": {"building_surface_name": wall}}})
        };
        assert_eq!(dangling_in(with("SOUTH")), [""; 0]);
        let found = dangling_in(with("North")).join("\n");
        assert!(found.contains("Window `Pane`") && found.contains("`North`"), "{found}");
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
            "`Roof` refers to a missing object `B`",
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
