//! Insulation of walls and roofs.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;

use super::roof::roof_surfaces;
use crate::construction::{INSULATION, LAYERS, ROOF_FILMS, WALL_FILMS, insulation_of, layers, resistance};
use crate::edit::Amount;
use crate::edit::copies::{copy, layered, require_no_source, spelled, unused_name, users_of};
use crate::model::{Fields, number};
use crate::zone::{self, Surface, SurfaceKind};
use crate::{Error, Model, Result};

/// Minimum resistance that the engine accepts, m²K/W.
const MIN_RESISTANCE: f64 = 1e-3;
/// Highest conductivity of an insulation material, W/mK.
const INSULATING: f64 = 0.2;
/// Resistances that differ by less are the same, m²K/W.
const SAME: f64 = 1e-9;

/// The numbers of constructions that were insulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Insulated {
    /// Constructions of exterior walls.
    pub walls: usize,
    /// Constructions of roofs.
    pub roofs: usize,
}

/// The part of a construction that changes its resistance.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Lever {
    /// The resistance of a `Material:NoMass`.
    Resistance(String),
    /// The conductivity of a `Material`.
    Conductivity(String),
    /// A new layer of insulation.
    NewLayer,
}

/// A resistance for the lever of a construction, m²K/W.
struct Requirement {
    construction: String,
    lever: Lever,
    resistance: f64,
}

/// Sets the assembly U-factor of every exterior wall and roof, if given, W/m²K with the code's air films, through the
/// resistance of its insulation.
///
/// The insulation is a `Material:NoMass`, or else the most resistive `Material`, whose conductivity changes. A
/// construction without insulation that needs more resistance gets a layer of it outside, or on top of the floor of an
/// attic. Insulation that other constructions use with another resistance is copied. Other surfaces with the same
/// construction change, too.
///
/// Under an attic, the ceiling counts as the roof, because the deck has no insulation and the attic is vented.
///
/// # Errors
/// [`Error::Edit`] for a construction that cannot have the U-factor; [`Error::MissingObject`] for a dangling reference.
pub fn insulate(model: &mut Model, walls: Option<Amount>, roofs: Option<Amount>) -> Result<Insulated> {
    let surfaces = zone::surfaces(model)?;
    let of_walls: BTreeSet<_> = match walls {
        Some(_) => constructions(surfaces.iter().filter(|s| s.is_exterior_wall())),
        None => BTreeSet::new(),
    };
    let tops = if roofs.is_some() { roof_surfaces(model, &surfaces)? } else { Vec::new() };
    let (floors, others): (Vec<_>, Vec<_>) = tops.iter().partition(|s| s.kind == SurfaceKind::Floor);
    let (floors, others) = (constructions(floors.into_iter()), constructions(others.into_iter()));
    let of_roofs = &floors | &others;
    let mut requirements = Vec::new();
    for (names, amount, films) in [(&of_walls, walls, WALL_FILMS), (&of_roofs, roofs, ROOF_FILMS)] {
        let Some(amount) = amount else { continue };
        for construction in names {
            requirements.push(requirement(model, construction, amount, films)?);
        }
    }
    reject_conflicts(&requirements)?;
    let mut of_levers: BTreeMap<Lever, Vec<Requirement>> = BTreeMap::new();
    for requirement in requirements {
        of_levers.entry(requirement.lever.clone()).or_default().push(requirement);
    }
    for (lever, requirements) in of_levers {
        match lever {
            Lever::NewLayer => {
                for each in &requirements {
                    let name = &each.construction;
                    // On the floor of an attic, the attic is behind the last layer.
                    add_layer(model, each, floors.contains(name) && !others.contains(name))?;
                }
            }
            Lever::Resistance(material) => set_all(model, INSULATION, &material, &requirements)?,
            Lever::Conductivity(material) => set_all(model, "Material", &material, &requirements)?,
        }
    }
    Ok(Insulated { walls: of_walls.len(), roofs: of_roofs.len() })
}

/// The constructions of surfaces, in lower case.
fn constructions<'a>(surfaces: impl Iterator<Item = &'a Surface>) -> BTreeSet<String> {
    surfaces.map(|surface| surface.construction.to_lowercase()).collect()
}

fn unsupported(construction: &str, why: &str) -> Error {
    Error::edit("Construction", construction, why)
}

