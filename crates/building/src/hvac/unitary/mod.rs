//! Unitary systems: one unit, one zone, driven by air flow and supply air temperature.
//!
//! Whatever packaged unit the model has is rewritten as one kind that obeys both commands exactly: a
//! blow-through `AirLoopHVAC:UnitarySystem` under setpoint control with a variable-volume fan and a two-speed
//! cooling coil, feeding a terminal whose minimum flow is the command. A heat pump's heating coils follow behind it.
//! Capacities, efficiencies, pressures and curves are those of the original unit.

mod assemble;
mod cooling_coil;
mod heat_pump;
mod outdoor_air;

use std::collections::HashSet;

use serde_json::{Value, json};

use super::common::{self, unsupported};
use super::distribution::{ServedZone, served_zones};
use super::{Actuator, EngineVariable, Quantity, Unitary};
use crate::model::{Fields, Model, number, text};
use crate::{Error, Result};
use outdoor_air::OutdoorAir;

/// Supply air temperatures an agent may ask for, °C. The lower end is what a cooling coil delivers without
/// freezing; the upper end is below what gas coils and heat pumps reach at full flow on a design day.
const SUPPLY_TEMPERATURE: (f64, f64) = (10.0, 45.0);
/// The engine's limit on supply air temperature, °C: above what an agent may ask for, so that it never binds.
const MAXIMUM_SUPPLY_TEMPERATURE: f64 = 80.0;
/// Outdoor temperature under which the compressor stops cooling, °C. Out of reach: an overheated zone is the
/// agent's to cool in any weather, and a lock-out would take the actuator away without a word.
const COOLING_LOCKOUT: f64 = -60.0;
/// Efficiencies of a fan whose model does not say: the engine's own defaults.
const FAN_EFFICIENCY: f64 = 0.7;
const MOTOR_EFFICIENCY: f64 = 0.9;
/// Part-load power of a variable-speed fan, by powers of the flow fraction (ASHRAE 90.1 appendix G, table
/// G3.1.3.15, method 2, without its minimum).
const FAN_POWER: [f64; 5] = [0.0013, 0.1470, 0.9506, -0.0998, 0.0];

/// Makes the unitary system of an air loop controllable. The model must be hard-sized.
///
/// # Errors
/// [`Error::Unsupported`] naming the object that cannot be rewritten; [`Error::MissingObject`] for a dangling
/// reference.
pub fn make_controllable(model: &mut Model, air_loop: &str, air_density: f64) -> Result<Unitary> {
    assemble::assemble(model, air_loop)?;
    heat_pump::rejoin(model, air_loop)?;
    let unit = Unit::find(model, air_loop)?;
    let schedules = Schedules::insert(model, &unit.served.zone);
    common::always_on(model, air_loop)?;
    common::own_thermostat(model, &unit.served.zone, 0.0, common::OUT_OF_REACH)?;
    let nodes = unit.rewrite(model)?;
    follow_supply_temperature(model, &unit, &nodes, &schedules.temperature);
    if let Some(outdoor_air) = &unit.outdoor_air {
        outdoor_air.follow(model, &unit, &nodes)?;
    }
    let terminal = follow_flow(model, &unit, &schedules.flow)?;
    let flow = terminal.design_flow * air_density;
    Ok(Unitary {
        flow: Actuator {
            name: format!("{} supply air flow", unit.served.zone),
            quantity: Quantity::SupplyAirFlow,
            low: 0.0,
            high: flow,
            component: "Schedule:Constant".into(),
            control: "Schedule Value".into(),
            key: schedules.flow,
            scale: 1.0 / flow,
            effect: EngineVariable::new("System Node Mass Flow Rate", &terminal.outlet),
            effect_scale: 1.0,
            heat: None,
        },
        supply_temperature: Actuator {
            name: format!("{} supply air temperature", unit.served.zone),
            quantity: Quantity::SupplyAirTemperature,
            low: SUPPLY_TEMPERATURE.0,
            high: SUPPLY_TEMPERATURE.1,
            component: "Schedule:Constant".into(),
            control: "Schedule Value".into(),
            key: schedules.temperature,
            scale: 1.0,
            effect: EngineVariable::new("System Node Temperature", &unit.outlet),
            effect_scale: 1.0,
            heat: None,
        },
        zone: unit.served.zone,
    })
}

