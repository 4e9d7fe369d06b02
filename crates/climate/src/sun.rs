//! Sun position and diffuse fraction, with the same bits on every machine.

use std::f64::consts::PI;

/// Solar constant, W/m².
const SOLAR_CONSTANT: f64 = 1367.0;
/// Samples per hour over which the solar altitude is averaged: every 5 minutes.
const SAMPLES: u32 = 12;

/// A place on earth and its clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct Position {
    /// Degrees north.
    pub latitude: f64,
    /// Degrees east.
    pub longitude: f64,
    /// Hours ahead of UTC.
    pub time_zone: f64,
}

/// The sun over one hour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sun {
    /// Extraterrestrial normal irradiance, W/m².
    pub extraterrestrial: f64,
    /// Mean cosine of the zenith angle, 0 at night.
    pub cosine: f64,
}

impl Sun {
    /// The sun over the hour that ends at `hour` (1 to 24), standard time, of a day of the year from 1.
    pub fn over(place: Position, day_of_year: u32, hour: u32) -> Self {
        let day = Day::of(place, day_of_year);
        let sample = |i| f64::from(hour - 1) + (f64::from(i) + 0.5) / f64::from(SAMPLES);
        let cosines = (0..SAMPLES).map(|i| day.cosine(sample(i)).max(0.0));
        Self { extraterrestrial: day.extraterrestrial, cosine: cosines.sum::<f64>() / f64::from(SAMPLES) }
    }

    /// Returns the extraterrestrial horizontal irradiation of the hour, Wh/m².
    pub fn horizontal(&self) -> f64 {
        self.extraterrestrial * self.cosine
    }
}

/// Diffuse fraction of global horizontal irradiance by clearness index (Erbs, Klein and Duffie 1982).
pub(super) fn diffuse_fraction(k: f64) -> f64 {
    if k <= 0.22 {
        1.0 - 0.09 * k
    } else if k <= 0.8 {
        0.9511 + k * (-0.1604 + k * (4.388 + k * (-16.638 + k * 12.336)))
    } else {
        0.165
    }
}

fn day_angle(day_of_year: u32) -> f64 {
    2.0 * PI * (f64::from(day_of_year) - 1.0) / 365.0
}

/// Squared ratio of mean to actual distance of the sun (Spencer 1971, as the next two).
fn eccentricity(angle: f64) -> f64 {
    let [s1, c1, s2, c2, ..] = harmonics(angle);
    1.00011 + 0.034221 * c1 + 0.00128 * s1 + 0.000719 * c2 + 0.000077 * s2
}

/// Radians.
fn declination(angle: f64) -> f64 {
    let [s1, c1, s2, c2, s3, c3] = harmonics(angle);
    0.006918 - 0.399912 * c1 + 0.070257 * s1 - 0.006758 * c2 + 0.000907 * s2 - 0.002697 * c3 + 0.00148 * s3
}

/// Equation of time, h.
fn equation_of_time(angle: f64) -> f64 {
    let [s1, c1, s2, c2, ..] = harmonics(angle);
    let minutes = 229.18 * (0.000075 + 0.001868 * c1 - 0.032077 * s1 - 0.014615 * c2 - 0.04089 * s2);
    minutes / 60.0
}

fn harmonics(angle: f64) -> [f64; 6] {
    let [a, b, c] = [1.0, 2.0, 3.0].map(|n| libm::sincos(n * angle));
    [a.0, a.1, b.0, b.1, c.0, c.1]
}

/// The solar geometry of a day.
struct Day {
    /// Sine of latitude times sine of declination, and cosine times cosine.
    sines: f64,
    cosines: f64,
    /// Standard time of solar noon, h.
    noon: f64,
    extraterrestrial: f64,
}

impl Day {
    fn of(place: Position, day_of_year: u32) -> Self {
        let angle = day_angle(day_of_year);
        let (sin_l, cos_l) = libm::sincos(place.latitude.to_radians());
        let (sin_d, cos_d) = libm::sincos(declination(angle));
        Self {
            sines: sin_l * sin_d,
            cosines: cos_l * cos_d,
            noon: 12.0 - place.longitude / 15.0 + place.time_zone - equation_of_time(angle),
            extraterrestrial: SOLAR_CONSTANT * eccentricity(angle),
        }
    }

    /// Cosine of the zenith angle at a standard time, h; negative at night.
    fn cosine(&self, hour: f64) -> f64 {
        self.sines + self.cosines * libm::cos((hour - self.noon) * PI / 12.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MONTREAL: Position = Position { latitude: 45.47, longitude: -73.75, time_zone: -5.0 };

    #[test]
    fn the_noon_altitude_at_the_solstices_is_known() {
        // 90° − latitude + declination, at the solstices, when declination is ±23.44°.
        for (day, declination) in [(172, 23.44f64), (355, -23.44)] {
            let noon = Day::of(MONTREAL, day).cosine(12.0 - 0.1);
            let expected = (45.47 - declination).to_radians().cos();
            assert!((noon - expected).abs() < 0.003, "{noon} {expected}");
        }
    }

    #[test]
    fn the_night_has_no_sun() {
        assert_eq!(Sun::over(MONTREAL, 10, 1).horizontal(), 0.0);
        assert!(Sun::over(MONTREAL, 172, 12).horizontal() > 1150.0);
    }

    #[test]
    fn erbs_is_continuous() {
        for k in [0.22, 0.8] {
            assert!((diffuse_fraction(k - 1e-9) - diffuse_fraction(k + 1e-9)).abs() < 0.005);
        }
    }
}
