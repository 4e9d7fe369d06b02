//! The energy scale τ_E of rewards, shipped as data for every class of buildings.

use std::sync::LazyLock;

use b2b_building::Class;
use serde::Deserialize;

/// Steps per hour of the shipped scales.
const STEPS_PER_HOUR: u32 = 12;

/// The energy scale of a class, as measured by `b2b tune`: mean HVAC energy of its tuned reactive controllers on
/// training buildings with targets by occupancy, over three days each of winter and summer (`01-08..01-10` and
/// `07-09..07-11`).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnergyScale {
    /// Class of buildings.
    pub class: Class,
    /// Mean HVAC energy of a 5-minute step, Wh/m².
    pub energy_scale: f64,
    /// Command that reproduces the value.
    pub command: String,
}

static SHIPPED: LazyLock<Vec<EnergyScale>> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../../data/energy_scale.json")).expect("a test reads the shipped file")
});

impl EnergyScale {
    /// Returns the scales of all measured classes.
    pub fn shipped() -> &'static [Self] {
        &SHIPPED
    }

    /// Returns τ_E of a class at `steps_per_hour`, Wh/m². `None` if the class has not been measured.
    pub fn of(class: Class, steps_per_hour: u32) -> Option<f64> {
        let shipped = SHIPPED.iter().find(|shipped| shipped.class == class)?;
        Some(shipped.energy_scale * f64::from(STEPS_PER_HOUR) / f64::from(steps_per_hour))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn shipped_scales_are_plausible_step_energies() {
        for shipped in EnergyScale::shipped() {
            // 0.1 to 1,200 W/m².
            assert!((0.01..100.0).contains(&shipped.energy_scale), "{shipped:?}");
            assert!(shipped.command.starts_with("b2b tune "));
            let half_an_hour = EnergyScale::of(shipped.class, 2).unwrap();
            assert!((half_an_hour / shipped.energy_scale - 6.0).abs() < 1e-12);
        }
        let classes: BTreeSet<_> = EnergyScale::shipped().iter().map(|shipped| shipped.class).collect();
        assert_eq!(classes.len(), EnergyScale::shipped().len(), "one entry per class");
    }
}
