//! Control of a zone through its thermostat: the target lies between the heating and the cooling setpoint.

use b2b_building::hvac::Actuator;
use b2b_building::hvac::setpoints::around;
use b2b_env::Target;

/// The setpoints of a zone.
#[derive(Clone, Debug)]
pub(super) struct Setpoints {
    /// Bounds of the heating setpoint, and of the cooling setpoint, if it has one.
    heating: [f64; 2],
    cooling: Option<[f64; 2]>,
    target: Target,
}

impl Setpoints {
    pub(super) fn new(heating: &Actuator, cooling: Option<&Actuator>, target: Target) -> Self {
        let bounds = |actuator: &Actuator| [actuator.low, actuator.high];
        Self { heating: bounds(heating), cooling: cooling.map(bounds), target }
    }

    pub(super) fn act(&self, observation: &[f64], action: &mut [f64]) {
        let target = self.target.of(observation);
        let [low, high] = self.heating;
        let Some([lowest, highest]) = self.cooling else {
            action[0] = target.clamp(low, high);
            return;
        };
        let [heating, cooling] = around(target);
        action[0] = heating.clamp(low, high);
        action[1] = cooling.clamp(lowest, highest);
    }
}
