//! Application of rules to the objects of a model.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use super::document::{Body, Document, Field, Object};
use super::report::Conversion;
use super::rules::{ClassRule, Edit, ListField, SplitField, Step};
use crate::model::begins;

/// Beginnings of the classes whose fields name output variables or meters.
const NAMES_OUTPUTS: [&str; 7] = [
    "EnergyManagementSystem:Sensor",
    "ExternalInterface:FunctionalMockupUnitExport:From:Variable",
    "Output:",
    "Meter:",
    "DemandManagerAssignmentList",
    "ElectricLoadCenter:Distribution",
    "UtilityCost:",
];

/// Converts a document by one step. Returns the objects that cannot be converted, each with the reason.
pub fn step(document: &mut Document, step: &Step, report: &mut Conversion) -> Vec<String> {
    let mut problems = Vec::new();
    for special in &step.special {
        problems.extend(special.convert(document, &step.to, report));
    }
    let rules: BTreeMap<String, &ClassRule> =
        step.classes.iter().map(|rule| (rule.class.to_lowercase(), rule)).collect();
    let mut context = Context { version: &step.to, only: only_objects(document, step), report };
    let mut objects = Vec::with_capacity(document.objects.len());
    for mut object in std::mem::take(&mut document.objects) {
        context.rename_outputs(&mut object, &step.names);
        let Some(rule) = rules.get(&object.class.to_lowercase()) else {
            objects.push(object);
            continue;
        };
        if let Some(why) = &rule.refuse {
            problems.push(format!("{} `{}`: {why}", object.class, object.name()));
        } else if let Some(why) = &rule.remove {
            context.report.left_out(&step.to, &object.class, format!("removed: {why}"));
        } else {
            let new = context.apply(&mut object, rule);
            objects.push(object);
            objects.extend(new);
        }
    }
    document.objects = objects;
    for (class, becomes) in step.classes.iter().filter_map(|rule| Some((&rule.class, rule.becomes.as_ref()?)))
    {
        let named = |text: &str| text.eq_ignore_ascii_case(class).then(|| becomes.clone());
        document.objects.iter_mut().for_each(|object| {
            object.change_texts(named);
        });
    }
    problems
}

/// Returns the name of the object that inserted fields refer to, by class.
fn only_objects(document: &Document, step: &Step) -> BTreeMap<String, String> {
    let edits = step.classes.iter().flat_map(|rule| &rule.edits);
    let classes = edits.filter_map(|edit| match edit {
        Edit::Insert { name_of, .. } => name_of.clone(),
        _ => None,
    });
    classes.filter_map(|class| Some((class.clone(), document.of(&class).next()?.name()))).collect()
}

struct Context<'a> {
    version: &'a str,
    only: BTreeMap<String, String>,
    report: &'a mut Conversion,
}

impl Context<'_> {
    /// Changes an object and returns those that are split off.
    fn apply(&mut self, object: &mut Object, rule: &ClassRule) -> Vec<Object> {
        let class = object.class.clone();
        let mut new = Vec::new();
        for edit in &rule.edits {
            if let Some(what) = self.edit(object, edit, &mut new) {
                self.report.changed(self.version, &class, what);
            }
        }
        if let Some(becomes) = &rule.becomes {
            self.report.changed(self.version, &class, format!("is now {becomes}"));
            object.class.clone_from(becomes);
        }
        new
    }

    /// Makes one change and returns what it did; `None` if nothing.
    fn edit(&mut self, object: &mut Object, edit: &Edit, new: &mut Vec<Object>) -> Option<String> {
        match edit {
            Edit::Insert { insert, at, value, name_of } => {
                let only = name_of.as_ref().and_then(|class| self.only.get(class));
                let done = object.insert(Field { at: *at, name: insert }, only.unwrap_or(value));
                done.then(|| format!("`{insert}` inserted"))
            }
            Edit::Drop { drop, at } => {
                let value = object.remove(Field { at: *at, name: drop })?;
                if !value.is_empty() {
                    let what = format!("`{drop}` = `{value}`");
                    self.report.left_out(self.version, &object.class, what);
                }
                Some(format!("`{drop}` dropped"))
            }
            Edit::Rename { rename, to } => {
                object.rename(rename, to).then(|| format!("`{rename}` is now `{to}`"))
            }
            Edit::Move { from, at, to, to_at } => {
                let value = object.remove(Field { at: *at, name: from }).unwrap_or_default();
                let done = object.insert(Field { at: *to_at, name: to }, &value);
                done.then(|| format!("`{from}` is now `{to}`"))
            }
            Edit::Change { change, at, values } => changed(object, change, *at, values),
            Edit::Default { default, at, value } => {
                let field = Field { at: *at, name: default };
                let is_blank = object.get(field).is_none();
                is_blank.then(|| object.set(field, value))?;
                Some(format!("`{default}` = `{value}`, the default before"))
            }
            Edit::Split { split, at, class, name, fields } => {
                let reference = Field { at: *at, name: split };
                new.push(split_off(object, reference, class, name, fields));
                Some(format!("a {class} of its own for fields that it had"))
            }
            Edit::List { list, of } => listed(object, list, of).then(|| format!("`{list}` is a list")),
        }
    }

    /// Renames output variables and meters.
    fn rename_outputs(&mut self, object: &mut Object, names: &[(String, String)]) {
        if !NAMES_OUTPUTS.iter().any(|beginning| begins(&object.class, beginning)) {
            return;
        }
        let mut renamed = Vec::new();
        object.change_texts(|text| {
            let new = names.iter().find_map(|(from, to)| renamed_output(text, from, to))?;
            renamed.push(format!("`{text}` is now `{new}`"));
            Some(new)
        });
        for what in renamed {
            self.report.changed(self.version, &object.class, what);
        }
    }
}

