//! Errors of weather forecasts: the autoregressive models of BOPTEST with its parameters
//! (`forecast/forecast_uncertainty_params.json` of ibpsa/project1-boptest, retrieved 2026).

use b2b_base::random::{standard_normal, stream, uniform};
use rand_chacha::ChaCha8Rng;

/// Name of the random streams.
const STREAM: &str = "boptest forecast";
/// Limits of a solar radiation forecast, as shares of the true value.
const SOLAR_SHARES: [f64; 2] = [0.2, 2.0];
/// Radiation above which errors are drawn again while the forecast is outside its limits, W/m².
const SOLAR_CHECKED: f64 = 50.0;
/// Draws of a forecast of radiation; the last is taken as it is.
const SOLAR_DRAWS: usize = 200;

/// The uncertainty of a forecast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Uncertainty {
    /// Small errors.
    Low,
    /// Usual errors.
    Medium,
    /// Large errors.
    High,
}

/// An autoregressive error: the first has a mean and a spread; each later one is a share of the previous plus a mean,
/// with a spread.
#[derive(Clone, Copy)]
struct Model {
    first: [f64; 2],
    share: f64,
    then: [f64; 2],
}

impl Uncertainty {
    /// All levels.
    pub const ALL: [Self; 3] = [Self::Low, Self::Medium, Self::High];

    /// Returns the name in requests.
    pub fn name(self) -> &'static str {
        match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }

    /// Outdoor temperature, K; normal.
    fn temperature(self) -> Model {
        match self {
            Self::Low => Model { first: [0.0, 0.6], share: 0.92, then: [0.0, 0.4] },
            Self::Medium => Model { first: [0.15, 1.2], share: 0.93, then: [0.0, 0.6] },
            Self::High => Model { first: [-0.58, 1.5], share: 0.95, then: [-0.015, 0.7] },
        }
    }

    /// Global horizontal radiation, W/m²; Laplace.
    fn solar(self) -> Model {
        match self {
            Self::Low => Model { first: [4.44, 57.42], share: 0.62, then: [1.86, 45.64] },
            Self::Medium => Model { first: [15.02, 122.6], share: 0.63, then: [4.44, 91.97] },
            Self::High => Model { first: [32.09, 119.94], share: 0.67, then: [10.63, 87.44] },
        }
    }

    /// Subtracts the errors of a forecast made at an hour of the year from hourly outdoor temperatures.
    pub fn disturb_temperatures(self, seed: u64, hour: u64, temperatures: &mut [f64]) {
        let mut random = stream(STREAM, seed, 2 * hour);
        let mut error = Errors::of(self.temperature());
        for temperature in temperatures {
            *temperature -= error.next(|| standard_normal(&mut random));
        }
    }

    /// Subtracts the errors of a forecast made at an hour of the year from hourly radiations. As in BOPTEST, errors are
    /// drawn until the forecast is within its limits, and the forecast is then smoothed over three hours.
    pub fn disturb_radiations(self, seed: u64, hour: u64, radiations: &mut [f64]) {
        let mut random = stream(STREAM, seed, 2 * hour + 1);
        let limits = |radiation: f64| SOLAR_SHARES.map(|share| share * radiation);
        let is_within = |(forecast, radiation): (&f64, &f64)| {
            let [least, most] = limits(*radiation);
            *radiation <= SOLAR_CHECKED || (least..=most).contains(forecast)
        };
        let mut forecast = vec![0.0; radiations.len()];
        for _ in 0..SOLAR_DRAWS {
            let mut error = Errors::of(self.solar());
            for (forecast, radiation) in forecast.iter_mut().zip(&*radiations) {
                *forecast = radiation - error.next(|| laplace(&mut random));
            }
            if forecast.iter().zip(&*radiations).all(is_within) {
                break;
            }
        }
        for (radiation, forecast) in radiations.iter_mut().zip(smoothed(&forecast)) {
            let [least, most] = limits(*radiation);
            *radiation = forecast.clamp(least, most);
        }
    }
}

