//! A zone: the setpoints in use, its calls for heating and cooling, its loops and its requests.
//!
//! Every step has two passes. [`Zone::observe`] derives setpoints and calls from the points of the zone, from which the
//! group derives its mode; [`Zone::control`] runs the loops that the mode allows.

pub mod demand;
mod hunting;
pub(super) mod optimum_start;
pub(super) mod requests;
pub(super) mod zone_loops;

use super::modes::{Mode, ZoneNeed};
use super::points::{Setpoints, Side, SiteInput, ZoneInput};
use super::supervision::Shift;
use optimum_start::{Goal, OptimumStart};
use requests::CoolingRequests;
pub use zone_loops::LoopGains;
use zone_loops::{Outputs, Reach, ZoneLoops};

/// Minimum distance between heating and cooling setpoint, K (5.3.2).
const LEAST_BAND: f64 = 0.5;
/// Distance inside a relaxed band at which setback and setup end, K (5.4.6).
const RELAXED_RELEASE: f64 = 1.0;
/// Distance beyond the aim of the loops at which a call ends once its loop is at 0, K.
const RELEASE: f64 = 0.15;
/// Change of a setpoint that counts as a relaxed band, K.
const RELAXATION: f64 = 0.1;
/// Heating setpoint of freeze protection, °C: it lasts until all zones are above 7 °C.
const FREEZE_SETPOINT: f64 = 8.0;

/// Setpoints before the first step, °C.
const REST: Setpoints = Setpoints { heating: 16.0, cooling: 32.0 };

/// Rules of the control of zones.
#[derive(Clone, Copy, Debug)]
pub(super) struct ZoneRules {
    /// Gains of the heating and the cooling loop.
    pub(super) gains: [LoopGains; 2],
    /// Distances inside the band at which the heating and the cooling loop aim, K.
    pub(super) margins: [f64; 2],
    /// Longest optimum start, h; 0 turns it off.
    pub(super) optimum_start: f64,
    /// Whether the setpoints are relaxed in unoccupied hours.
    pub(super) setback: bool,
}

/// A zone.
#[derive(Clone, Debug)]
pub(super) struct Zone {
    rules: ZoneRules,
    starts: [OptimumStart; 2],
    loops: ZoneLoops,
    requests: CoolingRequests,
    need: ZoneNeed,
    /// Whether optimum start of heating is on.
    preheats: bool,
    setpoints: Setpoints,
    aims: Setpoints,
    outputs: Outputs,
    shifts: ZoneShifts,
}

/// Shifts of what the zone chooses ([`Shift`]).
#[derive(Clone, Copy, Debug, Default)]
struct ZoneShifts {
    /// Shifts of the heating and the cooling setpoint, K.
    setpoints: [f64; 2],
    /// Time by which recovery starts earlier, h.
    start: f64,
}

impl Zone {
    pub(super) fn new(rules: ZoneRules) -> Self {
        Self {
            starts: Side::BOTH.map(|side| OptimumStart::new(side, rules.optimum_start)),
            loops: ZoneLoops::new(rules.gains),
            requests: CoolingRequests::default(),
            need: ZoneNeed { temperature: 20.0, people: false, calls: [false; 2], relaxed: [false; 2] },
            preheats: false,
            setpoints: REST,
            aims: REST,
            outputs: Outputs::default(),
            shifts: ZoneShifts::default(),
            rules,
        }
    }

    /// Forgets everything.
    pub(super) fn reset(&mut self) {
        *self = Self::new(self.rules);
    }

    /// Derives the setpoints in use and the calls of the zone.
    pub(super) fn observe(&mut self, input: &ZoneInput, site: SiteInput, hours: f64) -> ZoneNeed {
        self.need.temperature = input.temperature;
        self.need.people = input.people;
        let scheduled = site.demand.widen(self.scheduled(input, site.outdoor_temperature, hours));
        self.setpoints = self.shifts.apply(scheduled);
        for side in Side::BOTH {
            self.need.calls[side as usize] = self.calls(side);
        }
        self.need
    }