/// Returns the name of an output with `to` instead of `from`, in any case; `None` if it has no `from` or has `to`
/// already.
fn renamed_output(text: &str, from: &str, to: &str) -> Option<String> {
    // ASCII lower case has the same positions.
    let [lower, from, already] = [text, from, to].map(str::to_ascii_lowercase);
    if !lower.contains(&from) || lower.contains(&already) {
        return None;
    }
    let (mut new, mut end) = (String::new(), 0);
    for (at, _) in lower.match_indices(&from) {
        new += &text[end..at];
        new += to;
        end = at + from.len();
    }
    Some(new + &text[end..])
}

fn changed(object: &mut Object, field: &str, at: usize, values: &BTreeMap<String, String>) -> Option<String> {
    let new = |value: &str| {
        values.iter().find(|(from, _)| from.eq_ignore_ascii_case(value)).map(|(_, to)| to.clone())
    };
    if field == "*" {
        let mut what = None;
        object.change_texts(|text| {
            let to = new(text)?;
            what = Some(format!("`{text}` is now `{to}`"));
            Some(to)
        });
        return what;
    }
    let place = Field { at, name: field };
    let value = object.get(place)?;
    let to = new(&value)?;
    object.set(place, &to);
    Some(format!("`{field}`: `{value}` is now `{to}`"))
}

/// Moves fields of an object to a new one, which `reference` names.
fn split_off(
    object: &mut Object,
    reference: Field,
    class: &str,
    name: &str,
    fields: &[SplitField],
) -> Object {
    let owner = object.name();
    let with_name = |text: &str| text.replace("{name}", &owner);
    let place = |field: &SplitField| field.from.as_deref().map(|name| (field.at, name.to_owned()));
    let value = |field: &SplitField| match place(field) {
        Some((at, name)) => object.get(Field { at, name: &name }).unwrap_or_default(),
        None => field.value.as_deref().map(with_name).unwrap_or_default(),
    };
    let values: Vec<(&str, String)> =
        fields.iter().map(|field| (field.field.as_str(), value(field))).collect();
    let name = with_name(name);
    let new = Object::like(object, class, &name, &values);
    let mut taken: Vec<(usize, String)> = fields.iter().filter_map(place).collect();
    taken.sort();
    for (at, name) in taken.iter().rev() {
        object.remove(Field { at: *at, name });
    }
    if !reference.name.is_empty() && !object.insert(reference, &name) {
        object.set(reference, &name);
    }
    new
}

/// Gathers the numbered fields of an epJSON in a list.
fn listed(object: &mut Object, list: &str, of: &[ListField]) -> bool {
    let Body::Names { fields, .. } = &mut object.body else { return false };
    let mut items = Vec::new();
    loop {
        let number = (items.len() + 1).to_string();
        let item: Map<String, Value> = of
            .iter()
            .filter_map(|field| {
                Some((field.field.clone(), fields.remove(&field.numbered.replace("{n}", &number))?))
            })
            .collect();
        if item.is_empty() {
            break;
        }
        items.push(Value::Object(item));
    }
    let found = !items.is_empty();
    if found {
        fields.insert(list.to_owned(), Value::Array(items));
    }
    found
}
