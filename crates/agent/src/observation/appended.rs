//! Inputs of an agent besides the environment's observations: attributes, the forecast and feedback.

use b2b_building::morphology::COMMON;
use b2b_dataset::{BuildingName, Control, Placement};
use b2b_env::{Spaces, attribute_name};

use super::feature::{Feature, Source};
use super::options::ObservationOptions;
use crate::{Error, Result};

/// What feedback tells about the previous step, beside its action.
pub(super) const OF_STEP: [(&str, Source); 2] =
    [("previous reward", Source::PreviousReward), ("first step", Source::First)];

/// Returns the attributes of a building that an agent observes, in [-1, 1]; empty unless its options request them.
/// Needs the building's model, which worker processes drop.
///
/// # Errors
/// [`Error::Attributes`] if the building cannot be described.
pub fn attributes(options: ObservationOptions, spaces: &Spaces) -> Result<Vec<f64>> {
    if !options.attributes {
        return Ok(Vec::new());
    }
    let name = &spaces.building.name;
    let origin =
        Control::split_name(name).0.parse::<BuildingName>().map(|name| Placement::default().origin(&name));
    b2b_env::attributes(spaces, origin.unwrap_or_default())
        .map_err(|source| Error::Attributes { building: name.clone(), source: Box::new(source) })
}

/// Returns the features of attributes: the building's attributes and the task's energy weight.
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

/// Returns the features of the forecast: the outdoor temperature in 1 to `hours` hours.
pub(super) fn forecast_features(hours: u32, spaces: &Spaces) -> Vec<Feature> {
    let (day, hour) = (spaces.observation.day_of_year(), spaces.observation.time_of_day());
    let at = |ahead: u32| {
        let source = Source::Forecast { day, hour, ahead: f64::from(ahead) };
        Feature::new(format!("outdoor temperature in {ahead} h"), source)
    };
    (1..=hours).map(at).collect()
}

/// Returns the features of feedback: the previous action for the actuators with these names, the previous reward, and
/// whether the step is the first of an episode.
pub(super) fn feedback_features(actuators: &[String]) -> Vec<Feature> {
    let of_action =
        |(index, name): (usize, &String)| Feature::new(format!("{name} previous"), Source::Previous(index));
    let of_step = OF_STEP.map(|(name, source)| Feature::new(name, source));
    actuators.iter().enumerate().map(of_action).chain(of_step).collect()
}
