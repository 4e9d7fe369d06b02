//! Exploration noise.

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::limits::require;

/// The exploration noise of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct NoiseConfig {
    /// Correlation of the exploration noise between consecutive steps, 0 to less than 1.
    pub noise_correlation: f32,
    /// Whether environments come in pairs with the same episodes and opposite exploration noise, and each advantage
    /// becomes half its difference from the partner's. With an odd number of environments, the last one is unpaired.
    pub mirrored_noise: bool,
    /// Largest ratio of the comfort penalty with exploration noise to the penalty without it. The initial noise is the
    /// most that, on average over the environments' first day, keeps within this ratio, or adds at most a tenth to the
    /// whole penalty. Without `credit_by_zone`, the whole penalty counts as comfort. 0: the learner's own initial
    /// noise, such as `ppo.initial_log_std`.
    pub noise_cost: f64,
    /// Exploration noise at the end of the run, as a share of the initial noise. It falls exponentially in between, so
    /// that the agent ends up good without noise. 1: the noise is learned like the other parameters.
    pub final_noise: f64,
}

impl Default for NoiseConfig {
    fn default() -> Self {
        Self { noise_correlation: 0.0, mirrored_noise: false, noise_cost: 0.0, final_noise: 1.0 }
    }
}

impl NoiseConfig {
    /// Checks the values.
    pub(super) fn check(&self) -> Result<()> {
        let Self { noise_correlation, noise_cost, final_noise, .. } = *self;
        require((0.0..1.0).contains(&noise_correlation), || {
            format!("`noise_correlation` is {noise_correlation}; expected 0 to less than 1")
        })?;
        require(noise_cost == 0.0 || (noise_cost > 1.0 && noise_cost.is_finite()), || {
            format!("`noise_cost` is {noise_cost}; expected more than 1, or 0 for none")
        })?;
        require(final_noise > 0.0 && final_noise <= 1.0, || {
            format!("`final_noise` is {final_noise}; expected more than 0, at most 1")
        })
    }
}
