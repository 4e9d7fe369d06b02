//! The two sides of a comfort band.

/// Heating and cooling setpoint of a zone, °C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoints {
    /// Heating setpoint.
    pub heating: f64,
    /// Cooling setpoint; infinite for a zone without cooling.
    pub cooling: f64,
}

impl Setpoints {
    /// Returns the setpoint of a side.
    pub(super) fn of(self, side: Side) -> f64 {
        match side {
            Side::Heating => self.heating,
            Side::Cooling => self.cooling,
        }
    }
}

/// Heating or cooling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// Raises the temperature to the heating setpoint.
    Heating,
    /// Lowers the temperature to the cooling setpoint.
    Cooling,
}

impl Side {
    /// Both sides, in the order of arrays by side.
    pub(super) const BOTH: [Self; 2] = [Self::Heating, Self::Cooling];

    /// Returns how far a temperature is outside a setpoint, K; negative inside.
    pub(super) fn gap(self, temperature: f64, setpoint: f64) -> f64 {
        match self {
            Self::Heating => setpoint - temperature,
            Self::Cooling => temperature - setpoint,
        }
    }
}
