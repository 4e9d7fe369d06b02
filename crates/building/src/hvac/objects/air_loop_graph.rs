//! The supply side of air loops: their branches and the components on them.

use serde_json::{Value, json};

use super::references::Reference;
use crate::model::{Fields, Model, items, text};
use crate::{Error, Result};

/// A component of a branch, with the nodes at its ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Component {
    /// The component.
    pub object: Reference,
    /// Name of the node where the air enters.
    pub inlet: String,
    /// Name of the node where the air leaves.
    pub outlet: String,
}

impl Component {
    /// A component of this class and name between two nodes.
    pub fn new(class: &str, name: &str, inlet: &str, outlet: &str) -> Self {
        let object = Reference { class: class.to_owned(), name: name.to_owned() };
        Self { object, inlet: inlet.to_owned(), outlet: outlet.to_owned() }
    }

    fn read(item: &Fields) -> Self {
        let field = |field| text(item, field).unwrap_or_default();
        Self::new(
            field("component_object_type"),
            field("component_name"),
            field("component_inlet_node_name"),
            field("component_outlet_node_name"),
        )
    }

    fn to_epjson(&self) -> Value {
        json!({
            "component_object_type": self.object.class,
            "component_name": self.object.name,
            "component_inlet_node_name": self.inlet,
            "component_outlet_node_name": self.outlet,
        })
    }
}

/// Returns the names of the branches on the supply side of an air loop.
///
/// # Errors
/// [`Error::MissingObject`] when the loop or its branch list is not in the model.
pub fn branches(model: &Model, air_loop: &str) -> Result<Vec<String>> {
    let fields = model.require("AirLoopHVAC", air_loop)?;
    let list = text(fields, "branch_list_name").unwrap_or_default();
    let branches = items(model.require("BranchList", list)?, "branches");
    Ok(branches.filter_map(|item| text(item, "branch_name")).map(str::to_owned).collect())
}

/// Returns the one branch of an air loop's supply side.
///
/// # Errors
/// [`Error::Unsupported`] unless there is exactly one; [`Error::MissingObject`] for a dangling reference.
pub fn only_branch(model: &Model, air_loop: &str) -> Result<String> {
    let list = text(model.require("AirLoopHVAC", air_loop)?, "branch_list_name").unwrap_or_default();
    match <[String; 1]>::try_from(branches(model, air_loop)?) {
        Ok([branch]) => Ok(branch),
        Err(_) => Err(Error::unsupported(
            "BranchList",
            list,
            "its air handler has several branches; one is supported",
        )),
    }
}

/// Returns the components of a branch, in the direction of the air.
///
/// # Errors
/// [`Error::MissingObject`] when the branch is not in the model.
pub fn components(model: &Model, branch: &str) -> Result<Vec<Component>> {
    Ok(items(model.require("Branch", branch)?, "components").map(Component::read).collect())
}

/// Replaces the components of a branch.
///
/// # Errors
/// [`Error::MissingObject`] when the branch is not in the model.
pub fn set_components(model: &mut Model, branch: &str, components: &[Component]) -> Result<()> {
    let components: Vec<Value> = components.iter().map(Component::to_epjson).collect();
    model.require_mut("Branch", branch)?.insert("components".into(), components.into());
    Ok(())
}

/// Returns the objects on the supply side of an air loop, in the order of its branches.
///
/// # Errors
/// [`Error::MissingObject`] when the loop, its branch list or a branch is not in the model.
pub fn supply_components(model: &Model, air_loop: &str) -> Result<Vec<Reference>> {
    let mut found = Vec::new();
    for branch in branches(model, air_loop)? {
        found.extend(components(model, &branch)?.into_iter().map(|component| component.object));
    }
    Ok(found)
}
