//! Constructions of exterior walls and roofs that other surfaces share.

use std::collections::{BTreeMap, BTreeSet};

use super::copies::{copy, layered, require_no_source, spelled, users_of};
use super::envelope::roof::roof_surfaces;
use super::geometry::{OTHER_WALLS, require_corners};
use crate::zone::{Surface, SurfaceKind, surfaces};
use crate::{Model, Result};

const SURFACE: &str = "BuildingSurface:Detailed";

/// Gives exterior walls their own constructions where other surfaces share them.
///
/// # Errors
/// [`crate::Error::Edit`] for a wall without corners, or a construction that is not given by layers.
pub(super) fn walls(model: &mut Model) -> Result<()> {
    require_corners(model, &OTHER_WALLS)?;
    let all = surfaces(model)?;
    let walls = all.iter().filter(|s| s.is_exterior_wall());
    let walls: Vec<_> = walls.map(|s| (s.name.clone(), s.construction.clone())).collect();
    separate(model, &walls, "exterior wall")
}

/// Gives roofs their own constructions where other surfaces share them.
///
/// # Errors
/// Same as [`walls`].
pub(super) fn roofs(model: &mut Model) -> Result<()> {
    require_corners(model, &["Roof", "RoofCeiling:Detailed"])?;
    let all = surfaces(model)?;
    let roofs = roof_surfaces(model, &all)?;
    // The floor of an attic has the layers of the ceiling under it in reverse.
    let (floors, roofs): (Vec<_>, Vec<_>) = roofs.into_iter().partition(|s| s.kind == SurfaceKind::Floor);
    let named = |surfaces: Vec<&Surface>| -> Vec<_> {
        surfaces.iter().map(|s| (s.name.clone(), s.construction.clone())).collect()
    };
    let (floors, roofs) = (named(floors), named(roofs));
    separate(model, &floors, "attic floor")?;
    separate(model, &roofs, "roof")
}

/// Copies the constructions of surfaces, given with their names, that other objects use too.
fn separate(model: &mut Model, surfaces: &[(String, String)], kind: &str) -> Result<()> {
    let mut users: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    for (surface, construction) in surfaces {
        users.entry(construction.to_lowercase()).or_default().insert(surface);
        let shared = format!(
            "other surfaces share it; give each {kind} another construction with its own source first"
        );
        require_no_source(model, &construction, &shared)?;
    }
    for (construction, own) in users {
        layered(model, &construction)?;
        if users_of(model, &construction) == own.len() {
            continue;
        }
        let wanted = format!("{} of {kind}", spelled(model, "Construction", &construction));
        let copied = copy(model, "Construction", &construction, &wanted)?;
        for surface in own {
            let fields = model.require_mut(SURFACE, surface)?;
            fields.insert("construction_name".into(), copied.clone().into());
        }
    }
    Ok(())
}
