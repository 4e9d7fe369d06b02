//! Densities of Gaussian and squashed Gaussian actions, one dimension at a time.

use b2b_agent::network::tanh;

/// ½ ln 2π.
pub const HALF_LOG_TAU: f32 = 0.918_938_5;

/// Returns the logarithm of the density of an action.
pub fn log_density(action: f32, mean: f32, log_std: f32) -> f32 {
    let normal = (action - mean) * (-log_std).exp();
    -0.5 * normal * normal - log_std - HALF_LOG_TAU
}

/// Returns the derivatives of [`log_density`] with respect to mean and logarithm of the standard deviation.
pub fn log_density_gradient(action: f32, mean: f32, log_std: f32) -> (f32, f32) {
    let inverse = (-log_std).exp();
    let normal = (action - mean) * inverse;
    (normal * inverse, normal * normal - 1.0)
}

/// Returns the differential entropy, ½ + ½ ln 2π + ln σ.
pub fn entropy(log_std: f32) -> f32 {
    0.5 + HALF_LOG_TAU + log_std
}

/// A squashed action and the logarithm of its density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Squashed {
    /// The action, between -1 and 1.
    pub action: f32,
    /// Logarithm of its density.
    pub log_density: f32,
}

/// Returns tanh(mean + σ × normal) and its log density (Haarnoja et al. 2018, appendix C, eq. 21).
///
/// ln(1 - tanh² u) is computed as 2 (ln 2 - |u| - softplus(-2 |u|)), which stays finite far from 0.
pub fn squash(mean: f32, log_std: f32, normal: f32) -> Squashed {
    let value = mean + log_std.exp() * normal;
    let size = value.abs();
    let log_slope = 2.0 * (std::f32::consts::LN_2 - size - (-2.0 * size).exp().ln_1p());
    let log_density = -0.5 * normal * normal - log_std - HALF_LOG_TAU - log_slope;
    Squashed { action: tanh(value), log_density }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_match_the_definition() {
        let density = |x: f64, mean: f64, std: f64| {
            (-(x - mean).powi(2) / (2.0 * std * std)).exp() / (std * std::f64::consts::TAU.sqrt())
        };
        let found = f64::from(log_density(0.7, -0.2, -0.5));
        assert!((found - density(0.7, -0.2, (-0.5f64).exp()).ln()).abs() < 1e-6);
        for normal in [-2.5, 0.0, 0.4, 3.0] {
            let squashed = squash(0.3, -0.2, normal as f32);
            let value: f64 = 0.3 + (-0.2f64).exp() * normal;
            let expected = density(value, 0.3, (-0.2f64).exp()).ln() - (1.0 - value.tanh().powi(2)).ln();
            assert!((f64::from(squashed.log_density) - expected).abs() < 1e-5, "{squashed:?} {expected}");
        }
        assert!(squash(30.0, 2.0, 3.0).log_density.is_finite());
    }
}