/// Returns means over three hours; the first and the last hour stay as they are.
fn smoothed(hourly: &[f64]) -> Vec<f64> {
    let mut means = hourly.to_vec();
    for (mean, around) in means.iter_mut().skip(1).zip(hourly.windows(3)) {
        *mean = around.iter().sum::<f64>() / 3.0;
    }
    means
}

/// The errors of one forecast, in the order of time.
struct Errors {
    model: Model,
    last: Option<f64>,
}

impl Errors {
    fn of(model: Model) -> Self {
        Self { model, last: None }
    }

    fn next(&mut self, mut draw: impl FnMut() -> f64) -> f64 {
        let Model { first, share, then } = self.model;
        let [mean, spread] = match self.last {
            None => first,
            Some(last) => [last * share + then[0], then[1]],
        };
        *self.last.insert(mean + spread * draw())
    }
}

/// Draws from the Laplace distribution of mean 0 and scale 1.
fn laplace(random: &mut ChaCha8Rng) -> f64 {
    let centered = uniform(random) - 0.5;
    -centered.signum() * libm::log(1.0 - 2.0 * centered.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The deviation of errors of the temperature after some hours.
    fn deviation(level: Uncertainty, hours: usize) -> f64 {
        let squares = (0..4000).map(|hour| {
            let mut temperatures = vec![0.0; hours + 1];
            level.disturb_temperatures(1, hour, &mut temperatures);
            temperatures[hours].powi(2)
        });
        (squares.sum::<f64>() / 4000.0).sqrt()
    }

    #[test]
    fn errors_of_the_temperature_grow_to_the_deviation_of_the_model() {
        assert!((deviation(Uncertainty::Low, 0) - 0.6).abs() < 0.03);
        // spread / sqrt(1 - share²) is 1.02 K.
        assert!((deviation(Uncertainty::Low, 40) - 1.02).abs() < 0.05);
        assert!(deviation(Uncertainty::High, 40) > 1.8);
    }

    #[test]
    fn a_forecast_of_radiation_is_dark_at_night_and_within_its_shares() {
        let mut radiations = vec![0.0, 100.0, 500.0, 800.0, 0.0];
        Uncertainty::High.disturb_radiations(3, 12, &mut radiations);
        assert_eq!((radiations[0], radiations[4]), (0.0, 0.0));
        assert!(radiations[1..4].iter().zip([100.0, 500.0, 800.0]).all(|(value, actual)| {
            (SOLAR_SHARES[0] * actual..=SOLAR_SHARES[1] * actual).contains(value)
        }));
    }

    /// The RMS error and the mean change from hour to hour of forecasts of eight hours at 600 W/m².
    fn solar_errors(level: Uncertainty) -> [f64; 2] {
        let days = (0..500).map(|hour| {
            let mut radiations = [600.0; 8];
            level.disturb_radiations(7, hour, &mut radiations);
            let square = radiations.iter().map(|value| (value - 600.0).powi(2)).sum::<f64>() / 8.0;
            let change = radiations.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f64>() / 7.0;
            [square, change]
        });
        let [squares, changes] = days.fold([0.0; 2], |[a, b], [square, change]| [a + square, b + change]);
        [(squares / 500.0).sqrt(), changes / 500.0]
    }

    #[test]
    fn forecasts_of_radiation_are_smooth_and_their_errors_grow_with_the_level() {
        let [low, medium] = [Uncertainty::Low, Uncertainty::Medium].map(solar_errors);
        assert!(low[0] > 60.0 && medium[0] > 1.3 * low[0], "{low:?} {medium:?}");
        assert!(low[1] < 0.5 * low[0] && medium[1] < 0.5 * medium[0], "{low:?} {medium:?}");
        assert_eq!(smoothed(&[3.0, 0.0, 6.0, 3.0]), [3.0, 3.0, 3.0, 3.0]);
    }

    #[test]
    fn an_error_follows_the_seed_and_the_hour() {
        let of = |seed, hour| {
            let mut temperatures = vec![10.0; 5];
            Uncertainty::Medium.disturb_temperatures(seed, hour, &mut temperatures);
            temperatures
        };
        assert_eq!(of(1, 2), of(1, 2));
        assert!(of(1, 2) != of(2, 2) && of(1, 2) != of(1, 3));
    }
}
