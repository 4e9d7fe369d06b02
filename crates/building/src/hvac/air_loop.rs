//! Central air loops: supply temperature, outdoor air, dampers, reheat.
//!
//! [`make_controllable`] turns an air loop with variable-volume reheat terminals into one that does what an
//! agent says. What the shipped controls decide (supply temperature reset, economiser, minimum flows,
//! dampers under the thermostat) goes; the equipment and its capacities stay, but for the main heating coil.
//!
//! 1. The loop runs at every hour ([`common::always_on`]).
//! 2. The branch becomes outdoor air → fan → cooling coil → heating coil, so that the fan's heat is ahead of
//!    the coils that answer for the supply temperature.
//! 3. Both coils follow one scheduled supply temperature; outdoor air follows an actuator.
//! 4. Every terminal's damper stands where its schedule says, and its reheat coil holds the zone's heating
//!    setpoint; the cooling setpoint is out of reach, so that the thermostat never opens a damper.
//!
//! All dampers open ask for more than the fan gives (the boxes peak at different hours): then the flows of
//! all terminals scale down by the same share, to [`AirLoop::fan_flow`] in sum.
//!
//! **Leave the dampers alone until the first warm-up step is over.** What their schedules hold when the engine
//! begins a run (0 in the model) stays the least flow of the terminals for the whole run.

mod water_coil;

use std::collections::HashSet;

use serde_json::{Value, json};

use super::common::{self, OUT_OF_REACH, Reference, constant_schedule, is_one_of, items, size, unsupported};
use super::distribution::{ServedZone, served_zones};
use super::{Actuator, AirLoop, EngineVariable, Quantity, Terminal};
use crate::model::text;
use crate::{Model, Result};

/// Lowest supply temperature an agent may ask for, °C: what the cooling coils reach in summer.
pub const LOWEST_SUPPLY_TEMPERATURE: f64 = 10.0;
/// Highest supply temperature an agent may ask for, °C: what the heating coil reaches in winter.
pub const HIGHEST_SUPPLY_TEMPERATURE: f64 = 55.0;
/// Heating setpoint that no zone falls to, °C: reheat off.
pub const REHEAT_OFF: f64 = 10.0;
/// Highest heating setpoint an agent may give, °C.
pub const HIGHEST_HEATING_SETPOINT: f64 = 30.0;
/// Supply temperature before the first action, °C.
const NEUTRAL_SUPPLY_TEMPERATURE: f64 = 20.0;
/// By how much the main heating coil can warm the fan's design flow, K: room air to the highest supply
/// temperature with a quarter of outdoor air at -17 °C. The shipped coils (about 4 K) only temper outdoor air
/// and leave all heating to reheat: over 25 °C is out of their reach in winter.
const HEATING_COIL_RISE: f64 = 45.0;
/// Specific heat of air, J/(kg K).
const AIR_SPECIFIC_HEAT: f64 = 1006.0;

/// Schedule that is always 0.
const ALWAYS_OFF: &str = "B2B Always Off";
/// Air as warm as a reheat coil must make it for more air to bring more heat, K above the supply air.
const REHEAT_RISE: f64 = 15.0;
const SCHEDULE: [&str; 2] = ["Schedule:Constant", "Schedule Value"];
const TERMINAL: &str = "AirTerminal:SingleDuct:VAV:Reheat";
const OUTDOOR_AIR_SYSTEM: &str = "AirLoopHVAC:OutdoorAirSystem";
const DX_COOLING: &str = "CoilSystem:Cooling:DX";
const COOLING: [&str; 3] = [DX_COOLING, "Coil:Cooling:Water", "Coil:Cooling:Water:DetailedGeometry"];
const WATER_HEATING: &str = "Coil:Heating:Water";
const HEATING: [&str; 3] = ["Coil:Heating:Fuel", "Coil:Heating:Electric", WATER_HEATING];
/// Fans of variable flow, each with the field of its design flow.
const FANS: [(&str, &str); 2] =
    [("Fan:VariableVolume", "maximum_flow_rate"), ("Fan:SystemModel", "design_maximum_air_flow_rate")];

