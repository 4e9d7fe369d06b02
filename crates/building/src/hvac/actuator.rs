//! The entries of the action.

use serde::{Deserialize, Serialize};

/// What an actuator drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Air mass flow from a unitary system to its zone, kg/s.
    SupplyAirFlow,
    /// Air temperature at the outlet of a unitary system or of a central air handler, °C.
    SupplyAirTemperature,
    /// Outdoor air mass flow through the mixer of a central air loop, kg/s.
    OutdoorAirFlow,
    /// Opening of a zone's damper: the share of its terminal's design flow, 0 to 1.
    DamperOpening,
    /// Heating setpoint of a zone's thermostat, °C: reheat of a terminal, a unit heater.
    HeatingSetpoint,
}

impl Quantity {
    /// SI unit of the value an agent gives.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::SupplyAirFlow | Quantity::OutdoorAirFlow => "kg/s",
            Quantity::SupplyAirTemperature | Quantity::HeatingSetpoint => "°C",
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
    /// A variable of a key.
    pub fn new(name: &str, key: &str) -> Self {
        Self { name: name.to_owned(), key: key.to_owned() }
    }
}

/// One entry of the action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// Unique name for people, for example `Core_ZN supply air flow`.
    pub name: String,
    /// What it drives; gives the unit.
    pub quantity: Quantity,
    /// Lowest value an agent may give.
    pub low: f64,
    /// Highest value an agent may give.
    pub high: f64,
    /// Engine actuator: component type, for example `Schedule:Constant`.
    pub component: String,
    /// Engine actuator: control type, for example `Schedule Value`.
    pub control: String,
    /// Engine actuator: object name.
    pub key: String,
    /// Engine value per unit of the agent's value (1 / design flow where the engine takes a fraction).
    pub scale: f64,
    /// The engine variable that shows the driven quantity, in the same unit; for a damper its air flow, kg/s.
    pub effect: EngineVariable,
    /// Value of `effect` per unit of the agent's value (1, or for a damper its design flow, kg/s).
    pub effect_scale: f64,
    /// The engine variable that shows the heat, W, that a heating setpoint calls for. `None` for other quantities.
    pub heat: Option<EngineVariable>,
}

impl Actuator {
    /// An actuator that sets a `Schedule:Constant` in the unit of its quantity, between two bounds.
    pub(super) fn of_schedule(
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
