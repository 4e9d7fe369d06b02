//! What a measurement says.

use std::fmt;

use b2b_building::hvac::Quantity;
use serde::{Deserialize, Serialize};

/// What was measured on a building.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Report {
    /// Name of the building.
    pub building: String,
    /// One row an actuator, season, condition and level, in the order of the action.
    pub rows: Vec<Row>,
}

/// An actuator at one level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the actuator.
    pub actuator: String,
    /// What it drives.
    pub quantity: Quantity,
    /// Which day.
    pub season: Season,
    /// What the rest of its system did.
    pub condition: Condition,
    /// Where in its range.
    pub level: Level,
    /// Value given, in the unit of the quantity.
    pub command: f64,
    /// What came of it over the held steps, in the same unit; for a heating setpoint the zone's temperature, °C.
    pub lowest: f64,
    /// Mean of it.
    pub mean: f64,
    /// Highest.
    pub highest: f64,
    /// Greatest deviation: a share of the command for flows (of the highest command at zero), otherwise K.
    pub error: f64,
    /// What the error may be; infinite where heat is judged.
    pub tolerance: f64,
    /// Heat, W, where a heating setpoint is the command.
    pub heat: Option<f64>,
    /// The judgement.
    pub verdict: Verdict,
}

/// A day of the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Season {
    /// From Monday 16 January.
    Winter,
    /// From Monday 17 July.
    Summer,
}

/// A place in the range of an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// No flow.
    Zero,
    /// A fifth of the highest flow; otherwise the lowest value.
    Low,
    /// Three fifths of the highest flow; otherwise halfway.
    Middle,
    /// The highest value.
    High,
}

/// What the rest of the system does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// Supply air at a neutral temperature.
    NeutralSupply,
    /// Half of the design flow.
    MiddleFlow,
    /// All of the design flow.
    FullFlow,
    /// Every damper of the loop open.
    AllOpen,
    /// Supply air below room temperature.
    CoolSupply,
}

/// The judgement on a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Within the tolerance.
    Follows,
    /// Out of tolerance, with the equipment shown to be at its limit.
    AtCapacity(Limit),
    /// Out of tolerance.
    Fails,
}

/// A limit of the equipment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// A nearer command left the outlet where it was.
    Coil,
    /// The terminals take all that the fan gives.
    Fan,
    /// All of the supply air is outdoor air.
    SupplyFlow,
    /// Outdoor air makes up for exhaust fans.
    Exhaust,
    /// The zone is above the setpoint without heat.
    WarmZone,
}

/// Whether a quantity is a flow, which can be none.
pub(super) fn is_flow(quantity: Quantity) -> bool {
    !matches!(quantity, Quantity::SupplyAirTemperature | Quantity::HeatingSetpoint)
}

impl Report {
    /// The rows with a verdict of this kind.
    pub fn failures(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.verdict == Verdict::Fails)
    }
}

/// A table, one line a row.
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

/// The cells after the actuator's name.
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
        }
    }
}

/// The name of an enum's value as it is serialised, with spaces.
fn word(value: &impl Serialize) -> String {
    let name = serde_json::to_value(value).ok();
    name.as_ref().and_then(|n| n.as_str()).unwrap_or("?").replace('_', " ")
}
