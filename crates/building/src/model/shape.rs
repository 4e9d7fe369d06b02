//! The geometry of a building: the faces of all zones in one coordinate system.
//!
//! x and y are the axes of the building, z is up; [`Shape::north_axis`] is their rotation from true north. A surface
//! between two zones that the model has on only one side (boundary `Zone`) is a face of its own zone and also bounds
//! the other zone.

use std::collections::HashMap;

use crate::model::{number, text};
use crate::opening::{Opening, openings};
use crate::zone::{Surface, SurfaceKind, area_vector, polygon_area, surfaces};
use crate::{Model, Result};

/// A corner: x, y, z in m.
pub type Point = [f64; 3];

/// Maximum gap of a zone's enclosure, as a fraction of its area, to compute its volume from its faces.
const CLOSED: f64 = 1e-3;
/// Minimum height between levels, m.
const LEVEL: f64 = 0.5;

/// The faces of a building.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Names of the zones, in model order.
    pub zones: Vec<String>,
    /// Every surface of a known zone, in model order.
    pub faces: Vec<Face>,
    /// Angle from true north to the y axis, clockwise, degrees.
    pub north_axis: f64,
    /// Volumes of the zones that the model gives, m³.
    given_volumes: Vec<Option<f64>>,
}

/// A surface in building coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Name of the surface.
    pub name: String,
    /// Its zone, by number.
    pub zone: usize,
    /// Its kind.
    pub kind: SurfaceKind,
    /// Name of its construction.
    pub construction: String,
    /// What is on the other side.
    pub outside_boundary: OutsideBoundary,
    /// Whether it bounds two zones although the model has it on only one side.
    pub one_sided: bool,
    /// Corners, m.
    pub corners: Vec<Point>,
    /// Its windows and doors.
    pub openings: Vec<Opening>,
}

/// The outside boundary condition of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutsideBoundary {
    /// The outdoors.
    Outdoors,
    /// The ground.
    Ground,
    /// A zone, by number; the same zone for a floor within it.
    Zone(usize),
    /// An adiabatic boundary, or temperatures given by the model.
    Other,
}

/// A face seen from a zone that it bounds.
#[derive(Clone, Copy, Debug)]
pub struct Bound<'a> {
    /// The face.
    pub face: &'a Face,
    /// Its kind, seen from this zone.
    pub kind: SurfaceKind,
    /// Its outside boundary condition, seen from this zone.
    pub outside_boundary: OutsideBoundary,
    /// Outward normal with the length of the area, m².
    normal: Point,
}

impl Face {
    /// Returns the area including openings, m².
    pub fn area(&self) -> f64 {
        polygon_area(&self.corners)
    }

    /// Returns the area of its glazing, m².
    pub fn glass_area(&self) -> f64 {
        self.openings.iter().filter(|opening| opening.is_glass).map(Opening::area).sum()
    }
}

impl Bound<'_> {
    /// Returns the area including openings, m².
    pub fn area(&self) -> f64 {
        self.face.area()
    }
}

impl Shape {
    /// Computes the geometry of a model. Windows and doors without corners are omitted.
    ///
    /// # Errors
    /// The errors of [`surfaces`].
    pub fn of(model: &Model) -> Result<Self> {
        let zones = model.names("Zone");
        let surfaces = surfaces(model)?;
        let frames: Vec<Frame> = zones.iter().map(|zone| Frame::of(model, zone)).collect();
        let mut found: HashMap<String, Vec<Opening>> = HashMap::new();
        for opening in openings(model).into_iter().filter(|opening| opening.corners.len() >= 3) {
            found.entry(opening.surface.to_lowercase()).or_default().push(opening);
        }
        let mut faces = Vec::with_capacity(surfaces.len());
        for surface in &surfaces {
            // A surface of an unknown zone is an error that the engine reports.
            let Some(zone) = position(&zones, &surface.zone) else { continue };
            let frame = &frames[zone];
            let mut openings = found.remove(&surface.name.to_lowercase()).unwrap_or_default();
            openings.iter_mut().for_each(|opening| frame.place(&mut opening.corners));
            let mut corners = surface.corners.clone();
            frame.place(&mut corners);
            let outside_boundary = outside_boundary(model, surface, &zones, &surfaces);
            faces.push(Face {
                name: surface.name.clone(),
                zone,
                kind: surface.kind,
                construction: surface.construction.clone(),
                outside_boundary,
                one_sided: matches!(outside_boundary, OutsideBoundary::Zone(other) if other != zone)
                    && !surface.boundary.eq_ignore_ascii_case("Surface"),
                corners,
                openings,
            });
        }
        let given_volumes = zones.iter().map(|zone| given_volume(model, zone)).collect();
        Ok(Self { zones, faces, north_axis: north_axis(model), given_volumes })
    }

