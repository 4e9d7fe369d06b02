//! Detection of sustained oscillation of a zone, which indicates a limit cycle.

/// Minimum change of the air temperature between turning points that counts as a swing, K: the desirable accuracy of an
/// air temperature sensor in ISO 7726:1998 (table 2, class C, comfort). A thermometer does not show smaller cycles.
const SWING: f64 = 0.2;

/// Longest swing of an oscillation, h. Daily and occupancy cycles are slower.
const LONGEST: f64 = 1.0;

/// Number of consecutive swings in a sustained oscillation: the number of load disturbances within the supervision time
/// in Hägglund (*A control-loop performance monitor*, Control Engineering Practice 3(11), 1995).
const SUSTAINED: u32 = 10;

/// Detects sustained oscillation of the air temperature of a zone, step by step.
///
/// A *swing* goes from one turning point of the temperature to the next, at least [`SWING`] apart; smaller reversals
/// within it do not count. [`SUSTAINED`] consecutive swings, each within [`LONGEST`], under the same target, are a
/// sustained oscillation. All of its steps from the first turning point on count. Hägglund counts zero crossings of the
/// control error instead; turning points also reveal cycles that are not centered on the target.
#[derive(Clone, Debug, Default)]
pub(crate) struct Oscillation {
    /// Steps since the target changed.
    age: usize,
    target: f64,
    /// Lowest and highest temperature since the last turning point, and their ages.
    low: Extreme,
    high: Extreme,
    /// Direction of the current swing; `None` before the first turning point.
    rises: Option<bool>,
    /// Age of the turning point at the start of the current swing.
    began: usize,
    /// Consecutive swings within [`LONGEST`].
    swings: u32,
    /// Their steps, not yet counted.
    steps_of_swings: usize,
}

/// An extreme of the temperature.
#[derive(Clone, Copy, Debug, Default)]
struct Extreme {
    temperature: f64,
    age: usize,
}

impl Oscillation {
    /// Adds the temperature at the end of a step, °C, and the target of the step. Returns the number of steps newly
    /// found to be in sustained oscillation: at the end of a swing its steps, or all steps of the first ten swings;
    /// otherwise 0.
    pub(crate) fn add(&mut self, temperature: f64, target: f64, hours_per_step: f64) -> usize {
        if self.age == 0 || target != self.target {
            *self = Self { target, ..Self::default() };
        }
        let now = Extreme { temperature, age: self.age };
        self.age += 1;
        if now.age == 0 || temperature < self.low.temperature {
            self.low = now;
        }
        if now.age == 0 || temperature > self.high.temperature {
            self.high = now;
        }
        // The turning point confirmed by this step, if any.
        let turn = match self.rises {
            None | Some(false) if temperature - self.low.temperature >= SWING => Some(self.low),
            None | Some(true) if self.high.temperature - temperature >= SWING => Some(self.high),
            _ => None,
        };
        let Some(turn) = turn else { return 0 };
        let steps = self.turn(turn, hours_per_step);
        self.rises = Some(turn.temperature < temperature);
        (self.low, self.high) = (now, now);
        steps
    }

    /// Ends the current swing at a turning point and begins the next. Returns the number of steps newly found to be in
    /// oscillation.
    fn turn(&mut self, turn: Extreme, hours_per_step: f64) -> usize {
        if self.rises.is_some() {
            let steps = turn.age - self.began;
            if steps as f64 * hours_per_step <= LONGEST {
                self.swings += 1;
                self.steps_of_swings += steps;
            } else {
                (self.swings, self.steps_of_swings) = (0, 0);
            }
        }
        self.began = turn.age;
        if self.swings >= SUSTAINED { std::mem::take(&mut self.steps_of_swings) } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const STEP: f64 = 1.0 / 12.0;

    /// Returns the share of a day in sustained oscillation, with the temperature as a function of the hour.
    fn share(temperature: impl Fn(f64) -> f64, target: impl Fn(f64) -> f64) -> f64 {
        let mut oscillation = Oscillation::default();
        let hours = (0..288).map(|step| f64::from(step) * STEP);
        let steps: usize = hours.map(|hour| oscillation.add(temperature(hour), target(hour), STEP)).sum();
        steps as f64 / 288.0
    }

    fn wave(period: f64, amplitude: f64) -> impl Fn(f64) -> f64 {
        move |hour| 21.0 + amplitude * (TAU * hour / period).sin()
    }

    #[test]
    fn a_half_hour_cycle_counts_from_first_to_last_turn_even_off_target() {
        for target in [21.0, 23.0] {
            let share = share(wave(0.5, 0.5), |_| target);
            assert!((0.95..=1.0).contains(&share), "{share}");
        }
    }

    #[test]
    fn small_slow_short_or_target_following_swings_do_not_count() {
        assert_eq!(share(wave(0.5, 0.09), |_| 21.0), 0.0, "within the accuracy of a thermometer");
        assert_eq!(share(wave(24.0, 3.0), |_| 21.0), 0.0, "the rhythm of the day");
        assert_eq!(share(wave(3.0, 1.0), |_| 21.0), 0.0, "slower than an hour from turn to turn");
        let short = |hour: f64| if hour < 2.0 { wave(0.5, 0.5)(hour) } else { 21.0 };
        assert_eq!(share(short, |_| 21.0), 0.0, "eight swings");
        assert_eq!(share(wave(0.5, 0.5), |hour| hour.floor()), 0.0, "another target every hour");
    }

    #[test]
    fn an_oscillation_counts_until_it_stops() {
        let half = |hour: f64| if hour < 12.0 { wave(0.5, 0.5)(hour) } else { 21.0 };
        let share = share(half, |_| 21.0);
        assert!((0.45..=0.5).contains(&share), "{share}");
    }

    #[test]
    fn noise_hides_a_cycle_only_by_its_own_amplitude() {
        let noisy = |hour: f64| wave(1.0, 0.5)(hour) + 0.04 * (1000.0 * hour).sin();
        let share = share(noisy, |_| 21.0);
        assert!(share > 0.9, "{share}");
    }
}
