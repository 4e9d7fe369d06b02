//! Zones and their surfaces.

use serde_json::Value;

use crate::model::floors::{self, Floors};
use crate::model::{Fields, Model, items, number, text};
use crate::{Error, Result};

/// A zone of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// Name.
    pub name: String,
    /// Floor area, m²: entered in the model, or that of its floors.
    pub floor_area: f64,
    /// Number of identical zones: the zone's multiplier times its group's.
    pub multiplier: f64,
}

/// A space: a part of a zone.
#[derive(Clone, Debug, PartialEq)]
pub struct Space {
    /// Name.
    pub name: String,
    /// Floor area, m²: entered in the model, or that of its floors.
    pub floor_area: f64,
    /// Volume, m³, if given in the model.
    pub volume: Option<f64>,
}

/// Kinds of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Wall.
    Wall,
    /// Floor.
    Floor,
    /// Ceiling.
    Ceiling,
    /// Roof.
    Roof,
}

/// A heat-transfer surface with its corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Its class, such as `BuildingSurface:Detailed`.
    pub class: String,
    /// Name.
    pub name: String,
    /// Zone it belongs to.
    pub zone: String,
    /// Its kind.
    pub kind: SurfaceKind,
    /// Name of its construction.
    pub construction: String,
    /// Outside boundary condition: `Outdoors`, `Ground`, `Surface`, …
    pub boundary: String,
    /// Name of the surface or the zone on the other side, if there is one.
    pub boundary_object: String,
    /// Corners in the coordinates of the model, m; by default relative to the origin of the zone.
    pub corners: Vec<[f64; 3]>,
}

impl Surface {
    /// Returns the area, m².
    pub fn area(&self) -> f64 {
        polygon_area(&self.corners)
    }

    /// Returns whether it is a wall to the outdoors.
    pub fn is_exterior_wall(&self) -> bool {
        self.kind == SurfaceKind::Wall && self.boundary.eq_ignore_ascii_case("Outdoors")
    }
}

/// Returns the zones of a model, in model order.
///
/// # Errors
/// Same as [`surfaces`].
pub fn zones(model: &Model) -> Result<Vec<Zone>> {
    surfaces(model)?;
    let floors = Floors::of(model);
    let zones = model.names("Zone").into_iter().map(|name| Zone {
        floor_area: floors.areas(model, &name).zone,
        multiplier: multiplier(model, &name),
        name,
    });
    Ok(zones.collect())
}

/// Returns the number of identical zones: the zone's multiplier times its group's.
pub(crate) fn multiplier(model: &Model, zone: &str) -> f64 {
    let own = model.get("Zone", zone).and_then(|fields| number(fields, "multiplier"));
    own.unwrap_or(1.0) * group_multiplier(model, zone)
}

/// Returns the spaces of a zone; none if the zone is not divided.
pub fn spaces(model: &Model, zone: &str) -> Vec<Space> {
    let divisions = floors::spaces(model, zone);
    if divisions.is_empty() {
        return Vec::new();
    }
    let areas = Floors::of(model).areas(model, zone).spaces;
    let space = |((name, fields), floor_area): ((&str, &Fields), f64)| Space {
        name: name.to_owned(),
        floor_area,
        // The engine computes a volume of 0.
        volume: number(fields, "volume").filter(|volume| *volume > 0.0),
    };
    divisions.into_iter().zip(areas).map(space).collect()
}

/// Returns the floor area of a zone's surfaces that belong to no space, m²; `None` if there is no such surface. The
/// engine makes another space of them.
pub fn undivided_floor_area(model: &Model, zone: &str) -> Option<f64> {
    Floors::of(model).areas(model, zone).remainder
}

/// Returns the parts of a zone that a name refers to, by itself or by a list: `None` for the whole zone, or its spaces.
pub(crate) fn covered(model: &Model, place: &str, zone: &str) -> Vec<Option<Space>> {
    if covers_zone(model, place, zone) {
        return vec![None];
    }
    let is_covered = |space: &Space| {
        place.eq_ignore_ascii_case(&space.name)
            || lists(model, "SpaceList", place, ["spaces", "space_name"], &space.name)
    };
    spaces(model, zone).into_iter().filter(is_covered).map(Some).collect()
}

/// Returns the zone, space or list of them to which an object applies.
pub(crate) fn place(fields: &Fields) -> Option<&str> {
    ["zone_or_zonelist_or_space_or_spacelist_name", "zone_or_space_name", "zone_name"]
        .into_iter()
        .find_map(|field| text(fields, field))
}

