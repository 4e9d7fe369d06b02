//! Zones and their surfaces.

use serde_json::Value;

use crate::model::{Fields, Model, number, text};
use crate::{Error, Result};

/// A zone of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// Name.
    pub name: String,
    /// Floor area, m²: given in the model, or the sum of its floor surfaces.
    pub floor_area: f64,
    /// Zone multiplier.
    pub multiplier: f64,
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
    /// Area, m².
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
/// As [`surfaces`].
pub fn zones(model: &Model) -> Result<Vec<Zone>> {
    let surfaces = surfaces(model)?;
    let zones = model.objects("Zone").into_iter().map(|(name, fields)| Zone {
        name: name.to_owned(),
        floor_area: number(fields, "floor_area")
            .unwrap_or_else(|| floor_area(&surfaces, name) + other_floor_area(model, name)),
        multiplier: number(fields, "multiplier").unwrap_or(1.0),
    });
    Ok(zones.collect())
}

/// Returns whether a zone has air conditioning equipment.
pub fn has_equipment(model: &Model, zone: &str) -> bool {
    let connections = model.objects("ZoneHVAC:EquipmentConnections");
    let zones = connections.iter().filter_map(|(_, fields)| text(fields, "zone_name"));
    zones.into_iter().any(|name| name.eq_ignore_ascii_case(zone))
}

/// Returns the surfaces of a model, in model order (`BuildingSurface:Detailed`).
///
/// # Errors
/// [`Error::Unsupported`] when a surface has no type or fewer than three corners.
pub fn surfaces(model: &Model) -> Result<Vec<Surface>> {
    const CLASS: &str = "BuildingSurface:Detailed";
    model
        .objects(CLASS)
        .into_iter()
        .map(|(name, fields)| {
            surface(name, fields).ok_or_else(|| Error::Unsupported {
                class: CLASS.into(),
                name: name.into(),
                why: "it needs a surface type and at least three corners".into(),
            })
        })
        .collect()
}

fn surface(name: &str, fields: &Fields) -> Option<Surface> {
    let kind = match text(fields, "surface_type")?.to_ascii_lowercase().as_str() {
        "wall" => SurfaceKind::Wall,
        "floor" => SurfaceKind::Floor,
        "ceiling" => SurfaceKind::Ceiling,
        "roof" => SurfaceKind::Roof,
        _ => return None,
    };
    let part = |field: &str| text(fields, field).unwrap_or_default().to_owned();
    let corners: Vec<_> = fields.get("vertices")?.as_array()?.iter().map(corner).collect::<Option<_>>()?;
    (corners.len() >= 3).then(|| Surface {
        name: name.to_owned(),
        zone: part("zone_name"),
        kind,
        construction: part("construction_name"),
        boundary: part("outside_boundary_condition"),
        boundary_object: part("outside_boundary_condition_object"),
        corners,
    })
}

fn corner(vertex: &Value) -> Option<[f64; 3]> {
    let at = |axis: &str| vertex.get(format!("vertex_{axis}_coordinate"))?.as_f64();
    Some([at("x")?, at("y")?, at("z")?])
}

fn floor_area(surfaces: &[Surface], zone: &str) -> f64 {
    surfaces
        .iter()
        .filter(|s| s.kind == SurfaceKind::Floor && s.zone.eq_ignore_ascii_case(zone))
        .map(Surface::area)
        // Not `sum`, which is -0 of nothing.
        .fold(0.0, |sum, area| sum + area)
}

/// Returns the area of a zone's floors that are not `BuildingSurface:Detailed`, m².
fn other_floor_area(model: &Model, zone: &str) -> f64 {
    const FLOORS: [&str; 4] = ["Floor:Detailed", "Floor:GroundContact", "Floor:Adiabatic", "Floor:Interzone"];
    let floors = FLOORS.iter().flat_map(|class| model.objects(class));
    let own = floors
        .filter(|(_, fields)| text(fields, "zone_name").is_some_and(|name| name.eq_ignore_ascii_case(zone)));
    let area = |fields: &Fields| match fields.get("vertices").and_then(Value::as_array) {
        Some(vertices) => Some(polygon_area(&vertices.iter().map(corner).collect::<Option<Vec<_>>>()?)),
        None => Some(number(fields, "length")? * number(fields, "width")?),
    };
    own.filter_map(|(_, fields)| area(fields)).fold(0.0, |sum, area| sum + area)
}

/// Returns the area of a plane polygon in space, m².
pub fn polygon_area(corners: &[[f64; 3]]) -> f64 {
    area_vector(corners).iter().map(|n| n * n).sum::<f64>().sqrt()
}

/// Returns the normal of a plane polygon with the length of its area, by Newell's method.
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
    fn the_area_of_a_tilted_rectangle_is_length_times_width() {
        let roof = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 3.0, 4.0], [0.0, 3.0, 4.0]];
        assert!((polygon_area(&roof) - 20.0).abs() < 1e-12);
    }
}