/// Makes a central air loop do what an agent says, and lists its actuators.
///
/// The model must carry its sizes (no `Autosize` in the fan and the terminals). `air_density` (kg/m³) is the
/// engine's standard density at the site, which turns design volume flows into mass flows.
///
/// # Errors
/// [`Error::Unsupported`] naming the object that these edits do not know; [`Error::MissingObject`] when the
/// model refers to something that is not there.
pub fn make_controllable(model: &mut Model, air_loop: &str, air_density: f64) -> Result<AirLoop> {
    let branch = MainBranch::find(model, air_loop)?;
    let terminals = find_terminals(model, air_loop)?;
    let controller = outdoor_air_controller(model, &branch.outdoor_air)?;
    let fan_flow = fan_flow(model, &branch.fan)? * air_density;

    common::always_on(model, air_loop)?;
    common::remove_setpoint_managers(model, &branch.nodes());
    blow_through(model, &branch)?;
    for (coil, ends) in branch.blow_through() {
        water_coil::follow_outlet(model, &coil, &ends.outlet)?;
    }
    let highest = heating_reach(model, &branch.heating, fan_flow)?;
    let supply_temperature = schedule_supply_temperature(model, air_loop, &branch, highest);
    let mixed = &branch.ends[0].1.outlet;
    if common::is_referred_to(model, mixed) {
        // Heat recovery ahead of the mixer aims at what the mixed air should be.
        follow_schedule(model, air_loop, "Mixed Air", mixed, &supply_temperature.key);
    }
    let zones: Vec<_> = terminals.iter().map(|(zone, _)| zone.clone()).collect();
    let exhaust_flow = exhaust_flow(model, &zones)? * air_density;
    let outdoor_air = match exhaust_flow > 0.0 {
        true => schedule_outdoor_air(model, air_loop, &controller, fan_flow, air_density)?,
        false => free_outdoor_air(model, air_loop, &controller, fan_flow)?,
    };
    let terminals = terminals
        .into_iter()
        .map(|(zone, terminal)| drive_terminal(model, zone, &terminal, air_density))
        .collect::<Result<_>>()?;
    let name = air_loop.to_owned();
    Ok(AirLoop { name, supply_temperature, outdoor_air, fan_flow, exhaust_flow, terminals })
}

/// The supply branch of an air loop: what is on it and the nodes between.
struct MainBranch {
    name: String,
    outdoor_air: Reference,
    cooling: Reference,
    heating: Reference,
    fan: Reference,
    /// The ends of each component, in the order of the branch.
    ends: Vec<(Reference, Ends)>,
}

/// Inlet and outlet node of a component.
#[derive(Clone, Debug, PartialEq)]
struct Ends {
    inlet: String,
    outlet: String,
}

impl MainBranch {
    /// Reads the branch, and refuses components that the edits do not know.
    fn find(model: &Model, air_loop: &str) -> Result<Self> {
        let name = common::only_branch(model, air_loop)?;
        let mut ends = Vec::new();
        for item in items(model.require("Branch", &name)?, "components") {
            let field = |field| text(item, field).unwrap_or_default().to_owned();
            let component =
                Reference { class: field("component_object_type"), name: field("component_name") };
            require_known(model, &component)?;
            let [inlet, outlet] = ["component_inlet_node_name", "component_outlet_node_name"].map(field);
            ends.push((component, Ends { inlet, outlet }));
        }
        let one = |classes: &[&str]| one_of(&ends, classes, &name);
        Ok(Self {
            outdoor_air: one(&[OUTDOOR_AIR_SYSTEM])?,
            cooling: one(&COOLING)?,
            heating: one(&HEATING)?,
            fan: one(&FANS.map(|(class, _)| class))?,
            ends,
            name,
        })
    }

    /// Every node of the branch.
    fn nodes(&self) -> HashSet<String> {
        self.ends
            .iter()
            .flat_map(|(_, ends)| [&ends.inlet, &ends.outlet])
            .map(|node| node.to_lowercase())
            .collect()
    }

    /// The node at the end of the branch, where the air leaves the air handler.
    fn outlet(&self) -> &str {
        self.ends.last().map_or("", |(_, ends)| &ends.outlet)
    }

    /// The node between the cooling and the heating coil of the rewired branch.
    fn cooling_outlet(&self) -> String {
        outlet_node(&self.cooling)
    }

    /// The components in blow-through order with their nodes there.
    fn blow_through(&self) -> Vec<(Reference, Ends)> {
        let order = [&self.outdoor_air, &self.fan, &self.cooling, &self.heating];
        let mut inlet = self.ends[0].1.inlet.clone();
        let mut placed: Vec<(Reference, Ends)> = Vec::new();
        for component in order {
            let outlet = match component {
                c if c == &self.outdoor_air => self.ends[0].1.outlet.clone(),
                c if c == &self.heating => self.outlet().to_owned(),
                c => outlet_node(c),
            };
            placed.push((component.clone(), Ends { inlet, outlet: outlet.clone() }));
            inlet = outlet;
        }
        placed
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
        return Err(unsupported(class, name, "no way to drive it in a central air handler is known"));
    }
    let coil = text(fields, "cooling_coil_object_type");
    if coil.is_some_and(|class| !class.eq_ignore_ascii_case("Coil:Cooling:DX:TwoSpeed")) {
        return Err(unsupported(class, name, "its coil must be a Coil:Cooling:DX:TwoSpeed"));
    }
    Ok(())
}

