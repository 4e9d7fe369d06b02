//! The scale of a policy's actions.

use b2b_env::ActionSpace;
use serde::{Deserialize, Serialize};

/// The scale of a policy's actions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ActionScale {
    /// From -1 for the lower to 1 for the upper bound of an actuator; values beyond are clipped.
    #[default]
    Rescaled,
    /// Physical units; the environment clamps values out of bounds and counts them.
    Physical,
}

impl ActionScale {
    /// Converts an action of the policy to physical units, in place.
    pub(super) fn to_physical(self, space: &ActionSpace, action: &mut [f64]) {
        if self == Self::Rescaled {
            clip(action);
            space.rescale(action);
        }
    }
}

fn clip(action: &mut [f64]) {
    action.iter_mut().for_each(|value| *value = value.clamp(-1.0, 1.0));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_beyond_one_are_clipped_and_nan_stays_nan() {
        let mut action = [-7.0, -1.0, 0.25, 1.0, 7.0, f64::NAN];
        clip(&mut action);
        assert_eq!(action[..5], [-1.0, -1.0, 0.25, 1.0, 1.0]);
        assert!(action[5].is_nan(), "the environment rejects it by name");
    }
}
