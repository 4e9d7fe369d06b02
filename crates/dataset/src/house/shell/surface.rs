//! Surfaces of zones.

use b2b_building::Model;
use serde_json::{Value, json};

use crate::house::geometry::Point;

/// Boundary condition of surfaces in ground contact.
const CONDITION: &str = "GroundFCfactorMethod";

/// The outside boundary condition of a surface.
pub(crate) enum Faces<'a> {
    /// The outdoors.
    Outdoors,
    /// The ground.
    Ground,
    /// Another surface, in another zone or the same.
    Surface(&'a str),
}

pub(crate) fn surface(
    model: &mut Model,
    name: &str,
    zone: &str,
    kind: &str,
    construction: &str,
    faces: Faces,
    vertices: &[Point],
) {
    let (condition, other, sun, wind) = match faces {
        Faces::Outdoors => ("Outdoors", "", "SunExposed", "WindExposed"),
        Faces::Ground => (CONDITION, "", "NoSun", "NoWind"),
        Faces::Surface(other) => ("Surface", other, "NoSun", "NoWind"),
    };
    let vertices: Vec<Value> = vertices
        .iter()
        .map(
            |[x, y, z]| json!({"vertex_x_coordinate": x, "vertex_y_coordinate": y, "vertex_z_coordinate": z}),
        )
        .collect();
    let mut fields = json!({
        "surface_type": kind,
        "construction_name": construction,
        "zone_name": zone,
        "outside_boundary_condition": condition,
        "sun_exposure": sun,
        "wind_exposure": wind,
        "number_of_vertices": vertices.len(),
        "vertices": vertices,
    });
    if !other.is_empty() {
        fields["outside_boundary_condition_object"] = json!(other);
    }
    model.insert("BuildingSurface:Detailed", name, fields);
}
