//! Window-to-wall ratio.

use serde_json::json;

use crate::edit::geometry::require_corners;
use crate::model::number;
use crate::opening::{FENESTRATION, Opening, corners, is_glass, is_glass_door, openings, parent};
use crate::parameter::OutOfBounds;
use crate::zone::{self, Surface, area_vector, polygon_area};
use crate::{Error, Model, Parameter, Result};

/// Wall left above and below a window, m.
const MARGIN: f64 = 0.05;
/// Largest difference from the area of its bounding rectangle, relative to it, for which a polygon is a rectangle.
const ROUNDING: f64 = 0.01;
/// Largest sine of the angle from the vertical for which a wall is vertical.
const VERTICAL: f64 = 0.01;
/// Largest overlap along a wall, m, of openings that are side by side.
const TOUCHING: f64 = 0.001;

/// A window in a wall.
struct Window {
    name: String,
    /// Area over height, with the multipliers of the window and its zone, m.
    width: f64,
    height: f64,
    /// Maximum height in its wall.
    greatest: f64,
    /// Heights between which it stays, m.
    room: [f64; 2],
}

/// Resizes windows to a ratio of window and glass door area to gross exterior wall area.
///
/// Windows change in height and keep their width and place along the wall. Their centers stay at the same height where
/// the wall has room, and move up or down otherwise. Doors above or below a window bound it, and two windows share the
/// room between them, so that no window meets another or a door. All scale alike; when one fills its room, the others
/// take the rest. Glass doors stay as they are. In a wall that is not a rectangle,
/// such as a gable, windows do not grow. Returns the number of windows.
///
/// # Errors
/// [`Error::Parameter`] when the walls with windows are too small or glass doors alone reach the ratio;
/// [`Error::Edit`] for a window without corners or in a tilted wall.
pub fn resize(model: &mut Model, ratio: f64) -> Result<usize> {
    require_corners(model, &["Window", "GlazedDoor"])?;
    let surfaces = zone::surfaces(model)?;
    let outer = surfaces.iter().filter(|surface| surface.is_exterior_wall());
    let walls: f64 = outer.map(|wall| wall.area() * zone::multiplier(model, &wall.zone)).sum();
    let (windows, doors) = glass_in_walls(model, &surfaces)?;
    if windows.is_empty() {
        return Ok(0);
    }
    let max_glass: f64 = windows.iter().map(|w| w.width * w.greatest).sum();
    let reachable = Parameter::new("window_to_wall", "1", doors / walls, (max_glass + doors) / walls);
    let refused = || Error::Parameter(OutOfBounds { parameter: reachable, value: ratio });
    let factor = height_factor(&windows, ratio * walls - doors).ok_or_else(refused)?;
    for window in &windows {
        set_height(model, window, (window.height * factor).min(window.greatest));
    }
    Ok(windows.len())
}

/// The windows in exterior walls, in model order, and the area of the glass doors in them, m², in all copies of a zone.
fn glass_in_walls(model: &Model, surfaces: &[Surface]) -> Result<(Vec<Window>, f64)> {
    let (mut windows, mut doors) = (Vec::new(), 0.0);
    let all = openings(model);
    for (name, fields) in model.objects(FENESTRATION).into_iter().filter(|(_, fields)| is_glass(fields)) {
        let Some(wall) = parent(surfaces, fields).filter(|wall| wall.is_exterior_wall()) else { continue };
        let corners = corners(fields);
        let (low, high) = heights(&corners);
        let height = high - low;
        let copies = number(fields, "multiplier").unwrap_or(1.0) * zone::multiplier(model, &wall.zone);
        let width = mean_width(&corners, height) * copies;
        if is_glass_door(fields) {
            doors += width * height;
            continue;
        }
        if !is_vertical(wall) {
            let why =
                format!("its wall `{}` is tilted; only windows in vertical walls can be resized", wall.name);
            return Err(Error::edit(FENESTRATION, name, &why));
        }
        let room = room(model, name, wall, &all);
        let greatest = if is_rectangle(&wall.corners) { room[1] - room[0] - 2.0 * MARGIN } else { height };
        windows.push(Window { name: name.to_owned(), width, height, greatest: greatest.max(height), room });
    }
    Ok((windows, doors))
}

