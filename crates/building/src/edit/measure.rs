//! The quantities of a building that changes affect.

use super::Change;
use super::gains::{self, intensity};
use crate::description::{Description, Envelope, Location, Origin};
use crate::model::number;
use crate::shape::Shape;
use crate::zone::has_equipment;
use crate::{Conditioning, Model};

/// Computes a quantity of a model; `None` if the model does not give it.
type Measure = fn(&Model) -> Option<f64>;

/// Returns the quantity that a change affects, its unit and its computation.
pub(super) fn quantity(change: Change) -> (&'static str, &'static str, Measure) {
    match change {
        Change::XScale => ("length along x", "m", |model| size(model, 0)),
        Change::YScale => ("length along y", "m", |model| size(model, 1)),
        Change::NorthAxis => ("north axis", "°", north_axis),
        Change::WallU => ("mean U of walls", "W/m²K", |model| envelope(model)?.wall_u),
        Change::RoofU => ("mean U of roofs", "W/m²K", |model| envelope(model)?.roof_u),
        Change::WindowU => ("mean U of windows", "W/m²K", |model| envelope(model)?.window_u),
        Change::WindowShgc => ("mean SHGC of windows", "1", |model| envelope(model)?.window_shgc),
        Change::WindowToWall => ("window-to-wall ratio", "1", |model| Some(envelope(model)?.window_to_wall)),
        Change::Infiltration => {
            ("infiltration", "air changes/h", |model| Some(envelope(model)?.infiltration))
        }
        Change::People => ("people", "per 100 m²", |model| Some(100.0 * intensity(model, &gains::PEOPLE)?)),
        Change::Lights => ("lights", "W/m²", |model| intensity(model, &gains::LIGHTS)),
        Change::Equipment => ("equipment", "W/m²", |model| intensity(model, &gains::EQUIPMENT)),
    }
}

/// Extent of the building along an axis, m.
fn size(model: &Model, axis: usize) -> Option<f64> {
    let [low, high] = Shape::of(model).ok()?.extent();
    Some(high[axis] - low[axis])
}

fn north_axis(model: &Model) -> Option<f64> {
    let (_, building) = model.objects("Building").into_iter().next()?;
    Some(number(building, "north_axis").unwrap_or(0.0))
}

/// The envelope of the zones with equipment; of all zones if none has any.
fn envelope(model: &Model) -> Option<Envelope> {
    let zones = model.names("Zone");
    let has_any = zones.iter().any(|zone| has_equipment(model, zone));
    let is_conditioned = |zone: &String| !has_any || has_equipment(model, zone);
    let conditioning = zones.iter().map(|zone| match is_conditioned(zone) {
        true => Conditioning::HeatingAndCooling,
        false => Conditioning::None,
    });
    let conditioning: Vec<_> = conditioning.collect();
    let (location, origin) = (Location::default(), Origin::default());
    let description = Description::of_model("", model, &conditioning, &[], &[], location, origin);
    description.ok().map(|description| description.envelope)
}
