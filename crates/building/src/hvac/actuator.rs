//! Actuators: the entries of the action.

use serde::{Deserialize, Serialize};

/// Quantities that actuators control.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Air mass flow from a unitary system to its zones, kg/s.
    SupplyAirFlow,
    /// Air temperature at the outlet of a unitary system or of a central air handler, °C.
    SupplyAirTemperature,
    /// Outdoor air mass flow through the mixer of a central air loop, kg/s.
    OutdoorAirFlow,
    /// Opening of a zone's damper: the fraction of its terminal's design flow, 0 to 1.
    DamperOpening,
    /// Heating setpoint of a zone's thermostat, °C, which controls the reheat of a terminal, a unit heater, or all
    /// equipment of a zone that is controlled through its thermostat.
    HeatingSetpoint,
    /// Cooling setpoint of a zone's thermostat, °C.
    CoolingSetpoint,
}

impl Quantity {
    /// SI unit of the action value.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::SupplyAirFlow | Quantity::OutdoorAirFlow => "kg/s",
            Quantity::SupplyAirTemperature | Quantity::HeatingSetpoint | Quantity::CoolingSetpoint => "°C",
            Quantity::DamperOpening => "1",
        }
    }
}

/// An engine variable: its name and its key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EngineVariable {
    /// Variable name, for example `System Node Mass Flow Rate`.
    pub name: String,
    /// Key: a zone, a node, an object.
    pub key: String,
}

impl EngineVariable {
    /// The variable of a key.
    pub fn new(name: &str, key: &str) -> Self {
        Self { name: name.to_owned(), key: key.to_owned() }
    }
}

/// One entry of the action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// Unique name, for example `Core_ZN supply air flow`.
    pub name: String,
    /// The quantity it controls, which determines the unit.
    pub quantity: Quantity,
    /// Lower bound of the action value.
    pub low: f64,
    /// Upper bound of the action value.
    pub high: f64,
    /// Engine actuator: component type, for example `Schedule:Constant`.
    pub component: String,
    /// Engine actuator: control type, for example `Schedule Value`.
    pub control: String,
    /// Engine actuator: object name.
    pub key: String,
    /// Engine value per unit of the action value (1 / design flow if the engine takes a fraction).
    pub scale: f64,
    /// The engine variable of the controlled quantity, in the same unit; for a damper its air flow, kg/s.
    pub effect: EngineVariable,
    /// Value of `effect` per unit of the action value (1, or for a damper its design flow, kg/s).
    pub effect_scale: f64,
    /// The engine variable of the heating rate, W, under a heating setpoint, or of the cooling rate under a cooling
    /// setpoint; `None` for other quantities.
    pub heat: Option<EngineVariable>,
}

impl Actuator {
    /// An actuator that sets a `Schedule:Constant` in the unit of its quantity, between two bounds.
    pub fn of_schedule(
        schedule: String,
        name: String,
        quantity: Quantity,
        [low, high]: [f64; 2],
        effect: EngineVariable,
    ) -> Self {
        Self {
            name,
            quantity,
            low,
            high,
            component: "Schedule:Constant".into(),
            control: "Schedule Value".into(),
            key: schedule,
            scale: 1.0,
            effect,
            effect_scale: 1.0,
            heat: None,
        }
    }
}
