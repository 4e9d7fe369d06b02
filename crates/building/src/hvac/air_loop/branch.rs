//! The supply branch of a central air loop.

use std::collections::HashSet;

use super::components::{COOLING, FANS, HEATING, OUTDOOR_AIR_SYSTEM};
use crate::hvac::air_loop_graph::{Component, components, only_branch, set_components};
use crate::hvac::references::{Reference, is_one_of, parts};
use crate::model::{Model, text};
use crate::{Error, Result};

/// The supply branch of an air loop: its components and the nodes between them.
pub(super) struct MainBranch {
    name: String,
    pub(super) outdoor_air: Reference,
    cooling: Reference,
    pub(super) heating: Reference,
    pub(super) fan: Reference,
    /// The components, in the order of the branch.
    pub(super) components: Vec<Component>,
}

impl MainBranch {
    /// Reads the branch and rejects unsupported components.
    pub(super) fn find(model: &Model, air_loop: &str) -> Result<Self> {
        let name = only_branch(model, air_loop)?;
        let components = components(model, &name)?;
        components.iter().try_for_each(|component| require_known(model, &component.object))?;
        let one = |classes: &[&str]| one_of(&components, classes, &name);
        Ok(Self {
            outdoor_air: one(&[OUTDOOR_AIR_SYSTEM])?,
            cooling: one(&COOLING)?,
            heating: one(&HEATING)?,
            fan: one(&FANS.map(|(class, _)| class))?,
            components,
            name,
        })
    }

    /// Every node of the branch, in lower case.
    pub(super) fn nodes(&self) -> HashSet<String> {
        self.components
            .iter()
            .flat_map(|component| [&component.inlet, &component.outlet])
            .map(|node| node.to_lowercase())
            .collect()
    }

    /// The node at the end of the branch, where the air leaves the air handler.
    pub(super) fn outlet(&self) -> &str {
        self.components.last().map_or("", |component| &component.outlet)
    }

    /// The node between the cooling and the heating coil of the rewired branch.
    pub(super) fn cooling_outlet(&self) -> String {
        outlet_node(&self.cooling)
    }

    /// The components in blow-through order with their nodes there.
    pub(super) fn blow_through(&self) -> Vec<Component> {
        let order = [&self.outdoor_air, &self.fan, &self.cooling, &self.heating];
        let mut inlet = self.components[0].inlet.clone();
        let mut placed = Vec::new();
        for object in order {
            let outlet = match object {
                c if c == &self.outdoor_air => self.components[0].outlet.clone(),
                c if c == &self.heating => self.outlet().to_owned(),
                c => outlet_node(c),
            };
            placed.push(Component { object: object.clone(), inlet, outlet: outlet.clone() });
            inlet = outlet;
        }
        placed
    }

    /// Moves the fan upstream of the coils. Downstream of them, the coils' setpoints would have to be lowered by an
    /// estimate of its heat, which lags changes of the flow.
    pub(super) fn rewire(&self, model: &mut Model) -> Result<()> {
        let placed = self.blow_through();
        for component in &placed {
            if let Some(before) = self.components.iter().find(|c| c.object == component.object) {
                move_component(model, &component.object, before, component)?;
            }
        }
        set_components(model, &self.name, &placed)
    }
}

fn outlet_node(component: &Reference) -> String {
    format!("{} Outlet Node", component.name)
}

fn require_known(model: &Model, component: &Reference) -> Result<()> {
    let Reference { class, name } = component;
    let fields = model.require(class, name)?;
    let [fan, fan_system] = FANS.map(|(class, _)| class);
    let known: Vec<_> =
        [OUTDOOR_AIR_SYSTEM, fan, fan_system].into_iter().chain(COOLING).chain(HEATING).collect();
    if !is_one_of(class, &known) {
        return Err(Error::unsupported(class, name, "unsupported component of a central air handler"));
    }
    let coil = text(fields, "cooling_coil_object_type");
    if coil.is_some_and(|class| !class.eq_ignore_ascii_case("Coil:Cooling:DX:TwoSpeed")) {
        return Err(Error::unsupported(class, name, "its coil must be a Coil:Cooling:DX:TwoSpeed"));
    }
    Ok(())
}

fn one_of(components: &[Component], classes: &[&str], branch: &str) -> Result<Reference> {
    let mut found = components.iter().map(|c| &c.object).filter(|object| is_one_of(&object.class, classes));
    match (found.next(), found.next()) {
        (Some(object), None) => Ok(object.clone()),
        _ => Err(Error::unsupported("Branch", branch, &format!("it must have one {}", classes.join(" or ")))),
    }
}

/// Moves a component and the coil in it to other nodes, with a setpoint or sensor node at its outlet.
fn move_component(model: &mut Model, component: &Reference, from: &Component, to: &Component) -> Result<()> {
    let fields = model.require_mut(&component.class, &component.name)?;
    for value in fields.values_mut() {
        match value.as_str() {
            Some(node) if node.eq_ignore_ascii_case(&from.inlet) => *value = to.inlet.clone().into(),
            Some(node) if node.eq_ignore_ascii_case(&from.outlet) => *value = to.outlet.clone().into(),
            _ => {}
        }
    }
    if fields.contains_key("temperature_setpoint_node_name") {
        fields.insert("temperature_setpoint_node_name".into(), to.outlet.clone().into());
    }
    for part in parts(fields) {
        move_component(model, &part, from, to)?;
    }
    Ok(())
}