    /// Returns the setpoints by schedule and optimum start, and notes which are relaxed.
    fn scheduled(&mut self, input: &ZoneInput, outdoor: f64, hours: f64) -> Setpoints {
        let band = input.band();
        let mut used = band;
        for side in Side::BOTH {
            let next = input.next.map(|next| (next.hours, next.setpoints().of(side)));
            let narrower = next.filter(|(_, setpoint)| {
                side.gap(band.of(side), *setpoint) > RELAXATION && setpoint.is_finite()
            });
            let ZoneShifts { setpoints, start } = self.shifts;
            let shift = setpoints[side as usize];
            let goal = narrower.map(|(hours, setpoint)| Goal { hours, setpoint, shift, earlier: start });
            let starts = self.starts[side as usize].step(input.temperature, goal, outdoor, hours);
            let uses_next = narrower.is_some() && (starts || !self.rules.setback);
            if side == Side::Heating {
                self.preheats = starts;
            }
            self.need.relaxed[side as usize] = narrower.is_some() && !uses_next;
            if let (Some((_, setpoint)), true) = (narrower, uses_next) {
                match side {
                    Side::Heating => used.heating = setpoint,
                    Side::Cooling => used.cooling = setpoint,
                }
            }
        }
        Setpoints { cooling: used.cooling.max(used.heating + LEAST_BAND), ..used }
    }

    /// Returns the distance inside the band at which the loops aim, K.
    fn aim(&self, side: Side) -> f64 {
        self.rules.margins[side as usize].min((self.setpoints.cooling - self.setpoints.heating) / 4.0)
    }

    /// Returns whether the zone calls. A call begins halfway between the aim and the setpoint, and ends beyond the aim
    /// once the loop is at 0; in setback and setup, 1 K inside in any case.
    fn calls(&self, side: Side) -> bool {
        let inside = -side.gap(self.need.temperature, self.setpoints.of(side));
        let aim = self.aim(side);
        let output = match side {
            Side::Heating => self.outputs.heating,
            Side::Cooling => self.outputs.cooling,
        };
        match (self.need.calls[side as usize], self.need.relaxed[side as usize]) {
            (false, _) => inside < aim / 2.0,
            (true, true) if inside >= RELAXED_RELEASE => false,
            (true, _) => output > 0.0 || inside < aim + RELEASE,
        }
    }

    /// Runs the loops that the mode of the group allows within their reaches. Returns their outputs.
    pub(super) fn control(&mut self, mode: Mode, reaches: [Reach; 2], hours: f64) -> Outputs {
        let ZoneNeed { temperature, calls, .. } = self.need;
        self.aims = self.aims_in(mode);
        let allowed = mode.allows(calls);
        let reaches = [0, 1].map(|side| match allowed[side] {
            true => reaches[side],
            false => Reach { limit: 0.0, ..reaches[side] },
        });
        self.outputs = self.loops.step(temperature, self.aims, reaches, mode == Mode::Occupied, hours);
        self.requests.step(temperature, self.setpoints.cooling, self.outputs.cooling, hours);
        self.outputs
    }

    /// Shifts a choice of the zone.
    pub(super) fn shift(&mut self, shift: Shift, value: f64) {
        match shift {
            Shift::HeatingSetpoint => self.shifts.setpoints[Side::Heating as usize] = value,
            Shift::CoolingSetpoint => self.shifts.setpoints[Side::Cooling as usize] = value,
            Shift::Start => self.shifts.start = value,
            _ => (),
        }
    }

    /// Forgets the load of the heating loop, whose output is about to mean something else.
    pub(super) fn forget_heating(&mut self) {
        self.loops.forget_heating();
    }

    /// Returns the temperatures at which the loops aim in a mode, °C.
    pub(super) fn aims_in(&self, mode: Mode) -> Setpoints {
        let heating = self.setpoints.heating + self.aim(Side::Heating);
        let cooling = self.setpoints.cooling - self.aim(Side::Cooling);
        let heating = if mode == Mode::FreezeProtection { heating.max(FREEZE_SETPOINT) } else { heating };
        Setpoints { heating, cooling: cooling.max(heating) }
    }

    /// Returns the temperatures at which the loops aim, °C.
    pub(super) fn aims(&self) -> Setpoints {
        self.aims
    }

