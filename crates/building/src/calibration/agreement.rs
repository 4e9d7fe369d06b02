//! Agreement of a simulation with metered energy.

use serde::{Deserialize, Serialize};

/// Number of parameters that Guideline 14 subtracts from the number of months, for calibrated simulations.
const ADJUSTMENT: f64 = 1.0;
/// Limit of the coefficient of variation for monthly data, %.
const MAX_CV_RMSE: f64 = 15.0;
/// Limit of the absolute bias for monthly data, %.
const MAX_NMBE: f64 = 5.0;

/// Statistics of ASHRAE Guideline 14 with their limits for monthly data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// Coefficient of variation of the root mean square error, %: `√(Σ(m - s)² / (n - p)) / mean(m)` with p = 1.
    pub cv_rmse_percent: f64,
    /// Normalized mean bias error, %: `Σ(m - s) / ((n - p) mean(m))` with p = 1; positive if the simulation is too low.
    pub nmbe_percent: f64,
    /// Whether both are within the limits: 15 % and ±5 %.
    pub meets_guideline_14: bool,
}

impl Agreement {
    /// Compares metered and simulated energy of the same months, at least two.
    pub fn of(metered: &[f64], simulated: &[f64]) -> Self {
        let months = metered.len() as f64;
        let mean = metered.iter().sum::<f64>() / months;
        let errors = || metered.iter().zip(simulated).map(|(metered, simulated)| metered - simulated);
        let square: f64 = errors().map(|error| error * error).sum();
        let cv_rmse_percent = 100.0 * (square / (months - ADJUSTMENT)).sqrt() / mean;
        let nmbe_percent = 100.0 * errors().sum::<f64>() / ((months - ADJUSTMENT) * mean);
        let meets_guideline_14 = cv_rmse_percent <= MAX_CV_RMSE && nmbe_percent.abs() <= MAX_NMBE;
        Self { cv_rmse_percent, nmbe_percent, meets_guideline_14 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_statistics_match_the_guideline() {
        let agreement = Agreement::of(&[100.0, 200.0, 300.0], &[110.0, 190.0, 270.0]);
        // √((10² + 10² + 30²) / 2) / 200 and (-10 + 10 + 30) / (2 · 200).
        assert!((agreement.cv_rmse_percent - 100.0 * 550.0_f64.sqrt() / 200.0).abs() < 1e-12);
        assert!((agreement.nmbe_percent - 7.5).abs() < 1e-12);
        assert!(!agreement.meets_guideline_14);
        assert!(Agreement::of(&[100.0, 200.0, 300.0], &[101.0, 198.0, 303.0]).meets_guideline_14);
    }
}