    /// Returns the lowest and the highest corner of the bounding box of the building.
    pub fn extent(&self) -> [Point; 2] {
        extent(self.faces.iter().flat_map(|face| &face.corners))
    }

    /// Returns the faces that enclose a zone, without floors inside it.
    pub fn bounds(&self, zone: usize) -> Vec<Bound<'_>> {
        let own = self
            .faces
            .iter()
            .filter(|face| face.zone == zone && face.outside_boundary != OutsideBoundary::Zone(zone));
        let own = own.map(|face| Bound {
            face,
            kind: face.kind,
            outside_boundary: face.outside_boundary,
            normal: area_vector(&face.corners),
        });
        let others = self
            .faces
            .iter()
            .filter(|face| face.one_sided && face.outside_boundary == OutsideBoundary::Zone(zone));
        let others = others.map(|face| Bound {
            face,
            kind: other_side(face.kind),
            outside_boundary: OutsideBoundary::Zone(face.zone),
            normal: area_vector(&face.corners).map(|n| -n),
        });
        own.chain(others).collect()
    }

    /// Returns the lowest and the highest corner of the bounding box of a zone.
    pub fn zone_extent(&self, zone: usize) -> [Point; 2] {
        extent(self.bounds(zone).iter().flat_map(|bound| &bound.face.corners))
    }

    /// Returns the volume of a zone, m³: given in the model, or from its faces, or from its floor and height if they do
    /// not enclose it.
    pub fn volume(&self, zone: usize) -> f64 {
        if let Some(given) = self.given_volumes[zone] {
            return given;
        }
        let mut bounds = self.bounds(zone);
        let area: f64 = bounds.iter().map(Bound::area).sum();
        turn_out(&mut bounds);
        if length(sum(&bounds)) <= CLOSED * area {
            return bounds.iter().map(|b| dot(b.face.corners[0], b.normal) / 3.0).sum::<f64>().abs();
        }
        let floors = bounds.iter().filter(|bound| bound.kind == SurfaceKind::Floor);
        let [low, high] = self.zone_extent(zone);
        floors.map(Bound::area).sum::<f64>() * (high[2] - low[2]).max(0.0)
    }

    /// Returns the areas that pairs of zones share, m², by their numbers, the lower first.
    pub fn shared_areas(&self) -> Vec<([usize; 2], f64)> {
        let mut shared: Vec<([usize; 2], f64)> = Vec::new();
        for face in &self.faces {
            let OutsideBoundary::Zone(other) = face.outside_boundary else { continue };
            if other == face.zone {
                continue;
            }
            let pair = [face.zone.min(other), face.zone.max(other)];
            // A surface with a counterpart is counted twice.
            let area = face.area() * if face.one_sided { 1.0 } else { 0.5 };
            match shared.iter_mut().find(|(known, _)| *known == pair) {
                Some((_, sum)) => *sum += area,
                None => shared.push((pair, area)),
            }
        }
        shared.sort_by_key(|(pair, _)| *pair);
        shared
    }

    /// Returns the number of levels of the floors of the zones that satisfy a condition.
    pub fn levels(&self, zones: impl Fn(usize) -> bool) -> usize {
        let floors = self.faces.iter().filter(|face| face.kind == SurfaceKind::Floor && zones(face.zone));
        let middle = |face: &Face| {
            face.corners.iter().map(|corner| corner[2]).sum::<f64>() / face.corners.len() as f64
        };
        let mut heights: Vec<f64> = floors.map(middle).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup_by(|next, kept| *next - *kept < LEVEL);
        heights.len()
    }
}

/// The position and the rotation of a zone in the building.
struct Frame {
    origin: Point,
    /// Clockwise from the building's y axis, radians.
    turn: f64,
}

impl Frame {
    fn of(model: &Model, zone: &str) -> Self {
        let fields = model.get("Zone", zone).filter(|_| is_relative(model));
        let read = |field: &str| fields.and_then(|fields| number(fields, field)).unwrap_or(0.0);
        Self {
            origin: ["x_origin", "y_origin", "z_origin"].map(read),
            turn: read("direction_of_relative_north").to_radians(),
        }
    }

