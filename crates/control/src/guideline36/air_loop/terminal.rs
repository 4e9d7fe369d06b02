//! A terminal with reheat under dual-maximum logic, or without (Guideline 36, 5.5 and 5.6).
//!
//! The actuators are the damper, as a share of the design flow, and the setpoint that the reheat coil holds in its zone
//! by itself. The guideline's discharge temperature, which rises over the first half of the heating loop, cannot be
//! commanded: the coil does that within its capacity. The loop aims a little below the setpoint of the coil, so that it
//! leaves 0 only when the coil alone does not hold the zone. Its whole range is the guideline's second half: it raises
//! the flow.

use super::super::modes::Mode;
use super::super::zone::zone_loops::Outputs;

/// Distance of the coil's setpoint above the aim of the heating loop, K.
const COIL_LEAD: f64 = 0.05;
/// Minimum opening in heating (Vheat-min): without flow the coil gives no heat.
const LEAST_HEATING: f64 = 0.1;
/// Distances above the setpoint of the coil up to which a zone needs heat, and from which it needs none, K.
const NEED: [f64; 2] = [0.1, 0.5];
/// Temperature of the supply air above the zone from which it heats, K (5.6.5).
const WARM: f64 = 3.0;

/// Flows of a terminal as shares of its design flow.
#[derive(Clone, Copy, Debug)]
pub(super) struct TerminalRules {
    /// Minimum flow in occupied mode (Vmin): the larger of what ventilation needs and the parameter.
    pub(super) minimum: f64,
    /// Maximum flow in heating (Vheat-max).
    pub(super) heating_max: f64,
    /// Bounds of the coil's setpoint, °C; it is off at the lower one. `None` for a terminal that only cools.
    pub(super) coil: Option<[f64; 2]>,
}

/// State of a zone and its air handler.
#[derive(Clone, Copy, Debug)]
pub(super) struct TerminalInput {
    pub(super) mode: Mode,
    /// Outputs of the loops of the zone.
    pub(super) outputs: Outputs,
    /// Whether the zone may heat in this mode.
    pub(super) may_heat: bool,
    /// Air temperature of the zone, °C.
    pub(super) temperature: f64,
    /// Aim of the heating loop, °C.
    pub(super) heating_aim: f64,
    /// Supply air temperature setpoint, °C.
    pub(super) supply: f64,
}

/// Commands of a terminal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TerminalCommand {
    /// Damper opening, 0 to 1.
    pub(super) opening: f64,
    /// Temperature to which the zone is to be heated, °C: the setpoint of its coil, if it has one. `None` where it is
    /// not to be heated, or by the supply air.
    pub(super) heat: Option<f64>,
}

impl TerminalRules {
    /// Returns the commands of a step.
    pub(super) fn step(&self, input: TerminalInput) -> TerminalCommand {
        let TerminalInput { mode, outputs, supply, temperature, .. } = input;
        let central_heat = mode.heats() && supply >= temperature + WARM;
        let opening = match outputs {
            Outputs { heating, .. } if heating > 0.0 && central_heat => heating,
            Outputs { heating, .. } if heating > 0.0 && self.coil.is_some() => self.reheating(mode, heating),
            Outputs { cooling, .. } if cooling > 0.0 => self.cooling(mode, cooling, supply < temperature),
            _ => self.minimum(mode),
        };
        let [off, highest] = self.coil.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let setpoint = (input.heating_aim + COIL_LEAD).clamp(off, highest);
        let heats = input.may_heat && !central_heat && opening > 0.0 && setpoint > off;
        TerminalCommand { opening, heat: heats.then_some(setpoint) }
    }

    /// Returns the minimum opening in a mode (Vmin*).
    fn minimum(&self, mode: Mode) -> f64 {
        if mode == Mode::Occupied { self.minimum } else { 0.0 }
    }

    /// Returns the opening in cooling: from the minimum to fully open, if the supply air cools.
    fn cooling(&self, mode: Mode, cooling: f64, cools: bool) -> f64 {
        let minimum = self.minimum(mode);
        if cools { minimum + (1.0 - minimum) * cooling } else { minimum }
    }

    /// Returns the opening in heating by the coil: from the minimum to the maximum.
    fn reheating(&self, mode: Mode, heating: f64) -> f64 {
        let least = self.minimum(mode).max(LEAST_HEATING);
        let most = self.heating_max.max(least);
        least + (most - least) * heating
    }
}

