//! The meaning of an agent's actions.

use b2b_control::{Controller, Reactive, ReactiveParameters};
use b2b_env::{Spaces, rescale, unscale};
use serde::{Deserialize, Serialize};

/// How an agent's actions, each in [-1, 1], drive the actuators.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Acting {
    /// Actuator values: -1 and 1 are the lower and the upper bound.
    Direct,
    /// Corrections to the action of the reactive controllers.
    Residual {
        /// Largest correction, as a share of an actuator's range.
        authority: f64,
    },
}

impl Acting {
    /// Returns a description of the base controller; `None` with direct actions.
    pub fn base(self) -> Option<String> {
        match self {
            Self::Direct => None,
            Self::Residual { authority } => Some(format!("reactive controllers, authority {authority}")),
        }
    }

    /// Returns whether the agent corrects the reactive controllers.
    pub fn has_base(self) -> bool {
        matches!(self, Self::Residual { .. })
    }
}

/// Converts an agent's actions in an episode to physical units.
#[derive(Clone, Debug)]
pub struct Driver {
    acting: Acting,
    low: Vec<f64>,
    high: Vec<f64>,
    base: Option<Reactive>,
    /// The base controller's action, in physical units.
    base_action: Vec<f64>,
    /// The base controller's action, scaled to [-1, 1].
    base_row: Vec<f32>,
    action: Vec<f64>,
}

impl Driver {
    /// Creates the driver for a building. The reactive controllers use the parameters tuned for the building and the
    /// task.
    pub fn new(acting: Acting, spaces: &Spaces) -> Self {
        let base = acting.has_base().then(|| {
            let parameters = ReactiveParameters::tuned_for(&spaces.building, &spaces.episode.task);
            let steps_per_hour = spaces.episode.steps_per_hour;
            Reactive::new(&spaces.building, &spaces.observation, steps_per_hour, &parameters)
        });
        let actuators = spaces.action.len();
        Self {
            acting,
            low: spaces.action.low().to_vec(),
            high: spaces.action.high().to_vec(),
            base,
            base_action: spaces.action.middle(),
            base_row: vec![0.0; actuators],
            action: vec![0.0; actuators],
        }
    }

    /// Begins an episode.
    pub fn reset(&mut self) {
        if let Some(base) = &mut self.base {
            base.reset();
        }
    }

    /// Returns the base controller's action for an observation of the environment, from -1 to 1; zeros without one.
    pub fn base(&mut self, observation: &[f64]) -> &[f32] {
        if let Some(base) = &mut self.base {
            base.act(observation, &mut self.base_action);
            for (index, row) in self.base_row.iter_mut().enumerate() {
                let (low, high) = (self.low[index], self.high[index]);
                let action = self.base_action[index].clamp(low, high);
                self.base_action[index] = action;
                *row = unscale(action, low, high) as f32;
            }
        }
        &self.base_row
    }

    /// Returns the action in physical units for an action of the agent, whose values beyond ±1 are clipped.
    pub fn drive(&mut self, row: &[f32]) -> &[f64] {
        for (index, value) in row.iter().enumerate() {
            let (low, high, value) = (self.low[index], self.high[index], f64::from(value.clamp(-1.0, 1.0)));
            self.action[index] = match self.acting {
                Acting::Direct => rescale(value, low, high),
                Acting::Residual { authority } => {
                    (self.base_action[index] + value * authority * (high - low)).clamp(low, high)
                }
            };
        }
        if let Some(base) = &mut self.base {
            base.follow(&self.action);
        }
        &self.action
    }
}
