//! Building attributes that can be appended to observations.

use b2b_building::Description;
use b2b_building::description::Origin;
use b2b_building::morphology::{Attribute, Morphology};

use crate::spaces::Spaces;

/// Returns the common attributes of a building in the order of [`COMMON`](b2b_building::morphology::COMMON), scaled to
/// [-1, 1] by their bounds; unknown ones are 0.
///
/// # Errors
/// The errors of [`Description::of`].
pub fn attributes(spaces: &Spaces, origin: Origin) -> b2b_building::Result<Vec<f64>> {
    let description = Description::of(&spaces.building, &spaces.episode.weather, origin)?;
    Ok(Morphology::of(&spaces.building, &description).scaled_common_attributes())
}

/// Returns the name of an attribute's slot in an observation.
pub fn attribute_name(attribute: Attribute) -> String {
    let name = serde_json::to_value(attribute).unwrap_or_default();
    format!("building {}", name.as_str().unwrap_or_default())
}
