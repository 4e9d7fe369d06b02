//! A model of any version: objects with fields in positions (IDF) or by name (epJSON).

use serde_json::{Map, Value};

use crate::model::{Fields, Model};

/// The objects of a model, in the order of the IDF, or by class in model order for an epJSON.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Document {
    /// The objects.
    pub objects: Vec<Object>,
}

/// An object.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Its class.
    pub class: String,
    /// Its fields.
    pub body: Body,
}

/// The fields of an object.
#[derive(Clone, Debug, PartialEq)]
pub enum Body {
    /// Values in the order of an IDF.
    Positions(Vec<String>),
    /// Named fields of an epJSON.
    Names {
        /// Name of the object.
        name: String,
        /// The other fields.
        fields: Fields,
    },
}

/// A field of an object in both forms.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// Position in an IDF, from 1.
    pub at: usize,
    /// Name in an epJSON.
    pub name: &'a str,
}

/// The name of the field that is an object's key in an epJSON.
const NAME: &str = "name";

impl Document {
    /// Returns the objects of an epJSON.
    pub fn from_model(model: &Model) -> Self {
        let of_class = |class: &str| {
            let objects = model.objects(class).into_iter();
            let object = |(name, fields): (&str, &Fields)| Object {
                class: class.to_owned(),
                body: Body::Names { name: name.to_owned(), fields: fields.clone() },
            };
            objects.map(object).collect::<Vec<_>>()
        };
        Self { objects: model.classes().flat_map(of_class).collect() }
    }

    /// Returns the epJSON of named objects.
    pub fn into_model(self) -> Model {
        let mut model = Model::default();
        for object in self.objects {
            if let Body::Names { name, fields } = object.body {
                model.insert(&object.class, &name, Value::Object(fields));
            }
        }
        model
    }

    /// Returns the objects of a class.
    pub fn of<'a>(&'a self, class: &'a str) -> impl Iterator<Item = &'a Object> {
        self.objects.iter().filter(move |object| object.is(class))
    }

    /// Returns the version that the model names.
    pub fn version(&self) -> Option<String> {
        let field = Field { at: 1, name: "version_identifier" };
        self.of("Version").find_map(|object| object.get(field))
    }

    /// Sets the version.
    pub fn set_version(&mut self, version: &str) {
        let field = Field { at: 1, name: "version_identifier" };
        for object in self.objects.iter_mut().filter(|object| object.is("Version")) {
            match &mut object.body {
                Body::Positions(_) => object.set(field, version),
                Body::Names { fields, .. } => {
                    fields.insert(field.name.to_owned(), Value::from(version));
                }
            }
        }
    }
}

impl Object {
    /// Returns an object of the same form as another, with a name and fields in order.
    pub fn like(other: &Self, class: &str, name: &str, values: &[(&str, String)]) -> Self {
        let body = match &other.body {
            Body::Positions(_) => {
                let values = values.iter().map(|(_, value)| value.clone());
                Body::Positions([name.to_owned()].into_iter().chain(values).collect())
            }
            Body::Names { .. } => {
                let given = values.iter().filter(|(_, value)| !value.is_empty());
                let fields = given.map(|(field, value)| ((*field).to_owned(), json(value))).collect();
                Body::Names { name: name.to_owned(), fields }
            }
        };
        Self { class: class.to_owned(), body }
    }

    /// Returns whether it is of a class.
    pub fn is(&self, class: &str) -> bool {
        self.class.eq_ignore_ascii_case(class)
    }

    /// Returns its name: the first field of an IDF object.
    pub fn name(&self) -> String {
        self.get(Field { at: 1, name: NAME }).unwrap_or_default()
    }

    /// Returns the value of a field; `None` if it is blank.
    pub fn get(&self, field: Field) -> Option<String> {
        let value = match &self.body {
            Body::Positions(values) => values.get(field.at.checked_sub(1)?)?.clone(),
            Body::Names { name, .. } if field.name == NAME => name.clone(),
            Body::Names { fields, .. } => text_of(fields.get(field.name)?)?,
        };
        Some(value).filter(|value| !value.is_empty())
    }

    /// Sets a field.
    pub fn set(&mut self, field: Field, value: &str) {
        match &mut self.body {
            Body::Positions(values) => {
                values.resize(values.len().max(field.at), String::new());
                value.clone_into(&mut values[field.at - 1]);
            }
            Body::Names { name, .. } if field.name == NAME => value.clone_into(name),
            Body::Names { fields, .. } if value.is_empty() => {
                fields.remove(field.name);
            }
            Body::Names { fields, .. } => {
                fields.insert(field.name.to_owned(), json(value));
            }
        }
    }

    /// Inserts a field; in an IDF, those from its position on move back. Returns whether the object changed.
    pub fn insert(&mut self, field: Field, value: &str) -> bool {
        match &mut self.body {
            Body::Positions(values) if values.len() >= field.at => {
                values.insert(field.at - 1, value.to_owned());
                true
            }
            _ if value.is_empty() => false,
            _ => {
                self.set(field, value);
                true
            }
        }
    }

    /// Removes a field and returns its value, empty if it was blank; `None` if the object did not have it.
    pub fn remove(&mut self, field: Field) -> Option<String> {
        match &mut self.body {
            Body::Positions(values) => (values.len() >= field.at).then(|| values.remove(field.at - 1)),
            Body::Names { fields, .. } => fields.remove(field.name).as_ref().and_then(text_of),
        }
    }

    /// Renames a field, also in lists. Positions do not change. Returns whether the object had it.
    pub fn rename(&mut self, from: &str, to: &str) -> bool {
        match &mut self.body {
            Body::Positions(_) => false,
            Body::Names { fields, .. } => rename(fields, from, to),
        }
    }

    /// Calls `change` with every value of text; it returns a new value, or `None` to keep it. Returns whether a value
    /// changed.
    pub fn change_texts(&mut self, mut change: impl FnMut(&str) -> Option<String>) -> bool {
        match &mut self.body {
            Body::Positions(values) => values.iter_mut().fold(false, |changed, value| match change(value) {
                Some(new) => {
                    *value = new;
                    true
                }
                None => changed,
            }),
            Body::Names { name, fields } => {
                let renamed = change(name).map(|new| *name = new).is_some();
                fields.values_mut().fold(renamed, |changed, value| change_in(value, &mut change) || changed)
            }
        }
    }
}

fn rename(fields: &mut Fields, from: &str, to: &str) -> bool {
    let here = fields.remove(from).map(|value| fields.insert(to.to_owned(), value)).is_some();
    let items = fields.values_mut().filter_map(Value::as_array_mut).flatten();
    items
        .filter_map(Value::as_object_mut)
        .fold(here, |renamed, item: &mut Map<_, _>| rename(item, from, to) || renamed)
}

fn change_in(value: &mut Value, change: &mut impl FnMut(&str) -> Option<String>) -> bool {
    match value {
        Value::String(text) => change(text).map(|new| *text = new).is_some(),
        // Every value, also after one that changed.
        Value::Array(items) => {
            items.iter_mut().map(|item| usize::from(change_in(item, change))).sum::<usize>() > 0
        }
        Value::Object(fields) => {
            fields.values_mut().map(|item| usize::from(change_in(item, change))).sum::<usize>() > 0
        }
        _ => false,
    }
}

fn text_of(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

/// Returns a value as JSON: a number if it is one.
fn json(value: &str) -> Value {
    let number = value.parse::<f64>().ok().and_then(serde_json::Number::from_f64);
    number.map_or_else(|| Value::from(value), Value::Number)
}
