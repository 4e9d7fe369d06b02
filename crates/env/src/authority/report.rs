//! The report of a response check.

use std::fmt;

use b2b_building::hvac::Quantity;
use serde::{Deserialize, Deserializer, Serialize};

/// Response of all actuators of a building.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Report {
    /// Name of the building.
    pub building: String,
    /// One row per actuator, season, condition and level, in the order of the action.
    pub rows: Vec<Row>,
}

/// Response of an actuator at one level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the actuator.
    pub actuator: String,
    /// Controlled quantity.
    pub quantity: Quantity,
    /// Season.
    pub season: Season,
    /// State of the rest of the system.
    pub condition: Condition,
    /// Level in the range of the actuator.
    pub level: Level,
    /// Command, in the unit of the quantity.
    pub command: f64,
    /// Lowest response over the held steps, in the same unit; for a setpoint the zone temperature, °C. NaN if the
    /// engine ended the run, for which JSON has null.
    #[serde(deserialize_with = "or_nan")]
    pub lowest: f64,
    /// Mean response; for a setpoint the response at the end of the hold.
    #[serde(deserialize_with = "or_nan")]
    pub mean: f64,
    /// Highest response.
    #[serde(deserialize_with = "or_nan")]
    pub highest: f64,
    /// Largest deviation from the command, for a setpoint the last: relative for flows (to the highest command at
    /// zero), otherwise K.
    #[serde(deserialize_with = "or_nan")]
    pub error: f64,
    /// Tolerance of the error; infinite for setpoints, which are evaluated by their effect on the zone. JSON has null
    /// for it.
    #[serde(deserialize_with = "or_infinite")]
    pub tolerance: f64,
    /// Heat delivered or removed, W; setpoints only. For a setpoint of a thermostat, its mean over the hold.
    pub heat: Option<f64>,
    /// Verdict.
    pub verdict: Verdict,
    /// The error of the engine that ended the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
}

/// Season of the check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Season {
    /// Winter of the site: from January 16, south of the equator from July 17.
    Winter,
    /// Summer of the site: from July 17, south of the equator from January 16.
    Summer,
}

/// A level in the range of an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// No flow.
    Zero,
    /// 20 % of the highest flow; otherwise the lowest value.
    Low,
    /// 60 % of the highest flow; otherwise the middle of the range.
    Middle,
    /// The highest value.
    High,
}

/// State of the rest of the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// Supply air at a neutral temperature.
    NeutralSupply,
    /// Half of the design flow.
    MiddleFlow,
    /// The design flow.
    FullFlow,
    /// Every damper of the loop open.
    AllOpen,
    /// Supply air below room temperature.
    CoolSupply,
    /// No other setpoint calls for heating or cooling.
    Free,
}

/// Verdict on a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Within the tolerance.
    Follows,
    /// Out of tolerance with the equipment at its limit.
    AtCapacity(Limit),
    /// Out of tolerance.
    Fails,
}

/// A limit of the equipment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// Coil at capacity: a nearer command did not change the outlet.
    Coil,
    /// Fan at its design flow.
    Fan,
    /// All of the supply air is outdoor air.
    SupplyFlow,
    /// Outdoor air makes up for exhaust fans.
    Exhaust,
    /// Heater runs, and the zone stays below the setpoint.
    Heater,
    /// Zone above the setpoint without heat.
    WarmZone,
    /// Cooling runs, and the zone stays above the setpoint.
    Cooler,
    /// Zone below the cooling setpoint without cooling.
    CoolZone,
    /// Nothing happens, and a schedule of the model switches equipment off for at least 90 % of the month.
    SwitchedOff,
}

/// Returns whether a quantity is a flow, which can be zero.
pub(super) fn is_flow(quantity: Quantity) -> bool {
    !matches!(
        quantity,
        Quantity::SupplyAirTemperature | Quantity::HeatingSetpoint | Quantity::CoolingSetpoint
    )
}

impl Report {
    /// Rows that fail.
    pub fn failures(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.verdict == Verdict::Fails)
    }
}

/// Reads a number, or infinity from null.
fn or_infinite<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
}

/// Reads a number, or NaN from null.
fn or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// A table with one line per row.
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|row| row.actuator.chars().count()).max().unwrap_or(8);
        writeln!(
            f,
            "{:width$} season with         level   command   lowest     mean  highest    error    limit heat/W  verdict",
            "actuator",
        )?;
        for row in &self.rows {
            writeln!(f, "{:width$} {row}", row.actuator)?;
        }
        let count = |wanted: fn(&Verdict) -> bool| self.rows.iter().filter(|r| wanted(&r.verdict)).count();
        write!(
            f,
            "{}: {} follow, {} at capacity, {} fail",
            self.building,
            count(|v| *v == Verdict::Follows),
            count(|v| matches!(v, Verdict::AtCapacity(_))),
            count(|v| *v == Verdict::Fails),
        )
    }
}

/// The columns after the name of the actuator.
impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:6} {:12} {:6} ", word(&self.season), word(&self.condition), word(&self.level))?;
        for value in [self.command, self.lowest, self.mean, self.highest] {
            write!(f, "{value:8.3} ")?;
        }
        match is_flow(self.quantity) {
            true => write!(f, "{:7.2}% {:7.0}% ", 100.0 * self.error, 100.0 * self.tolerance)?,
            false if self.tolerance.is_finite() => {
                write!(f, "{:6.2} K {:6.1} K ", self.error, self.tolerance)?
            }
            false => write!(f, "{:6.2} K {:>8} ", self.error, "-")?,
        }
        match self.heat {
            Some(heat) => write!(f, "{heat:6.0} ")?,
            None => write!(f, "{:>6} ", "-")?,
        }
        match self.verdict {
            Verdict::Follows => f.write_str(" follows"),
            Verdict::AtCapacity(limit) => write!(f, " at capacity: {}", word(&limit)),
            Verdict::Fails => f.write_str(" FAILS"),
        }?;
        match &self.message {
            Some(message) => write!(f, ": {}", message.split_whitespace().collect::<Vec<_>>().join(" ")),
            None => Ok(()),
        }
    }
}

/// Returns the serialized name of an enum variant, with spaces.
fn word(value: &impl Serialize) -> String {
    let name = serde_json::to_value(value).ok();
    name.as_ref().and_then(|n| n.as_str()).unwrap_or("?").replace('_', " ")
}
