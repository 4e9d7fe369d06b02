//! The cost scale of the operation rewards, shipped as data for every class of buildings.

use std::sync::LazyLock;

use b2b_building::Class;
use serde::{Deserialize, Serialize};

/// Cost of an hour in a building whose class was not measured, currency/m²: a round figure near the mean of all
/// classes.
const TYPICAL: f64 = 9e-4;

/// The cost scale of a class, measured by `b2b tune operation`: the mean cost of the guideline controller in training
/// buildings of the class at constant prices, over the five two-week periods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostScale {
    /// Class of buildings.
    pub class: Class,
    /// Mean cost of an hour, currency/m².
    pub cost_scale: f64,
    /// Ids of the training buildings.
    pub buildings: Vec<String>,
}

static SHIPPED: LazyLock<Vec<CostScale>> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../../data/cost_scale.json")).expect("a test reads the shipped file")
});

impl CostScale {
    /// Returns the scales of all measured classes.
    pub fn shipped() -> &'static [Self] {
        &SHIPPED
    }

    /// Returns the mean cost of a step at `steps_per_hour` in a building of a class, currency/m²: a typical one if the
    /// class is unknown or has not been measured.
    pub fn of(class: Option<Class>, steps_per_hour: u32) -> f64 {
        let shipped = class.and_then(|class| SHIPPED.iter().find(|shipped| shipped.class == class));
        shipped.map_or(TYPICAL, |shipped| shipped.cost_scale) / f64::from(steps_per_hour)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn shipped_scales_are_plausible_costs_of_an_hour() {
        for shipped in CostScale::shipped() {
            // 1 to 100 W/m² at 0.04 to 0.2 per kWh.
            assert!((4e-5..2e-2).contains(&shipped.cost_scale), "{shipped:?}");
            let step = CostScale::of(Some(shipped.class), 12);
            assert!((12.0 * step / shipped.cost_scale - 1.0).abs() < 1e-12);
            assert!(!shipped.buildings.is_empty());
        }
        let classes: BTreeSet<_> = CostScale::shipped().iter().map(|shipped| shipped.class).collect();
        assert_eq!(classes.len(), CostScale::shipped().len(), "one entry per class");
    }

    #[test]
    fn a_building_of_no_class_has_a_typical_scale() {
        assert_eq!(CostScale::of(None, 12), TYPICAL / 12.0);
    }
}