/// Returns whether a surface belongs to a space.
pub(crate) fn is_in_space(model: &Model, surface: &str, space: &str) -> bool {
    let mut found = floors::classes(model).filter_map(|class| model.get(class, surface));
    found.any(|fields| names(fields, "space_name", space))
}

/// Returns whether a name refers to the zone, or to a list that contains it.
pub fn covers_zone(model: &Model, zone_or_list: &str, zone: &str) -> bool {
    zone_or_list.eq_ignore_ascii_case(zone)
        || lists(model, "ZoneList", zone_or_list, ["zones", "zone_name"], zone)
}

fn lists(model: &Model, class: &str, list: &str, [entries, field]: [&str; 2], name: &str) -> bool {
    model.get(class, list).is_some_and(|list| items(list, entries).any(|item| names(item, field, name)))
}

/// Returns whether a field has a name. The engine ignores case.
pub(super) fn names(fields: &Fields, field: &str, name: &str) -> bool {
    text(fields, field).is_some_and(|value| value.eq_ignore_ascii_case(name))
}

/// Returns the multiplier of the `ZoneGroup` of a zone.
fn group_multiplier(model: &Model, zone: &str) -> f64 {
    let groups = model.objects("ZoneGroup").into_iter().map(|(_, fields)| fields);
    let mut of_zone = groups
        .filter(|fields| text(fields, "zone_list_name").is_some_and(|list| covers_zone(model, list, zone)));
    of_zone.next().and_then(|fields| number(fields, "zone_list_multiplier")).unwrap_or(1.0)
}

/// Returns whether a zone has HVAC equipment.
pub fn has_equipment(model: &Model, zone: &str) -> bool {
    let connections = model.objects("ZoneHVAC:EquipmentConnections");
    let zones = connections.iter().filter_map(|(_, fields)| text(fields, "zone_name"));
    zones.into_iter().any(|name| name.eq_ignore_ascii_case(zone))
}

/// Returns the surfaces of a model that are given by their corners, by class and in model order:
/// `BuildingSurface:Detailed`, `Floor:Detailed`, `RoofCeiling:Detailed` and `Wall:Detailed`.
///
/// # Errors
/// [`Error::Unsupported`] when a surface has no type or fewer than three corners.
pub fn surfaces(model: &Model) -> Result<Vec<Surface>> {
    let is_detailed = |(class, ..): &(&str, &str, &Fields)| class.to_ascii_lowercase().ends_with(":detailed");
    let surface = |(class, name, fields): (&str, &str, &Fields)| {
        surface(class, name, fields).ok_or_else(|| Error::Unsupported {
            class: class.into(),
            name: name.into(),
            why: "it needs a surface type and at least three corners".into(),
        })
    };
    floors::surfaces(model).filter(is_detailed).map(surface).collect()
}

/// Returns the kind of a surface by its type, or else by its class. As in the engine, the class of roofs and ceilings
/// does not tell them apart; a roof is outdoors.
fn kind(class: &str, fields: &Fields) -> Option<SurfaceKind> {
    let is_outdoors = || names(fields, "outside_boundary_condition", "Outdoors");
    match floors::kind(class, fields).split(':').next()? {
        "wall" => Some(SurfaceKind::Wall),
        "floor" => Some(SurfaceKind::Floor),
        "roof" => Some(SurfaceKind::Roof),
        "roofceiling" if is_outdoors() => Some(SurfaceKind::Roof),
        "ceiling" | "roofceiling" => Some(SurfaceKind::Ceiling),
        _ => None,
    }
}

fn surface(class: &str, name: &str, fields: &Fields) -> Option<Surface> {
    let kind = kind(class, fields)?;
    let part = |field: &str| text(fields, field).unwrap_or_default().to_owned();
    let corners: Vec<_> = fields.get("vertices")?.as_array()?.iter().map(corner).collect::<Option<_>>()?;
    (corners.len() >= 3).then(|| Surface {
        class: class.to_owned(),
        name: name.to_owned(),
        zone: part("zone_name"),
        kind,
        construction: part("construction_name"),
        boundary: part("outside_boundary_condition"),
        boundary_object: part("outside_boundary_condition_object"),
        corners,
    })
}

pub(super) fn corner(vertex: &Value) -> Option<[f64; 3]> {
    let at = |axis: &str| vertex.get(format!("vertex_{axis}_coordinate"))?.as_f64();
    Some([at("x")?, at("y")?, at("z")?])
}

