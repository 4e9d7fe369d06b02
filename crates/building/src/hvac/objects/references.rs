//! References between the objects of a model.

use serde::{Deserialize, Serialize};

use crate::model::{Fields, Model, items, text};
use crate::{Error, Result};

/// A class and the name of one of its objects.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reference {
    /// EnergyPlus class.
    pub class: String,
    /// Object name.
    pub name: String,
}

/// Returns the object that two fields, class and name, refer to.
pub fn reference(fields: &Fields, class: &str, name: &str) -> Option<Reference> {
    Some(Reference { class: text(fields, class)?.to_owned(), name: text(fields, name)?.to_owned() })
}

/// Returns the fans and coils that an object refers to, as `…_object_type` with `…_name`.
pub fn parts(fields: &Fields) -> Vec<Reference> {
    fields
        .keys()
        .filter_map(|key| key.strip_suffix("_object_type"))
        .filter(|part| part.contains("fan") || part.contains("coil"))
        .filter_map(|part| reference(fields, &format!("{part}_object_type"), &format!("{part}_name")))
        .collect()
}

/// Returns the nodes of a list, or the node with this name.
pub fn nodes_of(model: &Model, name: &str) -> Vec<String> {
    match model.get("NodeList", name) {
        Some(list) => {
            items(list, "nodes").filter_map(|item| text(item, "node_name")).map(str::to_owned).collect()
        }
        None => vec![name.to_owned()],
    }
}

/// Returns whether a class is one of these, ignoring case as the engine does.
pub fn is_one_of(class: &str, classes: &[&str]) -> bool {
    classes.iter().any(|known| known.eq_ignore_ascii_case(class))
}

/// Returns a text field that must be given.
///
/// # Errors
/// [`Error::Unsupported`] when it is not.
pub(in crate::hvac) fn required(fields: &Fields, class: &str, name: &str, field: &str) -> Result<String> {
    text(fields, field)
        .map(str::to_owned)
        .ok_or_else(|| Error::unsupported(class, name, &format!("`{field}` is missing")))
}
