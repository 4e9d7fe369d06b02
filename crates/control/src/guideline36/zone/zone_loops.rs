//! The heating and the cooling loop of a zone (Guideline 36, 5.3.4 and 5.1.9): two proportional-integral loops, of
//! which at most one is on.

use serde::{Deserialize, Serialize};

use super::super::points::{Setpoints, Side};
use super::hunting::Hunting;

/// The integral term waits while a zone, at its present rate, reaches its setpoint within this time, h. After a change
/// of the setpoint by several kelvins, an integral term that grew for an hour would overshoot.
const ARRIVAL: f64 = 0.5;

/// Time in which the integral term of a loop that the mode turned off fades by a factor of e, h: a zone that is empty
/// for an hour has about the load that it had before.
const MEMORY: f64 = 1.0;

/// Gains of the loops.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoopGains {
    /// Proportional gain, 1/K; 0.001 to 10.
    pub proportional: f64,
    /// Integral time, s; 60 to 100,000.
    pub integral_time: f64,
}

impl LoopGains {
    /// The integral time of the Modelica Buildings Library, s.
    const INTEGRAL_TIME: f64 = 900.0;
    /// Gains of a unit of a single zone. The proportional gain of the Modelica Buildings Library, 0.1 per kelvin,
    /// leaves a zone outside its band for an hour after people come; this one is in the middle of the range in which
    /// the paper's loops are stable, at steps of 5 min, in buildings of all types.
    pub const UNIT: Self = Self { proportional: 0.25, integral_time: Self::INTEGRAL_TIME };
    /// Gains of a terminal of an air loop, likewise.
    pub const TERMINAL: Self = Self { proportional: 0.5, integral_time: Self::INTEGRAL_TIME };

    /// Returns the gains with at most this proportional gain, 1/K.
    pub(in super::super) fn at_most(self, proportional: f64) -> Self {
        Self { proportional: self.proportional.min(proportional), ..self }
    }
}

/// The range of a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Reach {
    /// Capacity with idle coils over the full capacity, at most 0: how far outdoor air takes the zone to the other
    /// side. An output of 0 stands for it, an output of 1 for the full capacity.
    pub(in super::super) idle: f64,
    /// Largest output; at 0 the loop is off.
    pub(in super::super) limit: f64,
}

impl Reach {
    /// A loop whose output of 0 has no effect on the zone.
    pub(in super::super) fn up_to(limit: f64) -> Self {
        Self { idle: 0.0, limit }
    }
}

/// A loop from 0 to 1.
#[derive(Clone, Copy, Debug)]
struct Loop {
    side: Side,
    enabled: bool,
    integral: f64,
    /// Distance outside the setpoint in the last step, K.
    error: f64,
    /// Capacity with idle coils over the full capacity, at most 0.
    idle: f64,
    output: f64,
}

impl Loop {
    const fn new(side: Side) -> Self {
        Self { side, enabled: false, integral: 0.0, error: 0.0, idle: 0.0, output: 0.0 }
    }

    /// Enables the loop outside its setpoint; disables it inside, once its output has been 0 for a step.
    fn step(&mut self, gains: LoopGains, error: f64, reach: Reach, hours: f64) -> f64 {
        let Reach { idle, limit } = reach;
        if error > 0.0 {
            self.enabled = true;
        } else if self.enabled && self.output <= 0.0 {
            self.stop();
        }
        if !self.enabled {
            self.rest(hours);
            return 0.0;
        }
        // The supply air stays as it is while outdoor air opens or gets colder.
        self.integral = (self.integral + self.idle - idle).max(0.0);
        self.idle = idle;
        let (span, proportional) = (1.0 - idle, gains.proportional * error);
        let arrives = (self.error - error) * ARRIVAL > error * hours;
        self.error = error;
        let change = proportional * hours * 3600.0 / gains.integral_time;
        // Integrates only as far as the output has room.
        self.integral += match change > 0.0 {
            true if arrives => 0.0,
            true => change.min((limit * span - proportional - self.integral).max(0.0)),
            false => change.max(-self.integral),
        };
        self.output = ((proportional + self.integral) / span).clamp(0.0, limit);
        self.output
    }

