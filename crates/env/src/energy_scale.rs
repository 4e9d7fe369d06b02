//! τ_E: the energy that a reward is measured by, shipped as data for every class of buildings.

use std::sync::LazyLock;

use b2b_building::Class;
use serde::Deserialize;

/// Steps an hour that the shipped scales are of.
const STEPS_PER_HOUR: u32 = 12;

/// The energy scale of a class, as `b2b tune` makes it: what its tuned reactive controllers use on training buildings over
/// a winter and a summer week.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnergyScale {
    /// For whom.
    pub class: Class,
    /// Mean HVAC energy of a step of 5 minutes, Wh/m².
    pub energy_scale: f64,
    /// The command that made it.
    pub command: String,
}

static SHIPPED: LazyLock<Vec<EnergyScale>> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../data/energy_scale.json")).expect("a test reads the shipped file")
});

impl EnergyScale {
    /// Every class that was measured.
    pub fn shipped() -> &'static [Self] {
        &SHIPPED
    }

    /// τ_E of a class for steps of which an hour has so many, Wh/m². `None` where it was not measured.
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
    fn shipped_scales_are_energies_of_a_step() {
        for shipped in EnergyScale::shipped() {
            // 0.1 to 1,200 W/m².
            assert!((0.01..100.0).contains(&shipped.energy_scale), "{shipped:?}");
            assert!(shipped.command.starts_with("b2b tune "));
            let half_an_hour = EnergyScale::of(shipped.class, 2).unwrap();
            assert!((half_an_hour / shipped.energy_scale - 6.0).abs() < 1e-12);
        }
        let classes: BTreeSet<_> = EnergyScale::shipped().iter().map(|shipped| shipped.class).collect();
        assert_eq!(classes.len(), EnergyScale::shipped().len(), "one entry a class");
    }
}
