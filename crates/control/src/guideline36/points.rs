//! Inputs of the sequences: the points of a zone and of the site at the beginning of a step.

pub use super::setpoints::Setpoints;
pub(super) use super::setpoints::Side;
use super::zone::demand::DemandLevel;

/// The next change of a zone's band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextBand {
    /// Time until the change, h.
    pub hours: f64,
    /// Heating setpoint after it, °C.
    pub heating: f64,
    /// Cooling setpoint after it, °C; infinite for a zone without cooling.
    pub cooling: f64,
}

impl NextBand {
    /// Returns the setpoints after the change.
    pub(super) fn setpoints(self) -> Setpoints {
        Setpoints { heating: self.heating, cooling: self.cooling }
    }
}

/// Points of a zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneInput {
    /// Air temperature, °C.
    pub temperature: f64,
    /// Scheduled heating setpoint, °C.
    pub heating: f64,
    /// Scheduled cooling setpoint, °C; infinite for a zone without cooling.
    pub cooling: f64,
    /// Whether people are present.
    pub people: bool,
    /// The next change of the setpoints, if the schedule has one.
    pub next: Option<NextBand>,
}

impl ZoneInput {
    /// Returns the scheduled setpoints.
    pub(super) fn band(&self) -> Setpoints {
        Setpoints { heating: self.heating, cooling: self.cooling }
    }
}

/// Points of the site.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SiteInput {
    /// Outdoor air temperature, °C.
    pub outdoor_temperature: f64,
    /// Level of demand limiting.
    pub demand: DemandLevel,
}
