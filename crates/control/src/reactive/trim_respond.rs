//! Trim and respond (ASHRAE Guideline 36, section 5.1.14): a setpoint drifts to where it costs least, and is
//! pushed back as long as the demand is not met.

/// Parameters of a trim-and-respond setpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrimRespond {
    /// Push per hour of unmet demand, K/h.
    pub respond: f64,
    /// Drift back per hour of met demand, K/h.
    pub trim: f64,
    /// Demand, 0 to 1, above which the setpoint responds.
    pub threshold: f64,
}

impl TrimRespond {
    /// How far the setpoint is pushed after a step of so many hours, K, between 0 and `most`.
    pub(super) fn step(&self, push: f64, demand: f64, hours: f64, most: f64) -> f64 {
        let change = if demand > self.threshold { self.respond } else { -self.trim };
        (push + change * hours).clamp(0.0, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_setpoint_is_pushed_while_demand_is_high_and_drifts_back_after() {
        let rule = TrimRespond { respond: 6.0, trim: 3.0, threshold: 0.5 };
        let pushed = rule.step(0.0, 0.9, 1.0, 10.0);
        assert_eq!(pushed, 6.0);
        assert_eq!(rule.step(pushed, 0.9, 1.0, 10.0), 10.0);
        assert_eq!(rule.step(pushed, 0.1, 1.0, 10.0), 3.0);
    }
}
