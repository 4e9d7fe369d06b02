//! Insulation of walls and roofs.

use std::collections::{BTreeMap, BTreeSet};

use b2b_building::construction::{INSULATION, ROOF_FILMS, WALL_FILMS, insulation_of, layers, resistance};
use b2b_building::zone::{self, Surface, SurfaceKind};
use b2b_building::{Error, Model, Result};
use serde_json::json;

/// Minimum resistance that the engine accepts, m²K/W.
const MIN_RESISTANCE: f64 = 1e-3;

/// Sets the assembly U-factor of every exterior wall and roof, W/m²K with the code's air films, through the resistance of
/// its insulation.
///
/// The roof of an attic is the ceiling under it: the deck above has no insulation, and the attic is vented.
pub(super) fn insulate(model: &mut Model, wall_u: f64, roof_u: f64) -> Result<()> {
    let surfaces = zone::surfaces(model)?;
    let walls = surfaces.iter().filter(|s| s.is_exterior_wall()).map(|s| s.construction.to_lowercase());
    let walls: BTreeSet<_> = walls.collect();
    let mut resistances = BTreeMap::new();
    for construction in &walls {
        require_resistance(model, construction, 1.0 / wall_u - WALL_FILMS, &mut resistances)?;
    }
    for construction in roof_constructions(model, &surfaces)? {
        require_resistance(model, &construction, 1.0 / roof_u - ROOF_FILMS, &mut resistances)?;
    }
    for (insulation, resistance) in resistances {
        let material = model.require_mut(INSULATION, &insulation)?;
        material.insert("thermal_resistance".into(), json!(resistance));
    }
    Ok(())
}

/// The insulated constructions of the roofs, in lower case.
fn roof_constructions(model: &Model, surfaces: &[Surface]) -> Result<BTreeSet<String>> {
    let mut constructions = BTreeSet::new();
    let is_roof = |s: &&Surface| s.kind == SurfaceKind::Roof && s.boundary.eq_ignore_ascii_case("Outdoors");
    for roof in surfaces.iter().filter(is_roof) {
        if insulation_of(model, &roof.construction)?.is_some() {
            constructions.insert(roof.construction.to_lowercase());
        } else {
            let attic_floors = surfaces.iter().filter(|s| is_over_a_room(s, &roof.zone));
            constructions.extend(attic_floors.map(|s| s.construction.to_lowercase()));
            constructions.extend(ceilings_under(surfaces, &roof.zone));
        }
    }
    Ok(constructions)
}

/// Returns whether a surface is a floor of a zone with a room under it.
fn is_over_a_room(surface: &Surface, zone: &str) -> bool {
    surface.kind == SurfaceKind::Floor
        && surface.zone.eq_ignore_ascii_case(zone)
        && surface.boundary.eq_ignore_ascii_case("Surface")
}

/// Constructions of the ceilings whose other side is a floor of a zone.
fn ceilings_under(surfaces: &[Surface], zone: &str) -> Vec<String> {
    let other_side =
        |s: &Surface| surfaces.iter().find(|other| other.name.eq_ignore_ascii_case(&s.boundary_object));
    let under = |s: &&Surface| {
        s.kind == SurfaceKind::Ceiling && other_side(s).is_some_and(|floor| is_over_a_room(floor, zone))
    };
    surfaces.iter().filter(under).map(|s| s.construction.to_lowercase()).collect()
}

/// Records the resistance of a construction's insulation for which its layers sum to `total`, m²K/W.
fn require_resistance(
    model: &Model,
    construction: &str,
    total: f64,
    resistances: &mut BTreeMap<String, f64>,
) -> Result<()> {
    let unsupported = |why: &str| Error::Unsupported {
        class: "Construction".into(),
        name: construction.to_owned(),
        why: why.to_owned(),
    };
    let insulation = insulation_of(model, construction)?.ok_or_else(|| {
        unsupported("none of its layers is a Material:NoMass, whose resistance could be changed")
    })?;
    let mut others = 0.0;
    for layer in layers(model.require("Construction", construction)?) {
        if !layer.eq_ignore_ascii_case(&insulation) {
            others += resistance(model, layer).ok_or_else(|| unsupported("a layer has no resistance"))?;
        }
    }
    let resistance = total - others;
    if resistance < MIN_RESISTANCE {
        return Err(unsupported("its other layers alone have a lower U-factor than requested"));
    }
    match resistances.insert(insulation, resistance) {
        Some(before) if (before - resistance).abs() > 1e-9 => Err(unsupported(
            "its insulation is shared with another construction that needs a different resistance",
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::Value;

    use super::*;
    use b2b_building::model::number;

    fn surface(kind: &str, zone: &str, construction: &str, boundary: &str, other: &str) -> Value {
        let corner =
            |x, y| json!({"vertex_x_coordinate": x, "vertex_y_coordinate": y, "vertex_z_coordinate": 0});
        json!({"surface_type": kind, "zone_name": zone, "construction_name": construction,
            "outside_boundary_condition": boundary, "outside_boundary_condition_object": other,
            "vertices": [corner(0, 0), corner(1, 0), corner(1, 1)]})
    }

    /// A room with an insulated wall under an attic with a bare deck.
    fn model() -> Model {
        let text = json!({
            "BuildingSurface:Detailed": {
                "Wall": surface("Wall", "Room", "Wall Con", "Outdoors", ""),
                "Deck": surface("Roof", "Attic", "Deck Con", "Outdoors", ""),
                "Attic Floor": surface("Floor", "Attic", "Roof Floor Con", "Surface", "Ceiling"),
                "Ceiling": surface("Ceiling", "Room", "Roof Con", "Surface", "Attic Floor")},
            "Construction": {
                "Wall Con": {"outside_layer": "Stucco", "layer_2": "Wall Insulation"},
                "Deck Con": {"outside_layer": "Stucco"},
                "Roof Con": {"outside_layer": "Roof Insulation", "layer_2": "Stucco"},
                "Roof Floor Con": {"outside_layer": "Stucco", "layer_2": "Roof Insulation"}},
            "Material": {"Stucco": {"thickness": 0.02, "conductivity": 0.5}},
            INSULATION: {"Wall Insulation": {"thermal_resistance": 1}, "Roof Insulation": {"thermal_resistance": 1}},
        });
        Model::from_epjson(&text.to_string(), Path::new("test.epJSON")).unwrap()
    }

    #[test]
    fn walls_and_the_ceiling_under_an_attic_get_their_u() {
        let mut model = model();
        insulate(&mut model, 0.5, 0.2).unwrap();
        let resistance = |name| number(model.get(INSULATION, name).unwrap(), "thermal_resistance").unwrap();
        assert!((resistance("Wall Insulation") - (2.0 - 0.15 - 0.04)).abs() < 1e-12);
        assert!((resistance("Roof Insulation") - (5.0 - 0.14 - 0.04)).abs() < 1e-12);
    }

    #[test]
    fn an_insulation_with_conflicting_resistances_is_rejected() {
        let mut model = model();
        let wall = model.require_mut("Construction", "Wall Con").unwrap();
        wall.insert("layer_2".into(), json!("Roof Insulation"));
        let error = insulate(&mut model, 0.5, 0.2).unwrap_err().to_string();
        assert!(error.contains("a different resistance"), "{error}");
    }

    #[test]
    fn a_wall_without_insulation_is_named() {
        let mut model = model();
        let wall = model.require_mut("Construction", "Wall Con").unwrap();
        wall.remove("layer_2");
        let error = insulate(&mut model, 0.5, 0.2).unwrap_err().to_string();
        assert!(error.contains("`wall con`"), "{error}");
    }
}
