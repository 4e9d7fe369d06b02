//! Trim-and-respond setpoint reset (ASHRAE Guideline 36, section 5.1.14): a setpoint is trimmed toward its most
//! efficient value, and responds to requests of the zones.

use serde::{Deserialize, Serialize};

/// Parameters of a trim-and-respond reset. The guideline's amounts per time step are rates here.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrimRespond {
    /// Respond rate per request (SPres), K/h; 0 to 100.
    pub respond: f64,
    /// Largest number of requests responded to, beyond those ignored; with `respond` it gives the maximum response
    /// (SPres-max); 1 to 100.
    pub max_requests: f64,
    /// Trim rate (SPtrim), K/h, applied when there are no more requests than those ignored; 0 to 100.
    pub trim: f64,
    /// Loop output above which a zone sends requests; 0 to 1.
    pub threshold: f64,
    /// Hysteresis of the threshold: a zone stops sending requests this far below it; 0.1 in Guideline 36, 5.6.8; 0 to
    /// 1.
    pub hysteresis: f64,
    /// Ignored requests (I), so that a single zone does not move the setpoint for all zones; 0 to 100.
    pub ignored_requests: f64,
}

/// Deviations from target at which a zone above the threshold sends two and three requests, K. In Guideline 36
/// (5.6.8.1), a zone sends them after a delay, regardless of its loop output.
const URGENT: [f64; 2] = [2.0, 3.0];

/// Request generator of a zone: whether it is sending requests.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Request(bool);

impl Request {
    /// Returns the number of requests, 0 to 3, for a loop output of 0 to 1 and an error, K, positive where there is
    /// demand.
    pub(super) fn count(&mut self, rule: &TrimRespond, demand: f64, error: f64) -> f64 {
        let threshold = if self.0 { rule.threshold - rule.hysteresis } else { rule.threshold };
        self.0 = demand > threshold.max(0.0);
        match error {
            _ if !self.0 => 0.0,
            error if error > URGENT[1] => 3.0,
            error if error > URGENT[0] => 2.0,
            _ => 1.0,
        }
    }
}

impl TrimRespond {
    /// Returns the reset of the setpoint after a step, K, between 0 and `max_reset`.
    pub(super) fn step(&self, reset: f64, requests: f64, hours: f64, max_reset: f64) -> f64 {
        let counted = requests - self.ignored_requests;
        let change = if counted > 0.0 { self.respond * counted.min(self.max_requests) } else { -self.trim };
        (reset + change * hours).clamp(0.0, max_reset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: TrimRespond = TrimRespond {
        respond: 6.0,
        max_requests: 1.5,
        trim: 3.0,
        threshold: 0.5,
        hysteresis: 0.1,
        ignored_requests: 0.0,
    };

    #[test]
    fn the_setpoint_responds_to_requests_and_is_trimmed_without_them() {
        let reset = RULE.step(0.0, 1.0, 1.0, 10.0);
        assert_eq!(reset, 6.0);
        assert_eq!(RULE.step(0.0, 2.0, 1.0, 10.0), 9.0, "limited by max_requests");
        assert_eq!(RULE.step(reset, 1.0, 1.0, 10.0), 10.0);
        assert_eq!(RULE.step(reset, 0.0, 1.0, 10.0), 3.0);
        let ignoring = TrimRespond { ignored_requests: 1.0, ..RULE };
        assert_eq!([1.0, 2.0].map(|requests| ignoring.step(3.0, requests, 1.0, 10.0)), [0.0, 9.0]);
    }

    #[test]
    fn requests_have_hysteresis_and_grow_with_the_deviation() {
        let mut request = Request::default();
        let mut count = |demand, error| request.count(&RULE, demand, error);
        assert_eq!(
            [count(0.45, 0.1), count(0.55, 0.1), count(0.45, 0.1), count(0.35, 0.1)],
            [0.0, 1.0, 1.0, 0.0]
        );
        assert_eq!([count(1.0, 2.5), count(1.0, 3.5), count(0.1, 3.5)], [2.0, 3.0, 0.0]);
    }
}
