//! Copies of materials and constructions under new names.

use crate::model::{Fields, text};
use crate::{Error, Model, Result};

/// Returns a name that is unused in the classes with this prefix. Materials of all classes share one namespace.
pub(super) fn unused_name(model: &Model, prefix: &str, wanted: &str) -> String {
    let classes: Vec<&str> = model.classes().filter(|class| class.starts_with(prefix)).collect();
    let is_free = |name: &String| classes.iter().all(|class| !model.contains(class, name));
    let numbered = (2..).map(|number| format!("{wanted} {number}"));
    let mut names = std::iter::once(wanted.to_owned()).chain(numbered);
    names.find(is_free).expect("a model has fewer objects than there are numbers")
}

/// Copies an object under an unused name, which is returned.
pub(super) fn copy(model: &mut Model, class: &str, name: &str, wanted: &str) -> Result<String> {
    let mut fields = model.require(class, name)?.clone();
    fields.remove("idf_order");
    let prefix = if class.starts_with("Construction") { "Construction" } else { family(class) };
    let copy = unused_name(model, prefix, wanted);
    model.insert(class, &copy, fields.into());
    Ok(copy)
}

fn family(class: &str) -> &str {
    class.split(':').next().unwrap_or(class)
}

/// Returns the name of an object as the model spells it.
pub(super) fn spelled(model: &Model, class: &str, name: &str) -> String {
    let mut names = model.names(class).into_iter();
    names.find(|known| known.eq_ignore_ascii_case(name)).unwrap_or_else(|| name.to_owned())
}

/// Returns how many objects are made of a construction: they name it in `construction_name`. A class of properties, such
/// as `ConstructionProperty:InternalHeatSource`, describes what others are made of.
pub(super) fn users_of(model: &Model, construction: &str) -> usize {
    let is_property = |class: &&str| family(class).ends_with("Property");
    let users = model.classes().filter(|class| !is_property(class));
    users.map(|class| naming(model, class, construction).len()).sum()
}

/// Checks that a construction has no heat source, which is at a layer of this construction.
///
/// # Errors
/// [`Error::Edit`] with the reason and the remedy.
pub(super) fn require_no_source(model: &Model, construction: &str, reason: &str) -> Result<()> {
    const SOURCE: &str = "ConstructionProperty:InternalHeatSource";
    let Some(source) = naming(model, SOURCE, construction).into_iter().next() else { return Ok(()) };
    Err(Error::edit("Construction", construction, &format!("the {SOURCE} `{source}` is in it, and {reason}")))
}

/// Returns the objects of a class that name a construction.
fn naming<'a>(model: &'a Model, class: &str, construction: &str) -> Vec<&'a str> {
    let names_it = |fields: &Fields| {
        text(fields, "construction_name").is_some_and(|name| name.eq_ignore_ascii_case(construction))
    };
    let objects = model.objects(class).into_iter();
    objects.filter(|(_, fields)| names_it(fields)).map(|(name, _)| name).collect()
}

/// Returns the class of a construction that is not given by layers.
pub(super) fn other_class<'a>(model: &'a Model, construction: &str) -> Option<&'a str> {
    model.classes().find(|class| class.starts_with("Construction:") && model.contains(class, construction))
}

/// Returns the layers of a construction as fields.
///
/// # Errors
/// [`Error::Edit`] for a construction that is not given by layers; [`Error::MissingObject`] for a dangling reference.
pub(super) fn layered<'a>(model: &'a Model, construction: &str) -> Result<&'a Fields> {
    match other_class(model, construction) {
        Some(class) => Err(Error::edit(class, construction, "only a Construction of layers can be changed")),
        None => model.require("Construction", construction),
    }
}