/// What a unit becomes.
const UNITARY_SYSTEM: &str = "AirLoopHVAC:UnitarySystem";

/// The heating coils that are no heat pump's.
const HEATERS: [&str; 2] = ["Coil:Heating:Fuel", "Coil:Heating:Electric"];

/// The classes this module rewrites.
const UNIT_CLASSES: [&str; 4] = [
    UNITARY_SYSTEM,
    "AirLoopHVAC:UnitaryHeatPump:AirToAir",
    "AirLoopHVAC:UnitaryHeatCool",
    "AirLoopHVAC:Unitary:Furnace:HeatCool",
];

/// The terminals that a unit can feed.
const TERMINALS: [&str; 2] =
    ["AirTerminal:SingleDuct:ConstantVolume:NoReheat", "AirTerminal:SingleDuct:VAV:NoReheat"];

/// Whether an air loop has a unit that this module rewrites, or the parts of one.
///
/// # Errors
/// [`Error::MissingObject`] for a dangling reference.
pub(super) fn has_unit(model: &Model, air_loop: &str) -> Result<bool> {
    let components = common::supply_components(model, air_loop)?;
    Ok(components.iter().any(|c| is_unit(&c.class)) || assemble::has_parts(model, air_loop)?)
}

/// Whether an object class is a unit that this module rewrites.
fn is_unit(class: &str) -> bool {
    common::is_one_of(class, &UNIT_CLASSES)
}

/// The branch and the component entry of the first unit on an air loop's supply side.
fn unit_component<'a>(model: &'a Model, air_loop: &str) -> Result<Option<(String, &'a Fields)>> {
    let fields = model.require("AirLoopHVAC", air_loop)?;
    let list = required(fields, "AirLoopHVAC", air_loop, "branch_list_name")?;
    for branch in common::items(model.require("BranchList", &list)?, "branches") {
        let branch = text(branch, "branch_name").unwrap_or_default();
        let unit = common::items(model.require("Branch", branch)?, "components")
            .find(|c| text(c, "component_object_type").is_some_and(is_unit));
        if let Some(unit) = unit {
            return Ok(Some((branch.to_owned(), unit)));
        }
    }
    Ok(None)
}

/// The packaged unit of an air loop, as the model has it.
struct Unit {
    air_loop: String,
    branch: String,
    class: String,
    name: String,
    inlet: String,
    outlet: String,
    demand_inlet: String,
    served: ServedZone,
    outdoor_air: Option<OutdoorAir>,
    /// Every node in it and at its ends, as they were, in lower case.
    old_nodes: HashSet<String>,
}

/// The control schedules of a zone's unit.
struct Schedules {
    flow: String,
    temperature: String,
}

/// A terminal after its edit.
struct Terminal {
    /// Volume flow, m³/s.
    design_flow: f64,
    outlet: String,
}

/// Name of the schedule of a zone's flow command, as a fraction of its terminal's design flow.
pub fn supply_air_flow_fraction(zone: &str) -> String {
    format!("{zone} Supply Air Flow Fraction")
}

/// Name of the schedule of a zone's supply air temperature command, °C.
pub fn supply_air_temperature(zone: &str) -> String {
    format!("{zone} Supply Air Temperature")
}

impl Schedules {
    fn insert(model: &mut Model, zone: &str) -> Self {
        let schedules =
            Self { flow: supply_air_flow_fraction(zone), temperature: supply_air_temperature(zone) };
        common::constant_schedule(model, &schedules.flow, 0.0);
        common::constant_schedule(model, &schedules.temperature, 20.0);
        schedules
    }
}

