//! Size and orientation of the whole building.

use std::collections::HashMap;

use serde_json::{Value, json};

use crate::model::{Fields, number, text};
use crate::shape::is_relative;
use crate::zone::{self, Surface};
use crate::{Error, Model, Result};

/// Classes of surfaces that are given by azimuth, length and height instead of corners.
const WITHOUT_CORNERS: [&str; 17] = [
    WALL_WITHOUT_CORNERS,
    "Wall:Adiabatic",
    "Wall:Underground",
    "Wall:Interzone",
    "Roof",
    "Ceiling:Adiabatic",
    "Ceiling:Interzone",
    "Floor:GroundContact",
    "Floor:Adiabatic",
    "Floor:Interzone",
    "Window",
    "Window:Interzone",
    "Door",
    "Door:Interzone",
    "GlazedDoor",
    "GlazedDoor:Interzone",
    "Shading:Building",
];

/// The class of exterior walls without corners.
pub(super) const WALL_WITHOUT_CORNERS: &str = "Wall:Exterior";

/// Angles that the engine counts from true north instead of the building's axes, 0 by default, and their periods.
const FROM_TRUE_NORTH: [(&str, &str, f64); 2] = [
    ("ZoneVentilation:WindandStackOpenArea", "effective_angle", 360.0),
    ("AirflowNetwork:SimulationControl", "azimuth_angle_of_long_axis_of_building", 180.0),
];

/// Sets the orientation: degrees from true north to the building's y axis. Openings to the wind turn with the building.
/// Returns the number of changed objects.
pub fn turn(model: &mut Model, north_axis: f64) -> usize {
    let names = model.names("Building");
    let mut count = names.len();
    let mut by = 0.0;
    for name in &names {
        if let Some(building) = model.get_mut("Building", name) {
            by = north_axis - number(building, "north_axis").unwrap_or(0.0);
            building.insert("north_axis".into(), json!(north_axis));
        }
    }
    for (class, field, period) in FROM_TRUE_NORTH.into_iter().filter(|_| by != 0.0) {
        for name in model.names(class) {
            if let Some(fields) = model.get_mut(class, &name) {
                let angle = number(fields, field).unwrap_or(0.0) + by;
                fields.insert(field.into(), json!(angle.rem_euclid(period)));
                count += 1;
            }
        }
    }
    count
}

/// Checks that the north axis takes effect in EnergyPlus.
///
/// # Errors
/// [`Error::Edit`] for a model in world coordinates.
pub fn require_relative_coordinates(model: &Model) -> Result<()> {
    if is_relative(model) {
        return Ok(());
    }
    let name = model.names("GlobalGeometryRules").into_iter().next().unwrap_or_default();
    let why = "its coordinates are world coordinates, for which EnergyPlus ignores the north axis; rotate the building in \
               the program that wrote the model, or export it with relative coordinates";
    Err(Error::edit("GlobalGeometryRules", &name, why))
}

/// Checks that all surfaces have corners and, if `x` and `y` differ, that all zones have the building's axes.
///
/// # Errors
/// [`Error::Edit`] naming the first object that cannot be stretched.
pub fn require_stretchable(model: &Model, x: f64, y: f64) -> Result<()> {
    require_corners(model, &WITHOUT_CORNERS)?;
    for (name, zone) in model.objects("Zone").into_iter().filter(|_| x != y && is_relative(model)) {
        if number(zone, "direction_of_relative_north").is_some_and(|angle| angle != 0.0) {
            let why = "its axes are rotated from the building's, so x_scale and y_scale must be equal";
            return Err(Error::edit("Zone", name, why));
        }
    }
    Ok(())
}

/// Checks that a model has no objects of classes without corners.
pub(super) fn require_corners(model: &Model, classes: &[&str]) -> Result<()> {
    for class in classes {
        if let Some(name) = model.names(class).first() {
            let why = "it has no corners (vertices); convert it to BuildingSurface:Detailed or \
                       FenestrationSurface:Detailed";
            return Err(Error::edit(class, name, why));
        }
    }
    Ok(())
}

/// Scales every corner of the building along x and y from the origin. Heights are not changed; volumes, floor areas and
/// slabs that the model gives as numbers are scaled.
///
/// # Errors
/// Same as [`zone::surfaces`].
pub fn stretch(model: &mut Model, x: f64, y: f64) -> Result<()> {
    let before = exposed_perimeters(model)?;
    for class in model.classes().map(str::to_owned).collect::<Vec<_>>() {
        for name in model.names(&class) {
            if let Some(fields) = model.get_mut(&class, &name) {
                stretch_object(&class, fields, x, y);
            }
        }
    }
    let after = exposed_perimeters(model)?;
    stretch_slabs(model, x * y, &before, &after)
}

