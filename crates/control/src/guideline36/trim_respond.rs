//! Trim and respond (Guideline 36, 5.1.14.3 and 5.1.14.4): a setpoint is trimmed toward its most efficient value, and
//! responds to requests for more.
//!
//! The guideline's amounts per time step of 2 min are rates here, so that they hold for steps of any length.

use serde::{Deserialize, Serialize};

/// Parameters of a reset. A response moves the setpoint down, a trim up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Guideline36Reset {
    /// Time from the start of the device to the first change (Td), h; 0 to 24.
    pub delay: f64,
    /// Ignored requests (I); 0 to 100. The guideline's 2 is for air handlers of tens of zones: with five zones, a hot
    /// one would get no response.
    pub ignored_requests: f64,
    /// Trim (SPtrim), K/h; 0 to 100.
    pub trim: f64,
    /// Response per request beyond the ignored ones (SPres), K/h; 0 to 100.
    pub respond: f64,
    /// Largest response (SPres-max), K/h; 0 to 100.
    pub max_respond: f64,
}

/// Time steps of the guideline in an hour: 2 min each.
const PER_HOUR: f64 = 30.0;

impl Default for Guideline36Reset {
    /// The guideline's reset of the supply air temperature: 10 min, 0.1, 0.2 and 0.6 K every 2 min, with no request
    /// ignored.
    fn default() -> Self {
        Self {
            delay: 10.0 / 60.0,
            ignored_requests: 0.0,
            trim: 0.1 * PER_HOUR,
            respond: 0.2 * PER_HOUR,
            max_respond: 0.6 * PER_HOUR,
        }
    }
}

/// A setpoint under trim and respond.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reset {
    rule: Guideline36Reset,
    /// Lowest and highest setpoint; the highest is the initial one.
    bounds: [f64; 2],
    setpoint: f64,
    /// Time since the start of the device, h.
    running: f64,
}

impl Reset {
    pub(super) fn new(rule: Guideline36Reset, bounds: [f64; 2]) -> Self {
        Self { rule, bounds, setpoint: bounds[1], running: 0.0 }
    }

    /// Returns to the initial setpoint.
    pub(super) fn reset(&mut self) {
        *self = Self::new(self.rule, self.bounds);
    }

    /// Returns the setpoint after a step with a number of requests; the initial one while the device is off.
    pub(super) fn step(&mut self, on: bool, requests: f64, hours: f64) -> f64 {
        if !on {
            self.reset();
            return self.setpoint;
        }
        self.running += hours;
        if self.running > self.rule.delay + 1e-9 {
            let net = requests - self.rule.ignored_requests;
            let rate = if net > 0.0 {
                -(net * self.rule.respond).min(self.rule.max_respond)
            } else {
                self.rule.trim
            };
            self.setpoint = (self.setpoint + rate * hours).clamp(self.bounds[0], self.bounds[1]);
        }
        self.setpoint
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1.0 / 12.0;

    fn after(requests: &[f64]) -> f64 {
        let rule = Guideline36Reset { ignored_requests: 2.0, ..Guideline36Reset::default() };
        let mut reset = Reset::new(rule, [12.0, 18.0]);
        requests.iter().fold(f64::NAN, |_, &requests| reset.step(true, requests, STEP))
    }

    #[test]
    fn two_requests_are_ignored_and_each_further_one_lowers_the_setpoint_by_half_a_kelvin_a_step() {
        // The first two steps are within the delay of 10 min.
        assert_eq!(after(&[9.0, 9.0]), 18.0);
        let changes = [2.0, 3.0, 4.0, 5.0, 9.0].map(|requests| after(&[0.0, 0.0, requests]) - 18.0);
        for (change, expected) in changes.into_iter().zip([0.0, -0.5, -1.0, -1.5, -1.5]) {
            assert!((change - expected).abs() < 1e-9, "{changes:?}");
        }
    }

    #[test]
    fn the_setpoint_is_trimmed_by_a_quarter_kelvin_a_step_within_its_bounds() {
        assert!((after(&[0.0, 0.0, 9.0, 9.0, 0.0]) - 15.25).abs() < 1e-9);
        assert_eq!(after(&[9.0; 20]), 12.0);
        assert_eq!(after(&[0.0; 20]), 18.0);
    }

    #[test]
    fn the_setpoint_is_the_initial_one_while_the_device_is_off() {
        let mut reset = Reset::new(Guideline36Reset::default(), [12.0, 18.0]);
        for _ in 0..20 {
            reset.step(true, 9.0, STEP);
        }
        assert_eq!(reset.step(false, 9.0, STEP), 18.0);
        assert_eq!(reset.step(true, 9.0, STEP), 18.0, "the delay counts from the start");
    }
}