/// Returns the heights between which a window can grow: those of its wall, of doors above and below it, and the middle
/// of the room that it shares with another window, m.
fn room(model: &Model, window: &str, wall: &Surface, openings: &[Opening]) -> [f64; 2] {
    let (floor, ceiling) = heights(&wall.corners);
    let in_wall = openings.iter().filter(|opening| opening.surface.eq_ignore_ascii_case(&wall.name));
    let (own, others): (Vec<_>, Vec<_>) = in_wall.partition(|opening| opening.name == window);
    let Some(own) = own.first() else { return [floor, ceiling] };
    let ((low, high), [left, right]) = (heights(&own.corners), along(wall, &own.corners));
    let mut room = [floor, ceiling];
    for other in others {
        let ([start, end], (bottom, top)) = (along(wall, &other.corners), heights(&other.corners));
        if right.min(end) - left.max(start) <= TOUCHING {
            continue;
        }
        let resized =
            model.get(FENESTRATION, &other.name).is_some_and(|it| is_glass(it) && !is_glass_door(it));
        let limit = |own: f64, edge: f64| if resized { (own + edge) / 2.0 } else { edge };
        if bottom + top > low + high {
            room[1] = room[1].min(limit(high, bottom).max(high));
        } else {
            room[0] = room[0].max(limit(low, top).min(low));
        }
    }
    room
}

/// Returns where some corners begin and end along a wall, m.
fn along(wall: &Surface, corners: &[[f64; 3]]) -> [f64; 2] {
    let [x, y, _] = area_vector(&wall.corners);
    let length = x.hypot(y);
    let places = corners.iter().map(|corner| (corner[1] * x - corner[0] * y) / length);
    places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], place| [low.min(place), high.max(place)])
}

fn is_vertical(wall: &Surface) -> bool {
    area_vector(&wall.corners)[2].abs() <= VERTICAL * wall.area()
}

/// Returns whether a polygon in a vertical plane fills its bounding rectangle.
fn is_rectangle(corners: &[[f64; 3]]) -> bool {
    let (low, high) = heights(corners);
    let around = width(corners) * (high - low);
    (polygon_area(corners) - around).abs() <= ROUNDING * around
}

/// The width of a rectangle, m, or of the rectangle with the height and the area of another polygon.
fn mean_width(corners: &[[f64; 3]], height: f64) -> f64 {
    if is_rectangle(corners) { width(corners) } else { polygon_area(corners) / height }
}

/// Returns the factor of all heights that gives the windows an area, m²; `None` if there is none. Windows that would
/// exceed their walls have their maximum height, and the others take the rest.
fn height_factor(windows: &[Window], area: f64) -> Option<f64> {
    let mut free: Vec<&Window> = windows.iter().collect();
    let mut left = area;
    loop {
        let factor = left / free.iter().map(|w| w.width * w.height).sum::<f64>();
        if !factor.is_finite() || factor <= 0.0 {
            return None;
        }
        let (full, rest): (Vec<&Window>, _) = free.into_iter().partition(|w| w.height * factor > w.greatest);
        if full.is_empty() {
            return Some(factor);
        }
        left -= full.iter().map(|w| w.width * w.greatest).sum::<f64>();
        free = rest;
    }
}

fn set_height(model: &mut Model, window: &Window, height: f64) {
    let Some(fields) = model.get_mut(FENESTRATION, &window.name) else { return };
    let [floor, ceiling] = window.room;
    let corners = corners(fields);
    let (low, high) = heights(&corners);
    let (lowest, highest) = (floor + MARGIN.min(low - floor), ceiling - MARGIN.min(ceiling - high));
    let bottom = ((low + high - height) / 2.0).min(highest - height).max(lowest);
    for (index, corner) in corners.iter().enumerate() {
        let z = bottom + (corner[2] - low) / (high - low) * height;
        fields.insert(format!("vertex_{}_z_coordinate", index + 1), json!(z));
    }
}