    fn place(&self, corners: &mut [Point]) {
        let (sin, cos) = (libm::sin(self.turn), libm::cos(self.turn));
        for corner in corners {
            let [x, y, z] = *corner;
            let turned = if self.turn == 0.0 { [x, y, z] } else { [x * cos + y * sin, y * cos - x * sin, z] };
            *corner = std::array::from_fn(|axis| turned[axis] + self.origin[axis]);
        }
    }
}

/// Returns whether corners are relative to the origins of their zones.
pub(crate) fn is_relative(model: &Model) -> bool {
    let rules = model.objects("GlobalGeometryRules");
    let system = rules.first().and_then(|(_, rules)| text(rules, "coordinate_system"));
    system.is_none_or(|system| system.eq_ignore_ascii_case("Relative"))
}

fn given_volume(model: &Model, zone: &str) -> Option<f64> {
    number(model.get("Zone", zone)?, "volume").filter(|volume| *volume > 0.0)
}

fn north_axis(model: &Model) -> f64 {
    let buildings = model.objects("Building");
    let angle = buildings.first().and_then(|(_, fields)| number(fields, "north_axis"));
    angle.filter(|_| is_relative(model)).unwrap_or(0.0)
}

fn outside_boundary(
    model: &Model,
    surface: &Surface,
    zones: &[String],
    surfaces: &[Surface],
) -> OutsideBoundary {
    let object = surface.boundary_object.as_str();
    let zone = |name: &str| position(zones, name).map_or(OutsideBoundary::Other, OutsideBoundary::Zone);
    match surface.boundary.to_ascii_lowercase().as_str() {
        "outdoors" => OutsideBoundary::Outdoors,
        boundary if boundary.starts_with("ground") || boundary == "foundation" => OutsideBoundary::Ground,
        "surface" => {
            let other = surfaces.iter().find(|other| other.name.eq_ignore_ascii_case(object));
            other.map_or(OutsideBoundary::Other, |other| zone(&other.zone))
        }
        "zone" => zone(object),
        "space" => {
            let space = model.get("Space", object).and_then(|space| text(space, "zone_name"));
            space.map_or(OutsideBoundary::Other, zone)
        }
        _ => OutsideBoundary::Other,
    }
}

pub(crate) fn position(zones: &[String], name: &str) -> Option<usize> {
    zones.iter().position(|zone| zone.eq_ignore_ascii_case(name))
}

fn other_side(kind: SurfaceKind) -> SurfaceKind {
    match kind {
        SurfaceKind::Wall => SurfaceKind::Wall,
        SurfaceKind::Floor => SurfaceKind::Ceiling,
        SurfaceKind::Ceiling | SurfaceKind::Roof => SurfaceKind::Floor,
    }
}

/// Reverses the normals of faces whose corners are in the wrong order, while each brings the zone closer to a closed
/// volume. The prototypes have such walls between zones.
fn turn_out(bounds: &mut [Bound]) {
    for _ in 0..bounds.len() {
        let open = sum(bounds);
        let without = |b: &Bound| length(std::array::from_fn(|axis| open[axis] - 2.0 * b.normal[axis]));
        let nearest = bounds.iter_mut().min_by(|a, b| without(a).total_cmp(&without(b)));
        match nearest {
            Some(bound) if without(bound) < 0.5 * length(open) => bound.normal = bound.normal.map(|n| -n),
            _ => return,
        }
    }
}

fn sum(bounds: &[Bound]) -> Point {
    std::array::from_fn(|axis| bounds.iter().map(|bound| bound.normal[axis]).sum())
}

