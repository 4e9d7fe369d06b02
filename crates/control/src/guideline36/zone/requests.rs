//! Requests of a zone for colder supply air (Guideline 36, 5.6.8.1) and their suppression after a change of its
//! setpoint (5.1.20).
//!
//! The guideline's delays of 2 min are shorter than a step of 5 min: a condition counts once it is observed.

/// Temperatures above the cooling setpoint that send two and three requests, K.
const URGENT: [f64; 2] = [2.0, 3.0];
/// Outputs of the cooling loop at which the single request starts and ends.
const LOOP: [f64; 2] = [0.95, 0.85];
/// Suppression per kelvin between the zone and its new setpoint, h: 9 min.
const SUPPRESSION: f64 = 9.0 / 60.0;
/// Longest suppression, h: 30 min.
const LONGEST_SUPPRESSION: f64 = 0.5;
/// Remaining suppression that counts as over, h.
const NOW: f64 = 1e-6;
/// Change of the setpoint that suppresses requests, K.
const CHANGE: f64 = 0.1;

/// Requests of a zone for colder supply air.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct CoolingRequests {
    /// Whether the loop is high.
    high: bool,
    setpoint: Option<f64>,
    /// Remaining suppression, h.
    suppressed: f64,
    count: f64,
}

impl CoolingRequests {
    /// Returns the number of requests, 0 to 3, at a temperature and a cooling setpoint (°C) and an output of the
    /// cooling loop.
    pub(in super::super) fn step(&mut self, temperature: f64, setpoint: f64, output: f64, hours: f64) -> f64 {
        let excess = temperature - setpoint;
        self.suppressed -= hours;
        let last = self.setpoint.replace(setpoint);
        if last.is_some_and(|last| (setpoint - last).abs() > CHANGE) {
            self.suppressed = (SUPPRESSION * excess.abs()).min(LONGEST_SUPPRESSION);
        }
        let listens = self.suppressed <= NOW;
        self.high = output > LOOP[usize::from(self.high)];
        self.count = match excess {
            excess if listens && excess > URGENT[1] => 3.0,
            excess if listens && excess > URGENT[0] => 2.0,
            _ => f64::from(u8::from(self.high)),
        };
        self.count
    }

    /// Returns the requests of the last step.
    pub(in super::super) fn count(&self) -> f64 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1.0 / 12.0;

    #[test]
    fn a_zone_sends_three_requests_above_3_k_two_above_2_k_whatever_its_loop() {
        let mut requests = CoolingRequests::default();
        let counts = [27.1, 26.9, 26.1, 25.9].map(|temperature| requests.step(temperature, 24.0, 0.0, STEP));
        assert_eq!(counts, [3.0, 2.0, 2.0, 0.0]);
    }

    #[test]
    fn a_zone_sends_one_request_above_95_percent_until_below_85_percent() {
        let mut requests = CoolingRequests::default();
        let counts = [0.94, 0.96, 0.86, 0.84, 0.94].map(|output| requests.step(24.5, 24.0, output, STEP));
        assert_eq!(counts, [0.0, 1.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn requests_by_temperature_are_suppressed_for_9_minutes_per_kelvin_and_at_most_30() {
        let steps_until_urgent = |temperature: f64| {
            let mut requests = CoolingRequests::default();
            requests.step(temperature, 29.0, 0.0, STEP);
            (1..20).find(|_| requests.step(temperature, 22.0, 0.0, STEP) > 1.0).unwrap()
        };
        // 2.5 K: 22.5 min after the change, in the fifth step after it. 6 K: 30 min, although 54.
        assert_eq!([steps_until_urgent(24.5), steps_until_urgent(28.0)], [6, 7]);
    }
}
