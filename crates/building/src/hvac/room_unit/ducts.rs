//! The air loop of a unit in a room.
//!
//! Nodes, in the order of the air: zone → return → outdoor air mixer, if there is any → unit → supply → terminal →
//! zone. The unit keeps its node of the mixed air or its inlet; its outlet becomes the terminal's.

use serde_json::{Value, json};

use super::zone_nodes::ZoneNodes;
use crate::hvac::air_loop_graph::{Component, set_components};
use crate::hvac::references::{Reference, reference, required};
use crate::hvac::schedules::ALWAYS_ON;
use crate::model::{Fields, number, text};
use crate::{Error, Model, Result};

const UNITARY_SYSTEM: &str = "AirLoopHVAC:UnitarySystem";
const OUTDOOR_AIR_SYSTEM: &str = "AirLoopHVAC:OutdoorAirSystem";
const MIXER: &str = "OutdoorAir:Mixer";
const CONTROLLER: &str = "Controller:OutdoorAir";
const TERMINAL: &str = "AirTerminal:SingleDuct:ConstantVolume:NoReheat";
const DISTRIBUTION: &str = "ZoneHVAC:AirDistributionUnit";

/// The names of an air loop's objects and nodes.
struct DuctedLoop {
    name: String,
    /// Node where the air enters the supply side.
    inlet: String,
    /// Node where the air enters the terminal, which delivers it to the zone.
    terminal: String,
    /// Design flow, m³/s.
    flow: f64,
}

/// Replaces the equipment of a zone with an air loop that has it as its only unit. Returns the name of the air loop.
///
/// # Errors
/// [`Error::Unsupported`] for a unit that takes air from elsewhere than its zone or delivers it elsewhere;
/// [`Error::MissingObject`] for a dangling reference.
pub(super) fn put_on_air_loop(model: &mut Model, zone: &str, unit: &Reference) -> Result<String> {
    let old = model.take(&unit.class, &unit.name)?;
    let node = |field: &str| required(&old, &unit.class, &unit.name, field);
    let (inlet, outlet) = (node("air_inlet_node_name")?, node("air_outlet_node_name")?);
    let zone = ZoneNodes::find(model, zone)?;
    refuse_other_paths(model, &zone, unit, [&inlet, &outlet])?;
    let name = name_of_air_loop(&unit.name);
    let terminal = format!("{name} Terminal Inlet");
    let air_loop = DuctedLoop { flow: design_flow(model, &old, unit)?, inlet, terminal, name };
    let mut components = Vec::new();
    let mut entry = air_loop.inlet.clone();
    if let Some((component, mixed)) = outdoor_air(model, &air_loop, &old)? {
        components.push(component);
        entry = mixed;
    }
    components.push(Component::new(UNITARY_SYSTEM, &unit.name, &entry, &air_loop.outlet()));
    model.insert(UNITARY_SYSTEM, &unit.name, Value::Object(old));
    air_loop.insert_supply_side(model, &components)?;
    air_loop.insert_demand_side(model);
    air_loop.insert_terminal(model, &outlet);
    zone.return_through(model, &air_loop.inlet, &air_loop.zone_return())?;
    let distribution = Reference { class: DISTRIBUTION.to_owned(), name: air_loop.distribution() };
    zone.replace(model, unit, &distribution)?;
    Ok(air_loop.name)
}

/// Returns the name of the air loop of a unit.
pub(super) fn name_of_air_loop(unit: &str) -> String {
    format!("{unit} Air Loop")
}

/// Rejects a unit that takes or delivers air at other nodes than its zone's.
fn refuse_other_paths(
    model: &Model,
    zone: &ZoneNodes,
    unit: &Reference,
    [inlet, outlet]: [&str; 2],
) -> Result<()> {
    let refused = |why: &str| Err(Error::unsupported(&unit.class, &unit.name, why));
    if !zone.takes(model, inlet) {
        return refused("its air inlet is not an exhaust node of its zone");
    }
    if !zone.delivers(model, outlet) {
        return refused("its air outlet is not an inlet node of its zone");
    }
    Ok(())
}

/// Returns the design flow of a unit, m³/s: the largest that it uses, limited by its fan.
fn design_flow(model: &Model, unit: &Fields, object: &Reference) -> Result<f64> {
    let fan = ["supply_air_fan", "supply_fan"]
        .iter()
        .find_map(|part| reference(unit, &format!("{part}_object_type"), &format!("{part}_name")))
        .ok_or_else(|| Error::unsupported(&object.class, &object.name, "it has no supply fan"))?;
    let fields = model.require(&fan.class, &fan.name)?;
    let sizes = ["design_maximum_air_flow_rate", "maximum_flow_rate"];
    let deliverable = sizes.iter().find_map(|size| number(fields, size)).ok_or_else(|| {
        Error::unsupported(&fan.class, &fan.name, "its design flow is not a number (is the model sized?)")
    })?;
    let used = largest(unit, "supply_air_flow_rate");
    Ok(if used > 0.0 { deliverable.min(used) } else { deliverable })
}

/// Returns the largest of the flows of a unit whose fields end in this way, m³/s; 0 if it has none.
fn largest(unit: &Fields, ending: &str) -> f64 {
    let flows = unit.keys().filter(|field| field.ends_with(ending));
    flows.filter_map(|field| number(unit, field)).fold(0.0, f64::max)
}

