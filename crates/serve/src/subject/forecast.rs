//! Forecasts: weather, prices, emissions, setpoints and presence ahead of a time.

use b2b_climate::EpwFile;
use b2b_env::{Bands, Spaces};
use b2b_tariff::{Carrier, Emissions, Moment};
use serde_json::{Map, Value, json};

use super::DAYS;
use super::forecast_errors::Uncertainty;
use super::points::Names;
use super::prices::{AllPrices, PriceScenario};
use super::units::ZERO_CELSIUS;
use crate::{Error, Result};

/// Hours of a year.
const HOURS: usize = 24 * DAYS as usize;

/// The quantity that a point forecasts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Quantity {
    OutdoorTemperature,
    Radiation,
    Price(PriceScenario),
    GasPrice,
    Emissions(Carrier),
    /// Of a controlled zone, given its index.
    Lower(usize),
    Upper(usize),
    Presence(usize),
}

/// A forecast point.
#[derive(Clone, Debug)]
struct Point {
    name: String,
    quantity: Quantity,
    unit: &'static str,
    description: String,
}

/// The forecasts of a building.
#[derive(Clone, Debug)]
pub(crate) struct Forecasts {
    points: Vec<Point>,
    bands: Bands,
    /// Emission profile, or the factors of the task by hour of the day: electricity and gas, kg/kWh.
    profile: Option<Emissions>,
    factors: [[f64; 24]; 2],
    /// Outdoor temperature at the end of every hour, °C.
    dry_bulbs: Vec<f64>,
    /// Mean global horizontal radiation of every hour, W/m².
    radiations: Vec<f64>,
}

/// The errors of the weather in a forecast.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct WeatherErrors {
    /// Of the outdoor temperature.
    pub temperature: Option<Uncertainty>,
    /// Of the solar radiation.
    pub solar: Option<Uncertainty>,
    /// Random seed.
    pub seed: u64,
}

impl Forecasts {
    /// Returns the forecasts of a building under a task with bands.
    ///
    /// # Errors
    /// [`Error::NoBands`]; [`Error::Climate`]; [`Error::Env`] for an unknown emission profile.
    pub fn new(spaces: &Spaces) -> Result<Self> {
        let episode = &spaces.episode;
        let task = &episode.task;
        let no_bands = || Error::NoBands { task: task.to_string() };
        let file = EpwFile::open(&episode.weather)?;
        let record = file.record()?;
        let (dry_bulbs, radiations) =
            (record.dry_bulbs(), record.global_radiation_in(episode.period.calendar()));
        let by_hour = |factor: &b2b_env::Hourly| std::array::from_fn(|hour| factor.at(hour as f64));
        Ok(Self {
            points: points(spaces),
            bands: Bands::of(spaces).ok_or_else(no_bands)?,
            profile: task.emission_profile.as_ref().map(|profile| profile.emissions()).transpose()?,
            factors: [by_hour(&task.emissions.electricity), by_hour(&task.emissions.gas)],
            dry_bulbs,
            radiations,
        })
    }

    /// Returns the outdoor temperature at the end of every hour of the year, °C.
    pub fn dry_bulbs(&self) -> &[f64] {
        &self.dry_bulbs
    }

    /// Returns the points with their metadata.
    pub fn payload(&self) -> Value {
        let about = |point: &Point| {
            (point.name.clone(), json!({"Unit": point.unit, "Description": point.description}))
        };
        Value::Object(self.points.iter().map(about).collect())
    }

    /// Returns the names of the points.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.points.iter().map(|point| point.name.as_str())
    }

    /// Returns the values of a point at some times, s of the year, the first of which is now; `None` if there is no
    /// such point. The end of the year is followed by its beginning.
    pub fn values(
        &self,
        name: &str,
        times: &[f64],
        prices: &AllPrices,
        errors: WeatherErrors,
    ) -> Option<Vec<f64>> {
        let point = self.points.iter().find(|point| point.name == name)?;
        let WeatherErrors { temperature, solar, seed } = errors;
        Some(match point.quantity {
            Quantity::OutdoorTemperature => {
                let values = HourlySeries::of(&self.dry_bulbs, times, |hour, values| {
                    temperature.inspect(|level| level.disturb_temperatures(seed, hour, values));
                });
                times.iter().map(|time| values.at(time / 3600.0) + ZERO_CELSIUS).collect()
            }
            Quantity::Radiation => {
                let values = HourlySeries::of(&self.radiations, times, |hour, values| {
                    solar.inspect(|level| level.disturb_radiations(seed, hour, values));
                });
                // The mean of an hour is its value at half past.
                times.iter().map(|time| values.at(time / 3600.0 + 0.5).max(0.0)).collect()
            }
            quantity => times.iter().map(|time| self.scheduled(quantity, moment(*time), prices)).collect(),
        })
    }

    /// Returns the value of a quantity that schedules and tariffs determine.
    fn scheduled(&self, quantity: Quantity, at: Moment, prices: &AllPrices) -> f64 {
        let people = |zone| self.bands.hours_to_people(zone, at.day, at.hour) == Some(0.0);
        let pair = |zone| self.bands.at(zone, at.day, at.hour, people(zone));
        match quantity {
            Quantity::Price(scenario) => prices.of(scenario).electricity(at, 0),
            Quantity::GasPrice => prices.gas(at),
            Quantity::Emissions(fuel) => match &self.profile {
                Some(profile) => profile.at(fuel, at),
                None => self.factors[usize::from(fuel != Carrier::Electricity)][at.hour as usize % 24],
            },
            Quantity::Lower(zone) => pair(zone).heating + ZERO_CELSIUS,
            Quantity::Upper(zone) => pair(zone).cooling + ZERO_CELSIUS,
            Quantity::Presence(zone) => f64::from(u8::from(people(zone))),
            Quantity::OutdoorTemperature | Quantity::Radiation => f64::NAN,
        }
    }
}

