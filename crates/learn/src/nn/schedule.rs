//! Schedules of learning rates.

use serde::{Deserialize, Serialize};

/// The schedule of a learning rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RateSchedule {
    /// The same rate in all updates.
    #[default]
    Constant,
    /// A rate that falls linearly to 0 after this number of updates.
    Linear {
        /// Number of updates.
        updates: u64,
    },
}

impl RateSchedule {
    /// Returns the factor of the learning rate after this number of updates.
    pub fn factor(self, done: u64) -> f64 {
        match self {
            Self::Constant => 1.0,
            Self::Linear { updates } => 1.0 - done.min(updates) as f64 / updates.max(1) as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_schedule_falls_to_0() {
        let schedule = RateSchedule::Linear { updates: 10 };
        assert_eq!([0, 5, 10, 12].map(|done| schedule.factor(done)), [1.0, 0.5, 0.0, 0.0]);
        assert_eq!(RateSchedule::Constant.factor(99), 1.0);
    }
}