    /// Turns the loop off for a step, and lets its integral term fade.
    fn rest(&mut self, hours: f64) {
        let integral = self.integral / (1.0 + hours / MEMORY);
        *self = Self { integral, idle: self.idle, ..Self::new(self.side) };
    }

    /// Turns the loop off and forgets its integral term.
    fn stop(&mut self) {
        *self = Self::new(self.side);
    }
}

/// Outputs of the loops of a zone, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in super::super) struct Outputs {
    pub(in super::super) heating: f64,
    pub(in super::super) cooling: f64,
}

/// The loops of a zone.
#[derive(Clone, Debug)]
pub(in super::super) struct ZoneLoops {
    /// Gains of heating and of cooling.
    gains: [LoopGains; 2],
    hunting: Hunting,
    heating: Loop,
    cooling: Loop,
}

impl ZoneLoops {
    pub(in super::super) fn new(gains: [LoopGains; 2]) -> Self {
        let [heating, cooling] = Side::BOTH.map(Loop::new);
        Self { gains, hunting: Hunting::new(), heating, cooling }
    }

    /// Forgets the integral term of the heating loop.
    pub(in super::super) fn forget_heating(&mut self) {
        self.heating.stop();
    }

    /// Returns the outputs for a temperature, °C, each within its reach. A loop without a setpoint is off. If both
    /// loops are on, the one whose side the zone has left is stopped.
    pub(in super::super) fn step(
        &mut self,
        temperature: f64,
        setpoints: Setpoints,
        reaches: [Reach; 2],
        occupied: bool,
        hours: f64,
    ) -> Outputs {
        let share = self.hunting.step(temperature, occupied);
        let gains = self.gains.map(|gains| gains.at_most(share * gains.proportional));
        let side = |own: &mut Loop, reach: Reach| {
            let gains = gains[own.side as usize];
            let setpoint = setpoints.of(own.side);
            if reach.limit <= 0.0 || !setpoint.is_finite() {
                own.rest(hours);
                return 0.0;
            }
            own.step(gains, own.side.gap(temperature, setpoint), reach, hours)
        };
        let [heating, cooling] = reaches;
        let mut outputs =
            Outputs { heating: side(&mut self.heating, heating), cooling: side(&mut self.cooling, cooling) };
        if outputs.heating > 0.0 && outputs.cooling > 0.0 {
            let heats = temperature < setpoints.heating;
            let leaving = if heats { &mut self.cooling } else { &mut self.heating };
            leaving.stop();
            *(if heats { &mut outputs.cooling } else { &mut outputs.heating }) = 0.0;
        }
        outputs
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::tests::room::Room;
    use super::*;

    const STEP: f64 = 1.0 / 12.0;
    const BAND: Setpoints = Setpoints { heating: 21.0, cooling: 24.0 };
    const ON: [Reach; 2] = [Reach { idle: 0.0, limit: 1.0 }; 2];
    const OFF: [Reach; 2] = [Reach { idle: 0.0, limit: 0.0 }; 2];

    #[test]
    fn a_step_of_5_minutes_adds_a_third_of_the_proportional_part_unless_the_zone_is_on_its_way() {
        let mut loops = ZoneLoops::new([LoopGains { proportional: 0.1, integral_time: 900.0 }; 2]);
        let outputs = [20.0, 20.0, 20.5].map(|temperature| loops.step(temperature, BAND, ON, true, STEP));
        let third = 0.1 / 3.0;
        for (output, expected) in outputs.iter().zip([0.1 + third, 0.1 + 2.0 * third, 0.05 + 2.0 * third]) {
            assert!((output.heating - expected).abs() < 1e-12, "{outputs:?}");
            assert_eq!(output.cooling, 0.0);
        }
    }

    #[test]
    fn a_loop_is_off_between_the_setpoints_and_without_a_setpoint() {
        let mut loops = ZoneLoops::new([LoopGains::UNIT; 2]);
        for temperature in [21.1, 22.5, 23.9] {
            assert_eq!(loops.step(temperature, BAND, ON, true, STEP), Outputs::default());
        }
        let heater = Setpoints { heating: 21.0, cooling: f64::INFINITY };
        assert_eq!(loops.step(40.0, heater, ON, true, STEP), Outputs::default());
        assert_eq!(loops.step(10.0, BAND, OFF, true, STEP), Outputs::default());
    }

    #[test]
    fn a_saturated_loop_leaves_saturation_as_soon_as_the_error_shrinks() {
        let mut loops = ZoneLoops::new([LoopGains::UNIT; 2]);
        for _ in 0..1000 {
            assert!(loops.step(12.0, BAND, ON, true, STEP).heating <= 1.0);
        }
        let steps = (0..20).position(|_| loops.step(21.5, BAND, ON, true, STEP).heating < 0.9);
        assert!(steps.is_some_and(|steps| steps <= 2), "{steps:?}");
        assert!(loops.step(21.5, BAND, ON, true, STEP).heating < 0.9);
    }

    #[test]
    fn the_supply_air_stays_as_it_is_when_outdoor_air_opens() {
        let mut loops = ZoneLoops::new([LoopGains::UNIT; 2]);
        let reach = |idle| [Reach { idle, limit: 1.0 }, Reach::up_to(1.0)];
        for _ in 0..10 {
            loops.step(20.5, BAND, reach(0.0), true, STEP);
        }
        let before = loops.step(21.0, BAND, reach(0.0), true, STEP).heating;
        let open = loops.step(21.0, BAND, reach(-0.5), true, STEP).heating;
        // From -0.5 to 1, the same capacity is a larger output.
        assert!((-0.5 + 1.5 * open - before).abs() < 1e-12, "{before} {open}");
        assert_eq!(
            loops.step(15.0, BAND, reach(-0.5), true, STEP).heating,
            1.0,
            "full capacity is an output of 1"
        );
    }

    #[test]
    fn a_loop_that_rests_for_an_hour_resumes_with_part_of_its_output() {
        let mut loops = ZoneLoops::new([LoopGains::UNIT; 2]);
        for _ in 0..20 {
            loops.step(20.5, BAND, ON, true, STEP);
        }
        let before = loops.step(21.0, BAND, ON, true, STEP).heating;
        for _ in 0..12 {
            assert_eq!(loops.step(20.0, BAND, OFF, true, STEP).heating, 0.0);
        }
        let after = loops.step(20.9999, BAND, ON, true, STEP).heating;
        assert!((0.3..0.5).contains(&(after / before)), "{before} {after}");
        assert!(
            loops.step(15.0, BAND, [Reach::up_to(0.6), Reach::up_to(1.0)], true, STEP).heating == 0.6,
            "the limit holds"
        );
    }

    #[test]
    fn a_heater_that_is_too_large_for_its_gain_stops_hunting() {
        let mut room = Room::new(19.0);
        room.soak(-15.0);
        let mut loops = ZoneLoops::new([LoopGains { proportional: 2.0, integral_time: 900.0 }; 2]);
        let mut swing = |steps: usize| {
            let air: Vec<f64> = (0..steps)
                .map(|_| {
                    let outputs = loops.step(room.air, BAND, ON, true, STEP);
                    room.step(-15.0, 20_000.0 * outputs.heating, STEP);
                    room.air
                })
                .collect();
            air.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
        };
        assert!(swing(12) > 1.0, "it does not hunt, and this test shows nothing");
        swing(60);
        let still = swing(12);
        assert!(still <= 0.25, "it still swings by {still} K");
    }

    #[test]
    fn a_room_settles_at_the_setpoint_without_hunting() {
        for (outdoor, setpoint) in [(-15.0, 21.0), (5.0, 21.0), (35.0, 24.0)] {
            let mut room = Room::new(22.5);
            room.soak(outdoor);
            let mut loops = ZoneLoops::new([LoopGains::UNIT; 2]);
            let mut last: Vec<f64> = Vec::new();
            for step in 0..288 {
                let outputs = loops.step(room.air, BAND, ON, true, STEP);
                room.step(outdoor, 8000.0 * (outputs.heating - outputs.cooling), STEP);
                if step >= 216 {
                    last.push(room.air);
                }
            }
            let (low, high) =
                last.iter().fold((f64::MAX, f64::MIN), |(low, high), &t| (low.min(t), high.max(t)));
            assert!(high - low < 0.2, "at {outdoor} °C it swings from {low} to {high}");
            assert!((last[0] - setpoint).abs() < 0.3, "at {outdoor} °C it holds {}", last[0]);
        }
    }
}
