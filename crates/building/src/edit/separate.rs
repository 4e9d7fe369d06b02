//! Constructions of exterior walls and roofs that other surfaces share.

use std::collections::{BTreeMap, BTreeSet};

use super::copies::{copy, layered, require_no_source, spelled, users_of};
use super::envelope::roof::roof_surfaces;
use super::geometry::{WALL_WITHOUT_CORNERS, require_corners};
use crate::zone::{Surface, SurfaceKind, surfaces};
use crate::{Model, Result};

/// Gives exterior walls their own constructions where other surfaces share them.
///
/// # Errors
/// [`crate::Error::Edit`] for a wall without corners, or a construction that is not given by layers.
pub(super) fn walls(model: &mut Model) -> Result<()> {
    require_corners(model, &[WALL_WITHOUT_CORNERS])?;
    let all = surfaces(model)?;
    let walls: Vec<&Surface> = all.iter().filter(|s| s.is_exterior_wall()).collect();
    separate(model, &walls, "exterior wall")
}

/// Gives roofs their own constructions where other surfaces share them.
///
/// # Errors
/// Same as [`walls`].
pub(super) fn roofs(model: &mut Model) -> Result<()> {
    require_corners(model, &["Roof"])?;
    let all = surfaces(model)?;
    let roofs = roof_surfaces(model, &all)?;
    // The floor of an attic has the layers of the ceiling under it in reverse.
    let (floors, roofs): (Vec<_>, Vec<_>) = roofs.into_iter().partition(|s| s.kind == SurfaceKind::Floor);
    separate(model, &floors, "attic floor")?;
    separate(model, &roofs, "roof")
}

/// Copies the constructions of surfaces that other objects use too.
fn separate(model: &mut Model, surfaces: &[&Surface], kind: &str) -> Result<()> {
    let mut users: BTreeMap<String, BTreeSet<[&str; 2]>> = BTreeMap::new();
    for surface in surfaces {
        let of_construction = users.entry(surface.construction.to_lowercase()).or_default();
        of_construction.insert([surface.class.as_str(), surface.name.as_str()]);
    }
    for (construction, own) in users {
        layered(model, &construction)?;
        if users_of(model, &construction) == own.len() {
            continue;
        }
        let shared = format!(
            "other surfaces share it; give each {kind} another construction with its own source first"
        );
        require_no_source(model, &construction, &shared)?;
        let wanted = format!("{} of {kind}", spelled(model, "Construction", &construction));
        let copied = copy(model, "Construction", &construction, &wanted)?;
        for [class, surface] in own {
            let fields = model.require_mut(class, surface)?;
            fields.insert("construction_name".into(), copied.clone().into());
        }
    }
    Ok(())
}