fn dot(a: Point, b: Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

fn extent<'a>(corners: impl Iterator<Item = &'a Point>) -> [Point; 2] {
    let empty = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    let [low, high] = corners.fold(empty, |[low, high], corner| {
        [
            std::array::from_fn(|axis| low[axis].min(corner[axis])),
            std::array::from_fn(|axis| high[axis].max(corner[axis])),
        ]
    });
    // Without corners the extent is empty.
    if low[0] > high[0] { [[0.0; 3]; 2] } else { [low, high] }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::{Value, json};

    use super::*;

    fn surface(kind: &str, zone: &str, [boundary, object]: [&str; 2], corners: &[Point]) -> Value {
        let corner = |[x, y, z]: &Point| json!({"vertex_x_coordinate": x, "vertex_y_coordinate": y, "vertex_z_coordinate": z});
        json!({"surface_type": kind, "zone_name": zone, "construction_name": "C",
            "outside_boundary_condition": boundary, "outside_boundary_condition_object": object,
            "vertices": corners.iter().map(corner).collect::<Vec<_>>()})
    }

    const FLOOR: [Point; 4] = [[0.0, 0.0, 0.0], [0.0, 4.0, 0.0], [5.0, 4.0, 0.0], [5.0, 0.0, 0.0]];
    const TOP: [Point; 4] = [[0.0, 0.0, 3.0], [5.0, 0.0, 3.0], [5.0, 4.0, 3.0], [0.0, 4.0, 3.0]];

    /// A room of 5 by 4 by 3 m whose origin is at x = 10; its east wall is given to the hall `B` on its side only,
    /// and with its corners in the wrong order.
    fn room() -> Model {
        let outdoors = ["Outdoors", ""];
        let wall = |a: [f64; 2], b: [f64; 2]| {
            [[a[0], a[1], 3.0], [a[0], a[1], 0.0], [b[0], b[1], 0.0], [b[0], b[1], 3.0]]
        };
        let text = json!({
            "Zone": {"A": {"x_origin": 10.0, "idf_order": 1}, "B": {"idf_order": 2}},
            "Building": {"X": {"north_axis": 30}},
            "BuildingSurface:Detailed": {
                "Floor": surface("Floor", "A", ["Ground", ""], &FLOOR),
                "Roof": surface("Roof", "A", outdoors, &TOP),
                "South": surface("Wall", "A", outdoors, &wall([0.0, 0.0], [5.0, 0.0])),
                "East": surface("Wall", "A", ["Zone", "b"], &wall([5.0, 4.0], [5.0, 0.0])),
                "North": surface("Wall", "A", outdoors, &wall([5.0, 4.0], [0.0, 4.0])),
                "West": surface("Wall", "A", outdoors, &wall([0.0, 4.0], [0.0, 0.0]))},
        });
        Model::from_epjson(&text.to_string(), Path::new("room.epJSON")).unwrap()
    }

    #[test]
    fn corners_are_relative_to_the_origin_of_their_zone() {
        let shape = Shape::of(&room()).unwrap();
        assert_eq!(shape.zone_extent(0), [[10.0, 0.0, 0.0], [15.0, 4.0, 3.0]]);
        assert_eq!(shape.north_axis, 30.0);
    }

    #[test]
    fn world_coordinates_are_not_transformed() {
        let mut model = room();
        model.insert("GlobalGeometryRules", "R", json!({"coordinate_system": "World"}));
        let shape = Shape::of(&model).unwrap();
        assert_eq!((shape.zone_extent(0)[0][0], shape.north_axis), (0.0, 0.0));
    }

    #[test]
    fn a_wall_with_reversed_corners_does_not_change_the_volume() {
        assert!((Shape::of(&room()).unwrap().volume(0) - 60.0).abs() < 1e-9);
    }

    #[test]
    fn a_given_volume_counts() {
        let mut model = room();
        model.require_mut("Zone", "A").unwrap().insert("volume".into(), json!(55.0));
        assert_eq!(Shape::of(&model).unwrap().volume(0), 55.0);
    }

    #[test]
    fn an_open_zone_has_the_volume_of_its_floor_and_height() {
        let mut model = room();
        model.remove("BuildingSurface:Detailed", "North");
        assert!((Shape::of(&model).unwrap().volume(0) - 60.0).abs() < 1e-9);
    }

    #[test]
    fn a_wall_given_on_one_side_bounds_both_zones_and_is_counted_once() {
        let shape = Shape::of(&room()).unwrap();
        assert_eq!(shape.bounds(1).len(), 1);
        assert_eq!(shape.bounds(1)[0].outside_boundary, OutsideBoundary::Zone(0));
        assert_eq!(shape.shared_areas(), [([0, 1], 12.0)]);
        let mut model = room();
        let east = model.require_mut("BuildingSurface:Detailed", "East").unwrap();
        east.insert("outside_boundary_condition".into(), "Surface".into());
        east.insert("outside_boundary_condition_object".into(), "East of B".into());
        let mut other = Value::Object(east.clone());
        other["zone_name"] = json!("B");
        other["outside_boundary_condition_object"] = json!("East");
        model.insert("BuildingSurface:Detailed", "East of B", other);
        assert_eq!(Shape::of(&model).unwrap().shared_areas(), [([0, 1], 12.0)]);
    }
}
