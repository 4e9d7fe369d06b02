//! A proportional-integral loop.

/// Gains of a PI loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// Proportional, 1/K.
    pub proportional: f64,
    /// Integral, 1/(K h).
    pub integral: f64,
}

/// A PI loop whose output stays in bounds, and whose integral does not wind up beyond them.
#[derive(Clone, Debug)]
pub(super) struct Pi {
    gains: Gains,
    low: f64,
    high: f64,
    /// Length of a step, h.
    hours: f64,
    integral: f64,
}

impl Pi {
    pub(super) fn new(gains: Gains, low: f64, high: f64, hours: f64) -> Self {
        Self { gains, low, high, hours, integral: 0.0 }
    }

    pub(super) fn reset(&mut self) {
        self.integral = 0.0;
    }

    /// The output for an error, K.
    pub(super) fn step(&mut self, error: f64) -> f64 {
        let proportional = self.gains.proportional * error;
        let integral = self.integral + self.gains.integral * error * self.hours;
        let output = proportional + integral;
        // Integrate only where it moves the output, or moves it back into bounds.
        let winds_up = (output > self.high && error > 0.0) || (output < self.low && error < 0.0);
        if !winds_up {
            self.integral = integral.clamp(self.low, self.high);
        }
        (proportional + self.integral).clamp(self.low, self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_held_at_its_bound_comes_back_as_soon_as_the_error_turns() {
        let gains = Gains { proportional: 0.2, integral: 1.0 };
        let mut pi = Pi::new(gains, -1.0, 1.0, 1.0 / 12.0);
        for _ in 0..1000 {
            assert!(pi.step(10.0) <= 1.0);
        }
        let back = (0..20).position(|_| pi.step(-1.0) < 0.9);
        assert!(back.is_some_and(|steps| steps <= 2), "{back:?}");
    }
}