fn stretch_object(class: &str, fields: &mut Fields, x: f64, y: f64) {
    match class {
        "FenestrationSurface:Detailed" => {
            for corner in 1..=4 {
                stretch_fields(fields, &format!("vertex_{corner}_#_coordinate"), x, y);
            }
        }
        "Zone" | "Space" => {
            stretch_fields(fields, "#_origin", x, y);
            multiply(fields, "volume", x * y);
            multiply(fields, "floor_area", x * y);
        }
        "Daylighting:ReferencePoint" => {
            stretch_fields(fields, "#_coordinate_of_reference_point", x, y);
        }
        _ => {
            let corners = fields.get_mut("vertices").and_then(Value::as_array_mut).into_iter().flatten();
            for corner in corners.filter_map(Value::as_object_mut) {
                stretch_fields(corner, "vertex_#_coordinate", x, y);
            }
        }
    }
}

/// Multiplies the x and the y field of this name, in which `#` stands for the axis.
fn stretch_fields(fields: &mut Fields, name: &str, x: f64, y: f64) {
    multiply(fields, &name.replace('#', "x"), x);
    multiply(fields, &name.replace('#', "y"), y);
}

/// EnergyPlus's placeholder for a value that it calculates.
const CALCULATED: f64 = -9999.0;

/// Multiplies a numeric field, except -9999 and `Autocalculate`. `OtherEquipment` may have negative values.
pub(super) fn multiply(fields: &mut Fields, field: &str, factor: f64) {
    if let Some(value) = number(fields, field).filter(|value| *value != CALCULATED) {
        fields.insert(field.to_owned(), json!(value * factor));
    }
}

/// Scales the areas and exposed edges of slabs on grade; edges in proportion to their zone's exterior walls.
fn stretch_slabs(
    model: &mut Model,
    area: f64,
    before: &HashMap<String, f64>,
    after: &HashMap<String, f64>,
) -> Result<()> {
    const F_FACTOR: &str = "Construction:FfactorGroundFloor";
    const KIVA: &str = "SurfaceProperty:ExposedFoundationPerimeter";
    let floors = zone::surfaces(model)?;
    let perimeter = |floor: Option<&Surface>| {
        let zone = floor.map(|floor| floor.zone.to_lowercase()).unwrap_or_default();
        match (before.get(&zone), after.get(&zone)) {
            (Some(before), Some(after)) if *before > 0.0 => after / before,
            _ => 1.0,
        }
    };
    for slab in model.names(F_FACTOR) {
        let factor = perimeter(floors.iter().find(|floor| floor.construction.eq_ignore_ascii_case(&slab)));
        let fields = model.require_mut(F_FACTOR, &slab)?;
        multiply(fields, "area", area);
        multiply(fields, "perimeterexposed", factor);
    }
    for edge in model.names(KIVA) {
        let fields = model.require_mut(KIVA, &edge)?;
        let surface = text(fields, "surface_name").unwrap_or(&edge);
        let factor = perimeter(floors.iter().find(|floor| floor.name.eq_ignore_ascii_case(surface)));
        multiply(fields, "total_exposed_perimeter", factor);
    }
    Ok(())
}

/// Returns the length of each zone's exterior walls, m, by lower-case zone name.
fn exposed_perimeters(model: &Model) -> Result<HashMap<String, f64>> {
    let mut lengths = HashMap::new();
    for wall in zone::surfaces(model)?.iter().filter(|s| s.is_exterior_wall()) {
        *lengths.entry(wall.zone.to_lowercase()).or_insert(0.0) += length(wall);
    }
    Ok(lengths)
}

