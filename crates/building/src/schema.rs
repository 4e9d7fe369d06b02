//! The input schema of the engine, which is data in its library.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use b2b_energyplus::Library;
use ciborium::Value;

/// The schema: what the engine knows of every class and field.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schema {
    classes: HashMap<String, ObjectClass>,
    /// Groups that have members.
    groups: HashSet<String>,
    /// Words that follow `@` in the library, in upper case: among them every function of EMS programs.
    functions: HashSet<String>,
}

#[derive(Clone, Debug, Default, PartialEq)]
struct ObjectClass {
    /// Groups of references that the name of an object belongs to.
    groups: Vec<String>,
    /// Fields, including the fields of lists.
    fields: HashMap<String, ClassField>,
}

/// A field.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClassField {
    /// Groups of references of which it names a member.
    pub names: Vec<String>,
    /// Groups of references that its value belongs to.
    pub groups: Vec<String>,
    /// Whether it must be given.
    pub required: bool,
    /// Whether it must be more than zero.
    pub positive: bool,
    /// Whether it must be a whole number.
    pub whole: bool,
    /// Whether the engine sizes it if it is blank.
    pub autosized: bool,
}

impl Schema {
    /// Returns the schema in a library; an empty one if it has none.
    pub fn of(library: &Library) -> Arc<Self> {
        static KNOWN: LazyLock<Mutex<HashMap<PathBuf, Arc<Schema>>>> = LazyLock::new(Mutex::default);
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let path = library.path().to_owned();
        Arc::clone(known.entry(path).or_insert_with_key(|path| {
            let bytes = std::fs::read(path).unwrap_or_default();
            Arc::new(Self::in_bytes(&bytes).unwrap_or_default())
        }))
    }

    /// Returns the schema in the bytes of a library: a CBOR map that begins with `$schema`.
    fn in_bytes(bytes: &[u8]) -> Option<Self> {
        const KEY: &[u8] = b"\x67$schema";
        let at = bytes.windows(KEY.len()).position(|window| window == KEY)?;
        // The byte before the first key is the size of the map.
        let value: Value = ciborium::from_reader(&bytes[at.checked_sub(1)?..]).ok()?;
        Some(Self { functions: functions_in(bytes), ..Self::in_value(&value)? })
    }

    fn in_value(value: &Value) -> Option<Self> {
        let classes = entries(get(value, "properties")?);
        let classes: HashMap<_, _> =
            classes.map(|(name, class)| (name.to_lowercase(), ObjectClass::of(class))).collect();
        let groups = classes.values().flat_map(|class: &ObjectClass| {
            class.groups.iter().chain(class.fields.values().flat_map(|field| &field.groups))
        });
        let groups = groups.cloned().collect();
        Some(Self { classes, groups, functions: HashSet::new() })
    }

    /// Returns a schema that is written as JSON.
    #[cfg(test)]
    pub fn of_json(json: &serde_json::Value) -> Self {
        Self::in_value(&Value::serialized(json).unwrap()).unwrap()
    }

    /// Returns a field of a class.
    pub fn field(&self, class: &str, field: &str) -> Option<&ClassField> {
        self.classes.get(&class.to_lowercase())?.fields.get(field)
    }

    /// Returns the fields of a class that the engine sizes if they are blank.
    pub fn sized_if_blank(&self, class: &str) -> impl Iterator<Item = &str> {
        let fields = self.classes.get(&class.to_lowercase()).into_iter().flat_map(|class| &class.fields);
        fields.filter(|(_, field)| field.autosized).map(|(name, _)| name.as_str())
    }

    /// Returns the groups of references that the names of a class belong to.
    pub fn groups(&self, class: &str) -> &[String] {
        self.classes.get(&class.to_lowercase()).map_or(&[], |class| &class.groups)
    }

    /// Returns whether EMS programs may call a function, which is named without `@` and in any case. True for
    /// every function if none is known.
    pub fn has_function(&self, function: &str) -> bool {
        self.functions.is_empty() || self.functions.contains(&function.to_uppercase())
    }

    /// Returns whether a group of references has members among names of objects or values of fields. Others are lists
    /// of classes or of the engine's outputs.
    pub fn has_group(&self, group: &str) -> bool {
        self.groups.contains(group)
    }
}

