//! Economizer: its high limit (Guideline 36, 5.1.17, with the limits of ASHRAE 90.1 by climate zone), and the outdoor
//! air that mixes to the supply air temperature.

/// Distance below the limit at which the economizer is enabled again, K.
const HYSTERESIS: f64 = 1.0;
/// Shortest time from closing to opening again, h: 10 min.
const LEAST_STAY: f64 = 10.0 / 60.0;

/// Outdoor temperature above which an economizer is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum HighLimit {
    /// Fixed dry bulb, °C, or the return air where that is colder.
    Fixed(f64),
    /// The temperature of the return air.
    ReturnAir,
}

impl HighLimit {
    /// Returns the limit of an ASHRAE climate zone, for example `5B`: a fixed dry bulb, or the return air without a
    /// zone.
    pub(super) fn of_zone(zone: Option<&str>) -> Self {
        match zone {
            Some("0A" | "1A" | "2A" | "3A" | "4A") => Self::Fixed(18.0),
            Some("5A" | "6A") => Self::Fixed(21.0),
            Some(_) => Self::Fixed(24.0),
            None => Self::ReturnAir,
        }
    }
}

/// An economizer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Economizer {
    limit: HighLimit,
    /// Shift of a fixed limit, K.
    shift: f64,
    enabled: bool,
    /// Time since the last switch, h.
    stayed: f64,
}

impl Economizer {
    pub(super) fn new(limit: HighLimit) -> Self {
        Self { limit, shift: 0.0, enabled: false, stayed: f64::INFINITY }
    }

    /// Forgets everything.
    pub(super) fn reset(&mut self) {
        *self = Self::new(self.limit);
    }

    /// Returns whether the economizer may open at outdoor and return air temperatures, °C. `cools`: whether the air
    /// handler runs to cool. It closes at once.
    pub(super) fn step(&mut self, cools: bool, outdoor: f64, return_air: f64, hours: f64) -> bool {
        self.stayed += hours;
        let limit = match self.limit {
            HighLimit::Fixed(limit) => (limit + self.shift).min(return_air),
            HighLimit::ReturnAir => return_air,
        };
        let wanted = cools && outdoor < if self.enabled { limit } else { limit - HYSTERESIS };
        if wanted != self.enabled && (!wanted || self.stayed >= LEAST_STAY) {
            (self.enabled, self.stayed) = (wanted, 0.0);
        }
        self.enabled
    }

    /// Returns whether its limit is fixed, so that a shift moves it.
    pub(super) fn has_fixed_limit(&self) -> bool {
        matches!(self.limit, HighLimit::Fixed(_))
    }

    /// Shifts a fixed limit, K.
    pub(super) fn shift(&mut self, shift: f64) {
        self.shift = shift;
    }

    /// Returns whether it may open.
    pub(super) fn is_enabled(&self) -> bool {
        self.enabled
    }
}

/// Returns the share of outdoor air that brings the mixed air to a temperature, °C; 1 if outdoor air is warmer than it
/// or the return air.
pub(super) fn outdoor_share(outdoor: f64, return_air: f64, mixed: f64) -> f64 {
    if outdoor >= mixed || outdoor >= return_air {
        return 1.0;
    }
    ((return_air - mixed) / (return_air - outdoor)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1.0 / 12.0;

    #[test]
    fn the_limit_depends_on_the_climate_zone() {
        let zones = ["1A", "4A", "5A", "6A", "5B", "7", "8"].map(|zone| HighLimit::of_zone(Some(zone)));
        let limits = [18.0, 18.0, 21.0, 21.0, 24.0, 24.0, 24.0].map(HighLimit::Fixed);
        assert_eq!(zones, limits);
        assert_eq!(HighLimit::of_zone(None), HighLimit::ReturnAir);
        let has_fixed = |zone| Economizer::new(HighLimit::of_zone(zone)).has_fixed_limit();
        assert_eq!([Some("5B"), None].map(has_fixed), [true, false]);
    }

    #[test]
    fn the_economizer_is_off_from_the_limit_on_and_on_again_1_k_below() {
        let mut economizer = Economizer::new(HighLimit::Fixed(21.0));
        let mut at = |outdoor| economizer.step(true, outdoor, 23.0, 4.0 * STEP);
        assert_eq!(
            [20.5, 19.9, 20.9, 21.0, 20.5, 19.9].map(&mut at),
            [false, true, true, false, false, true]
        );
        let mut differential = Economizer::new(HighLimit::ReturnAir);
        let mut at = |outdoor| differential.step(true, outdoor, 23.0, 4.0 * STEP);
        assert_eq!([22.5, 21.9, 22.9, 23.0].map(&mut at), [false, true, true, false]);
    }

    #[test]
    fn the_economizer_stays_off_for_10_minutes_and_while_nothing_is_cooled() {
        let mut economizer = Economizer::new(HighLimit::Fixed(21.0));
        let mut at = |outdoor| economizer.step(true, outdoor, 23.0, STEP);
        assert_eq!([15.0, 22.0, 15.0, 15.0].map(&mut at), [true, false, false, true]);
        assert!(!economizer.step(false, 15.0, 23.0, STEP));
    }

    #[test]
    fn outdoor_air_mixes_to_the_supply_temperature() {
        assert!((outdoor_share(0.0, 23.0, 13.0) - 10.0 / 23.0).abs() < 1e-12);
        assert_eq!([outdoor_share(15.0, 23.0, 13.0), outdoor_share(10.0, 23.0, 25.0)], [1.0, 0.0]);
    }
}