/// Returns the resistance that gives a construction its U-factor.
fn requirement(model: &Model, construction: &str, amount: Amount, films: f64) -> Result<Requirement> {
    let fields = layered(model, construction)?;
    let mut all = Vec::new();
    for layer in layers(fields) {
        let resistance = resistance(model, layer)
            .ok_or_else(|| unsupported(construction, &format!("its layer `{layer}` has no resistance")))?;
        all.push((layer, resistance));
    }
    let sum: f64 = all.iter().map(|(_, resistance)| resistance).sum();
    let u = amount.of(Some(1.0 / (sum + films))).unwrap_or_default();
    let total = 1.0 / u - films;
    let insulation = insulation_of(model, construction)?;
    let lever = insulation
        .and_then(|material| share(&all, &material, total).map(|r| (Lever::Resistance(material), r)));
    let lever = lever.or_else(|| through_mass(model, &all, total, sum));
    let too_low =
        "its other layers alone have a lower U-factor than requested; request a lower one, or remove layers";
    let (lever, resistance) = lever.ok_or_else(|| unsupported(construction, too_low))?;
    Ok(Requirement { construction: construction.to_owned(), lever, resistance })
}

/// Returns the resistance of each layer of a material for which all layers sum to `total`; `None` if it is too low.
fn share(all: &[(&str, f64)], material: &str, total: f64) -> Option<f64> {
    let is_it = |layer: &str| layer.eq_ignore_ascii_case(material);
    let mut others = 0.0;
    for (_, resistance) in all.iter().filter(|(layer, _)| !is_it(layer)) {
        others += resistance;
    }
    let count = all.iter().filter(|(layer, _)| is_it(layer)).count();
    Some((total - others) / count as f64).filter(|resistance| *resistance >= MIN_RESISTANCE)
}

/// Returns the lever of a construction whose layers have mass: its insulation, or a new layer if it has none and needs
/// more resistance.
fn through_mass(model: &Model, all: &[(&str, f64)], total: f64, sum: f64) -> Option<(Lever, f64)> {
    let massive = all.iter().filter(|(layer, _)| model.contains("Material", layer));
    let best = massive.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(layer, _)| layer.to_lowercase());
    let conductivity = |material: &String| number(model.get("Material", material)?, "conductivity");
    let is_insulation = best.as_ref().and_then(conductivity).is_some_and(|k| k <= INSULATING);
    let more = total - sum;
    if !is_insulation && more >= MIN_RESISTANCE && all.len() < LAYERS.len() {
        return Some((Lever::NewLayer, more));
    }
    let best = best?;
    share(all, &best, total).map(|resistance| (Lever::Conductivity(best), resistance))
}

/// Rejects a construction that walls and roofs share with different resistances.
fn reject_conflicts(requirements: &[Requirement]) -> Result<()> {
    for (index, each) in requirements.iter().enumerate() {
        let mut others = requirements[..index].iter().filter(|other| other.construction == each.construction);
        if others.any(|other| (other.resistance - each.resistance).abs() > SAME) {
            return Err(unsupported(
                &each.construction,
                "walls and roofs share it; use separate constructions",
            ));
        }
    }
    Ok(())
}

/// Sets the resistance of a material in constructions. Constructions with different resistances get copies of it; the
/// material itself changes only if no other construction uses it.
fn set_all(model: &mut Model, class: &str, material: &str, requirements: &[Requirement]) -> Result<()> {
    let mut groups: Vec<Vec<&Requirement>> = Vec::new();
    for each in requirements {
        match groups.iter_mut().find(|group| (group[0].resistance - each.resistance).abs() <= SAME) {
            Some(group) => group.push(each),
            None => groups.push(vec![each]),
        }
    }
    let is_shared = has_other_users(model, material, requirements);
    for (index, group) in groups.iter().enumerate() {
        let Some(last) = group.last() else { continue };
        let name = if index == 0 && !is_shared {
            material.to_owned()
        } else {
            copy_for(model, class, material, group)?
        };
        set(model.require_mut(class, &name)?, class, last.resistance);
    }
    Ok(())
}

fn set(material: &mut Fields, class: &str, resistance: f64) {
    if class == INSULATION {
        material.insert("thermal_resistance".into(), json!(resistance));
    } else if let Some(thickness) = number(material, "thickness") {
        material.insert("conductivity".into(), json!(thickness / resistance));
    }
}

/// Returns whether a material is also in a construction that some surface uses and that no requirement names.
fn has_other_users(model: &Model, material: &str, requirements: &[Requirement]) -> bool {
    let has_it = |fields: &Fields| layers(fields).any(|layer| layer.eq_ignore_ascii_case(material));
    let is_required =
        |name: &str| requirements.iter().any(|each| each.construction.eq_ignore_ascii_case(name));
    let mut constructions = model.objects("Construction").into_iter();
    constructions.any(|(name, fields)| has_it(fields) && !is_required(name) && users_of(model, name) > 0)
}

