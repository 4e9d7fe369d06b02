//! The controllable form of a unit.

use serde_json::{Value, json};

use super::unit::{HEATERS, Nodes, UNITARY_SYSTEM, Unit, coil};
use super::{cooling_coil, heat_pump};
use crate::hvac::air_loop_graph::{Component, components, set_components};
use crate::hvac::references::{Reference, is_one_of};
use crate::hvac::schedules::ALWAYS_ON;
use crate::model::{Fields, Model, number, text};
use crate::{Error, Result};

/// Coils whose water the unit itself controls.
const WATER_COOLING: [&str; 2] = ["Coil:Cooling:Water", "Coil:Cooling:Water:DetailedGeometry"];
const WATER_HEATING: &str = "Coil:Heating:Water";
const TWO_SPEED: &str = "Coil:Cooling:DX:TwoSpeed";
/// The engine's limit on supply air temperature, °C: above the bounds of the action, so that it never binds.
const MAXIMUM_SUPPLY_TEMPERATURE: f64 = 80.0;
/// Outdoor temperature below which the compressor does not cool, °C. It is never reached: an overheated zone can be
/// cooled in any weather, and a lockout would disable the actuator silently.
const COOLING_LOCKOUT: f64 = -60.0;
/// Fan efficiencies where the model has none: the engine's defaults.
const FAN_EFFICIENCY: f64 = 0.7;
const MOTOR_EFFICIENCY: f64 = 0.9;
/// Part-load power of a variable-speed fan, by powers of the flow fraction (ASHRAE 90.1 appendix G, table
/// G3.1.3.15, method 2, without its minimum).
const FAN_POWER: [f64; 5] = [0.0013, 0.1470, 0.9506, -0.0998, 0.0];

impl Unit {
    /// Replaces the unit with its controllable form and returns the nodes inside it.
    pub(super) fn rewrite(&self, model: &mut Model) -> Result<Nodes> {
        let old = model.take(&self.component.object.class, &self.component.object.name)?;
        if coil(&old, "reheat_coil").is_some() {
            let why =
                "it dehumidifies with a reheat coil, which would oppose the commanded supply temperature";
            return Err(self.unsupported(why));
        }
        remove_multispeed_design(model, &old);
        let supplemental = coil(&old, "supplemental_heating_coil");
        let nodes = self.inner_nodes(supplemental.is_some());
        let (fan, flow) = self.rewrite_fan(model, &old, &nodes)?;
        let cooling = self.rewrite_cooling_coil(model, &old, &nodes)?;
        let heating = coil(&old, "heating_coil").ok_or_else(|| self.unsupported("it has no heating coil"))?;
        match heating.class.eq_ignore_ascii_case(WATER_HEATING) {
            true => place(model, &heating, &nodes.cooling, &nodes.heating)?,
            false => place_heating_coil(model, &heating, &nodes.cooling, &nodes.heating)?,
        }
        if let Some(supplemental) = &supplemental {
            place_heating_coil(model, supplemental, &nodes.heating, self.outlet())?;
        }
        let mut unit = self.controllable_form(&fan, flow, &cooling);
        let mut behind = Vec::new();
        if self.heats_apart(&heating) {
            behind = heat_pump::move_coils_out(model, self, &nodes, &heating, supplemental.as_ref())?;
        } else {
            put_heating_coils(&mut unit, &old, &heating, supplemental.as_ref());
        }
        let outlet = if behind.is_empty() { self.outlet() } else { &nodes.cooling };
        unit["air_outlet_node_name"] = json!(outlet);
        let name = &self.component.object.name;
        model.insert(UNITARY_SYSTEM, name, unit);
        behind.insert(0, Component::new(UNITARY_SYSTEM, name, self.inlet(), outlet));
        self.replace_on_branch(model, behind)?;
        Ok(nodes)
    }

    fn inner_nodes(&self, supplemental: bool) -> Nodes {
        Nodes {
            fan: format!("{} Fan Outlet", self.air_loop),
            cooling: format!("{} Cooling Coil Outlet", self.air_loop),
            heating: match supplemental {
                true => format!("{} Heating Coil Outlet", self.air_loop),
                false => self.outlet().to_owned(),
            },
        }
    }

    /// The unit under setpoint control, without its heating coils and its outlet.
    fn controllable_form(&self, fan: &str, flow: f64, cooling: &Reference) -> Value {
        let mut unit = json!({
            "control_type": "SetPoint",
            "controlling_zone_or_thermostat_location": self.served.zone,
            "dehumidification_control_type": "None",
            "availability_schedule_name": ALWAYS_ON,
            "air_inlet_node_name": self.inlet(),
            "supply_fan_object_type": "Fan:VariableVolume",
            "supply_fan_name": fan,
            "fan_placement": "BlowThrough",
            "supply_air_fan_operating_mode_schedule_name": ALWAYS_ON,
            "cooling_coil_object_type": cooling.class,
            "cooling_coil_name": cooling.name,
            "minimum_supply_air_temperature": 2.0,
            "latent_load_control": "SensibleOnlyLoadControl",
            "maximum_supply_air_temperature": MAXIMUM_SUPPLY_TEMPERATURE,
        });
        for regime in ["cooling", "heating", "no_load"] {
            unit[format!("{regime}_supply_air_flow_rate_method")] = json!("SupplyAirFlowRate");
            unit[format!("{regime}_supply_air_flow_rate")] = json!(flow);
        }
        unit
    }

    /// Replaces the unit on its branch by other components.
    fn replace_on_branch(&self, model: &mut Model, new: Vec<Component>) -> Result<()> {
        let mut on_branch = components(model, &self.branch)?;
        let is_unit = |c: &Component| c.object.name.eq_ignore_ascii_case(&self.component.object.name);
        if let Some(at) = on_branch.iter().position(is_unit) {
            on_branch.splice(at..=at, new);
        }
        set_components(model, &self.branch, &on_branch)
    }

