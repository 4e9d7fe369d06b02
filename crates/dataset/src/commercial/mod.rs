//! The five commercial types as functions of nine parameters and a place.
//!
//! [`generate`] modifies the ASHRAE 90.1-2019 prototype for Denver to the building of [`CommercialParameters`] at
//! another place:
//!
//! 1. `relocate`: site, design days, ground and mains water of the weather file.
//! 2. [`edit::geometry`] and [`edit::loads`]: the building is stretched, and loads given per zone are scaled with the
//!    floor area.
//! 3. [`edit::opaque`], [`edit::glazing`], [`edit::windows`] and [`edit::infiltration`]: the envelope, whose bounds
//!    follow the code's requirements in the climate zone (`prescriptive`).
//! 4. `economizer`, `recovery`, `capacity` and `kitchen`: equipment that the code and the climate require.
//!
//! The model is autosized: [`b2b_building::PreparedBuilding`] sizes it for its design days.
//!
//! # Simplifications
//! - The economizer's capacity threshold (54,000 Btu/h) is applied to the unstretched unit in Denver.
//! - A stretched restaurant keeps its refrigerated cases.
//! - Skylights, doors and slab edges keep the prototype's values, for climate zone 5.
//! - The code's classes of assembly: walls are steel-framed and roofs insulated above deck, as in the paper; attics,
//!   metal buildings and semi-heated storage follow the same two values.
//!
//! # Reproducibility
//! The bytes are the same on every machine: only arithmetic and square roots, which IEEE 754 rounds exactly; other
//! functions are from the `libm` crate.

mod capacity;
mod economizer;
mod kitchen;
mod parameters;
mod prescriptive;
mod recovery;
mod relocate;

pub use parameters::{CommercialParameters, bounds};
pub use prescriptive::Prescriptive;

use b2b_building::edit::{self, Amount};
use b2b_building::{BuildingType, Model};
use b2b_climate::{Place, Site};

use crate::Result;

/// Generates the autosized model of a commercial building at a place. `base` is the prototype of the type, and `site`
/// is read from the weather file of `place`.
///
/// The same arguments give the same bytes.
///
/// # Errors
/// [`crate::Error::Parameter`] naming the parameter that is out of [`bounds`]; [`crate::Error::NotCommercial`] for a
/// house; [`b2b_building::Error::MissingObject`] and [`b2b_building::Error::Unsupported`] when `base` is not a
/// prototype.
pub fn generate(
    base: &Model,
    building_type: BuildingType,
    place: &Place,
    site: &Site,
    parameters: &CommercialParameters,
) -> Result<Model> {
    generate_in_zone(base, building_type, place.ashrae_zone, site, parameters)
}

/// [`generate`] for a climate zone, for example `5B`.
///
/// # Errors
/// Same as [`generate`], and [`crate::Error::ClimateZone`] for a zone outside 1A to 8.
pub fn generate_in_zone(
    base: &Model,
    building_type: BuildingType,
    ashrae_zone: &str,
    site: &Site,
    parameters: &CommercialParameters,
) -> Result<Model> {
    parameters.check(building_type, ashrae_zone)?;
    build(base, building_type, ashrae_zone, site, parameters)
}

/// Generates the code-compliant variant of a prototype at another place: the envelope and the equipment meet the code;
/// geometry, window areas and leakage are the prototype's.
///
/// # Errors
/// Same as [`generate`], except for parameters out of bounds.
pub fn code_compliant(
    base: &Model,
    building_type: BuildingType,
    place: &Place,
    site: &Site,
) -> Result<Model> {
    let parameters = CommercialParameters::of_code(building_type, place.ashrae_zone)?;
    build(base, building_type, place.ashrae_zone, site, &parameters)
}

/// Moves the prototype to a site whose climate zone is unknown: the envelope is kept, and the equipment is sized for
/// the design days of the site.
///
/// # Errors
/// Same as [`generate`], when `base` is not a prototype.
pub fn relocated(base: &Model, site: &Site) -> Result<Model> {
    let mut model = base.clone();
    relocate::relocate(&mut model, site);
    size_for_site(&mut model)?;
    Ok(model)
}

fn build(
    base: &Model,
    building_type: BuildingType,
    ashrae_zone: &str,
    site: &Site,
    parameters: &CommercialParameters,
) -> Result<Model> {
    let mut model = base.clone();
    relocate::relocate(&mut model, site);
    let (x, y) = (parameters.x_scale, parameters.y_scale);
    edit::geometry::stretch(&mut model, x, y)?;
    edit::geometry::turn(&mut model, parameters.north_axis);
    edit::loads::scale(&mut model, x * y);
    let value = |value| Some(Amount::Value(value));
    edit::opaque::insulate(&mut model, value(parameters.wall_u), value(parameters.roof_u))?;
    edit::glazing::glaze(&mut model, value(parameters.window_u), Some(parameters.window_shgc))?;
    edit::windows::resize(&mut model, parameters.window_to_wall)?;
    edit::infiltration::scale(&mut model, parameters.infiltration);
    economizer::choose(&mut model, ashrae_zone);
    recovery::add(&mut model, building_type, ashrae_zone)?;
    size_for_site(&mut model)?;
    Ok(model)
}

fn size_for_site(model: &mut Model) -> b2b_building::Result<()> {
    capacity::leave_to_sizing(model)?;
    kitchen::settle(model)
}
