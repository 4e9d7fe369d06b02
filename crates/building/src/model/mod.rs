//! EnergyPlus models as epJSON documents, with the operations that edits need.
//!
//! Names of classes and objects are case-insensitive in EnergyPlus and in every query here. Objects are returned in
//! *model order*: the order of the IDF they were converted from (`idf_order`), then by name.

pub mod construction;
pub(crate) mod floors;
pub mod opening;
pub mod people;
pub mod shape;
pub mod zone;

use std::fmt;
use std::path::Path;

use b2b_energyplus::Library;
use serde::Serialize;
use serde::de::{Deserialize, DeserializeSeed, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use crate::{Error, Result, user_file};

/// The fields of one object.
pub type Fields = Map<String, Value>;

/// An EnergyPlus model: class → object name → fields.
///
/// Its text is deterministic: classes, names and fields are in alphabetical order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct Model {
    classes: Map<String, Value>,
}

impl Model {
    /// Reads a model file: epJSON, or IDF through the engine's own converter.
    ///
    /// # Errors
    /// [`Error::Malformed`] and [`Error::Io`] naming the file; [`Error::Engine`] with the engine's messages when it
    /// cannot read an IDF.
    pub fn read(path: &Path, library: &Library) -> Result<Self> {
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("idf")) {
            return Self::from_epjson(&library.convert_idf(path)?, path);
        }
        let text = user_file::read(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
        Self::from_epjson(&text, path)
    }

    /// Parses an epJSON text.
    ///
    /// # Errors
    /// [`Error::Malformed`] when the text is not JSON, repeats a name, or is not class → name → fields.
    pub fn from_epjson(text: &str, path: &Path) -> Result<Self> {
        let malformed = |why: String| Error::Malformed { path: path.to_owned(), why };
        let Unique(classes) = serde_json::from_str(text).map_err(|e| malformed(e.to_string()))?;
        for (class, objects) in &classes {
            let objects = objects
                .as_object()
                .ok_or_else(|| malformed(format!("class `{class}` is not a JSON object")))?;
            for (name, fields) in objects {
                if !fields.is_object() {
                    return Err(malformed(format!("{class} `{name}` is not a JSON object")));
                }
            }
        }
        Ok(Self { classes })
    }

    /// Returns the model as epJSON text.
    pub fn to_epjson(&self) -> String {
        serde_json::to_string_pretty(&self.classes).expect("a JSON map always serializes")
    }

    /// Returns the objects of a class with their names, in model order.
    pub fn objects(&self, class: &str) -> Vec<(&str, &Fields)> {
        let mut objects: Vec<_> = self
            .class(class)
            .into_iter()
            .flatten()
            .filter_map(|(name, value)| Some((name.as_str(), value.as_object()?)))
            .collect();
        objects.sort_by_key(|(_, fields)| order(fields));
        objects
    }

    /// Returns the names of the objects of a class, in model order; owned, so that the model can be edited.
    pub fn names(&self, class: &str) -> Vec<String> {
        self.objects(class).iter().map(|(name, _)| (*name).to_owned()).collect()
    }

    /// Returns the classes that have objects.
    pub fn classes(&self) -> impl Iterator<Item = &str> {
        self.classes.keys().map(String::as_str)
    }

    /// Returns whether a class has an object with this name.
    pub fn contains(&self, class: &str, name: &str) -> bool {
        self.get(class, name).is_some()
    }

    /// Returns the fields of an object.
    pub fn get(&self, class: &str, name: &str) -> Option<&Fields> {
        self.class(class)?
            .iter()
            .find(|(key, _)| key.eq_ignore_ascii_case(name))
            .and_then(|(_, value)| value.as_object())
    }

    /// Returns the fields of an object, for editing.
    pub fn get_mut(&mut self, class: &str, name: &str) -> Option<&mut Fields> {
        self.class_mut(class)?
            .iter_mut()
            .find(|(key, _)| key.eq_ignore_ascii_case(name))
            .and_then(|(_, value)| value.as_object_mut())
    }

    /// Returns every object for editing: its class, its name and its fields.
    pub fn objects_mut(&mut self) -> impl Iterator<Item = (&str, &str, &mut Fields)> {
        let classes =
            self.classes.iter_mut().filter_map(|(class, objects)| Some((class, objects.as_object_mut()?)));
        classes.flat_map(|(class, objects)| {
            let with_class = move |(name, fields)| {
                Some((class.as_str(), String::as_str(name), Value::as_object_mut(fields)?))
            };
            objects.iter_mut().filter_map(with_class)
        })
    }