impl Unit {
    fn find(model: &Model, air_loop: &str) -> Result<Self> {
        let fields = model.require("AirLoopHVAC", air_loop)?;
        let demand_inlet = demand_inlet(model, air_loop, fields)?;
        let (branch, component) = unit_component(model, air_loop)?
            .ok_or_else(|| unsupported("AirLoopHVAC", air_loop, "its branches have no unitary system"))?;
        let part = |field: &str| text(component, field).unwrap_or_default().to_owned();
        let (class, name) = (part("component_object_type"), part("component_name"));
        let (inlet, outlet) = (part("component_inlet_node_name"), part("component_outlet_node_name"));
        let mut old_nodes = inner_nodes(model, model.require(&class, &name)?)?;
        old_nodes.extend([inlet.clone(), outlet.clone(), demand_inlet.clone()]);
        let old_nodes = old_nodes.iter().map(|node| node.to_lowercase()).collect();
        let served = only_zone(model, air_loop)?;
        let outdoor_air = OutdoorAir::find(model, &inlet);
        let air_loop = air_loop.to_owned();
        Ok(Self {
            air_loop,
            branch,
            class,
            name,
            inlet,
            outlet,
            demand_inlet,
            served,
            outdoor_air,
            old_nodes,
        })
    }

    /// Replaces the unit by its controllable form and returns the nodes inside it.
    fn rewrite(&self, model: &mut Model) -> Result<Nodes> {
        let old = take(model, &self.class, &self.name)?;
        if coil(&old, "reheat_coil").is_some() {
            let why = "it dries air with a reheat coil, which the agent's supply temperature would fight";
            return Err(unsupported(&self.class, &self.name, why));
        }
        remove_multispeed_design(model, &old);
        let supplemental = coil(&old, "supplemental_heating_coil");
        let nodes = Nodes {
            fan: format!("{} Fan Outlet", self.air_loop),
            cooling: format!("{} Cooling Coil Outlet", self.air_loop),
            heating: match &supplemental {
                Some(_) => format!("{} Heating Coil Outlet", self.air_loop),
                None => self.outlet.clone(),
            },
        };
        let (fan, flow) = self.rewrite_fan(model, &old, &nodes)?;
        let cooling = self.rewrite_cooling_coil(model, &old, &nodes)?;
        let heating = coil(&old, "heating_coil")
            .ok_or_else(|| unsupported(&self.class, &self.name, "it has no heating coil"))?;
        place_heating_coil(model, &heating, &nodes.cooling, &nodes.heating)?;
        if let Some(supplemental) = &supplemental {
            place_heating_coil(model, supplemental, &nodes.heating, &self.outlet)?;
        }
        let mut unit = json!({
            "control_type": "SetPoint",
            "controlling_zone_or_thermostat_location": self.served.zone,
            "dehumidification_control_type": "None",
            "availability_schedule_name": common::ALWAYS_ON,
            "air_inlet_node_name": self.inlet,
            "supply_fan_object_type": "Fan:VariableVolume",
            "supply_fan_name": fan,
            "fan_placement": "BlowThrough",
            "supply_air_fan_operating_mode_schedule_name": common::ALWAYS_ON,
            "cooling_coil_object_type": "Coil:Cooling:DX:TwoSpeed",
            "cooling_coil_name": cooling,
            "minimum_supply_air_temperature": 2.0,
            "latent_load_control": "SensibleOnlyLoadControl",
            "maximum_supply_air_temperature": MAXIMUM_SUPPLY_TEMPERATURE,
        });
        for regime in ["cooling", "heating", "no_load"] {
            unit[format!("{regime}_supply_air_flow_rate_method")] = json!("SupplyAirFlowRate");
            unit[format!("{regime}_supply_air_flow_rate")] = json!(flow);
        }
        let mut components = Vec::new();
        if self.heats_apart(&heating) {
            components = heat_pump::stand_apart(model, self, &nodes, &heating, supplemental.as_ref())?;
        } else {
            unit["heating_coil_object_type"] = json!(heating.0);
            unit["heating_coil_name"] = json!(heating.1);
            unit["dx_heating_coil_sizing_ratio"] = json!(1.0);
            if let Some((class, name)) = supplemental {
                unit["supplemental_heating_coil_object_type"] = json!(class);
                unit["supplemental_heating_coil_name"] = json!(name);
                let limit = "maximum_outdoor_dry_bulb_temperature_for_supplemental_heater_operation";
                unit[limit] = old.get(limit).cloned().unwrap_or(json!(21.0));
            }
        }
        let outlet = if components.is_empty() { &self.outlet } else { &nodes.cooling };
        unit["air_outlet_node_name"] = json!(outlet);
        components.insert(0, component(UNITARY_SYSTEM, &self.name, &self.inlet, outlet));
        model.insert(UNITARY_SYSTEM, &self.name, unit);
        self.put_on_branch(model, components)?;
        Ok(nodes)
    }