fn one_of(ends: &[(Reference, Ends)], classes: &[&str], branch: &str) -> Result<Reference> {
    let mut found = ends.iter().map(|(component, _)| component).filter(|c| is_one_of(&c.class, classes));
    match (found.next(), found.next()) {
        (Some(component), None) => Ok(component.clone()),
        _ => Err(unsupported("Branch", branch, &format!("it must have one {}", classes.join(" or ")))),
    }
}

/// Puts the fan ahead of the coils. Behind them its heat would be taken off the coils' setpoints by an
/// estimate that lags whenever the flow jumps.
fn blow_through(model: &mut Model, branch: &MainBranch) -> Result<()> {
    let placed = branch.blow_through();
    for (component, ends) in &placed {
        if let Some((_, before)) = branch.ends.iter().find(|(c, _)| c == component) {
            move_component(model, component, before, ends)?;
        }
    }
    let components: Vec<Value> =
        placed.iter().map(|(component, ends)| branch_item(component, ends)).collect();
    model.require_mut("Branch", &branch.name)?.insert("components".into(), components.into());
    Ok(())
}

fn branch_item(component: &Reference, ends: &Ends) -> Value {
    json!({
        "component_object_type": component.class,
        "component_name": component.name,
        "component_inlet_node_name": ends.inlet,
        "component_outlet_node_name": ends.outlet,
    })
}

/// Gives a component, and the coil in it, other nodes; a setpoint or sensor node at its outlet moves with it.
fn move_component(model: &mut Model, component: &Reference, from: &Ends, to: &Ends) -> Result<()> {
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
    for part in common::parts(fields) {
        move_component(model, &part, from, to)?;
    }
    Ok(())
}

/// The highest supply temperature an agent may ask for, °C. A coil that burns gas or runs on electricity is made to
/// warm the fan's design flow (kg/s) by [`HEATING_COIL_RISE`]. A water coil stays as it is, because its plant is sized
/// for it: it reaches what it adds to [`NEUTRAL_SUPPLY_TEMPERATURE`].
fn heating_reach(model: &mut Model, coil: &Reference, fan_flow: f64) -> Result<f64> {
    if coil.class.eq_ignore_ascii_case(WATER_HEATING) {
        let rise = water_coil::capacity(model, coil)? / (AIR_SPECIFIC_HEAT * fan_flow);
        return Ok((NEUTRAL_SUPPLY_TEMPERATURE + rise).min(HIGHEST_SUPPLY_TEMPERATURE));
    }
    let enough = HEATING_COIL_RISE * AIR_SPECIFIC_HEAT * fan_flow;
    let shipped = size(model, &coil.class, &coil.name, "nominal_capacity")?;
    let fields = model.require_mut(&coil.class, &coil.name)?;
    fields.insert("nominal_capacity".into(), shipped.max(enough).into());
    Ok(HIGHEST_SUPPLY_TEMPERATURE)
}

/// One scheduled temperature for both coils: behind the cooling coil and behind the heating coil.
fn schedule_supply_temperature(
    model: &mut Model,
    air_loop: &str,
    branch: &MainBranch,
    highest: f64,
) -> Actuator {
    let name = format!("{air_loop} Supply Air Temperature");
    constant_schedule(model, &name, NEUTRAL_SUPPLY_TEMPERATURE);
    follow_schedule(model, air_loop, "Cooling", &branch.cooling_outlet(), &name);
    follow_schedule(model, air_loop, "Heating", branch.outlet(), &name);
    Actuator {
        quantity: Quantity::SupplyAirTemperature,
        low: LOWEST_SUPPLY_TEMPERATURE,
        high: highest,
        effect: EngineVariable::new("System Node Temperature", branch.outlet()),
        ..scheduled(name, format!("{air_loop} supply air temperature"))
    }
}

fn follow_schedule(model: &mut Model, air_loop: &str, place: &str, node: &str, schedule: &str) {
    let fields = json!({
        "control_variable": "Temperature",
        "schedule_name": schedule,
        "setpoint_node_or_nodelist_name": node,
    });
    model.insert("SetpointManager:Scheduled", &format!("{air_loop} {place} Setpoint"), fields);
}