    /// Returns the fields of an object that must exist.
    ///
    /// # Errors
    /// [`Error::MissingObject`] naming the class and the object.
    pub fn require(&self, class: &str, name: &str) -> Result<&Fields> {
        self.get(class, name).ok_or_else(|| missing(class, name))
    }

    /// Returns the fields of an object that must exist, for editing.
    ///
    /// # Errors
    /// [`Error::MissingObject`] naming the class and the object.
    pub fn require_mut(&mut self, class: &str, name: &str) -> Result<&mut Fields> {
        self.get_mut(class, name).ok_or_else(|| missing(class, name))
    }

    /// Returns a size that an object must have.
    ///
    /// # Errors
    /// [`Error::Unsupported`] when the field is not a number; [`Error::MissingObject`] naming the class and the object.
    pub fn require_size(&self, class: &str, name: &str, field: &str) -> Result<f64> {
        let unsized_field =
            || Error::unsupported(class, name, &format!("`{field}` must be a number: size the model first"));
        number(self.require(class, name)?, field).ok_or_else(unsized_field)
    }

    /// Removes an object that must exist and returns its fields.
    ///
    /// # Errors
    /// [`Error::MissingObject`] naming the class and the object.
    pub fn take(&mut self, class: &str, name: &str) -> Result<Fields> {
        self.remove(class, name).ok_or_else(|| missing(class, name))
    }

    /// Inserts an object, replacing one with the same name.
    ///
    /// # Panics
    /// When `fields` is not a JSON object: a bug in the caller, not an error in a user's file.
    pub fn insert(&mut self, class: &str, name: &str, fields: Value) {
        assert!(fields.is_object(), "{class} `{name}`: fields must be an object");
        self.remove(class, name);
        let class = self.class_key(class).unwrap_or_else(|| class.to_owned());
        let objects = self.classes.entry(class).or_insert_with(|| Value::Object(Map::new()));
        if let Value::Object(objects) = objects {
            objects.insert(name.to_owned(), fields);
        }
    }

    /// Removes an object and returns its fields.
    pub fn remove(&mut self, class: &str, name: &str) -> Option<Fields> {
        let class = self.class_key(class)?;
        let objects = self.classes.get_mut(&class)?.as_object_mut()?;
        let key = objects.keys().find(|k| k.eq_ignore_ascii_case(name))?.clone();
        let fields = objects.remove(&key);
        if objects.is_empty() {
            self.classes.remove(&class);
        }
        match fields {
            Some(Value::Object(fields)) => Some(fields),
            _ => None,
        }
    }

    /// Removes every object of a class.
    pub fn remove_class(&mut self, class: &str) {
        if let Some(class) = self.class_key(class) {
            self.classes.remove(&class);
        }
    }

    /// Replaces every string field equal to `from` with `to`: renames a node or an object wherever it is referenced.
    pub fn replace_references(&mut self, from: &str, to: &str) {
        for objects in self.classes.values_mut() {
            replace_strings(objects, from, to);
        }
    }

    fn class_key(&self, class: &str) -> Option<String> {
        if self.classes.contains_key(class) {
            return Some(class.to_owned());
        }
        self.classes.keys().find(|k| k.eq_ignore_ascii_case(class)).cloned()
    }

    fn class(&self, class: &str) -> Option<&Map<String, Value>> {
        self.classes.get(&self.class_key(class)?)?.as_object()
    }

    fn class_mut(&mut self, class: &str) -> Option<&mut Map<String, Value>> {
        let key = self.class_key(class)?;
        self.classes.get_mut(&key)?.as_object_mut()
    }
}

/// A JSON object without duplicate names at any depth. JSON parsers silently keep one of several duplicates.
struct Unique(Map<String, Value>);

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(UniqueVisitor).and_then(|value| match value {
            Value::Object(members) => Ok(Self(members)),
            _ => Err(D::Error::custom("the document is not a JSON object")),
        })
    }
}

/// Parses any value and rejects duplicate names in objects.
struct UniqueVisitor;

