//! What an agent is asked to do.

use serde::{Deserialize, Serialize};

/// A comfort-energy task: a target temperature and what energy is worth against it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Target of every controlled zone, °C.
    pub target: f64,
    /// Weight w_E of the energy term (paper, eq. 1).
    pub energy_weight: f64,
    /// Energy scale τ_E, Wh/m² a step: what energy is divided by before it is weighted.
    pub energy_scale: f64,
    /// How zones that cannot be cooled are judged.
    pub heating_only_zones: HeatingOnlyZones,
}

/// How zones with heating and no cooling enter the reward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeatingOnlyZones {
    /// They count below target only: a warehouse at 35 °C in summer has no cooling to blame.
    #[default]
    BelowTarget,
    /// They count on both sides, as the paper has it.
    BothSides,
}

impl Default for Task {
    /// 21 °C, energy not counted.
    fn default() -> Self {
        Self {
            target: 21.0,
            energy_weight: 0.0,
            energy_scale: 1.0,
            heating_only_zones: HeatingOnlyZones::BelowTarget,
        }
    }
}