    /// Whether the heating coils leave the unit: those of a heat pump. With an economiser, which aims at a temperature
    /// ahead of the fan, the engine would go round the air side a dozen times.
    fn heats_apart(&self, heating: &Coil) -> bool {
        let economises = self.outdoor_air.as_ref().is_some_and(|air| air.has_economiser);
        heating.0.eq_ignore_ascii_case(heat_pump::HEATING_COIL) && !economises
    }

    /// Puts components on the branch in the place of the unit.
    fn put_on_branch(&self, model: &mut Model, new: Vec<Value>) -> Result<()> {
        let branch = model.require_mut("Branch", &self.branch)?;
        let is_unit = |component: &Value| {
            component["component_name"].as_str().is_some_and(|name| name.eq_ignore_ascii_case(&self.name))
        };
        if let Some(components) = branch.get_mut("components").and_then(Value::as_array_mut)
            && let Some(at) = components.iter().position(is_unit)
        {
            components.splice(at..=at, new);
        }
        Ok(())
    }

    /// A variable-volume fan with the old fan's pressure and efficiencies, and no minimum flow.
    /// Returns its name and its design flow, m³/s.
    fn rewrite_fan(&self, model: &mut Model, unit: &Fields, nodes: &Nodes) -> Result<(String, f64)> {
        let class = text(unit, "supply_fan_object_type").or(text(unit, "supply_air_fan_object_type"));
        let name = text(unit, "supply_fan_name").or(text(unit, "supply_air_fan_name"));
        let (Some(class), Some(name)) = (class, name) else {
            return Err(unsupported(&self.class, &self.name, "it has no supply fan"));
        };
        let fan = take(model, class, name)?;
        let given = |fields: &[&str]| fields.iter().find_map(|f| number(&fan, f));
        let read = |fields: &[&str]| {
            given(fields).ok_or_else(|| {
                unsupported(class, name, &format!("`{}` is not a number (is the model sized?)", fields[0]))
            })
        };
        let flow = read(&["design_maximum_air_flow_rate", "maximum_flow_rate"])?;
        let [c1, c2, c3, c4, c5] = FAN_POWER;
        model.insert(
            "Fan:VariableVolume",
            name,
            json!({
                "availability_schedule_name": common::ALWAYS_ON,
                "fan_total_efficiency": given(&["fan_total_efficiency"]).unwrap_or(FAN_EFFICIENCY),
                "pressure_rise": read(&["design_pressure_rise", "pressure_rise"])?,
                "maximum_flow_rate": flow,
                "fan_power_minimum_flow_rate_input_method": "Fraction",
                "fan_power_minimum_flow_fraction": 0.0,
                "motor_efficiency": given(&["motor_efficiency"]).unwrap_or(MOTOR_EFFICIENCY),
                "motor_in_airstream_fraction":
                    given(&["motor_in_air_stream_fraction", "motor_in_airstream_fraction"]).unwrap_or(1.0),
                "fan_power_coefficient_1": c1,
                "fan_power_coefficient_2": c2,
                "fan_power_coefficient_3": c3,
                "fan_power_coefficient_4": c4,
                "fan_power_coefficient_5": c5,
                "air_inlet_node_name": self.inlet,
                "air_outlet_node_name": nodes.fan,
            }),
        );
        Ok((name.to_owned(), flow))
    }

