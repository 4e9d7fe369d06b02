//! Schedules of learning rates.

use serde::{Deserialize, Serialize};

/// The schedule of a learning rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RateSchedule {
    /// The same rate in all updates.
    #[default]
    Constant,
    /// A rate that falls linearly to 0 at the end of a run.
    Linear,
}

impl RateSchedule {
    /// Returns the factor of the learning rate when this share of a run is done.
    pub fn factor(self, done: f64) -> f64 {
        match self {
            Self::Constant => 1.0,
            Self::Linear => 1.0 - done.clamp(0.0, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_schedule_falls_to_0() {
        assert_eq!([0.0, 0.5, 1.0, 1.2].map(|done| RateSchedule::Linear.factor(done)), [1.0, 0.5, 0.0, 0.0]);
        assert_eq!(RateSchedule::Constant.factor(0.9), 1.0);
    }
}