/// Returns the area of a planar polygon in space, m².
pub fn polygon_area(corners: &[[f64; 3]]) -> f64 {
    area_vector(corners).iter().map(|n| n * n).sum::<f64>().sqrt()
}

/// Returns the normal of a planar polygon, by Newell's method. The normal's length is the polygon's area.
pub fn area_vector(corners: &[[f64; 3]]) -> [f64; 3] {
    let mut normal = [0.0; 3];
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        normal[0] += a[1] * b[2] - a[2] * b[1];
        normal[1] += a[2] * b[0] - a[0] * b[2];
        normal[2] += a[0] * b[1] - a[1] * b[0];
    }
    normal.map(|n| n / 2.0)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    const DETAILED: &str = "BuildingSurface:Detailed";

    #[test]
    fn surfaces_of_every_class_with_corners_count() {
        let corner = |x: f64, z: f64| json!({"vertex_x_coordinate": x, "vertex_y_coordinate": 0.0, "vertex_z_coordinate": z});
        let corners = [corner(0.0, 3.0), corner(0.0, 0.0), corner(2.0, 0.0), corner(2.0, 3.0)];
        let surface = |boundary: &str| json!({"zone_name": "A", "space_name": "West", "vertices": corners, "outside_boundary_condition": boundary});
        let mut model = Model::default();
        for (class, boundary) in [
            ("Floor:Detailed", "Ground"),
            ("ROOFCEILING:DETAILED", "outdoors"),
            ("RoofCeiling:Detailed", "Adiabatic"),
            ("Wall:Detailed", "Outdoors"),
        ] {
            model.insert(class, boundary, surface(boundary));
        }
        model.insert("Wall:Exterior", "E", json!({"zone_name": "A"}));
        let surfaces = surfaces(&model).unwrap();
        let found: Vec<_> =
            surfaces.iter().map(|each| (each.name.as_str(), each.kind, each.area())).collect();
        let expected = [
            ("Ground", SurfaceKind::Floor, 6.0),
            ("Adiabatic", SurfaceKind::Ceiling, 6.0),
            ("outdoors", SurfaceKind::Roof, 6.0),
            ("Outdoors", SurfaceKind::Wall, 6.0),
        ];
        assert_eq!(found, expected);
        assert!(surfaces[3].is_exterior_wall() && surfaces[3].class == "Wall:Detailed");
        assert!(is_in_space(&model, "ground", "west") && !is_in_space(&model, "E", "West"));
    }

    #[test]
    fn floors_of_every_class_count() {
        let mut model = Model::default();
        model.insert("Zone", "A", json!({}));
        model.insert("Floor:GroundContact", "1", json!({"zone_name": "a", "length": 5.0, "width": 4.0}));
        let corner = |x: f64, y: f64| json!({"vertex_x_coordinate": x, "vertex_y_coordinate": y, "vertex_z_coordinate": 0.0});
        let corners = [corner(0.0, 0.0), corner(0.0, 3.0), corner(2.0, 3.0), corner(2.0, 0.0)];
        model.insert("Floor:Detailed", "2", json!({"zone_name": "A", "vertices": corners}));
        model.insert("Floor:Adiabatic", "3", json!({"zone_name": "B", "length": 1.0, "width": 1.0}));
        assert_eq!(zones(&model).unwrap()[0].floor_area, 26.0);
    }

    #[test]
    fn the_multiplier_of_a_group_counts() {
        let mut model = Model::default();
        model.insert("Zone", "A", json!({"floor_area": 10.0, "multiplier": 3}));
        model.insert("Zone", "B", json!({"floor_area": 10.0}));
        model.insert("ZoneList", "Floors", json!({"zones": [{"zone_name": "a"}]}));
        model.insert("ZoneGroup", "Tower", json!({"zone_list_name": "floors", "zone_list_multiplier": 4}));
        let multipliers: Vec<f64> = zones(&model).unwrap().iter().map(|zone| zone.multiplier).collect();
        assert_eq!(multipliers, [12.0, 1.0]);
    }

    #[test]
    fn spaces_have_the_area_of_their_floors() {
        let mut model = Model::default();
        let corner = |x: f64, y: f64| json!({"vertex_x_coordinate": x, "vertex_y_coordinate": y, "vertex_z_coordinate": 0.0});
        let corners = [corner(0.0, 0.0), corner(0.0, 3.0), corner(2.0, 3.0), corner(2.0, 0.0)];
        let floor =
            json!({"surface_type": "Floor", "zone_name": "A", "space_name": "west", "vertices": corners});
        model.insert(DETAILED, "1", floor);
        model.insert("Space", "West", json!({"zone_name": "a"}));
        model.insert("Space", "East", json!({"zone_name": "A", "floor_area": 5.0}));
        model.insert("Space", "Other", json!({"zone_name": "B"}));
        let areas: Vec<(String, f64)> =
            spaces(&model, "A").into_iter().map(|space| (space.name, space.floor_area)).collect();
        assert_eq!(areas, [("East".into(), 5.0), ("West".into(), 6.0)]);
    }

    /// Two zones on two levels, the upper one with two spaces and without floors.
    fn levels(condition: &str, object: &str) -> Model {
        let corner = |x: f64, y: f64| json!({"vertex_x_coordinate": x, "vertex_y_coordinate": y, "vertex_z_coordinate": 3.0});
        let corners = [corner(0.0, 0.0), corner(2.0, 0.0), corner(2.0, 3.0), corner(0.0, 3.0)];
        let surface = |fields: [&str; 5]| {
            let [zone, space, kind, condition, object] = fields;
            json!({"zone_name": zone, "space_name": space, "surface_type": kind, "vertices": corners,
                "outside_boundary_condition": condition, "outside_boundary_condition_object": object})
        };
        let mut model = Model::default();
        for zone in ["Low", "High"] {
            model.insert("Zone", zone, json!({}));
        }
        for space in ["East", "West"] {
            model.insert("Space", space, json!({"zone_name": "High"}));
            model.insert(DETAILED, space, surface(["High", space, "Roof", "Outdoors", ""]));
        }
        let mut floor = surface(["low", "", "Floor", "Ground", ""]);
        floor.as_object_mut().unwrap().remove("space_name");
        let mut ceiling = surface(["low", "", "Ceiling", condition, object]);
        ceiling.as_object_mut().unwrap().remove("space_name");
        model.insert(DETAILED, "Floor", floor);
        model.insert(DETAILED, "Ceiling", ceiling);
        model
    }

    /// The areas that the engine prints for these cases.
    #[test]
    fn areas_are_the_engines() {
        let areas = |model: &Model| {
            let spaces = spaces(model, "High").into_iter().map(|space| space.floor_area);
            let areas: Vec<f64> = zones(model).unwrap().into_iter().map(|zone| zone.floor_area).collect();
            (areas, spaces.collect::<Vec<f64>>())
        };
        let set = |model: &mut Model, class: &str, name: &str, area: f64| {
            _ = model.require_mut(class, name).unwrap().insert("floor_area".into(), json!(area));
        };
        let mut model = levels("Adiabatic", "");
        set(&mut model, "Zone", "Low", 0.0);
        set(&mut model, "Space", "East", 10.0);
        let west = json!({"zone_name": "High", "space_name": "west", "length": 6.0, "width": 5.0});
        model.insert("Floor:Adiabatic", "West floor", west);
        assert_eq!(areas(&model), (vec![40.0, 6.0], vec![10.0, 30.0]), "the zone is the sum of its spaces");
        set(&mut model, "Zone", "High", 80.0);
        assert_eq!(areas(&model), (vec![80.0, 6.0], vec![20.0, 60.0]), "spaces are scaled to their zone");
        model.remove("Space", "East");
        model.remove(DETAILED, "East");
        model.require_mut("Space", "West").unwrap().insert("floor_area".into(), json!(0.0));
        assert_eq!(areas(&model), (vec![80.0, 6.0], vec![80.0]), "the only space is all of its zone");
    }

    #[test]
    fn ceilings_below_and_ceiling_heights_count_once_they_are_entered() {
        let entered = |condition: &str, object: &str| {
            let mut model = levels(condition, object);
            model.require_mut("Zone", "Low").unwrap().insert("ceiling_height".into(), json!(5.0));
            floors::enter(&mut model);
            let volume = number(model.require("Zone", "Low").unwrap(), "volume");
            assert_eq!((volume, zones(&model).unwrap()[1].floor_area), (Some(30.0), 6.0));
            (zones(&model).unwrap()[0].floor_area, spaces(&model, "High")[0].floor_area)
        };
        assert_eq!(entered("zone", "high"), (6.0, 0.0), "they are the last space's");
        assert_eq!(entered("Space", "East"), (6.0, 6.0));
        assert_eq!(entered("Surface", "East"), (0.0, 0.0));
    }

    #[test]
    fn the_area_of_a_tilted_rectangle_is_length_times_width() {
        let roof = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 3.0, 4.0], [0.0, 3.0, 4.0]];
        assert!((polygon_area(&roof) - 20.0).abs() < 1e-12);
    }
}