    /// A two-speed coil with the old coil's performance.
    fn rewrite_cooling_coil(&self, model: &mut Model, unit: &Fields, nodes: &Nodes) -> Result<String> {
        let (class, name) = coil(unit, "cooling_coil")
            .ok_or_else(|| unsupported(&self.class, &self.name, "it has no cooling coil"))?;
        let old = take(model, &class, &name)?;
        let mut new = cooling_coil::two_speed_equivalent(&class, old)
            .ok_or_else(|| unsupported(&class, &name, "no two-speed equivalent is known for it"))?;
        new["availability_schedule_name"] = json!(common::ALWAYS_ON);
        new["air_inlet_node_name"] = json!(nodes.fan);
        new["air_outlet_node_name"] = json!(nodes.cooling);
        new["condenser_type"] = json!("AirCooled");
        new["minimum_outdoor_dry_bulb_temperature_for_compressor_operation"] = json!(COOLING_LOCKOUT);
        model.insert("Coil:Cooling:DX:TwoSpeed", &name, new);
        Ok(name)
    }
}

/// Every node that a fan or a coil of a unit is on.
fn inner_nodes(model: &Model, unit: &Fields) -> Result<Vec<String>> {
    let mut nodes = Vec::new();
    for part in common::parts(unit) {
        let part = model.require(&part.class, &part.name)?;
        let ends = ["air_inlet_node_name", "air_outlet_node_name"];
        nodes.extend(ends.iter().filter_map(|end| text(part, end)).map(str::to_owned));
    }
    Ok(nodes)
}

/// The nodes inside a unit.
struct Nodes {
    fan: String,
    cooling: String,
    heating: String,
}

/// Class and name of a coil.
type Coil = (String, String);

/// A component of a branch.
fn component(class: &str, name: &str, inlet: &str, outlet: &str) -> Value {
    json!({
        "component_object_type": class,
        "component_name": name,
        "component_inlet_node_name": inlet,
        "component_outlet_node_name": outlet,
    })
}

/// The coil that a unit refers to.
fn coil(unit: &Fields, which: &str) -> Option<Coil> {
    let class = text(unit, &format!("{which}_object_type"))?;
    let name = text(unit, &format!("{which}_name"))?;
    Some((class.to_owned(), name.to_owned()))
}

fn remove_multispeed_design(model: &mut Model, unit: &Fields) {
    let design = |field: &str| text(unit, &format!("design_specification_multispeed_object_{field}"));
    if let (Some(class), Some(name)) = (design("type"), design("name")) {
        model.remove(class, name);
    }
}

/// Heating coils that can follow a setpoint keep their class; only their place in the air changes.
fn place_heating_coil(model: &mut Model, coil: &Coil, inlet: &str, outlet: &str) -> Result<()> {
    let (class, name) = coil;
    let of_heat_pump = class.eq_ignore_ascii_case(heat_pump::HEATING_COIL);
    if !of_heat_pump && !common::is_one_of(class, &HEATERS) {
        return Err(unsupported(class, name, "no setpoint control is known for this heating coil"));
    }
    let fields = model.require_mut(class, name)?;
    fields.insert("availability_schedule_name".into(), json!(common::ALWAYS_ON));
    fields.insert("air_inlet_node_name".into(), json!(inlet));
    fields.insert("air_outlet_node_name".into(), json!(outlet));
    if of_heat_pump {
        return Ok(());
    }
    // The unitary system controls the coil; a setpoint node of its own would be a second master.
    fields.remove("temperature_setpoint_node_name");
    Ok(())
}