impl TerminalCommand {
    /// Returns how much a zone needs heat, 0 to 1: fully below a temperature just above its coil's setpoint.
    pub(super) fn needs_heat(self, temperature: f64) -> f64 {
        let [first, last] = NEED;
        self.heat.map_or(0.0, |setpoint| ((last - (temperature - setpoint)) / (last - first)).clamp(0.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULES: TerminalRules = TerminalRules { minimum: 0.15, heating_max: 0.5, coil: Some([10.0, 30.0]) };
    const INPUT: TerminalInput = TerminalInput {
        mode: Mode::Occupied,
        outputs: Outputs { heating: 0.0, cooling: 0.0 },
        may_heat: true,
        temperature: 22.0,
        heating_aim: 21.05,
        supply: 13.0,
    };

    fn step(mode: Mode, heating: f64, cooling: f64) -> TerminalCommand {
        let may_heat = mode.allows([true; 2])[0];
        RULES.step(TerminalInput { mode, may_heat, outputs: Outputs { heating, cooling }, ..INPUT })
    }

    #[test]
    fn cooling_opens_from_the_minimum_to_the_design_flow() {
        let openings = [0.0, 0.5, 1.0].map(|cooling| step(Mode::Occupied, 0.0, cooling).opening);
        assert_eq!(openings, [0.15, 0.575, 1.0]);
        assert_eq!([Mode::CoolDown, Mode::Setup].map(|mode| step(mode, 0.0, 0.5).opening), [0.5; 2]);
        let warm = TerminalInput { supply: 25.0, outputs: Outputs { heating: 0.0, cooling: 1.0 }, ..INPUT };
        assert_eq!(RULES.step(warm).opening, 0.15, "supply air above the room does not cool");
    }

    #[test]
    fn heating_raises_the_flow_from_the_minimum_to_half_of_the_design_flow() {
        let openings = [0.0, 0.5, 1.0].map(|heating| step(Mode::Occupied, heating, 0.0).opening);
        for (opening, expected) in openings.into_iter().zip([0.15, 0.325, 0.5]) {
            assert!((opening - expected).abs() < 1e-12, "{openings:?}");
        }
        let setpoint = step(Mode::Occupied, 0.0, 0.0).heat.unwrap();
        assert!((setpoint - 21.1).abs() < 1e-9, "the coil leads the loop");
    }

    #[test]
    fn a_zone_needs_no_heat_half_a_kelvin_above_its_coil_or_without_it() {
        let command = TerminalCommand { opening: 0.15, heat: Some(21.1) };
        let needs = [20.0, 21.2, 21.4, 21.6].map(|temperature| command.needs_heat(temperature));
        for (need, expected) in needs.into_iter().zip([1.0, 1.0, 0.5, 0.0]) {
            assert!((need - expected).abs() < 1e-9, "{needs:?}");
        }
        assert_eq!(TerminalCommand { heat: None, ..command }.needs_heat(9.0), 0.0, "the coil is off");
    }

    #[test]
    fn warm_up_heats_by_flow_with_the_coil_off() {
        let warm = |temperature| {
            let outputs = Outputs { heating: 0.6, cooling: 0.0 };
            RULES.step(TerminalInput { mode: Mode::WarmUp, supply: 35.0, outputs, temperature, ..INPUT })
        };
        assert_eq!(warm(18.0), TerminalCommand { opening: 0.6, heat: None });
        let weak = warm(33.0);
        assert!(
            (weak.opening - 0.34).abs() < 1e-12 && weak.heat > Some(21.0),
            "without central heat: {weak:?}"
        );
    }

    #[test]
    fn a_terminal_is_closed_and_cold_without_people_and_need() {
        for mode in [Mode::Unoccupied, Mode::WarmUp, Mode::CoolDown, Mode::Setup, Mode::Setback] {
            assert_eq!(step(mode, 0.0, 0.0), TerminalCommand { opening: 0.0, heat: None });
        }
    }

    #[test]
    fn without_a_coil_heating_raises_the_flow_only_of_warm_air() {
        let rules = TerminalRules { coil: None, ..RULES };
        let heated = |mode, supply| {
            let outputs = Outputs { heating: 0.8, cooling: 0.0 };
            rules.step(TerminalInput { mode, supply, outputs, temperature: 19.0, ..INPUT })
        };
        let cold = heated(Mode::Occupied, 13.0);
        assert_eq!(cold.opening, 0.15, "more cold air would not heat");
        assert_eq!(cold.needs_heat(19.0), 1.0, "the air handler does not cool what it supplies");
        assert_eq!(heated(Mode::WarmUp, 35.0).opening, 0.8);
    }
}