/// Copies a material for constructions, and returns the name of the copy.
fn copy_for(model: &mut Model, class: &str, material: &str, group: &[&Requirement]) -> Result<String> {
    let first = spelled(model, "Construction", &group[0].construction);
    let wanted = format!("{} of {first}", spelled(model, class, material));
    let copied = copy(model, class, material, &wanted)?;
    for each in group {
        let fields = model.require_mut("Construction", &each.construction)?;
        for layer in LAYERS {
            if let Some(value) = fields.get_mut(layer)
                && value.as_str().is_some_and(|name| name.eq_ignore_ascii_case(material))
            {
                *value = copied.clone().into();
            }
        }
    }
    Ok(copied)
}

/// Adds a layer of insulation outside, or behind the last layer, with the surface of the layer that was there.
fn add_layer(model: &mut Model, requirement: &Requirement, is_last: bool) -> Result<()> {
    let moved = "a new layer would move the source's; add a layer of insulation and number the source's layers by it first";
    require_no_source(model, &requirement.construction, moved)?;
    let construction = model.require("Construction", &requirement.construction)?;
    let mut all: Vec<String> = layers(construction).map(str::to_owned).collect();
    let wanted = format!("Insulation of {}", spelled(model, "Construction", &requirement.construction));
    let name = unused_name(model, "Material", &wanted);
    let mut fields = json!({"roughness": "MediumSmooth", "thermal_resistance": requirement.resistance});
    let beside = if is_last { all.last() } else { all.first() };
    if let Some(outside) = beside.and_then(|layer| model.get("Material", layer)) {
        for field in ["roughness", "thermal_absorptance", "solar_absorptance", "visible_absorptance"] {
            if let Some(value) = outside.get(field) {
                fields[field] = value.clone();
            }
        }
    }
    model.insert(INSULATION, &name, fields);
    let construction = model.require_mut("Construction", &requirement.construction)?;
    all.insert(if is_last { all.len() } else { 0 }, name);
    for (field, layer) in LAYERS.into_iter().zip(all) {
        construction.insert(field.into(), layer.into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::Value;

    use super::*;
    use crate::construction::assembly_resistance;

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

    fn insulate_to(model: &mut Model, wall_u: f64, roof_u: f64) -> Result<Insulated> {
        insulate(model, Some(Amount::Value(wall_u)), Some(Amount::Value(roof_u)))
    }

    fn u(model: &Model, construction: &str, films: f64) -> f64 {
        1.0 / (assembly_resistance(model, construction).unwrap() + films)
    }

    #[test]
    fn walls_and_the_ceiling_under_an_attic_get_their_u() {
        let mut model = model();
        assert_eq!(insulate_to(&mut model, 0.5, 0.2).unwrap(), Insulated { walls: 1, roofs: 2 });
        let resistance = |name| number(model.get(INSULATION, name).unwrap(), "thermal_resistance").unwrap();
        assert!((resistance("Wall Insulation") - (2.0 - 0.15 - 0.04)).abs() < 1e-12);
        assert!((resistance("Roof Insulation") - (5.0 - 0.14 - 0.04)).abs() < 1e-12);
    }

    #[test]
    fn insulation_shared_by_walls_and_roofs_is_copied() {
        let mut model = model();
        let wall = model.require_mut("Construction", "Wall Con").unwrap();
        wall.insert("layer_2".into(), json!("Roof Insulation"));
        insulate_to(&mut model, 0.5, 0.2).unwrap();
        assert!((u(&model, "Wall Con", WALL_FILMS) - 0.5).abs() < 1e-12);
        for side in ["Roof Con", "Roof Floor Con"] {
            assert!((u(&model, side, ROOF_FILMS) - 0.2).abs() < 1e-12);
        }
        let layer =
            |construction: &str, layer: &str| model.get("Construction", construction).unwrap()[layer].clone();
        assert_eq!(layer("Roof Con", "outside_layer"), layer("Roof Floor Con", "layer_2"));
        assert_ne!(layer("Roof Con", "outside_layer"), layer("Wall Con", "layer_2"));
    }

    #[test]
    fn insulation_shared_with_other_surfaces_keeps_its_resistance_there() {
        let mut model = model();
        insulate(&mut model, Some(Amount::Value(0.4)), None).unwrap();
        let partition = json!({"outside_layer": "Wall Insulation"});
        model.insert("Construction", "Partition Con", partition);
        model.insert(
            "BuildingSurface:Detailed",
            "Partition",
            surface("Wall", "Room", "partition con", "Adiabatic", ""),
        );
        let before = assembly_resistance(&model, "Partition Con").unwrap();
        insulate(&mut model, Some(Amount::Times(0.5)), None).unwrap();
        assert!((u(&model, "Wall Con", WALL_FILMS) - 0.2).abs() < 1e-12);
        assert_eq!(assembly_resistance(&model, "Partition Con"), Some(before));
    }

    #[test]
    fn a_bare_wall_gets_a_layer_and_an_insulating_material_another_conductivity() {
        let mut model = model();
        let wall = model.require_mut("Construction", "Wall Con").unwrap();
        wall.remove("layer_2");
        insulate(&mut model, Some(Amount::Value(0.5)), None).unwrap();
        assert!((u(&model, "Wall Con", WALL_FILMS) - 0.5).abs() < 1e-12);
        assert_eq!(model.get("Construction", "Wall Con").unwrap()["layer_2"], "Stucco");
        assert_eq!(model.get("Material", "Stucco").unwrap()["conductivity"], 0.5);

        model.insert("Material", "Wool", json!({"thickness": 0.1, "conductivity": 0.04}));
        model.insert("Construction", "Wall Con", json!({"outside_layer": "Stucco", "layer_2": "wool"}));
        for target in [0.2, 1.5] {
            insulate(&mut model, Some(Amount::Value(target)), None).unwrap();
            assert!((u(&model, "Wall Con", WALL_FILMS) - target).abs() < 1e-12);
        }
        assert_eq!(model.get("Material", "Wool").unwrap()["thickness"], 0.1);
        assert_eq!(model.get("Construction", "Wall Con").unwrap()["layer_2"], "wool");
    }

    #[test]
    fn a_bare_ceiling_under_an_attic_gets_its_layer_on_the_attic_s_side() {
        let mut model = model();
        let slab = json!({"thickness": 0.2, "conductivity": 0.5});
        model.insert("Material", "Slab", slab);
        for construction in ["Roof Con", "Roof Floor Con"] {
            model.insert("Construction", construction, json!({"outside_layer": "Slab"}));
        }
        insulate(&mut model, None, Some(Amount::Value(0.3))).unwrap();
        let layers = |name: &str| -> Vec<String> {
            layers(model.get("Construction", name).unwrap()).map(str::to_owned).collect()
        };
        assert_eq!(layers("Roof Con"), ["Insulation of Roof Con", "Slab"]);
        assert_eq!(layers("Roof Floor Con"), ["Slab", "Insulation of Roof Floor Con"]);
    }

    #[test]
    fn a_heat_source_stays_in_its_construction_or_is_named() {
        const SOURCE: &str = "ConstructionProperty:InternalHeatSource";
        let mut model = model();
        let source = json!({"construction_name": "Wall con", "thermal_source_present_after_layer_number": 1});
        model.insert(SOURCE, "Tubes", source);
        assert_eq!(users_of(&model, "Wall Con"), 1);
        insulate_to(&mut model, 0.5, 0.2).unwrap();
        assert!((u(&model, "Wall Con", WALL_FILMS) - 0.5).abs() < 1e-12);
        model.require_mut("Construction", "Wall Con").unwrap().remove("layer_2");
        let error = insulate(&mut model, Some(Amount::Value(0.5)), None).unwrap_err().to_string();
        assert!(error.contains("`Tubes`") && error.contains("add a layer of insulation"), "{error}");
    }

    #[test]
    fn a_roof_over_a_room_with_equipment_is_itself_insulated() {
        let mut model = model();
        model.insert("ZoneHVAC:EquipmentConnections", "Attic", json!({"zone_name": "attic"}));
        insulate(&mut model, None, Some(Amount::Value(0.2))).unwrap();
        assert!((u(&model, "Deck Con", ROOF_FILMS) - 0.2).abs() < 1e-12);
        let ceiling = model.get(INSULATION, "Roof Insulation").unwrap();
        assert_eq!(number(ceiling, "thermal_resistance"), Some(1.0));
    }

    #[test]
    fn a_construction_that_cannot_have_the_u_is_named() {
        let mut model = model();
        model.insert("Material", "Brick", json!({"thickness": 0.5, "conductivity": 0.5}));
        let wall = model.require_mut("Construction", "Wall Con").unwrap();
        wall.insert("layer_3".into(), json!("Brick"));
        wall.insert("layer_4".into(), json!("Gone"));
        let amount = Some(Amount::Value(5.0));
        let error = insulate(&mut model, amount, None).unwrap_err().to_string();
        assert!(error.contains("`wall con`") && error.contains("`Gone`"), "{error}");
        model.require_mut("Construction", "Wall Con").unwrap().remove("layer_4");
        let error = insulate(&mut model, amount, None).unwrap_err().to_string();
        assert!(error.contains("`wall con`") && error.contains("lower U-factor"), "{error}");
    }
}