/// One scheduled setpoint on every node from the cooling coil to the demand side, in place of all others.
fn follow_supply_temperature(model: &mut Model, unit: &Unit, nodes: &Nodes, schedule: &str) {
    let driven = [&nodes.cooling, &nodes.heating, &unit.outlet, &unit.demand_inlet];
    common::remove_setpoint_managers(model, &unit.old_nodes);
    let list = format!("{} Setpoint Nodes", unit.air_loop);
    let mut unique: Vec<&String> = driven.to_vec();
    unique.dedup();
    model.insert(
        "NodeList",
        &list,
        json!({"nodes": unique.iter().map(|n| json!({"node_name": n})).collect::<Vec<_>>()}),
    );
    model.insert(
        "SetpointManager:Scheduled",
        &format!("{} Supply Setpoint", unit.air_loop),
        json!({
            "control_variable": "Temperature",
            "schedule_name": schedule,
            "setpoint_node_or_nodelist_name": list,
        }),
    );
}

/// The terminal becomes one whose minimum flow is the command: with the zone's cooling setpoint out of reach
/// it never asks for more.
fn follow_flow(model: &mut Model, unit: &Unit, schedule: &str) -> Result<Terminal> {
    const VARIABLE: &str = TERMINALS[1];
    let ServedZone { unit: distribution, terminal: common::Reference { class, name }, .. } = &unit.served;
    if !common::is_one_of(class, &TERMINALS) {
        return Err(unsupported(class, name, "only terminals without reheat are known on a unitary system"));
    }
    let design_flow = common::size(model, class, name, "maximum_air_flow_rate")?;
    let fields = model.require_mut("ZoneHVAC:AirDistributionUnit", distribution)?;
    fields.insert("air_terminal_object_type".into(), json!(VARIABLE));
    let old = take(model, class, name)?;
    let outlet = required(&old, class, name, "air_outlet_node_name")?;
    model.insert(
        VARIABLE,
        name,
        json!({
            "availability_schedule_name": common::ALWAYS_ON,
            "air_inlet_node_name": required(&old, class, name, "air_inlet_node_name")?,
            "air_outlet_node_name": outlet,
            "maximum_air_flow_rate": design_flow,
            "zone_minimum_air_flow_input_method": "Scheduled",
            "minimum_air_flow_fraction_schedule_name": schedule,
        }),
    );
    Ok(Terminal { design_flow, outlet })
}

/// The node where the unit's air enters the demand side.
fn demand_inlet(model: &Model, air_loop: &str, fields: &Fields) -> Result<String> {
    let field = required(fields, "AirLoopHVAC", air_loop, "demand_side_inlet_node_names")?;
    match &common::nodes_of(model, &field)[..] {
        [node] => Ok(node.clone()),
        _ => Err(unsupported("AirLoopHVAC", air_loop, "it has two ducts to the demand side, known is one")),
    }
}

/// The one zone of an air loop.
fn only_zone(model: &Model, air_loop: &str) -> Result<ServedZone> {
    let served = served_zones(model, air_loop)?;
    let [zone] = <[ServedZone; 1]>::try_from(served).map_err(|served| {
        let zones: Vec<_> = served.iter().map(|s| s.zone.as_str()).collect();
        let why = format!("its unitary system serves several zones ({}), known is one", zones.join(", "));
        unsupported("AirLoopHVAC", air_loop, &why)
    })?;
    Ok(zone)
}

/// Takes an object out that must be there.
fn take(model: &mut Model, class: &str, name: &str) -> Result<Fields> {
    model
        .remove(class, name)
        .ok_or_else(|| Error::MissingObject { class: class.to_owned(), name: name.to_owned() })
}

fn required(fields: &Fields, class: &str, name: &str, field: &str) -> Result<String> {
    text(fields, field)
        .map(str::to_owned)
        .ok_or_else(|| unsupported(class, name, &format!("`{field}` is not given")))
}

#[cfg(test)]
mod tests;
