//! Drivers: inputs that can be forecast and on which the effect of a point depends.

use crate::guideline36::Shift;

/// Outdoor temperatures at which an hour is fully cold and fully mild, °C.
const COLD_TO_MILD: [f64; 2] = [-4.0, 6.0];
/// Outdoor temperatures at which an hour is fully mild and fully warm, °C.
const MILD_TO_WARM: [f64; 2] = [12.0, 20.0];
/// Outdoor temperature below which it is cold, °C, and the difference that counts as 1, K.
pub(super) const COLD: [f64; 2] = [18.0, 20.0];
/// Outdoor temperature above which it is warm, °C, and the difference that counts as 1, K.
pub(super) const WARM: [f64; 2] = [14.0, 10.0];
/// Largest value of cold and warm.
const MOST: f64 = 2.0;
/// Outdoor temperature around which the limit of an economizer matters, °C, and the distance at which it no longer
/// does, K.
const ECONOMIZER: [f64; 2] = [20.0, 8.0];
/// Smallest difference between the setpoints of a schedule with a setback, K.
const SETBACK: f64 = 0.5;

/// The drivers of an hour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Drivers {
    /// Outdoor temperature, °C.
    outdoor: f64,
    /// How far the setpoints have left their setback, 0 to 1; 1 without a setback.
    narrow: f64,
}

impl Drivers {
    /// Largest number of terms of a shift.
    pub(super) const TERMS: usize = 3;

    /// Returns the drivers at an outdoor temperature and a mean heating setpoint (°C) between its lowest and its
    /// highest.
    pub(super) fn new(outdoor: f64, setpoint: f64, [low, high]: [f64; 2]) -> Self {
        let narrow =
            if high - low < SETBACK { 1.0 } else { ((setpoint - low) / (high - low)).clamp(0.0, 1.0) };
        Self { outdoor, narrow }
    }

    pub(super) fn narrow(self) -> f64 {
        self.narrow
    }

    /// Returns the levels of a shift that are tried, in its unit; `None` for a shift that stays the guideline's.
    pub(super) fn levels(shift: Shift) -> Option<[f64; 2]> {
        match shift {
            Shift::SupplyTemperature => Some([-3.0, 6.0]),
            Shift::EconomizerLimit => Some([-6.0, 6.0]),
            Shift::MinimumFlow => Some([-0.1, 0.15]),
            Shift::HeatingTemperature => Some([-3.0, 6.0]),
            Shift::CoolingTemperature => Some([-3.0, 4.0]),
            Shift::HeatingSetpoint | Shift::CoolingSetpoint | Shift::Start => None,
        }
    }

    /// Returns the hours for which a level stays in the identification, so that zones follow: the fabric of a building
    /// stores the heat of an air handler.
    pub(super) fn held(shift: Shift) -> usize {
        if Shift::AIR_LOOP.contains(&shift) { 8 } else { 2 }
    }

    /// Returns the earlier hours whose mean level still has an effect: fabric and plenums keep the heat of an air
    /// handler, and a unit's air of another temperature is felt in the next hour.
    pub(super) fn lasting(shift: Shift) -> usize {
        if Shift::AIR_LOOP.contains(&shift) { 12 } else { 1 }
    }

    /// Returns whether a level that is tried may be chosen. Supply air colder than the guideline's takes more reheat
    /// and cooling than it saves in fans, and a lower limit turns cool outdoor air away; their effects only help to
    /// estimate those of the other levels.
    pub(super) fn may_be_chosen(shift: Shift, level: f64) -> bool {
        !Shift::AIR_LOOP.contains(&shift) || level > 0.0
    }

    /// Returns whether a shift may be chosen in an hour. In warm hours, warmer supply air opens dampers and speeds up fans
    /// until zones are short of cooling, later than the trials of an identification show.
    pub(super) fn allow(self, shift: Shift) -> bool {
        shift != Shift::SupplyTemperature || self.outdoor < MILD_TO_WARM[0]
    }

    /// Returns how cold and how warm an outdoor temperature is, 0 to 2.
    pub(super) fn cold_and_warm(outdoor: f64) -> [f64; 2] {
        [(COLD[0] - outdoor) / COLD[1], (outdoor - WARM[0]) / WARM[1]].map(|value| value.clamp(0.0, MOST))
    }

    /// Returns the number of terms of a shift's effect, and whether it has a part for the own hour (1) or also one for
    /// [earlier hours](Self::lasting) (2).
    pub(super) fn shape(shift: Shift) -> (usize, usize) {
        match shift {
            Shift::SupplyTemperature => (3, 2),
            Shift::MinimumFlow => (2, 1),
            _ => (1, 2),
        }
    }

    /// Returns the terms of a shift's effect, as a share of the hour's amount without it; the ones beyond
    /// [`Drivers::shape`] are 0.
    pub(super) fn terms(self, shift: Shift) -> [f64; Self::TERMS] {
        let outdoor = self.outdoor;
        let passed = |[from, to]: [f64; 2]| ((outdoor - from) / (to - from)).clamp(0.0, 1.0);
        let (cold, warm) = (1.0 - passed(COLD_TO_MILD), passed(MILD_TO_WARM));
        match shift {
            Shift::SupplyTemperature => [cold, 1.0 - cold - warm, warm],
            Shift::MinimumFlow => [1.0 - warm, warm, 0.0],
            Shift::HeatingTemperature => [1.0 - warm, 0.0, 0.0],
            Shift::CoolingTemperature => [warm, 0.0, 0.0],
            Shift::EconomizerLimit => {
                let near = 1.0 - (outdoor - ECONOMIZER[0]).abs() / ECONOMIZER[1];
                [near.max(0.0), 0.0, 0.0]
            }
            Shift::HeatingSetpoint | Shift::CoolingSetpoint | Shift::Start => [0.0; Self::TERMS],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drivers_follow_the_weather_and_the_schedule() {
        let at = |outdoor, setpoint| Drivers::new(outdoor, setpoint, [16.0, 20.0]);
        assert_eq!(at(1.0, 20.0).terms(Shift::SupplyTemperature), [0.5, 0.5, 0.0]);
        assert_eq!(at(25.0, 20.0).terms(Shift::SupplyTemperature), [0.0, 0.0, 1.0]);
        assert_eq!(at(16.0, 20.0).terms(Shift::MinimumFlow), [0.5, 0.5, 0.0]);
        assert_eq!([at(20.0, 16.0), at(20.0, 20.0)].map(Drivers::narrow), [0.0, 1.0]);
        assert_eq!(Drivers::new(24.0, 20.0, [20.0, 20.2]).narrow(), 1.0, "without a setback");
        for shift in [Shift::AIR_LOOP, Shift::UNIT].concat() {
            let (terms, _) = Drivers::shape(shift);
            let beyond = [-20.0, 20.0, 35.0]
                .map(|outdoor| at(outdoor, 20.0).terms(shift)[terms..].iter().all(|term| *term == 0.0));
            assert_eq!(beyond, [true; 3], "{shift:?}");
        }
    }
}
