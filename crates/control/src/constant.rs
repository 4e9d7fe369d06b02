//! A constant action.

use b2b_env::ActionSpace;

use crate::kind::{self, AnyController, Case};
use crate::{Controller, Result};

/// Applies the same action at every step.
#[derive(Clone, Debug)]
pub struct Constant {
    action: Vec<f64>,
}

impl Constant {
    /// Creates a controller that repeats this action.
    pub fn new(action: Vec<f64>) -> Self {
        Self { action }
    }

    /// Creates a controller that repeats the middle of the bounds.
    pub fn middle(space: &ActionSpace) -> Self {
        Self::new(space.middle())
    }
}

impl Controller for Constant {
    fn reset(&mut self) {}

    fn act(&mut self, _observation: &[f64], action: &mut [f64]) {
        action.copy_from_slice(&self.action);
    }
}

/// The kind `constant`.
pub(crate) struct Kind;

impl kind::Kind for Kind {
    fn name(&self) -> &'static str {
        "constant"
    }

    fn help(&self) -> &'static str {
        "middle of every actuator's range"
    }

    fn make(&self, case: &Case<'_>) -> Result<Box<dyn AnyController>> {
        Ok(Box::new(Constant::middle(case.action)))
    }
}
