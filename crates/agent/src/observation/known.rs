//! Inputs of an agent besides the environment's observations: attributes and the forecast.

use b2b_building::morphology::COMMON;
use b2b_dataset::{BuildingName, Placement};
use b2b_env::{Spaces, attribute_name};

use super::feature::{Feature, Source};
use super::options::ObservationOptions;
use crate::{Error, Result};

/// Temperature and scale of outdoor temperatures, °C and K.
pub(super) const OUTDOOR: (f64, f64) = (10.0, 15.0);

/// Returns the attributes of a building that an agent observes, from -1 to 1: none unless its options request them.
/// Requires the model of the building, which a worker process has dropped.
///
/// # Errors
/// [`Error::Attributes`] if the building cannot be described.
pub fn attributes(options: ObservationOptions, spaces: &Spaces) -> Result<Vec<f64>> {
    if !options.attributes {
        return Ok(Vec::new());
    }
    let name = &spaces.building.name;
    let origin = name.parse::<BuildingName>().map(|name| Placement::default().origin(&name));
    b2b_env::attributes(spaces, origin.unwrap_or_default())
        .map_err(|source| Error::Attributes { building: name.clone(), source: Box::new(source) })
}

/// Returns the features of attributes: those of the building, and the weight of energy in the task.
pub(super) fn attribute_features(attributes: &[f64], spaces: &Spaces) -> Vec<Feature> {
    if attributes.is_empty() {
        return Vec::new();
    }
    let building = COMMON.iter().zip(attributes);
    let building =
        building.map(|(slot, value)| Feature::new(attribute_name(slot.quantity), Source::Constant(*value)));
    let weight = Source::Constant(spaces.episode.task.energy_weight);
    building.chain([Feature::new("task energy weight", weight)]).collect()
}

/// Returns the features of the forecast: the outdoor temperature at full hours from now.
pub(super) fn forecast_features(hours: u32, spaces: &Spaces) -> Vec<Feature> {
    let (day, hour) = (spaces.observation.day_of_year(), spaces.observation.time_of_day());
    let at = |ahead: u32| {
        let source = Source::Forecast { day, hour, ahead: f64::from(ahead) };
        Feature::new(format!("outdoor temperature in {ahead} h"), source)
    };
    (1..=hours).map(at).collect()
}

/// Returns the outdoor temperatures at the end of each hour of the year, °C; none without a forecast.
///
/// # Errors
/// [`Error::Io`] for a weather file that cannot be read; [`Error::Forecast`] for one that is not of a year.
pub(super) fn outdoor_temperatures(hours: u32, spaces: &Spaces) -> Result<Vec<f64>> {
    if hours == 0 {
        return Ok(Vec::new());
    }
    let path = &spaces.episode.weather;
    let text = std::fs::read(path).map_err(crate::error::at(path))?;
    let temperatures = b2b_climate::epw::dry_bulbs(&String::from_utf8_lossy(&text));
    match temperatures.len() {
        8760 => Ok(temperatures),
        hours => Err(Error::Forecast { path: path.clone(), hours }),
    }
}

/// Returns the temperature at an hour of the year, between those at the ends of hours: see [`outdoor_temperatures`].
pub(super) fn at_hour(temperatures: &[f64], hour: f64) -> f64 {
    let place = (hour - 1.0).rem_euclid(temperatures.len() as f64);
    let (index, share) = (place as usize % temperatures.len(), place.fract());
    temperatures[index] * (1.0 - share) + temperatures[(index + 1) % temperatures.len()] * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_temperature_of_the_weather_file_is_that_at_the_end_of_its_hour() {
        let temperatures: Vec<f64> = (1..=8760).map(f64::from).collect();
        assert_eq!([1.0, 1.5, 8760.0].map(|hour| at_hour(&temperatures, hour)), [1.0, 1.5, 8760.0]);
        assert_eq!([8761.0, 8760.5].map(|hour| at_hour(&temperatures, hour)), [1.0, 4380.5]);
    }
}