/// Lowest and highest z of some corners.
fn heights(corners: &[[f64; 3]]) -> (f64, f64) {
    corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c[2]), h.max(c[2])))
}

/// Extent in plan of a vertical rectangle, m.
fn width(corners: &[[f64; 3]]) -> f64 {
    let distance = |a: &[f64; 3], b: &[f64; 3]| {
        let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
        (dx * dx + dy * dy).sqrt()
    };
    corners.iter().map(|corner| distance(corner, &corners[0])).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::Value;

    use super::*;

    fn glass(kind: &str, x: [f64; 2], z: [f64; 2]) -> Value {
        let mut fields = json!({"surface_type": kind, "building_surface_name": "Wall"});
        let corners = [(x[0], z[1]), (x[0], z[0]), (x[1], z[0]), (x[1], z[1])];
        for (i, (x, z)) in corners.into_iter().enumerate() {
            fields[format!("vertex_{}_x_coordinate", i + 1)] = json!(x);
            fields[format!("vertex_{}_y_coordinate", i + 1)] = json!(0.0);
            fields[format!("vertex_{}_z_coordinate", i + 1)] = json!(z);
        }
        fields
    }

    /// A wall of 10 m by 3 m with two windows and a glass door.
    fn model() -> Model {
        let corner =
            |x, z| json!({"vertex_x_coordinate": x, "vertex_y_coordinate": 0, "vertex_z_coordinate": z});
        let text = json!({
            "BuildingSurface:Detailed": {"Wall": {"surface_type": "Wall", "outside_boundary_condition": "Outdoors",
                "vertices": [corner(0, 3), corner(0, 0), corner(10, 0), corner(10, 3)]}},
            FENESTRATION: {
                "Low": glass("Window", [1.0, 3.0], [0.1, 1.1]),
                "High": glass("Window", [4.0, 6.0], [0.5, 2.5]),
                "Door": glass("GlassDoor", [7.0, 8.0], [0.0, 2.0])},
        });
        Model::from_epjson(&text.to_string(), Path::new("test.epJSON")).unwrap()
    }

    fn z(model: &Model, window: &str) -> (f64, f64) {
        heights(&corners(model.get(FENESTRATION, window).unwrap()))
    }

    #[test]
    fn the_ratio_is_met_and_doors_stay() {
        for ratio in [0.1, 0.2, 8.0 / 30.0, 0.40] {
            let mut model = model();
            resize(&mut model, ratio).unwrap();
            let (low, high) = (z(&model, "Low"), z(&model, "High"));
            let area = 2.0 * (low.1 - low.0) + 2.0 * (high.1 - high.0) + 2.0;
            assert!((area / 30.0 - ratio).abs() < 1e-12, "{ratio}: {}", area / 30.0);
            assert_eq!(z(&model, "Door"), (0.0, 2.0));
            assert!(low.0 >= MARGIN - 1e-12 && high.1 <= 3.0 - MARGIN + 1e-12);
        }
    }

    #[test]
    fn windows_move_and_share_the_area_that_a_full_wall_cannot_take() {
        let mut model = model();
        resize(&mut model, 0.40).unwrap();
        let (low, high) = (z(&model, "Low"), z(&model, "High"));
        assert!((high.1 - high.0 - 2.9).abs() < 1e-12, "{high:?}");
        assert!((low.1 - low.0 - 2.1).abs() < 1e-12 && (low.0 - MARGIN).abs() < 1e-12, "{low:?}");
    }

    #[test]
    fn windows_above_each_other_and_above_doors_do_not_meet() {
        let mut model = model();
        model.insert(FENESTRATION, "Above", glass("Window", [2.0, 4.0], [1.5, 2.5]));
        model.insert(FENESTRATION, "Transom", glass("Window", [7.0, 8.0], [2.1, 2.4]));
        model.insert(FENESTRATION, "Entry", glass("Door", [8.5, 9.5], [0.0, 2.1]));
        model.insert(FENESTRATION, "Fanlight", glass("Window", [8.5, 9.5], [2.2, 2.4]));
        resize(&mut model, 0.45).unwrap();
        let names = ["Low", "High", "Door", "Above", "Transom", "Entry", "Fanlight"];
        let openings = openings(&model);
        let area: f64 = openings.iter().filter(|each| each.is_glass).map(Opening::area).sum();
        assert!((area / 30.0 - 0.45).abs() < 1e-12, "{area}");
        let [low, _, door, above, transom, entry, fanlight] = names.map(|name| z(&model, name));
        assert!(above.0 - low.1 >= 2.0 * MARGIN - 1e-12, "{low:?} {above:?}");
        assert!(transom.0 >= door.1 + MARGIN - 1e-12 && fanlight.0 >= entry.1 + MARGIN - 1e-12);
        assert!(transom.1 <= 2.95 + 1e-12, "{transom:?}");
    }

    #[test]
    fn the_walls_windows_and_doors_of_a_repeated_zone_count_as_often() {
        let mut model = model();
        let mut bare = model.require("BuildingSurface:Detailed", "Wall").unwrap().clone();
        bare.insert("zone_name".into(), json!("Top"));
        model.insert("BuildingSurface:Detailed", "Bare wall", bare.into());
        let wall = model.require_mut("BuildingSurface:Detailed", "Wall").unwrap();
        wall.insert("zone_name".into(), json!("Mid"));
        model.insert("Zone", "Mid", json!({"multiplier": 9}));
        resize(&mut model, 0.3).unwrap();
        let height = |name| z(&model, name).1 - z(&model, name).0;
        let glass = 9.0 * (2.0 * height("Low") + 2.0 * height("High") + 2.0);
        assert!((glass / (10.0 * 30.0) - 0.3).abs() < 1e-12, "{glass}");
    }

    #[test]
    fn windows_in_a_gable_do_not_grow_and_copies_count() {
        let mut model = model();
        let corners = model.require_mut("BuildingSurface:Detailed", "Wall").unwrap();
        let ridge = json!({"vertex_x_coordinate": 5, "vertex_y_coordinate": 0, "vertex_z_coordinate": 6});
        corners["vertices"].as_array_mut().unwrap().push(ridge);
        model.require_mut(FENESTRATION, "Low").unwrap().insert("multiplier".into(), json!(2));
        let area = |model: &Model| {
            let height = |name| z(model, name).1 - z(model, name).0;
            2.0 * (2.0 * height("Low") + height("High")) + 2.0
        };
        assert_eq!(area(&model), 10.0);
        resize(&mut model, 6.0 / 45.0).unwrap();
        assert!((area(&model) - 6.0).abs() < 1e-9, "{}", area(&model));
        let error = resize(&mut model, 0.30).unwrap_err().to_string();
        assert!(error.contains("window_to_wall"), "{error}");
    }

    #[test]
    fn what_cannot_be_resized_is_named() {
        let mut tilted = model();
        tilted.require_mut("BuildingSurface:Detailed", "Wall").unwrap()["vertices"][0]["vertex_y_coordinate"] =
            json!(3);
        let error = resize(&mut tilted, 0.2).unwrap_err().to_string();
        assert!(error.contains("tilted"), "{error}");
        let mut simple = model();
        simple.insert("Window", "South Window", json!({"building_surface_name": "Wall"}));
        let error = resize(&mut simple, 0.2).unwrap_err().to_string();
        assert!(error.contains("Window `South Window`") && error.contains("FenestrationSurface"), "{error}");
    }

    #[test]
    fn a_ratio_that_does_not_fit_is_rejected_with_the_limits() {
        let error = resize(&mut model(), 0.6).unwrap_err().to_string();
        assert!(error.contains("window_to_wall") && error.contains("0.45"), "{error}");
    }
}
