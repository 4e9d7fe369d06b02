//! Optimum start (Guideline 36, 5.4.6; ASHRAE 90.1, 6.4.3.3.3): when recovery from setback must begin so that a zone is
//! at its next setpoint in time.
//!
//! The rate at which a zone recovers is learned as in the Modelica Buildings Library (`OptimalStart`): the mean rate of
//! the last three starts, at least 1 K/h, and a start at most 3 h ahead. Unlike there,
//!
//! - the time is estimated at every step from the present temperature rather than once at 3 h, so that the drift of the
//!   zone until the start counts;
//! - the rate is the rise that was reached rather than the one that was wanted;
//! - the rate depends on the outdoor temperature, as 90.1 requires: losses take a share of the capacity that grows with
//!   the distance between outdoors and the setpoint, to all of it at the distance for which equipment is designed.

use super::super::points::Side;

/// Starts that are remembered.
const MEMORY: usize = 3;
/// Rate before the first start, K/h: 3 K in 2 h, the recovery time of the baseline in BOPTEST's hydronic commercial
/// case.
const FIRST_RATE: f64 = 1.5;
/// Lowest rate, K/h.
const SLOWEST: f64 = 1.0;
/// Shortest time over which a rate is measured, h: 120 s.
const SHORTEST: f64 = 120.0 / 3600.0;
/// Distance between outdoors and the setpoint at which losses take the whole capacity, K.
const DESIGN_DISTANCE: f64 = 50.0;
/// Minimum share of the capacity that is left for recovery.
const LEAST_SHARE: f64 = 0.25;
/// Gap at which recovery counts as complete, K: the hysteresis of zone loops in the Modelica Buildings Library. The
/// loop throttles near the setpoint, and closing the rest in advance would begin the start too early.
const IN_TIME: f64 = 0.25;
/// Change of the next setpoint that makes it another one, K.
const OTHER_GOAL: f64 = 0.01;

/// A change of the setpoint ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Goal {
    /// Time until the change, h.
    pub(in super::super) hours: f64,
    /// Setpoint after it, °C.
    pub(in super::super) setpoint: f64,
    /// Shift of the setpoint by a supervisor, K.
    pub(in super::super) shift: f64,
    /// Time by which a supervisor starts earlier, h.
    pub(in super::super) earlier: f64,
}

/// A start whose rate is being measured.
#[derive(Clone, Copy, Debug)]
struct Measurement {
    setpoint: f64,
    /// Gap to the setpoint when it began, K.
    first_gap: f64,
    /// Share of the capacity that was left by losses.
    share: f64,
    /// Time since, h.
    hours: f64,
}

/// Optimum start of one side of a zone.
#[derive(Clone, Debug)]
pub(in super::super) struct OptimumStart {
    side: Side,
    /// Longest time ahead of the change, before a supervisor's `earlier`, h.
    limit: f64,
    /// Rates that the last starts would have had without losses, K/h, the oldest first.
    rates: [f64; MEMORY],
    starts: usize,
    /// Setpoint for which the zone has been started ahead.
    started: Option<f64>,
    measured: Option<Measurement>,
}

impl OptimumStart {
    pub(in super::super) fn new(side: Side, limit: f64) -> Self {
        Self { side, limit, rates: [0.0; MEMORY], starts: 0, started: None, measured: None }
    }

    /// Returns whether the zone must recover now to the next setpoint, if that is narrower than the present one. To be
    /// called at every step, of `hours`. Temperatures of the zone and outdoors, °C.
    pub(in super::super) fn step(
        &mut self,
        temperature: f64,
        goal: Option<Goal>,
        outdoor: f64,
        hours: f64,
    ) -> bool {
        self.measure(temperature, hours);
        let Some(goal) = goal else {
            self.started = None;
            return false;
        };
        let same = self.started.is_some_and(|setpoint| (setpoint - goal.setpoint).abs() < OTHER_GOAL);
        let aim = goal.setpoint + goal.shift;
        let gap = self.side.gap(temperature, aim);
        let share = self.share(outdoor, goal.setpoint);
        let ahead = ((gap - IN_TIME) / self.rate(share)).min(self.limit) + goal.earlier;
        let begins = gap > IN_TIME && goal.hours <= ahead;
        if begins && !same {
            self.measured = Some(Measurement { setpoint: aim, first_gap: gap, share, hours: 0.0 });
        }
        self.started = (same || begins).then_some(goal.setpoint);
        self.started.is_some()
    }

    /// Returns the share of the capacity that losses leave for recovery.
    fn share(&self, outdoor: f64, setpoint: f64) -> f64 {
        (1.0 - self.side.gap(outdoor, setpoint) / DESIGN_DISTANCE).clamp(LEAST_SHARE, 1.0)
    }

    /// Returns the rate expected with a share of the capacity, K/h: from the mean of the last starts.
    pub(in super::super) fn rate(&self, share: f64) -> f64 {
        let known = &self.rates[MEMORY - self.starts..];
        match known.len() {
            0 => FIRST_RATE,
            count => (share * known.iter().sum::<f64>() / count as f64).max(SLOWEST),
        }
    }

