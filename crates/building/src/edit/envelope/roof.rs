//! The surfaces that insulate a building at its top.

use crate::construction::{assembly_resistance, insulation_of};
use crate::zone::{Surface, SurfaceKind, has_equipment};
use crate::{Model, Result};

/// Returns the surfaces that hold the roof insulation: the roofs, or the ceilings under an attic, from both sides.
///
/// # Errors
/// [`crate::Error::MissingObject`] for a dangling reference.
pub(in crate::edit) fn roof_surfaces<'a>(model: &Model, surfaces: &'a [Surface]) -> Result<Vec<&'a Surface>> {
    let mut insulated = Vec::new();
    let is_roof = |s: &&Surface| s.kind == SurfaceKind::Roof && s.boundary.eq_ignore_ascii_case("Outdoors");
    for roof in surfaces.iter().filter(is_roof) {
        let below = ceilings(surfaces, &roof.zone);
        if is_attic_roof(model, roof, &below)? {
            insulated.extend(below);
        } else {
            insulated.push(roof);
        }
    }
    Ok(insulated)
}

/// Returns whether a roof covers an attic: a deck over better insulated ceilings.
fn is_attic_roof(model: &Model, roof: &Surface, below: &[&Surface]) -> Result<bool> {
    if model.contains("Construction", &roof.construction)
        && insulation_of(model, &roof.construction)?.is_some()
    {
        return Ok(false);
    }
    let resistance = |surface: &Surface| assembly_resistance(model, &surface.construction).unwrap_or(0.0);
    let is_better = |ceiling: &&Surface| resistance(ceiling) > resistance(roof);
    Ok(!has_equipment(model, &roof.zone) && below.iter().any(is_better))
}

/// Returns the floors of a zone that have a room under them, and their other sides.
fn ceilings<'a>(surfaces: &'a [Surface], zone: &str) -> Vec<&'a Surface> {
    let other_side =
        |s: &Surface| surfaces.iter().find(|other| other.name.eq_ignore_ascii_case(&s.boundary_object));
    let is_under = |s: &Surface| {
        s.kind == SurfaceKind::Ceiling && other_side(s).is_some_and(|floor| is_over_a_room(floor, zone))
    };
    surfaces.iter().filter(|s| is_over_a_room(s, zone) || is_under(s)).collect()
}

/// Returns whether a surface is a floor of a zone with a room under it.
fn is_over_a_room(surface: &Surface, zone: &str) -> bool {
    surface.kind == SurfaceKind::Floor
        && surface.zone.eq_ignore_ascii_case(zone)
        && surface.boundary.eq_ignore_ascii_case("Surface")
}