    /// Returns the last report to the group.
    pub(super) fn need(&self) -> ZoneNeed {
        self.need
    }

    /// Returns the setpoints in use.
    pub(super) fn setpoints(&self) -> Setpoints {
        self.setpoints
    }

    /// Returns the outputs of the last step.
    pub(super) fn outputs(&self) -> Outputs {
        self.outputs
    }

    /// Returns its requests for colder supply air.
    pub(super) fn cooling_requests(&self) -> f64 {
        self.requests.count()
    }

    /// Returns whether heating has begun ahead of its schedule.
    pub(super) fn preheats(&self) -> bool {
        self.preheats
    }
}

impl ZoneShifts {
    /// Returns setpoints after the shifts.
    fn apply(self, setpoints: Setpoints) -> Setpoints {
        let heating = setpoints.heating + self.setpoints[Side::Heating as usize];
        let cooling = setpoints.cooling + self.setpoints[Side::Cooling as usize];
        Setpoints { heating, cooling: cooling.max(heating + LEAST_BAND) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::points::NextBand;
    use super::demand::DemandLevel;
    use super::*;

    const STEP: f64 = 1.0 / 12.0;
    pub(super) const RULES: ZoneRules = ZoneRules {
        gains: [LoopGains { proportional: 0.1, integral_time: 900.0 }; 2],
        margins: [0.2; 2],
        optimum_start: 3.0,
        setback: true,
    };

    const FULL: [Reach; 2] = [Reach { idle: 0.0, limit: 1.0 }; 2];
    const SITE: SiteInput = SiteInput { outdoor_temperature: 10.0, demand: DemandLevel::NONE };

    fn night(temperature: f64, hours: f64) -> ZoneInput {
        let next = Some(NextBand { hours, heating: 21.0, cooling: 24.0 });
        ZoneInput { temperature, heating: 16.0, cooling: 32.0, people: false, next }
    }

    #[test]
    fn setback_starts_below_the_setpoint_and_ends_at_most_1_k_above() {
        let mut zone = Zone::new(RULES);
        let mut calls = |temperature| zone.observe(&night(temperature, 9.0), SITE, STEP);
        let needs = [16.5, 15.9, 16.3, 17.1, 16.3].map(&mut calls);
        assert_eq!(needs.map(|need| need.calls[0]), [false, true, true, false, false]);
        assert!(needs.iter().all(|need| need.relaxed == [true; 2]));
    }

    #[test]
    fn optimum_start_uses_the_next_band_and_is_not_a_setback() {
        let mut zone = Zone::new(RULES);
        let need = zone.observe(&night(18.0, 1.5), SITE, STEP);
        assert_eq!(
            (zone.setpoints(), need.relaxed),
            (Setpoints { heating: 21.0, cooling: 32.0 }, [false, true])
        );
        assert_eq!(need.calls, [true, false]);
        let off = ZoneRules { optimum_start: 0.0, ..RULES };
        assert_eq!(Zone::new(off).observe(&night(18.0, 1.5), SITE, STEP).calls, [false; 2]);
    }

    #[test]
    fn without_setback_the_band_of_occupied_hours_is_held_all_night() {
        let mut zone = Zone::new(ZoneRules { setback: false, ..RULES });
        let need = zone.observe(&night(20.0, 9.0), SITE, STEP);
        assert_eq!(zone.setpoints(), Setpoints { heating: 21.0, cooling: 24.0 });
        assert_eq!((need.calls, need.relaxed), ([true, false], [false; 2]));
    }

    #[test]
    fn the_loops_aim_inside_the_band_and_demand_levels_widen_it() {
        let mut zone = Zone::new(RULES);
        let mut heats = |temperature, level| {
            let day = ZoneInput { temperature, heating: 21.0, cooling: 24.0, people: true, next: None };
            zone.reset();
            zone.observe(&day, SiteInput { demand: DemandLevel::new(level).unwrap(), ..SITE }, STEP);
            zone.control(Mode::Occupied, FULL, STEP).heating > 0.0
        };
        assert_eq!(
            [heats(21.1, 0), heats(21.25, 0), heats(20.5, 2), heats(20.1, 2)],
            [true, false, false, true]
        );
    }
}