impl<'de> DeserializeSeed<'de> for UniqueVisitor {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> std::result::Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for UniqueVisitor {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> std::result::Result<Value, A::Error> {
        let mut members = Map::new();
        while let Some(name) = access.next_key::<String>()? {
            if members.contains_key(&name) {
                return Err(A::Error::custom(format!("duplicate name `{name}`: rename one of the objects")));
            }
            members.insert(name, access.next_value_seed(UniqueVisitor)?);
        }
        Ok(Value::Object(members))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> std::result::Result<Value, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = access.next_element_seed(UniqueVisitor)? {
            items.push(item);
        }
        Ok(Value::Array(items))
    }

    fn visit_str<E>(self, text: &str) -> std::result::Result<Value, E> {
        Ok(text.into())
    }

    fn visit_bool<E>(self, value: bool) -> std::result::Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> std::result::Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> std::result::Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E>(self, value: f64) -> std::result::Result<Value, E> {
        Ok(value.into())
    }

    fn visit_unit<E>(self) -> std::result::Result<Value, E> {
        Ok(Value::Null)
    }
}

/// Returns whether the name of a class begins in a certain way, such as `Sizing:`. Case is ignored.
pub(crate) fn begins(class: &str, beginning: &str) -> bool {
    class.get(..beginning.len()).is_some_and(|start| start.eq_ignore_ascii_case(beginning))
}

/// Returns a text field; `None` if it is missing, blank or not text.
pub fn text<'a>(fields: &'a Fields, field: &str) -> Option<&'a str> {
    fields.get(field)?.as_str().filter(|text| !text.is_empty())
}

/// Returns a numeric field; `None` if it is missing or not a number.
pub fn number(fields: &Fields, field: &str) -> Option<f64> {
    fields.get(field)?.as_f64()
}

/// Returns the objects in an array field.
pub fn items<'a>(fields: &'a Fields, array: &str) -> impl Iterator<Item = &'a Fields> {
    fields.get(array).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_object)
}

fn order(fields: &Fields) -> u64 {
    fields.get("idf_order").and_then(Value::as_u64).unwrap_or(u64::MAX)
}

fn missing(class: &str, name: &str) -> Error {
    Error::MissingObject { class: class.to_owned(), name: name.to_owned() }
}

fn replace_strings(value: &mut Value, from: &str, to: &str) {
    match value {
        Value::String(text) if text.eq_ignore_ascii_case(from) => *text = to.to_owned(),
        Value::Array(items) => items.iter_mut().for_each(|v| replace_strings(v, from, to)),
        Value::Object(fields) => fields.values_mut().for_each(|v| replace_strings(v, from, to)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> Model {
        let text = r#"{"Zone": {"B": {"idf_order": 1}, "A": {"idf_order": 2}}}"#;
        Model::from_epjson(text, Path::new("test.epJSON")).unwrap()
    }

    #[test]
    fn objects_come_in_model_order_and_names_ignore_case() {
        assert_eq!(model().names("ZONE"), ["B", "A"]);
        assert!(model().contains("zone", "a"));
    }

    #[test]
    fn an_empty_text_is_a_blank_field_as_in_the_engine() {
        let fields = serde_json::json!({"outside_layer": "Brick", "layer_2": ""});
        let fields = fields.as_object().unwrap();
        assert_eq!((text(fields, "outside_layer"), text(fields, "layer_2")), (Some("Brick"), None));
        assert_eq!(construction::layers(fields).collect::<Vec<_>>(), ["Brick"]);
    }

    #[test]
    fn replacing_a_reference_reaches_every_field() {
        let mut model = model();
        model.insert("ZoneList", "all", serde_json::json!({"zones": [{"zone_name": "a"}]}));
        model.replace_references("A", "C");
        assert_eq!(model.get("ZoneList", "all").unwrap()["zones"][0]["zone_name"], "C");
    }

    #[test]
    fn a_duplicate_object_is_rejected_by_name() {
        let text = r#"{"Zone": {"Core": {"x": [1, -2, 0.5, true, null]}, "Core": {}}}"#;
        let error = Model::from_epjson(text, Path::new("two.epJSON")).unwrap_err().to_string();
        assert!(error.contains("`Core`") && error.contains("two.epJSON"), "{error}");
    }

    #[test]
    fn a_malformed_document_is_named() {
        let error = Model::from_epjson("{\"Zone\": 3}", Path::new("bad.epJSON")).unwrap_err();
        assert!(error.to_string().contains("bad.epJSON"), "{error}");
        assert!(error.to_string().contains("Zone"), "{error}");
    }
}
