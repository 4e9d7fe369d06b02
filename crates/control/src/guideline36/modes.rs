//! Modes of a zone group (Guideline 36, 5.4.6 and 5.15).
//!
//! The guideline takes its occupied mode from a schedule. Here a group is occupied while people use one of its zones,
//! because outdoor air follows people. Without people:
//!
//! - With the setpoints of occupied hours, or once optimum start has begun, a zone outside them starts warm-up or
//!   cool-down: no minimum outdoor air, and the fan runs only while a zone needs it.
//! - With a wider band, a zone outside it starts setback or setup, which last until it is 1 K inside or needs nothing
//!   more to stay inside. The guideline starts with five zones or the average of all, and always heats by 1 K; here
//!   every zone counts, because every zone's discomfort does, and the loops modulate: a fan at low flow takes little.
//! - Otherwise the group is unoccupied: no flow.

use super::points::Side;

/// Temperatures below which freeze protection starts in any zone, and from which it ends in all, °C.
const FREEZE: [f64; 2] = [4.0, 7.0];

/// Mode of a zone group, with the numbers of the Modelica Buildings Library (`Types/OperationModes`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// People are present.
    Occupied = 1,
    /// Recovers to or holds the cooling setpoint of occupied hours before people come.
    CoolDown = 2,
    /// A zone is above the cooling setpoint of unoccupied hours.
    Setup = 3,
    /// Recovers to or holds the heating setpoint of occupied hours before people come.
    WarmUp = 4,
    /// A zone is below the heating setpoint of unoccupied hours.
    Setback = 5,
    /// A zone is near freezing.
    FreezeProtection = 6,
    /// Nobody is present and no zone needs anything.
    #[default]
    Unoccupied = 7,
}

impl Mode {
    /// Names of the modes, in the order of their numbers from 1.
    pub const NAMES: &'static [&'static str] =
        &["occupied", "cool-down", "setup", "warm-up", "setback", "freeze protection", "unoccupied"];

    /// Returns the number of the mode, for records.
    pub fn number(self) -> f64 {
        f64::from(self as u8)
    }

    /// Returns whether the fan runs.
    pub(super) fn runs(self) -> bool {
        self != Self::Unoccupied
    }

    /// Returns whether the air handler supplies heat to zones, with all other zones closed.
    pub(super) fn heats(self) -> bool {
        matches!(self, Self::WarmUp | Self::Setback | Self::FreezeProtection)
    }

    /// Returns whether a zone may heat and cool in this mode, given its calls.
    pub(super) fn allows(self, calls: [bool; 2]) -> [bool; 2] {
        let [heating, cooling] = calls;
        match self {
            Self::Occupied => [true, true],
            Self::CoolDown => [heating, cooling],
            Self::Setup => [false, cooling],
            Self::WarmUp | Self::Setback => [heating, false],
            Self::FreezeProtection => [true, false],
            Self::Unoccupied => [false, false],
        }
    }
}

/// Report of a zone to its group. Arrays are by side: heating, cooling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ZoneNeed {
    /// Air temperature, °C.
    pub(super) temperature: f64,
    /// Whether people are present.
    pub(super) people: bool,
    /// Whether it is outside its setpoint.
    pub(super) calls: [bool; 2],
    /// Whether the setpoint is one of unoccupied hours: a narrower one follows, and optimum start has not begun.
    pub(super) relaxed: [bool; 2],
}

/// The mode of a group and whether freeze protection is on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ZoneGroup {
    mode: Mode,
    freezing: bool,
}

impl ZoneGroup {
    /// Returns the mode of the next step.
    pub(super) fn step(&mut self, zones: impl Iterator<Item = ZoneNeed> + Clone) -> Mode {
        let coldest = zones.clone().map(|zone| zone.temperature).fold(f64::INFINITY, f64::min);
        self.freezing = coldest < FREEZE[usize::from(self.freezing)];
        self.mode = if self.freezing { Mode::FreezeProtection } else { by_need(zones) };
        self.mode
    }

    /// Returns the mode of the last step.
    pub(super) fn mode(&self) -> Mode {
        self.mode
    }
}

/// Returns the first mode that applies, in the guideline's order.
fn by_need(zones: impl Iterator<Item = ZoneNeed> + Clone) -> Mode {
    let any = |side: Side, wide: bool| {
        zones.clone().any(|zone| zone.calls[side as usize] && zone.relaxed[side as usize] == wide)
    };
    if zones.clone().any(|zone| zone.people) {
        return Mode::Occupied;
    }
    let by_call = [
        (Mode::CoolDown, Side::Cooling, false),
        (Mode::Setup, Side::Cooling, true),
        (Mode::WarmUp, Side::Heating, false),
        (Mode::Setback, Side::Heating, true),
    ];
    let mode = by_call.into_iter().find(|&(_, side, wide)| any(side, wide));
    mode.map_or(Mode::Unoccupied, |(mode, ..)| mode)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOTHING: ZoneNeed =
        ZoneNeed { temperature: 20.0, people: false, calls: [false; 2], relaxed: [true; 2] };

    fn mode(zones: &[ZoneNeed]) -> Mode {
        ZoneGroup::default().step(zones.iter().copied())
    }

    #[test]
    fn people_in_one_zone_make_the_group_occupied() {
        let someone = ZoneNeed { people: true, ..NOTHING };
        assert_eq!(mode(&[NOTHING, someone]), Mode::Occupied);
        assert_eq!(mode(&[NOTHING, NOTHING]), Mode::Unoccupied);
    }

    #[test]
    fn calls_of_a_relaxed_band_are_setback_and_setup_and_others_warm_up_and_cool_down() {
        let call = |calls, relaxed| mode(&[NOTHING, ZoneNeed { calls, relaxed, ..NOTHING }]);
        assert_eq!(call([true, false], [true; 2]), Mode::Setback);
        assert_eq!(call([true, false], [false; 2]), Mode::WarmUp);
        assert_eq!(call([false, true], [true; 2]), Mode::Setup);
        assert_eq!(call([false, true], [false; 2]), Mode::CoolDown);
    }

    #[test]
    fn cooling_comes_before_heating() {
        let hot = ZoneNeed { calls: [false, true], ..NOTHING };
        let cold = ZoneNeed { calls: [true, false], relaxed: [false; 2], ..NOTHING };
        assert_eq!(mode(&[cold, hot]), Mode::Setup);
        assert_eq!(mode(&[cold]), Mode::WarmUp);
    }

    #[test]
    fn freeze_protection_starts_below_4_and_ends_above_7_degrees() {
        let mut group = ZoneGroup::default();
        let mut at = |temperature| group.step([NOTHING, ZoneNeed { temperature, ..NOTHING }].into_iter());
        let modes = [4.5, 3.9, 6.9, 7.1, 6.9].map(&mut at);
        let (off, on) = (Mode::Unoccupied, Mode::FreezeProtection);
        assert_eq!(modes, [off, on, on, off, off]);
    }
}
