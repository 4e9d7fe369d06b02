//! The five commercial types as functions of eight parameters and a place.
//!
//! [`generate`] takes the stock ASHRAE 90.1-2019 prototype, which stands in Denver, and makes of it the building
//! that [`CommercialParameters`] describe at another place:
//!
//! 1. [`relocate`]: site, design days, ground and mains water of the weather file.
//! 2. [`geometry`] and [`loads`]: the building is stretched, and what is given for the whole of a zone grows with
//!    its floor.
//! 3. [`opaque`], [`glazing`], [`windows`] and [`infiltration`]: the envelope, relative to what the code asks of the
//!    place's climate zone ([`prescriptive`]).
//! 4. [`economizer`], [`recovery`], [`capacity`] and [`kitchen`]: what the code and the climate ask of the equipment.
//!
//! The model comes out autosized: [`b2b_building::PreparedBuilding`] sizes it for its own design days.
//!
//! # Left out
//! - The economiser's capacity threshold (54,000 Btu/h) is that of the unstretched unit in Denver.
//! - A stretched restaurant keeps its refrigerated cases.
//! - Skylights, doors and slab edges keep the prototype's values, those of climate zone 5.
//! - The code's classes of assembly: walls are steel-framed and roofs insulated above deck, as in the paper; attics,
//!   metal buildings and semi-heated storage follow the same two values.
//!
//! # Same bytes everywhere
//! Only the four operations and square roots, which IEEE 754 rounds exactly; other functions are of the `libm` crate.

mod capacity;
mod economizer;
mod geometry;
mod glazing;
mod infiltration;
mod kitchen;
mod loads;
mod opaque;
mod parameters;
mod prescriptive;
mod recovery;
mod relocate;
mod windows;

pub use parameters::{CommercialParameters, bounds};
pub use prescriptive::Prescriptive;

use b2b_building::{BuildingType, Model};
use b2b_climate::{Place, Site};

use crate::Result;

/// The model of a commercial building at a place, autosized. `base` is the stock prototype of the type, and `site` is
/// read from the weather file of `place`.
///
/// The same arguments give the same bytes.
///
/// # Errors
/// [`crate::Error::Parameter`] naming the parameter that is out of [`bounds`]; [`crate::Error::NotCommercial`] for a
/// house; [`b2b_building::Error::MissingObject`] and [`b2b_building::Error::Unsupported`] when `base` is not such a prototype.
pub fn generate(
    base: &Model,
    building_type: BuildingType,
    place: &Place,
    site: &Site,
    parameters: &CommercialParameters,
) -> Result<Model> {
    generate_in_zone(base, building_type, place.ashrae_zone, site, parameters)
}

/// [`generate`] at a place that is known by its climate zone alone, such as `5B`.
///
/// # Errors
/// As [`generate`], and [`crate::Error::ClimateZone`] for a zone that is none of 1 to 8.
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

/// The prototype at another place as the code asks for it there: shape, window areas and leakage are the prototype's.
///
/// # Errors
/// As [`generate`], but for the bounds, which are those of the generator.
pub fn as_the_code_asks(
    base: &Model,
    building_type: BuildingType,
    place: &Place,
    site: &Site,
) -> Result<Model> {
    let parameters = CommercialParameters::of_code(building_type, place.ashrae_zone)?;
    build(base, building_type, place.ashrae_zone, site, &parameters)
}

/// The prototype at a site whose climate zone is not known: it keeps its envelope and has its equipment sized for the
/// site's design days.
///
/// # Errors
/// As [`generate`], when `base` is not such a prototype.
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
    let code = Prescriptive::of(ashrae_zone)?;
    let mut model = base.clone();
    relocate::relocate(&mut model, site);
    geometry::stretch(&mut model, parameters.x_scale, parameters.y_scale)?;
    geometry::turn(&mut model, parameters.north_axis);
    loads::scale(&mut model, parameters.x_scale * parameters.y_scale);
    opaque::insulate(&mut model, code.wall_u * parameters.envelope, code.roof_u * parameters.envelope)?;
    glazing::glaze(&mut model, parameters.window_u, parameters.window_shgc)?;
    windows::resize(&mut model, parameters.window_to_wall)?;
    infiltration::scale(&mut model, parameters.infiltration);
    economizer::choose(&mut model, ashrae_zone);
    recovery::add(&mut model, building_type, ashrae_zone)?;
    size_for_site(&mut model)?;
    Ok(model)
}

fn size_for_site(model: &mut Model) -> b2b_building::Result<()> {
    capacity::leave_to_sizing(model)?;
    kitchen::settle(model)
}
