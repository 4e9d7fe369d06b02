//! Trim and respond (ASHRAE Guideline 36, section 5.1.14): a setpoint drifts to where it costs least, and is
//! pushed back as long as zones ask for it.

use serde::{Deserialize, Serialize};

/// Parameters of a trim-and-respond setpoint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrimRespond {
    /// Push per request and hour, K/h; 0 to 100.
    pub respond: f64,
    /// Requests beyond which more of them push no faster; 1 to 100.
    pub most_requests: f64,
    /// Drift back per hour without requests, K/h; 0 to 100.
    pub trim: f64,
    /// Demand above which a zone asks; 0 to 1.
    pub threshold: f64,
    /// How far demand falls below the threshold before the zone stops asking; 0.1 in Guideline 36, 5.6.8; 0 to 1.
    pub release: f64,
    /// Requests that are not heard, so that one zone alone does not move all others; 0 to 100.
    pub ignored: f64,
}

/// Deviations from target at which a zone asks twice and three times, K (Guideline 36, 5.6.8.1).
const URGENT: [f64; 2] = [2.0, 3.0];

/// What a zone asks of the system that serves it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Request(bool);

impl Request {
    /// How often it asks, 0 to 3, at a demand of 0 to 1 that an error (K, positive where there is demand) has led to.
    pub(super) fn count(&mut self, rule: &TrimRespond, demand: f64, error: f64) -> f64 {
        let threshold = if self.0 { rule.threshold - rule.release } else { rule.threshold };
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
    /// How far the setpoint is pushed after a step of so many hours with so many requests, K, between 0 and `most`.
    pub(super) fn step(&self, push: f64, requests: f64, hours: f64, most: f64) -> f64 {
        let heard = requests - self.ignored;
        let change = if heard > 0.0 { self.respond * heard.min(self.most_requests) } else { -self.trim };
        (push + change * hours).clamp(0.0, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: TrimRespond = TrimRespond {
        respond: 6.0,
        most_requests: 1.5,
        trim: 3.0,
        threshold: 0.5,
        release: 0.1,
        ignored: 0.0,
    };

    #[test]
    fn the_setpoint_is_pushed_while_zones_ask_and_drifts_back_after() {
        let pushed = RULE.step(0.0, 1.0, 1.0, 10.0);
        assert_eq!(pushed, 6.0);
        assert_eq!(RULE.step(0.0, 2.0, 1.0, 10.0), 9.0, "no faster than the most");
        assert_eq!(RULE.step(pushed, 1.0, 1.0, 10.0), 10.0);
        assert_eq!(RULE.step(pushed, 0.0, 1.0, 10.0), 3.0);
        let deaf = TrimRespond { ignored: 1.0, ..RULE };
        assert_eq!([1.0, 2.0].map(|requests| deaf.step(3.0, requests, 1.0, 10.0)), [0.0, 9.0]);
    }

    #[test]
    fn a_zone_asks_until_its_demand_is_well_met_and_more_often_when_it_is_far_off() {
        let mut request = Request::default();
        let mut count = |demand, error| request.count(&RULE, demand, error);
        assert_eq!(
            [count(0.45, 0.1), count(0.55, 0.1), count(0.45, 0.1), count(0.35, 0.1)],
            [0.0, 1.0, 1.0, 0.0]
        );
        assert_eq!([count(1.0, 2.5), count(1.0, 3.5), count(0.1, 3.5)], [2.0, 3.0, 0.0]);
    }
}
