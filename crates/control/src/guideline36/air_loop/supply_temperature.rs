//! Supply air temperature setpoint of an air handler of several zones (Guideline 36, 5.16.2.2).
//!
//! The guideline lowers the setpoint as it gets warmer outdoors in occupied mode, whether or not a zone cools. Here it
//! stays at the upper end of the reset while no zone cools, because cold air at minimum flow would be reheated. While
//! no zone needs heat, it is lowered to the temperature of the mixed air, which people and lights warm for free. When
//! one does, heat from the coil of the air handler costs less than electric reheat.

use super::super::modes::Mode;
use super::super::trim_respond::{Guideline36Reset, Reset};

/// Outdoor temperatures between which the setpoint falls from its reset value to its minimum, °C (OAT_Min, OAT_Max).
const OUTDOOR: [f64; 2] = [16.0, 21.0];
/// Setpoint in warm-up, setback and freeze protection, °C.
const WARM_UP: f64 = 35.0;

/// Parameters of the setpoint.
#[derive(Clone, Copy, Debug)]
pub(super) struct SupplyTemperatureRules {
    /// Lowest and highest setpoint in cooling (Min_ClgSAT, Max_ClgSAT), °C.
    pub(super) cooling: [f64; 2],
    /// Reset by the requests of the zones.
    pub(super) trim_respond: Guideline36Reset,
    /// Whether the setpoint is reset; it is the lowest otherwise.
    pub(super) resets: bool,
    /// Bounds of the actuator, °C.
    pub(super) reach: [f64; 2],
}

/// The supply air temperature setpoint.
#[derive(Clone, Copy, Debug)]
pub(super) struct SupplyTemperature {
    rules: SupplyTemperatureRules,
    reset: Reset,
    /// Upper end of the outdoor reset (t_max), °C.
    highest: f64,
    /// Shift of the setpoint while the air handler does not heat, K.
    shift: f64,
}

impl SupplyTemperature {
    pub(super) fn new(rules: SupplyTemperatureRules) -> Self {
        let reset = Reset::new(rules.trim_respond, rules.cooling);
        Self { rules, reset, highest: rules.cooling[1], shift: 0.0 }
    }

    /// Forgets everything.
    pub(super) fn restart(&mut self) {
        *self = Self::new(self.rules);
    }

    /// Returns the setpoint, °C, in a mode, with the requests of the zones. `outdoor`: the outdoor temperature while a
    /// zone cools, °C.
    pub(super) fn step(&mut self, mode: Mode, outdoor: Option<f64>, requests: f64, hours: f64) -> f64 {
        self.highest = self.reset.step(mode.runs() && !mode.heats(), requests, hours);
        let [lowest, _] = self.rules.cooling;
        let setpoint = match mode {
            Mode::WarmUp | Mode::Setback | Mode::FreezeProtection => self.warm(),
            Mode::CoolDown => lowest + self.shift,
            _ if !self.rules.resets => lowest + self.shift,
            Mode::Occupied | Mode::Setup | Mode::Unoccupied => {
                let setpoint = outdoor.map_or(self.highest, |outdoor| self.by_outdoor_temperature(outdoor));
                setpoint + self.shift
            }
        };
        setpoint.clamp(self.rules.reach[0], self.rules.reach[1])
    }

    /// Returns the setpoint of warm-up: 35 °C, or what the heating coil reaches.
    pub(super) fn warm(&self) -> f64 {
        WARM_UP.min(self.rules.reach[1])
    }

    /// Returns a setpoint of [`Self::step`] lowered to a temperature, °C, but not below the lowest one in cooling. Its
    /// shift stays.
    pub(super) fn at_most(&self, setpoint: f64, temperature: f64) -> f64 {
        setpoint.min(temperature.max(self.rules.cooling[0]) + self.shift)
    }

    /// Shifts the setpoint while the air handler does not heat, K.
    pub(super) fn shift(&mut self, shift: f64) {
        self.shift = shift;
    }

    /// Returns the upper end of the outdoor reset (t_max), °C.
    pub(super) fn highest(&self) -> f64 {
        self.highest
    }

    fn by_outdoor_temperature(&self, outdoor: f64) -> f64 {
        let share = ((outdoor - OUTDOOR[0]) / (OUTDOOR[1] - OUTDOOR[0])).clamp(0.0, 1.0);
        self.highest + share * (self.rules.cooling[0] - self.highest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1.0 / 12.0;
    const RULES: SupplyTemperatureRules = SupplyTemperatureRules {
        cooling: [12.0, 18.0],
        trim_respond: Guideline36Reset {
            delay: 0.0,
            ignored_requests: 2.0,
            trim: 3.0,
            respond: 6.0,
            max_respond: 18.0,
        },
        resets: true,
        reach: [10.0, 55.0],
    };

    fn setpoint(mode: Mode, outdoor: f64) -> f64 {
        SupplyTemperature::new(RULES).step(mode, Some(outdoor), 0.0, STEP)
    }

    #[test]
    fn the_setpoint_falls_from_18_at_16_degrees_outdoors_to_12_at_21() {
        let at = [-10.0, 16.0, 18.5, 21.0, 35.0].map(|outdoor| setpoint(Mode::Occupied, outdoor));
        assert_eq!(at, [18.0, 18.0, 15.0, 12.0, 12.0]);
        assert_eq!(setpoint(Mode::Setup, 18.5), 15.0);
    }

    #[test]
    fn without_a_zone_that_cools_the_setpoint_is_at_the_upper_end_of_the_reset() {
        let mut supply = SupplyTemperature::new(RULES);
        assert_eq!(supply.step(Mode::Occupied, None, 0.0, STEP), 18.0);
        assert_eq!(supply.step(Mode::Occupied, Some(25.0), 0.0, STEP), 12.0);
    }

    #[test]
    fn requests_lower_the_upper_end_of_the_outdoor_reset() {
        let mut supply = SupplyTemperature::new(RULES);
        let cold: Vec<f64> = (0..3).map(|_| supply.step(Mode::Occupied, Some(0.0), 4.0, STEP)).collect();
        assert_eq!(cold, [17.0, 16.0, 15.0]);
        assert!((supply.step(Mode::Occupied, Some(18.5), 2.0, STEP) - 13.625).abs() < 1e-9);
    }

    #[test]
    fn warm_up_is_at_35_degrees_or_at_the_reach_of_the_coil_and_cool_down_at_the_lowest() {
        assert_eq!([Mode::WarmUp, Mode::Setback].map(|mode| setpoint(mode, 0.0)), [35.0; 2]);
        let weak = SupplyTemperatureRules { reach: [10.0, 27.0], ..RULES };
        assert_eq!(SupplyTemperature::new(weak).step(Mode::WarmUp, None, 0.0, STEP), 27.0);
        assert_eq!(setpoint(Mode::CoolDown, 0.0), 12.0);
    }

    #[test]
    fn without_reset_the_setpoint_is_fixed() {
        let fixed = SupplyTemperatureRules { resets: false, ..RULES };
        for outdoor in [-10.0, 18.0, 30.0] {
            assert_eq!(SupplyTemperature::new(fixed).step(Mode::Occupied, Some(outdoor), 0.0, STEP), 12.0);
        }
    }
}