/// Returns the forecast points of a building, with BOPTEST's names.
fn points(spaces: &Spaces) -> Vec<Point> {
    let point = |name: &str, quantity, unit, description: &str| Point {
        name: name.to_owned(),
        quantity,
        unit,
        description: description.to_owned(),
    };
    const PRICE: &str = "($/Euro)/kWh";
    const EMITTED: &str = "kgCO2/kWh";
    let mut points = vec![
        point("TDryBul", Quantity::OutdoorTemperature, "K", "Outdoor air temperature"),
        point("HGloHor", Quantity::Radiation, "W/m2", "Global horizontal solar radiation"),
        point("PriceGasPower", Quantity::GasPrice, PRICE, "Price of gas"),
        point(
            "EmissionsElectricPower",
            Quantity::Emissions(Carrier::Electricity),
            EMITTED,
            "CO2 of electricity",
        ),
        point("EmissionsGasPower", Quantity::Emissions(Carrier::Gas), EMITTED, "CO2 of gas"),
    ];
    points.extend(PriceScenario::ALL.map(|scenario| {
        let description = format!("Price of electricity, scenario {}", scenario.name());
        point(scenario.point(), Quantity::Price(scenario), PRICE, &description)
    }));
    let mut names = Names::default();
    for (index, zone) in spaces.controlled_zones().enumerate() {
        let zone = &spaces.building.zones[zone];
        let name = names.unique(&zone.name);
        let mut give = |word: &str, quantity, unit, description: &str| {
            let description = format!("{description} of {}", zone.name);
            points.push(point(&format!("{word}[{name}]"), quantity, unit, &description));
        };
        give("LowerSetp", Quantity::Lower(index), "K", "Heating setpoint");
        if zone.conditioning == b2b_building::Conditioning::HeatingAndCooling {
            give("UpperSetp", Quantity::Upper(index), "K", "Cooling setpoint");
        }
        give("Occupancy", Quantity::Presence(index), "1", "Scheduled occupancy (1 or 0)");
    }
    points
}

/// Returns the moment of a time, s of the year, rounded to the second.
fn moment(time: f64) -> Moment {
    let seconds = time.round();
    let day = (seconds / 86_400.0) as u32;
    Moment { day: day % DAYS + 1, hour: (seconds - 86_400.0 * f64::from(day)) / 3600.0 }
}

/// Hourly values from the hour before a forecast on, each at the end of its hour.
struct HourlySeries {
    /// Time of the first value, hours of the year.
    first: f64,
    values: Vec<f64>,
}

impl HourlySeries {
    /// Returns the values of a year that cover some times, with errors from the hour of the first time on.
    fn of(year: &[f64], times: &[f64], disturb: impl FnOnce(u64, &mut [f64])) -> Self {
        let [now, last] = [times.first(), times.last()].map(|time| time.copied().unwrap_or(0.0) / 3600.0);
        let first = now.floor() - 1.0;
        let count = (last.ceil() - first) as usize + 2;
        let at = |index: usize| (first as i64 + index as i64 - 1).rem_euclid(HOURS as i64) as usize;
        let mut values: Vec<f64> = (0..count).map(|index| year[at(index)]).collect();
        // The first value lies before the forecast.
        disturb(now.floor() as u64, &mut values[1..]);
        Self { first, values }
    }

    /// Returns the value at an hour of the year, by interpolation.
    fn at(&self, hour: f64) -> f64 {
        let place = hour - self.first;
        let index = (place.floor() as usize).min(self.values.len() - 2);
        let share = place - index as f64;
        self.values[index] * (1.0 - share) + self.values[index + 1] * share
    }
}

/// Returns the times of a forecast from now on, s.
pub(crate) fn times(now: f64, horizon: f64, interval: f64) -> Vec<f64> {
    let count = (horizon / interval + 1e-9).floor() as usize + 1;
    (0..count).map(|index| now + index as f64 * interval).collect()
}

/// Returns a payload of series by name.
pub(crate) fn series(named: impl IntoIterator<Item = (String, Vec<f64>)>) -> Value {
    let named = named.into_iter().map(|(name, values)| (name, Value::from(values)));
    Value::Object(named.collect::<Map<_, _>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_hourly_value_is_at_the_end_of_its_hour() {
        let year: Vec<f64> = (1..=HOURS).map(|hour| hour as f64).collect();
        let times = times(3600.0 * 10.25, 7200.0, 900.0);
        let values = HourlySeries::of(&year, &times, |_, _| ());
        assert_eq!(times.len(), 9);
        for time in times {
            assert!((values.at(time / 3600.0) - time / 3600.0).abs() < 1e-9, "{time}");
        }
        let turn = HourlySeries::of(&year, &[3600.0 * 8759.5, 3600.0 * 8761.5], |_, _| ());
        assert_eq!(turn.at(8760.5), 0.5 * (8760.0 + 1.0), "the year begins anew");
    }

    #[test]
    fn a_time_is_a_moment_of_the_calendar_year() {
        assert_eq!(moment(0.0), Moment { day: 1, hour: 0.0 });
        assert_eq!(moment(86_400.0 * 364.0 + 43_200.0), Moment { day: 365, hour: 12.0 });
        assert_eq!(moment(86_400.0 * 365.0), Moment { day: 1, hour: 0.0 });
    }
}
