//! Sun, sky and air of each hour of a morphed year.

use super::months::{HOURS, PASSES};
use crate::sun;

/// Maximum clearness index: a dry, high, clear sky.
const CLEAREST: f64 = 0.82;
/// Extraterrestrial irradiation below which the clearness of an hour is not meaningful, Wh/m².
const LOW_SUN: f64 = 30.0;
/// Stefan-Boltzmann constant, W/m²K⁴.
const STEFAN_BOLTZMANN: f64 = 5.6697e-8;

/// Scales pressures to another elevation, m, by the standard atmosphere (ASHRAE Fundamentals, psychrometrics).
pub(super) fn at_elevation(pressures: &[f64], from: f64, to: f64) -> Vec<f64> {
    let standard = |elevation: f64| libm::pow(1.0 - 2.25577e-5 * elevation, 5.2559);
    let ratio = standard(to) / standard(from);
    pressures.iter().map(|pressure| pressure * ratio).collect()
}

pub(super) fn suns(place: sun::Position) -> Vec<sun::Sun> {
    (0..HOURS as u32).map(|hour| sun::Sun::over(place, hour / 24 + 1, hour % 24 + 1)).collect()
}

/// Clearness index of each hour: global over extraterrestrial irradiation; the whole day's when the sun is low or down.
pub(super) fn clearness(global: &[f64], suns: &[sun::Sun]) -> Vec<f64> {
    let of_day = |day: usize| {
        let hours = day * 24..(day + 1) * 24;
        let outside: f64 = suns[hours.clone()].iter().map(sun::Sun::horizontal).sum();
        global[hours].iter().sum::<f64>() / outside
    };
    let of_hour = |hour: usize| match suns[hour].horizontal() {
        outside if outside > LOW_SUN => global[hour] / outside,
        _ => of_day(hour / 24),
    };
    (0..global.len()).map(of_hour).collect()
}

/// Global horizontal irradiation of a month that sums to `target`, within the maximum clearness index.
pub(super) fn with_total(clearness: &[f64], suns: &[sun::Sun], target: f64) -> Vec<f64> {
    let hours = |scale: f64| {
        let pairs = clearness.iter().zip(suns);
        pairs.map(|(k, sun)| (scale * k).min(CLEAREST) * sun.horizontal()).collect::<Vec<f64>>()
    };
    let mut scale = 1.0;
    for _ in 0..PASSES {
        scale *= target / hours(scale).iter().sum::<f64>();
    }
    hours(scale)
}

/// Direct normal and diffuse horizontal irradiation, Wh/m².
pub(super) fn split(global: f64, sun: sun::Sun) -> (f64, f64) {
    let outside = sun.horizontal();
    if outside <= 0.0 {
        return (0.0, 0.0);
    }
    let diffuse = global * sun::diffuse_fraction(global / outside);
    ((global - diffuse) / sun.cosine, diffuse)
}

/// Relative humidity, % (Magnus, coefficients of Alduchov and Eskridge 1996).
pub(super) fn humidity(dry_bulb: f64, dew_point: f64) -> f64 {
    let exponent = |t: f64| 17.625 * t / (243.04 + t);
    (100.0 * libm::exp(exponent(dew_point) - exponent(dry_bulb))).clamp(0.0, 100.0)
}

/// Long-wave radiation of the sky on a horizontal surface, W/m² (Clark and Allen 1978, Walton 1983, as EnergyPlus).
pub(super) fn sky_radiation(dry_bulb: f64, dew_point: f64, cover: f64) -> f64 {
    let clear = 0.787 + 0.764 * libm::log((dew_point + 273.15) / 273.0);
    let cloud = 1.0 + cover * (0.0224 + cover * (-0.0035 + cover * 0.00028));
    let kelvin = dry_bulb + 273.15;
    clear * cloud * STEFAN_BOLTZMANN * kelvin * kelvin * kelvin * kelvin
}