/// Returns the words of upper-case letters and digits that follow `@` in the bytes of a library.
fn functions_in(bytes: &[u8]) -> HashSet<String> {
    let is_of_word = |byte: &u8| byte.is_ascii_uppercase() || byte.is_ascii_digit();
    let mut words = HashSet::new();
    for rest in bytes.split(|byte| *byte == b'@') {
        let word: String =
            rest.iter().take_while(|byte| is_of_word(byte)).map(|byte| char::from(*byte)).collect();
        if word.len() > 1 {
            words.insert(word);
        }
    }
    words
}

impl ObjectClass {
    fn of(class: &Value) -> Self {
        let mut fields = HashMap::new();
        for (_, pattern) in get(class, "patternProperties").into_iter().flat_map(entries) {
            read_fields(pattern, &mut fields);
        }
        let groups = get(class, "name").map(|name| words(name, "reference")).unwrap_or_default();
        Self { groups, fields }
    }
}

/// Reads the fields of an object or of the items of a list.
fn read_fields(object: &Value, fields: &mut HashMap<String, ClassField>) {
    let required = words(object, "required");
    for (name, field) in get(object, "properties").into_iter().flat_map(entries) {
        match get(field, "items") {
            Some(items) => read_fields(items, fields),
            None => {
                fields.insert(
                    name.to_owned(),
                    ClassField::of(field, required.iter().any(|other| other == name)),
                );
            }
        }
    }
}

impl ClassField {
    fn of(field: &Value, required: bool) -> Self {
        let forms = get(field, "anyOf").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let forms = || [field].into_iter().chain(forms);
        let is_whole = |form| get(form, "type").and_then(Value::as_text) == Some("integer");
        let default = get(field, "default").and_then(Value::as_text);
        Self {
            names: words(field, "object_list"),
            groups: words(field, "reference"),
            required,
            positive: forms().any(|form| get(form, "exclusiveMinimum").is_some()),
            whole: forms().any(is_whole),
            autosized: default.is_some_and(|word| word.eq_ignore_ascii_case("Autosize")),
        }
    }
}

fn entries(value: &Value) -> impl Iterator<Item = (&str, &Value)> {
    value.as_map().into_iter().flatten().map(|(key, value)| (key.as_text().unwrap_or(""), value))
}

fn get<'a>(value: &'a Value, key: &str) -> Option<&'a Value> {
    entries(value).find(|(name, _)| *name == key).map(|(_, value)| value)
}

fn words(value: &Value, key: &str) -> Vec<String> {
    let items = get(value, key).and_then(Value::as_array).into_iter().flatten();
    items.filter_map(Value::as_text).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn functions_are_the_words_that_follow_an_at_sign() {
        let schema =
            Schema { functions: functions_in(b"\0@SIN\0@CURVEVALUE\0@A@Hace\0"), ..Schema::default() };
        assert!(schema.has_function("CurveValue") && schema.has_function("sin"));
        assert!(!schema.has_function("Hace") && !schema.has_function("ExtCtrlObs"));
        assert!(Schema::default().has_function("anything"));
    }

    #[test]
    fn a_field_has_its_groups_and_limits_also_in_a_list() {
        let item = json!({"properties": {"branch_name": {"object_list": ["Branches"]}}, "required": ["branch_name"]});
        let size = json!({"default": "Autosize", "anyOf": [{"type": "number", "exclusiveMinimum": 0.0}]});
        let count = json!({"anyOf": [{"type": "integer"}, {"type": "string"}]});
        let fields = json!({"properties": {"flow": size, "count": count, "branches": {"type": "array", "items": item}}});
        let class = json!({"name": {"reference": ["Lists"]}, "patternProperties": {".*": fields}});
        let schema = Schema::of_json(&json!({"properties": {"BranchList": class}}));
        let branch = schema.field("branchlist", "branch_name").unwrap();
        assert!(branch.required && branch.names == ["Branches"]);
        let flow = schema.field("BranchList", "flow").unwrap();
        assert!(flow.positive && flow.autosized && !flow.required && !flow.whole);
        assert!(schema.field("BranchList", "count").unwrap().whole);
        assert_eq!(schema.sized_if_blank("BranchList").collect::<Vec<_>>(), ["flow"]);
        assert_eq!(schema.groups("BranchList"), ["Lists"]);
        assert!(schema.has_group("Lists") && !schema.has_group("Branches"));
    }
}