    /// Returns whether the heating coils are moved out of the unit, as a heat pump's are unless it has an economizer.
    /// An economizer aims at a temperature upstream of the fan, and the engine would iterate the air side a dozen
    /// times.
    fn heats_apart(&self, heating: &Reference) -> bool {
        let economizes = self.outdoor_air.as_ref().is_some_and(|air| air.has_economizer);
        heating.class.eq_ignore_ascii_case(heat_pump::HEATING_COIL) && !economizes
    }

    /// Replaces the fan with a variable-volume fan that has its pressure and efficiencies and no minimum flow. Returns
    /// its name and its design flow, m³/s.
    fn rewrite_fan(&self, model: &mut Model, unit: &Fields, nodes: &Nodes) -> Result<(String, f64)> {
        let class = text(unit, "supply_fan_object_type").or(text(unit, "supply_air_fan_object_type"));
        let name = text(unit, "supply_fan_name").or(text(unit, "supply_air_fan_name"));
        let (Some(class), Some(name)) = (class, name) else {
            return Err(self.unsupported("it has no supply fan"));
        };
        let fan = model.take(class, name)?;
        let given = |fields: &[&str]| fields.iter().find_map(|f| number(&fan, f));
        let read = |fields: &[&str]| {
            given(fields).ok_or_else(|| {
                Error::unsupported(
                    class,
                    name,
                    &format!("`{}` is not a number (is the model sized?)", fields[0]),
                )
            })
        };
        let flow = read(&["design_maximum_air_flow_rate", "maximum_flow_rate"])?;
        let [c1, c2, c3, c4, c5] = FAN_POWER;
        model.insert(
            "Fan:VariableVolume",
            name,
            json!({
                "availability_schedule_name": ALWAYS_ON,
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
                "air_inlet_node_name": self.inlet(),
                "air_outlet_node_name": nodes.fan,
            }),
        );
        Ok((name.to_owned(), flow))
    }

    /// Moves a water cooling coil to its nodes, or replaces a DX coil with a two-speed coil of the same performance.
    fn rewrite_cooling_coil(&self, model: &mut Model, unit: &Fields, nodes: &Nodes) -> Result<Reference> {
        let cooling = coil(unit, "cooling_coil").ok_or_else(|| self.unsupported("it has no cooling coil"))?;
        if is_one_of(&cooling.class, &WATER_COOLING) {
            place(model, &cooling, &nodes.fan, &nodes.cooling)?;
            return Ok(cooling);
        }
        let Reference { class, name } = cooling;
        let old = model.take(&class, &name)?;
        let mut new = cooling_coil::two_speed_equivalent(&class, old).ok_or_else(|| {
            Error::unsupported(&class, &name, "unsupported cooling coil: it has no two-speed equivalent")
        })?;
        new["availability_schedule_name"] = json!(ALWAYS_ON);
        new["air_inlet_node_name"] = json!(nodes.fan);
        new["air_outlet_node_name"] = json!(nodes.cooling);
        new["condenser_type"] = json!("AirCooled");
        new["minimum_outdoor_dry_bulb_temperature_for_compressor_operation"] = json!(COOLING_LOCKOUT);
        model.insert(TWO_SPEED, &name, new);
        Ok(Reference { class: TWO_SPEED.to_owned(), name })
    }
}

/// Sets the heating coils of a unit.
fn put_heating_coils(unit: &mut Value, old: &Fields, heating: &Reference, supplemental: Option<&Reference>) {
    unit["heating_coil_object_type"] = json!(heating.class);
    unit["heating_coil_name"] = json!(heating.name);
    unit["dx_heating_coil_sizing_ratio"] = json!(1.0);
    if let Some(Reference { class, name }) = supplemental {
        unit["supplemental_heating_coil_object_type"] = json!(class);
        unit["supplemental_heating_coil_name"] = json!(name);
        let limit = "maximum_outdoor_dry_bulb_temperature_for_supplemental_heater_operation";
        unit[limit] = old.get(limit).cloned().unwrap_or(json!(21.0));
    }
}

fn remove_multispeed_design(model: &mut Model, unit: &Fields) {
    let design = |field: &str| text(unit, &format!("design_specification_multispeed_object_{field}"));
    if let (Some(class), Some(name)) = (design("type"), design("name")) {
        model.remove(class, name);
    }
}

/// Moves a heating coil that can follow a setpoint to other nodes.
fn place_heating_coil(model: &mut Model, coil: &Reference, inlet: &str, outlet: &str) -> Result<()> {
    let Reference { class, name } = coil;
    let of_heat_pump = class.eq_ignore_ascii_case(heat_pump::HEATING_COIL);
    if !of_heat_pump && !is_one_of(class, &HEATERS) {
        return Err(Error::unsupported(class, name, "unsupported heating coil: it cannot follow a setpoint"));
    }
    place(model, coil, inlet, outlet)?;
    if !of_heat_pump {
        // The unitary system controls the coil; a setpoint node of its own would conflict.
        model.require_mut(class, name)?.remove("temperature_setpoint_node_name");
    }
    Ok(())
}

/// Moves a coil to other nodes, and makes it always available.
fn place(model: &mut Model, coil: &Reference, inlet: &str, outlet: &str) -> Result<()> {
    let fields = model.require_mut(&coil.class, &coil.name)?;
    fields.insert("availability_schedule_name".into(), json!(ALWAYS_ON));
    fields.insert("air_inlet_node_name".into(), json!(inlet));
    fields.insert("air_outlet_node_name".into(), json!(outlet));
    Ok(())
}