/// Leaves outdoor air to its actuator: no economiser beside it. The controller's ventilation requirement
/// stays, as what is asked for when nothing is commanded, and to be read.
fn free_outdoor_air(model: &mut Model, air_loop: &str, controller: &str, fan_flow: f64) -> Result<Actuator> {
    let fields = model.require_mut("Controller:OutdoorAir", controller)?;
    fields.insert("economizer_control_type".into(), "NoEconomizer".into());
    fields.insert("lockout_type".into(), "NoLockout".into());
    let node = text(fields, "actuator_node_name").unwrap_or_default().to_owned();
    Ok(Actuator {
        name: format!("{air_loop} outdoor air flow"),
        quantity: Quantity::OutdoorAirFlow,
        low: 0.0,
        high: fan_flow,
        component: "Outdoor Air Controller".into(),
        control: "Air Mass Flow Rate".into(),
        key: controller.to_owned(),
        scale: 1.0,
        effect: EngineVariable::new("System Node Mass Flow Rate", &node),
        effect_scale: 1.0,
        heat: None,
    })
}

/// As [`free_outdoor_air`], by a schedule of the least outdoor air. Exhaust fans take air from the zones of the loop, and
/// the engine brings in at least as much, but not against an actuator: that would let the missing air appear from
/// nowhere.
fn schedule_outdoor_air(
    model: &mut Model,
    air_loop: &str,
    controller: &str,
    fan_flow: f64,
    air_density: f64,
) -> Result<Actuator> {
    let schedule = format!("{air_loop} Outdoor Air Share");
    constant_schedule(model, &schedule, 0.0);
    let free = free_outdoor_air(model, air_loop, controller, fan_flow)?;
    let fields = model.require_mut("Controller:OutdoorAir", controller)?;
    fields.retain(|field, _| {
        !field.contains("fraction_of_outdoor_air")
            && !field.contains("time_of_day")
            && !field.contains("humid")
    });
    let ventilation = text(fields, "mechanical_ventilation_controller_name").map(str::to_owned);
    for limit in ["minimum_outdoor_air_flow_rate", "maximum_outdoor_air_flow_rate"] {
        fields.insert(limit.into(), (fan_flow / air_density).into());
    }
    fields.insert("minimum_limit_type".into(), "FixedMinimum".into());
    fields.insert("minimum_outdoor_air_schedule_name".into(), schedule.clone().into());
    if let Some(name) = ventilation {
        // It stays, to be read, and asks for nothing.
        constant_schedule(model, ALWAYS_OFF, 0.0);
        let ventilation = model.require_mut("Controller:MechanicalVentilation", &name)?;
        ventilation.insert("availability_schedule_name".into(), ALWAYS_OFF.into());
    }
    let [component, control] = SCHEDULE.map(str::to_owned);
    Ok(Actuator { component, control, key: schedule, scale: 1.0 / fan_flow, ..free })
}

/// Design flow of the exhaust fans in some zones, m³/s.
fn exhaust_flow(model: &Model, zones: &[String]) -> Result<f64> {
    const FAN: &str = "Fan:ZoneExhaust";
    let mut flow = 0.0;
    for zone in zones {
        for fan in common::zone_equipment(model, zone)?.iter().filter(|e| is_one_of(&e.class, &[FAN])) {
            flow += size(model, FAN, &fan.name, "maximum_flow_rate")?;
        }
    }
    Ok(flow)
}

/// Puts a terminal's damper on a schedule, and its reheat coil on the zone's own heating setpoint.
fn drive_terminal(model: &mut Model, zone: String, terminal: &str, air_density: f64) -> Result<Terminal> {
    common::switch_on(model, &Reference { class: TERMINAL.into(), name: terminal.into() })?;
    let design_flow = size(model, TERMINAL, terminal, "maximum_air_flow_rate")? * air_density;
    let opening = schedule_damper(model, &zone, terminal)?;
    let setpoints = common::own_thermostat(model, &zone, REHEAT_OFF, OUT_OF_REACH)?;
    let fields = model.require(TERMINAL, terminal)?;
    let inlet = text(fields, "air_inlet_node_name").unwrap_or_default();
    let coil = text(fields, "reheat_coil_name").unwrap_or_default();
    let class = text(fields, "reheat_coil_object_type").unwrap_or_default();
    let heating_opening = match class.eq_ignore_ascii_case(WATER_HEATING) {
        true => {
            let coil = Reference { class: class.to_owned(), name: coil.to_owned() };
            let flow = water_coil::capacity(model, &coil)? / (AIR_SPECIFIC_HEAT * REHEAT_RISE);
            (flow / design_flow).clamp(0.0, 1.0)
        }
        false => 1.0,
    };
    let damper = Actuator {
        quantity: Quantity::DamperOpening,
        low: 0.0,
        high: 1.0,
        effect: EngineVariable::new("System Node Mass Flow Rate", inlet),
        effect_scale: design_flow,
        ..scheduled(opening, format!("{zone} damper opening"))
    };
    let reheat = Actuator {
        quantity: Quantity::HeatingSetpoint,
        low: REHEAT_OFF,
        high: HIGHEST_HEATING_SETPOINT,
        effect: EngineVariable::new("Zone Thermostat Heating Setpoint Temperature", &zone),
        heat: Some(EngineVariable::new("Heating Coil Heating Rate", coil)),
        ..scheduled(setpoints.heating, format!("{zone} heating setpoint"))
    };
    Ok(Terminal { zone, damper, reheat, design_flow, heating_opening })
}