/// Puts the mixer of a unit into an outdoor air system with the unit's largest flow of outdoor air, and returns its
/// component and the node of the mixed air. A unit without a mixer has none; a mixer without outdoor air is removed.
fn outdoor_air(
    model: &mut Model,
    air_loop: &DuctedLoop,
    unit: &Fields,
) -> Result<Option<(Component, String)>> {
    let flow = largest(unit, "outdoor_air_flow_rate");
    let Some(mixer) = text(unit, "outdoor_air_mixer_name") else { return Ok(None) };
    if flow <= 0.0 {
        model.remove(MIXER, mixer);
        return Ok(None);
    }
    let fields = model.require(MIXER, mixer)?;
    let node = |field: &str| required(fields, MIXER, mixer, field);
    let mixed = node("mixed_air_node_name")?;
    let mut controller = json!({
        "mixed_air_node_name": mixed,
        "return_air_node_name": node("return_air_stream_node_name")?,
        "relief_air_outlet_node_name": node("relief_air_stream_node_name")?,
        "actuator_node_name": node("outdoor_air_stream_node_name")?,
        "minimum_outdoor_air_flow_rate": flow,
        "maximum_outdoor_air_flow_rate": air_loop.flow.max(flow),
        "economizer_control_type": "NoEconomizer",
        "minimum_limit_type": "FixedMinimum",
    });
    if let Some(schedule) = text(unit, "outdoor_air_schedule_name") {
        controller["minimum_outdoor_air_schedule_name"] = json!(schedule);
    }
    let [system, controllers, equipment] =
        ["Outdoor Air", "Controllers", "Outdoor Air Equipment"].map(|part| air_loop.named(part));
    model.insert(CONTROLLER, &system, controller);
    let list = json!({"controller_1_object_type": CONTROLLER, "controller_1_name": system});
    model.insert("AirLoopHVAC:ControllerList", &controllers, list);
    let list = json!({"component_1_object_type": MIXER, "component_1_name": mixer});
    model.insert("AirLoopHVAC:OutdoorAirSystem:EquipmentList", &equipment, list);
    let fields = json!({"controller_list_name": controllers, "outdoor_air_equipment_list_name": equipment});
    model.insert(OUTDOOR_AIR_SYSTEM, &system, fields);
    let component = Component::new(OUTDOOR_AIR_SYSTEM, &system, &air_loop.inlet, &mixed);
    Ok(Some((component, mixed)))
}

impl DuctedLoop {
    /// Returns the name of a part.
    fn named(&self, part: &str) -> String {
        format!("{} {part}", self.name)
    }

    fn outlet(&self) -> String {
        self.named("Supply Outlet")
    }

    fn zone_return(&self) -> String {
        self.named("Zone Return")
    }

    fn distribution(&self) -> String {
        self.named("Distribution")
    }

    fn insert_supply_side(&self, model: &mut Model, components: &[Component]) -> Result<()> {
        let [branches, branch] = ["Branches", "Branch"].map(|part| self.named(part));
        let fields = json!({
            "design_supply_air_flow_rate": self.flow,
            "branch_list_name": branches,
            "supply_side_inlet_node_name": self.inlet,
            "supply_side_outlet_node_names": self.outlet(),
            "demand_side_inlet_node_names": self.named("Demand Inlet"),
            "demand_side_outlet_node_name": self.named("Demand Outlet"),
        });
        model.insert("AirLoopHVAC", &self.name, fields);
        model.insert("BranchList", &branches, json!({"branches": [{"branch_name": branch}]}));
        model.insert("Branch", &branch, json!({}));
        set_components(model, &branch, components)
    }

    fn insert_demand_side(&self, model: &mut Model) {
        const SPLITTER: &str = "AirLoopHVAC:ZoneSplitter";
        const MIXER: &str = "AirLoopHVAC:ZoneMixer";
        let [splitter, mixer] = ["Splitter", "Mixer"].map(|part| self.named(part));
        let [inlet, outlet] = ["Demand Inlet", "Demand Outlet"].map(|part| self.named(part));
        let fields = json!({
            "supply_air_path_inlet_node_name": inlet,
            "components": [{"component_object_type": SPLITTER, "component_name": splitter}],
        });
        model.insert("AirLoopHVAC:SupplyPath", &self.named("Supply Path"), fields);
        let fields = json!({"inlet_node_name": inlet, "nodes": [{"outlet_node_name": self.terminal}]});
        model.insert(SPLITTER, &splitter, fields);
        let fields = json!({
            "return_air_path_outlet_node_name": outlet,
            "components": [{"component_object_type": MIXER, "component_name": mixer}],
        });
        model.insert("AirLoopHVAC:ReturnPath", &self.named("Return Path"), fields);
        let fields = json!({"outlet_node_name": outlet, "nodes": [{"inlet_node_name": self.zone_return()}]});
        model.insert(MIXER, &mixer, fields);
    }

    /// Adds the terminal that delivers air through the node of the unit.
    fn insert_terminal(&self, model: &mut Model, delivered: &str) {
        let terminal = self.named("Terminal");
        let fields = json!({
            "availability_schedule_name": ALWAYS_ON,
            "air_inlet_node_name": self.terminal,
            "air_outlet_node_name": delivered,
            "maximum_air_flow_rate": self.flow,
        });
        model.insert(TERMINAL, &terminal, fields);
        let fields = json!({
            "air_distribution_unit_outlet_node_name": delivered,
            "air_terminal_object_type": TERMINAL,
            "air_terminal_name": terminal,
        });
        model.insert(DISTRIBUTION, &self.distribution(), fields);
    }
}
