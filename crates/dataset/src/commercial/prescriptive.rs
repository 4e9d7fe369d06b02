//! Prescriptive envelope requirements by climate zone.

use crate::{Error, Result};

/// W/m²K in one Btu/h·ft²·°F.
pub(super) const SI_PER_IP: f64 = 5.678_263;

/// Prescriptive maxima of ASHRAE 90.1 for non-residential spaces in one climate zone, and the limit of the
/// generator on infiltration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prescriptive {
    /// U-factor of fixed windows, W/m²K.
    pub window_u: f64,
    /// Solar heat gain coefficient of windows.
    pub window_shgc: f64,
    /// U-factor of steel-framed walls, W/m²K.
    pub wall_u: f64,
    /// U-factor of roofs with insulation above the deck, W/m²K.
    pub roof_u: f64,
    /// Maximum multiplier of infiltration.
    pub infiltration: f64,
}

/// Zones 1 to 8: window U, SHGC, wall U, roof U (IP units as published) and highest infiltration multiplier. ASHRAE
/// 90.1-2022 tables 5.5-1 to 5.5-8 and the paper's appendix on dataset generation.
const TABLE: [[f64; 5]; 8] = [
    [0.50, 0.23, 0.124, 0.048, 2.0],
    [0.45, 0.25, 0.084, 0.039, 2.0],
    [0.42, 0.25, 0.077, 0.039, 2.0],
    [0.36, 0.36, 0.064, 0.032, 1.5],
    [0.36, 0.38, 0.055, 0.032, 1.5],
    [0.34, 0.38, 0.049, 0.032, 1.2],
    [0.29, 0.40, 0.049, 0.028, 1.2],
    [0.26, 0.40, 0.037, 0.028, 1.2],
];

impl Prescriptive {
    /// Returns the requirements in a climate zone, for example `5B` or `7`.
    ///
    /// # Errors
    /// [`Error::ClimateZone`] when it is outside 1A to 8, or without a letter below 7: economizers depend on it.
    pub fn of(ashrae_zone: &str) -> Result<Self> {
        let row = thermal_zone(ashrae_zone).and_then(|zone| TABLE.get(zone.checked_sub(1)?));
        let &[window_u, window_shgc, wall_u, roof_u, infiltration] =
            row.ok_or_else(|| Error::ClimateZone { zone: ashrae_zone.to_owned() })?;
        Ok(Self {
            window_u: window_u * SI_PER_IP,
            window_shgc,
            wall_u: wall_u * SI_PER_IP,
            roof_u: roof_u * SI_PER_IP,
            infiltration,
        })
    }
}

/// The thermal part of a climate zone: 5 of `5B`.
fn thermal_zone(ashrae_zone: &str) -> Option<usize> {
    let (digit, moisture) = ashrae_zone.split_at_checked(1)?;
    let zone = digit.parse().ok()?;
    let known = match moisture {
        "" => zone >= 7,
        letter => ["A", "B", "C"].contains(&letter),
    };
    known.then_some(zone)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zone_is_known_by_its_digit_and_in_si_units() {
        let denver = Prescriptive::of("5B").unwrap();
        assert!((denver.window_u - 2.044).abs() < 1e-3);
        assert_eq!(denver, Prescriptive::of("5A").unwrap());
        assert_eq!(Prescriptive::of("8").unwrap().infiltration, 1.2);
    }

    #[test]
    fn an_unknown_zone_is_rejected_by_name() {
        for zone in ["", "0A", "2", "9", "5D", "B5", "Ω"] {
            let error = Prescriptive::of(zone).unwrap_err().to_string();
            assert!(error.contains(&format!("`{zone}`")), "{error}");
        }
    }

    #[test]
    fn requirements_for_walls_and_roofs_increase_with_cold() {
        for pair in TABLE.windows(2) {
            assert!(pair[1][2] <= pair[0][2] && pair[1][3] <= pair[0][3]);
        }
    }
}