/// Returns the length of a vertical wall in plan, m.
fn length(wall: &Surface) -> f64 {
    let extent = |axis: usize| {
        let values = wall.corners.iter().map(|corner| corner[axis]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    let (dx, dy) = (extent(0), extent(1));
    (dx * dx + dy * dy).sqrt()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn wall(zone: &str, corners: [[f64; 3]; 4]) -> Value {
        let vertices: Vec<_> = corners
            .iter()
            .map(|[x, y, z]| {
                json!({"vertex_x_coordinate": x, "vertex_y_coordinate": y, "vertex_z_coordinate": z})
            })
            .collect();
        json!({"surface_type": "Wall", "zone_name": zone, "construction_name": "W",
            "outside_boundary_condition": "Outdoors", "vertices": vertices})
    }

    fn model() -> Model {
        let south = [[0.0, 0.0, 3.0], [0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 0.0, 3.0]];
        let west = [[0.0, 4.0, 3.0], [0.0, 4.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 3.0]];
        let mut floor = wall("Z", [[0.0; 3], [0.0, 4.0, 0.0], [10.0, 4.0, 0.0], [10.0, 0.0, 0.0]]);
        floor["surface_type"] = json!("Floor");
        floor["construction_name"] = json!("Slab");
        floor["outside_boundary_condition"] = json!("GroundFCfactorMethod");
        let text = json!({
            "Building": {"B": {"north_axis": 90}},
            "Zone": {"Z": {"x_origin": 2, "y_origin": 3, "volume": 120, "ceiling_height": -9999.0}},
            "BuildingSurface:Detailed": {"S": wall("Z", south), "W": wall("Z", west), "F": floor},
            "Construction:FfactorGroundFloor": {"Slab": {"area": 40, "perimeterexposed": 14}},
        });
        Model::from_epjson(&text.to_string(), Path::new("test.epJSON")).unwrap()
    }

    #[test]
    fn a_stretched_building_keeps_its_height_and_scales_the_rest() {
        let mut model = model();
        stretch(&mut model, 2.0, 0.5).unwrap();
        let surfaces = zone::surfaces(&model).unwrap();
        let area = |name| surfaces.iter().find(|s| s.name == name).unwrap().area();
        assert_eq!((area("S"), area("W"), area("F")), (60.0, 6.0, 40.0));
        let zone = model.require("Zone", "Z").unwrap();
        assert_eq!((number(zone, "x_origin"), number(zone, "y_origin")), (Some(4.0), Some(1.5)));
        assert_eq!((number(zone, "volume"), number(zone, "ceiling_height")), (Some(120.0), Some(-9999.0)));
    }

    #[test]
    fn slab_edges_follow_the_walls_on_them() {
        let mut model = model();
        stretch(&mut model, 2.0, 0.5).unwrap();
        let slab = model.require("Construction:FfactorGroundFloor", "Slab").unwrap();
        assert_eq!((number(slab, "area"), number(slab, "perimeterexposed")), (Some(40.0), Some(22.0)));
    }

    #[test]
    fn an_object_that_cannot_be_stretched_is_named() {
        let mut model = model();
        require_stretchable(&model, 2.0, 1.0).unwrap();
        model.require_mut("Zone", "Z").unwrap().insert("direction_of_relative_north".into(), json!(30));
        require_stretchable(&model, 2.0, 2.0).unwrap();
        let error = require_stretchable(&model, 2.0, 1.0).unwrap_err().to_string();
        assert!(error.contains("Zone `Z`") && error.contains("must be equal"), "{error}");
        model.insert("Wall:Exterior", "North Wall", json!({}));
        let error = require_stretchable(&model, 2.0, 2.0).unwrap_err().to_string();
        assert!(error.contains("Wall:Exterior `North Wall`") && error.contains("convert it"), "{error}");
    }

    #[test]
    fn a_model_in_world_coordinates_cannot_be_turned() {
        let mut model = model();
        require_relative_coordinates(&model).unwrap();
        model.insert("GlobalGeometryRules", "Rules", json!({"coordinate_system": "World"}));
        let error = require_relative_coordinates(&model).unwrap_err().to_string();
        assert!(error.contains("`Rules`") && error.contains("north axis"), "{error}");
    }

    #[test]
    fn the_given_north_axis_replaces_the_model_s() {
        let mut model = model();
        assert_eq!(turn(&mut model, 30.0), 1);
        assert_eq!(number(model.require("Building", "B").unwrap(), "north_axis"), Some(30.0));
    }

    #[test]
    fn openings_to_the_wind_turn_with_the_building() {
        let mut model = model();
        turn(&mut model, 30.0);
        let class = "ZoneVentilation:WindandStackOpenArea";
        model.insert(class, "Door", json!({"effective_angle": 300}));
        assert_eq!(turn(&mut model, 120.0), 2);
        assert_eq!(number(model.require(class, "Door").unwrap(), "effective_angle"), Some(30.0));
    }
}
