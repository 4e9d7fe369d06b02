//! Temperatures of undisturbed ground.

use std::f64::consts::TAU;

use crate::Result;
use crate::epw::Line;

/// Depth of the ground temperatures at a foundation, m: the middle set of most EPW headers, about the depth of a
/// basement floor.
const DEPTH: f64 = 2.0;
/// Fields of one depth in GROUND TEMPERATURES: depth, conductivity, density, specific heat, 12 months.
const FIELDS: usize = 16;
/// Soil diffusivity that the temperatures in headers assume, m²/day.
const DIFFUSIVITY: f64 = 2.322576e-3 * 24.0;
/// Days of a year.
const DAYS: f64 = 365.0;

/// Returns the monthly temperatures at the depth nearest to 2 m in a header, °C, January first; `None` if it has none.
pub(crate) fn of_header(line: &Line) -> Result<Option<[f64; 12]>> {
    let depths = line.number(1)? as usize;
    let mut nearest = (f64::INFINITY, None);
    for start in (0..depths).map(|depth| 2 + depth * FIELDS) {
        let away = (line.number(start)? - DEPTH).abs();
        if away < nearest.0 {
            nearest = (away, Some(start));
        }
    }
    let Some(start) = nearest.1 else { return Ok(None) };
    let mut months = [0.0; 12];
    for (month, temperature) in months.iter_mut().enumerate() {
        *temperature = line.within(start + 4 + month, 70.0)?;
    }
    Ok(Some(months))
}

/// Returns the monthly temperatures at 2 m under air with these monthly means, °C, January first: the first harmonic of
/// the air, damped and delayed by the soil (Kusuda and Achenbach, 1965).
pub(crate) fn under_air(months: &[f64; 12]) -> [f64; 12] {
    let middle = |month: usize| TAU * (month as f64 + 0.5) / 12.0;
    let mean = months.iter().sum::<f64>() / 12.0;
    let project = |wave: fn(f64) -> f64| {
        months.iter().enumerate().map(|(month, air)| air * wave(middle(month))).sum::<f64>() / 6.0
    };
    let (cosine, sine) = (project(libm::cos), project(libm::sin));
    let depth = DEPTH * (TAU / (2.0 * DAYS * DIFFUSIVITY)).sqrt();
    let damping = libm::exp(-depth);
    std::array::from_fn(|month| {
        let at = middle(month) - depth;
        mean + damping * (cosine * libm::cos(at) + sine * libm::sin(at))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Monthly mean air temperatures of Denver's TMY3 file, °C.
    const AIR: [f64; 12] = [-0.2, 0.9, 4.5, 8.9, 14.4, 20.4, 23.3, 22.4, 17.2, 10.4, 3.6, -0.8];

    #[test]
    fn ground_follows_the_air_later_and_less() {
        let ground = under_air(&AIR);
        let warmest = (0..12).max_by(|a, b| ground[*a].total_cmp(&ground[*b])).unwrap();
        let swing = ground[warmest] - ground.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((7..=9).contains(&warmest), "{ground:?}");
        assert!((0.4..0.7).contains(&(swing / 24.1)), "{swing}");
        assert!((ground.iter().sum::<f64>() - AIR.iter().sum::<f64>()).abs() < 1e-9);
    }
}
