//! Minimum outdoor air of an air handler (Guideline 36, 5.16.3).
//!
//! The design minimum of a system is its requirement for all of its zones ([`b2b_building::hvac::Ventilation`]). As in
//! the guideline, only zones in occupied mode count, so that it is 0 in warm-up, cool-down, setback and setup. The
//! guideline's reset of the minimum by the flows of the zones is left out: a task requires the design minimum while
//! people are present.

use super::super::modes::Mode;
use super::economizer::outdoor_share;

/// Outdoor air of an air handler, kg/s.
#[derive(Clone, Copy, Debug)]
pub(super) struct OutdoorAir {
    /// Design minimum.
    pub(super) minimum: f64,
    /// Temperature rise across the fan at its design flow, K.
    pub(super) fan_rise: f64,
    /// Design flow of the fan.
    pub(super) fan_flow: f64,
}

/// Air flow, temperatures and the economizer of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Air {
    /// Supply flow, kg/s.
    pub(super) flow: f64,
    /// Supply air temperature setpoint, °C.
    pub(super) supply: f64,
    /// Temperature of the return air, °C.
    pub(super) return_air: f64,
    /// Outdoor temperature, °C.
    pub(super) outdoor: f64,
    /// Whether the economizer is enabled.
    pub(super) economizes: bool,
}

impl OutdoorAir {
    /// Returns the minimum in a mode, kg/s.
    pub(super) fn minimum(&self, mode: Mode) -> f64 {
        if mode == Mode::Occupied { self.minimum } else { 0.0 }
    }

    /// Returns the outdoor air flow, kg/s: the minimum, or what the economizer mixes to the supply air temperature. A
    /// minimum above the supply flow means all outdoor air.
    pub(super) fn step(&self, mode: Mode, air: Air) -> f64 {
        let minimum = self.minimum(mode);
        if !air.economizes {
            return minimum;
        }
        let mixed = air.supply - self.rise(air.flow);
        (air.flow * outdoor_share(air.outdoor, air.return_air, mixed)).max(minimum)
    }

    /// Returns the supply air temperature behind coils that are off, at the minimum of outdoor air and a flow above
    /// 0, °C.
    pub(super) fn untempered(&self, mode: Mode, air: Air) -> f64 {
        let share = (self.minimum(mode) / air.flow).min(1.0);
        air.return_air + share * (air.outdoor - air.return_air) + self.rise(air.flow)
    }

    /// Returns the temperature rise across the fan, K. The power of a variable fan falls with about the third power of
    /// the flow, so its rise with the second. Air that is too cold would be heated again.
    fn rise(&self, flow: f64) -> f64 {
        let share = (flow / self.fan_flow).min(1.0);
        self.fan_rise * share * share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTDOOR_AIR: OutdoorAir = OutdoorAir { minimum: 0.5, fan_rise: 1.0, fan_flow: 4.0 };
    const AIR: Air = Air { flow: 2.0, supply: 13.0, return_air: 23.0, outdoor: 3.0, economizes: false };

    #[test]
    fn the_minimum_holds_in_occupied_mode_and_is_0_in_all_others() {
        assert_eq!(OUTDOOR_AIR.step(Mode::Occupied, AIR), 0.5);
        for mode in [Mode::WarmUp, Mode::CoolDown, Mode::Setback, Mode::Setup, Mode::Unoccupied] {
            assert_eq!(OUTDOOR_AIR.step(mode, AIR), 0.0);
        }
    }

    #[test]
    fn without_coils_the_supply_air_is_mixed_air_and_the_rise_of_the_fan() {
        // A quarter of 3 °C and three quarters of 23 °C.
        assert!((OUTDOOR_AIR.untempered(Mode::Occupied, AIR) - 18.25).abs() < 1e-12);
        assert!((OUTDOOR_AIR.untempered(Mode::Setup, AIR) - 23.25).abs() < 1e-12, "without outdoor air");
    }

    #[test]
    fn the_economizer_mixes_to_the_supply_temperature_less_the_rise_of_the_fan() {
        // At half of the design flow the fan adds 0.25 K: 12.75 °C from 23 and 3 °C.
        let free = Air { economizes: true, ..AIR };
        assert!((OUTDOOR_AIR.step(Mode::Occupied, free) - 2.0 * 10.25 / 20.0).abs() < 1e-12);
        assert_eq!(OUTDOOR_AIR.step(Mode::Setup, Air { outdoor: 15.0, ..free }), 2.0, "all outdoor air");
        let cold = Air { outdoor: -27.0, supply: 22.0, ..free };
        assert_eq!(OUTDOOR_AIR.step(Mode::Occupied, cold), 0.5, "not less than the minimum");
    }
}
