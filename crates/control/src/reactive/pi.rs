//! A proportional-integral loop.

use serde::{Deserialize, Serialize};

/// Gains of a PI loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gains {
    /// Proportional gain, 1/K; 0 to 10.
    pub proportional: f64,
    /// Integral gain, 1/(K h); 0 to 100.
    pub integral: f64,
}

/// A PI loop with bounded output and anti-windup, whose integral term is reset when the target jumps.
#[derive(Clone, Debug)]
pub(super) struct Pi {
    gains: Gains,
    low: f64,
    high: f64,
    /// Time step, h.
    hours: f64,
    /// Change of the target within a step that resets the integral term, K.
    jump: f64,
    integral: f64,
    target: Option<f64>,
}

impl Pi {
    pub(super) fn new(gains: Gains, [low, high]: [f64; 2], hours: f64, jump: f64) -> Self {
        Self { gains, low, high, hours, jump, integral: 0.0, target: None }
    }

    pub(super) fn reset(&mut self) {
        self.integral = 0.0;
        self.target = None;
    }

    /// Returns the output for an error from a target, K. A jump of the target resets the integral term: it reflects the
    /// load at the previous target.
    pub(super) fn step(&mut self, error: f64, target: f64) -> f64 {
        let before = self.target.replace(target);
        if before.is_some_and(|before| (target - before).abs() >= self.jump) {
            self.integral = 0.0;
        }
        let proportional = self.gains.proportional * error;
        let integral = self.integral + self.gains.integral * error * self.hours;
        let output = proportional + integral;
        // Integrates only while the output is within bounds or returns to them.
        let winds_up = (output > self.high && error > 0.0) || (output < self.low && error < 0.0);
        if !winds_up {
            self.integral = integral.clamp(self.low, self.high);
        }
        (proportional + self.integral).clamp(self.low, self.high)
    }

    /// Sets the integral term to an output imposed from outside.
    pub(super) fn hold(&mut self, output: f64) {
        self.integral = output;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAINS: Gains = Gains { proportional: 0.2, integral: 1.0 };

    #[test]
    fn a_saturated_loop_recovers_as_soon_as_the_error_changes_sign() {
        let mut pi = Pi::new(GAINS, [-1.0, 1.0], 1.0 / 12.0, 0.5);
        for _ in 0..1000 {
            assert!(pi.step(10.0, 21.0) <= 1.0);
        }
        let back = (0..20).position(|_| pi.step(-1.0, 21.0) < 0.9);
        assert!(back.is_some_and(|steps| steps <= 2), "{back:?}");
    }

    #[test]
    fn a_jump_of_the_target_resets_the_integral_and_a_drift_does_not() {
        let mut pi = Pi::new(GAINS, [-1.0, 1.0], 1.0 / 12.0, 0.5);
        for _ in 0..100 {
            pi.step(0.5, 21.0);
        }
        assert!(pi.step(0.0, 21.3) > 0.8, "a drift of 0.3 K");
        assert_eq!(pi.step(0.0, 18.0), 0.0);
    }
}
