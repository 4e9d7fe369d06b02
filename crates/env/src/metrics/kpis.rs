//! Key performance indicators of operation, as BOPTEST defines them, in its units.

use serde::{Deserialize, Serialize};

use crate::reward::ZoneStep;

/// Averaging time of the peak demand, h.
const DEMAND_HOURS: f64 = 0.25;
/// Tolerance on sums of hours.
const EPSILON: f64 = 1e-9;

/// Sums over an episode that only the indicators need. Discomfort is integrated with the trapezoid rule over each step,
/// during which the band is constant, from the start of the episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Kpis {
    /// Discomfort, K h, summed over the zones.
    discomfort: f64,
    /// Temperatures of the zones at the end of the last step, °C.
    temperatures: Vec<f64>,
    /// Demands of electricity, of gas and other fuels, and of district heat.
    demands: [Demand; 3],
    /// Air quality, in a task with the CO₂ balance.
    #[serde(default)]
    air: Option<AirQuality>,
}

/// CO₂ above a limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct AirQuality {
    /// ppm.
    limit: f64,
    /// ppm h above the limit, summed over the zones.
    above: f64,
    /// Concentrations of the zones at the end of the last step, ppm.
    concentrations: Vec<f64>,
}

/// The largest mean demand over a quarter of an hour. The energy of a step is spread evenly over its quarters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Demand {
    /// Wh/m² since the quarter began.
    energy: f64,
    /// Hours since the quarter began.
    hours: f64,
    /// W/m².
    peak: f64,
}

impl Kpis {
    /// Begins an episode with the temperatures of the zones.
    pub fn begin(temperatures: Vec<f64>) -> Self {
        Self { temperatures, ..Self::default() }
    }

    /// Starts counting CO₂ above a limit, ppm, from the zones' present concentrations, ppm.
    #[must_use]
    pub fn with_carbon_dioxide(self, limit: f64, concentrations: Vec<f64>) -> Self {
        Self { air: Some(AirQuality { limit, above: 0.0, concentrations }), ..self }
    }

    /// Adds a step: the zones at its end, and electricity, gas with other fuels, and district heat, Wh/m².
    pub fn add(&mut self, zones: &[ZoneStep], energy: [f64; 3], hours: f64) {
        for (zone, last) in zones.iter().zip(&mut self.temperatures) {
            let before = ZoneStep { temperature: *last, ..*zone };
            self.discomfort += 0.5 * (before.deviation().abs() + zone.deviation().abs()) * hours;
            *last = zone.temperature;
        }
        if let Some(air) = &mut self.air {
            air.add(zones, hours);
        }
        for (demand, energy) in self.demands.iter_mut().zip(energy) {
            demand.add(energy, hours);
        }
    }

    /// Returns the discomfort, K h per zone, for a number of zones.
    pub fn discomfort(&self, zones: usize) -> f64 {
        self.discomfort / zones.max(1) as f64
    }

    /// Returns the CO₂ above the limit, ppm h per zone, for a number of zones; `None` without the CO₂ balance.
    pub fn bad_air(&self, zones: usize) -> Option<f64> {
        Some(self.air.as_ref()?.above / zones.max(1) as f64)
    }

    /// Returns the peak demand of electricity (0), gas and other fuels (1) or district heat (2), kW/m²; `None` if none
    /// was used.
    pub fn peak(&self, carrier: usize) -> Option<f64> {
        let peak = self.demands[carrier].peak;
        (peak > 0.0).then_some(peak / 1000.0)
    }
}

impl AirQuality {
    fn add(&mut self, zones: &[ZoneStep], hours: f64) {
        let above = |concentration: f64| (concentration - self.limit).max(0.0);
        let now = zones.iter().filter_map(|zone| zone.carbon_dioxide);
        for (last, now) in self.concentrations.iter_mut().zip(now) {
            self.above += 0.5 * (above(*last) + above(now)) * hours;
            *last = now;
        }
    }
}

impl Demand {
    fn add(&mut self, energy: f64, hours: f64) {
        let mut left = hours;
        while left > EPSILON {
            let room = DEMAND_HOURS - self.hours;
            let part = if left <= room + EPSILON { left } else { room };
            self.energy += if part == hours { energy } else { energy * part / hours };
            self.hours += part;
            left -= part;
            if self.hours >= DEMAND_HOURS - EPSILON {
                self.peak = self.peak.max(self.energy / self.hours);
                (self.energy, self.hours) = (0.0, 0.0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setpoints::band::Pair;

    fn zone(temperature: f64) -> ZoneStep {
        let pair = Pair { heating: 21.0, cooling: 24.0 };
        ZoneStep { pair, ..ZoneStep::with_target(temperature, 22.5, true, true) }
    }

    #[test]
    fn discomfort_is_the_integral_by_trapezoids() {
        let mut kpis = Kpis::begin(vec![21.0, 22.0]);
        for temperature in [20.0, 19.0, 22.0] {
            kpis.add(&[zone(temperature), zone(22.0)], [0.0; 3], 0.5);
        }
        // 0 → 1 → 2 → 0 K in three half hours, in one of two zones.
        assert!((kpis.discomfort(2) - (0.5 + 1.5 + 1.0) * 0.5 / 2.0).abs() < 1e-12);
    }

    #[test]
    fn bad_air_is_the_integral_above_the_limit() {
        let mut kpis = Kpis::begin(vec![22.0]).with_carbon_dioxide(900.0, vec![400.0]);
        for concentration in [1000.0, 1200.0, 800.0] {
            kpis.add(&[ZoneStep { carbon_dioxide: Some(concentration), ..zone(22.0) }], [0.0; 3], 0.5);
        }
        // 0 → 100 → 300 → 0 ppm in three half hours.
        assert!((kpis.bad_air(1).unwrap() - (50.0 + 200.0 + 150.0) * 0.5).abs() < 1e-9);
        assert_eq!(Kpis::begin(Vec::new()).bad_air(1), None);
    }

    #[test]
    fn peak_demand_is_a_mean_over_a_quarter_of_an_hour() {
        let mut kpis = Kpis::begin(Vec::new());
        for energy in [1.0, 4.0, 1.0, 2.0, 2.0, 2.5] {
            kpis.add(&[], [energy, 0.0, 0.0], 1.0 / 12.0);
        }
        // The second quarter has 6.5 Wh/m², the first 6.
        assert!((kpis.peak(0).unwrap() - 6.5 / 0.25 / 1000.0).abs() < 1e-12);
        assert_eq!(kpis.peak(1), None);
        // Half of the second step of 10 min is in the first quarter.
        let mut kpis = Kpis::begin(Vec::new());
        for energy in [6.0, 12.0, 0.0] {
            kpis.add(&[], [energy, 0.0, 0.0], 1.0 / 6.0);
        }
        assert!((kpis.peak(0).unwrap() - (6.0 + 6.0) / 0.25 / 1000.0).abs() < 1e-12);
        let mut kpis = Kpis::begin(Vec::new());
        kpis.add(&[], [20.0, 0.0, 0.0], 1.0);
        assert_eq!(kpis.peak(0), Some(0.02));
    }
}