/// Makes the scheduled opening the terminal's minimum flow. With the cooling setpoint out of reach and the
/// damper not reversed for heating, a terminal never leaves its minimum. The schedule is 0 because its value at
/// the begin of a run is a floor for the whole run.
fn schedule_damper(model: &mut Model, zone: &str, terminal: &str) -> Result<String> {
    let name = format!("{zone} Damper Opening");
    constant_schedule(model, &name, 0.0);
    let fields = model.require_mut(TERMINAL, terminal)?;
    fields.retain(|field, _| {
        !field.contains("minimum_air_flow")
            && !field.starts_with("maximum_flow_")
            && !field.contains("turndown")
    });
    fields.insert("zone_minimum_air_flow_input_method".into(), "Scheduled".into());
    fields.insert("minimum_air_flow_fraction_schedule_name".into(), name.clone().into());
    fields.insert("damper_heating_action".into(), "Normal".into());
    Ok(name)
}

/// An actuator of a `Schedule:Constant`, to be completed.
fn scheduled(schedule: String, name: String) -> Actuator {
    let [component, control] = SCHEDULE.map(str::to_owned);
    Actuator {
        name,
        quantity: Quantity::SupplyAirTemperature,
        low: 0.0,
        high: 0.0,
        component,
        control,
        key: schedule,
        scale: 1.0,
        effect: EngineVariable::new("", ""),
        effect_scale: 1.0,
        heat: None,
    }
}

/// The outdoor air controller among the controllers of an outdoor air system.
fn outdoor_air_controller(model: &Model, system: &Reference) -> Result<String> {
    let list = text(model.require(&system.class, &system.name)?, "controller_list_name").unwrap_or_default();
    let controllers = model.require("AirLoopHVAC:ControllerList", list)?;
    (1..=8)
        .filter(|i| {
            text(controllers, &format!("controller_{i}_object_type"))
                .is_some_and(|class| class.eq_ignore_ascii_case("Controller:OutdoorAir"))
        })
        .find_map(|i| text(controllers, &format!("controller_{i}_name")))
        .map(str::to_owned)
        .ok_or_else(|| unsupported(&system.class, &system.name, "it has no Controller:OutdoorAir"))
}

/// The terminals of an air loop, each with its zone, in model order of the zones.
fn find_terminals(model: &Model, air_loop: &str) -> Result<Vec<(String, String)>> {
    let mut terminals = Vec::new();
    for ServedZone { zone, terminal, .. } in served_zones(model, air_loop)? {
        if !terminal.class.eq_ignore_ascii_case(TERMINAL) {
            let why = format!("a terminal must be an {TERMINAL}");
            return Err(unsupported(&terminal.class, &terminal.name, &why));
        }
        require_reheat(model, &terminal.name)?;
        terminals.push((zone, terminal.name));
    }
    Ok(terminals)
}

fn require_reheat(model: &Model, terminal: &str) -> Result<()> {
    let coil = text(model.require(TERMINAL, terminal)?, "reheat_coil_object_type").unwrap_or_default();
    if is_one_of(coil, &HEATING) {
        return Ok(());
    }
    Err(unsupported(TERMINAL, terminal, &format!("its reheat coil must be a {}", HEATING.join(" or a "))))
}

/// Design flow of a fan, m³/s.
fn fan_flow(model: &Model, fan: &Reference) -> Result<f64> {
    let field = FANS.iter().find(|(class, _)| class.eq_ignore_ascii_case(&fan.class)).map(|(_, field)| field);
    let field = field.ok_or_else(|| unsupported(&fan.class, &fan.name, "it is no fan of variable flow"))?;
    size(model, &fan.class, &fan.name, field)
}

#[cfg(test)]
mod tests;