    /// Measures the rate of a start until recovery is complete or has taken the longest time.
    fn measure(&mut self, temperature: f64, hours: f64) {
        let Some(mut measured) = self.measured else { return };
        measured.hours += hours;
        let gap = self.side.gap(temperature, measured.setpoint);
        if gap > IN_TIME && measured.hours < self.limit {
            self.measured = Some(measured);
            return;
        }
        self.measured = None;
        let closed = measured.first_gap - gap.max(0.0);
        self.rates.rotate_left(1);
        self.rates[MEMORY - 1] = (closed / measured.hours.max(SHORTEST) / measured.share).max(0.0);
        self.starts = (self.starts + 1).min(MEMORY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1.0 / 12.0;
    const OUTDOOR: f64 = 11.0;
    /// Share of the capacity left 10 K below the setpoint.
    const SHARE: f64 = 0.8;

    fn goal(hours: f64, setpoint: f64) -> Goal {
        Goal { hours, setpoint, shift: 0.0, earlier: 0.0 }
    }

    /// Runs a night and a morning from 16 °C with a change to 21 °C at 6:00, in a zone that warms by `rate` (K/h) from
    /// the start on. Returns how long before the change it started, and its temperature at the change.
    fn night(start: &mut OptimumStart, rate: f64) -> (f64, f64) {
        let (mut temperature, mut ahead, mut at_change) = (16.0, 0.0, 0.0);
        for step in 0..144 {
            let hours = 6.0 - f64::from(step) * STEP;
            let before = hours > 1e-9;
            let started = start.step(temperature, before.then(|| goal(hours, 21.0)), OUTDOOR, STEP);
            if started && ahead == 0.0 {
                ahead = hours;
            }
            at_change = if before { temperature } else { at_change };
            let warms = started || !before;
            temperature = if warms { (temperature + rate * STEP).min(21.0) } else { temperature };
        }
        (ahead, at_change)
    }

    #[test]
    fn the_first_start_is_at_the_limit_and_the_later_ones_at_the_learned_rate() {
        let mut start = OptimumStart::new(Side::Heating, 3.0);
        let (ahead, _) = night(&mut start, 4.0);
        assert!((ahead - 3.0).abs() < STEP, "5 K at 1.5 K/h, at most 3 h: {ahead}");
        assert!((start.rate(SHARE) - 4.0).abs() < 0.3, "{}", start.rate(SHARE));
        let (ahead, reached) = night(&mut start, 4.0);
        assert!((ahead - 1.19).abs() < 1.5 * STEP, "4.75 K at 4 K/h: {ahead}");
        assert!(reached > 19.9, "a step before the change: {reached}");
    }

    #[test]
    fn the_rate_is_the_mean_of_the_last_three_starts_and_at_least_1_k_per_hour() {
        let mut start = OptimumStart::new(Side::Heating, 3.0);
        for rate in [8.0, 2.0, 2.0, 2.0] {
            night(&mut start, rate);
        }
        assert!((start.rate(SHARE) - 2.0).abs() < 0.2, "the first is forgotten: {}", start.rate(SHARE));
        for _ in 0..3 {
            night(&mut start, 0.1);
        }
        assert_eq!(start.rate(SHARE), 1.0);
    }

    #[test]
    fn a_start_is_earlier_on_a_colder_day() {
        let mut start = OptimumStart::new(Side::Heating, 3.0);
        night(&mut start, 4.0);
        // 3.75 K at 4 K/h with 80 % of the capacity: 0.9 h; with 40 %, 1.9 h.
        assert!(!start.clone().step(17.0, Some(goal(1.5, 21.0)), OUTDOOR, STEP));
        assert!(start.step(17.0, Some(goal(1.5, 21.0)), -9.0, STEP));
    }

    #[test]
    fn a_supervisor_moves_the_start_and_its_goal() {
        let begins = |goal: Goal, temperature| {
            OptimumStart::new(Side::Heating, 3.0).step(temperature, Some(goal), OUTDOOR, STEP)
        };
        // 0.75 K at 1.5 K/h begin 0.5 h ahead.
        assert_eq!([0.4, 0.6].map(|hours| begins(goal(hours, 21.0), 20.0)), [true, false]);
        let earlier = |hours| Goal { earlier: 2.0, ..goal(hours, 21.0) };
        assert_eq!([2.4, 2.6].map(|hours| begins(earlier(hours), 20.0)), [true, false]);
        assert!(begins(Goal { shift: 1.0, ..goal(0.5, 21.0) }, 21.0) && !begins(goal(0.5, 21.0), 21.0));
    }

    #[test]
    fn a_zone_at_its_next_setpoint_is_not_started() {
        for (side, temperature) in [(Side::Heating, 20.8), (Side::Heating, 25.0), (Side::Cooling, 20.0)] {
            let mut start = OptimumStart::new(side, 3.0);
            assert!(!start.step(temperature, Some(goal(STEP, 21.0)), OUTDOOR, STEP));
        }
        let mut start = OptimumStart::new(Side::Cooling, 3.0);
        assert!(start.step(29.0, Some(goal(2.0, 24.0)), OUTDOOR, STEP), "cooling recovers downward");
        assert!(start.step(23.0, Some(goal(1.0, 24.0)), OUTDOOR, STEP), "a start lasts to the change");
    }
}
