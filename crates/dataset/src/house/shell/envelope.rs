//! The envelope above the ground.

use b2b_building::Model;
use serde_json::json;

use super::construction::{
    CONCRETE, FILM_CEILING, FILM_OUTSIDE, FILM_WALL, GYPSUM, SHEATHING, SHINGLES, SIDING, construction,
    insulation,
};
use super::surface::{Faces, surface};
use crate::house::geometry::{Geometry, Side};
use crate::house::parameters::{Foundation, House};
use crate::house::zones::{ATTIC, LIVING};

/// Area of partitions per heated floor area (engineering judgment).
const PARTITIONS: f64 = 1.0;

pub(crate) fn add(model: &mut Model, house: &House, geometry: &Geometry) {
    for layer in [SIDING, SHEATHING, SHINGLES, GYPSUM] {
        layer.add(model);
    }
    walls(model, house, geometry);
    ceiling(model, house, geometry);
    roof(model, geometry);
    windows(model, house, geometry);
    if house.foundation == Foundation::Basement {
        foundation_above_grade(model, house, geometry);
    }
    floors(model, geometry);
    partitions(model, house);
}

fn walls(model: &mut Model, house: &House, geometry: &Geometry) {
    let others =
        FILM_OUTSIDE + SIDING.resistance() + SHEATHING.resistance() + GYPSUM.resistance() + FILM_WALL;
    insulation(model, "Wall Insulation", house.effective_wall_resistance() - others);
    construction(model, "Wall", &["Siding", "Sheathing", "Wall Insulation", "Gypsum"]);
    for side in Side::ALL {
        let Some([bottom, top]) = geometry.outer_wall(side) else { continue };
        let vertices = geometry.wall(side, bottom, top);
        surface(model, &wall_name(side), LIVING, "Wall", "Wall", Faces::Outdoors, &vertices);
    }
}

fn foundation_above_grade(model: &mut Model, house: &House, geometry: &Geometry) {
    CONCRETE.add(model);
    let others = FILM_OUTSIDE + CONCRETE.resistance() + GYPSUM.resistance() + FILM_WALL;
    let resistance = house.effective_foundation_resistance() - others;
    insulation(model, "Foundation Insulation", resistance);
    construction(model, "Foundation Wall", &["Concrete", "Foundation Insulation", "Gypsum"]);
    for side in Side::ALL.into_iter().filter(|side| !geometry.has_garage(*side)) {
        let name = format!("Living {} Foundation Wall", side.name());
        let vertices = geometry.wall(side, 0.0, geometry.sill);
        surface(model, &name, LIVING, "Wall", "Foundation Wall", Faces::Outdoors, &vertices);
    }
}

fn ceiling(model: &mut Model, house: &House, geometry: &Geometry) {
    let others = 2.0 * FILM_CEILING + GYPSUM.resistance();
    insulation(model, "Attic Insulation", house.effective_attic_resistance() - others);
    construction(model, "Ceiling", &["Attic Insulation", "Gypsum"]);
    construction(model, "Attic Floor", &["Gypsum", "Attic Insulation"]);
    let z = geometry.ceiling;
    let (ceiling, floor) = ("Living Ceiling", "Attic Floor");
    let up = geometry.facing_up(z);
    surface(model, ceiling, LIVING, "Ceiling", "Ceiling", Faces::Surface(floor), &up);
    let down = geometry.facing_down(z);
    surface(model, floor, ATTIC, "Floor", "Attic Floor", Faces::Surface(ceiling), &down);
}

fn roof(model: &mut Model, geometry: &Geometry) {
    construction(model, "Roof", &["Shingles", "Sheathing"]);
    construction(model, "Gable", &["Siding", "Sheathing"]);
    for side in Side::ALL {
        let (kind, built) = match side {
            Side::South | Side::North => ("Roof", "Roof"),
            Side::East | Side::West => ("Wall", "Gable"),
        };
        let name = format!("Attic {} {built}", side.name());
        surface(model, &name, ATTIC, kind, built, Faces::Outdoors, &geometry.roof(side));
    }
}

fn windows(model: &mut Model, house: &House, geometry: &Geometry) {
    let glazing = json!({
        "u_factor": house.window_u,
        "solar_heat_gain_coefficient": house.window_shgc,
    });
    model.insert("WindowMaterial:SimpleGlazingSystem", "Glazing", glazing);
    construction(model, "Window", &["Glazing"]);
    for side in Side::ALL {
        let mut window = json!({
            "surface_type": "Window",
            "construction_name": "Window",
            "building_surface_name": wall_name(side),
            "number_of_vertices": 4,
        });
        let Some(corners) = geometry.window(side, house.window_to_wall) else { continue };
        for (corner, point) in corners.iter().enumerate() {
            for (axis, value) in ["x", "y", "z"].iter().zip(point) {
                window[format!("vertex_{}_{axis}_coordinate", corner + 1)] = json!(value);
            }
        }
        let name = format!("Living {} Window", side.name());
        model.insert("FenestrationSurface:Detailed", &name, window);
    }
}

/// The floors between levels: both faces are in the heated zone, which they give mass and floor area.
fn floors(model: &mut Model, geometry: &Geometry) {
    if geometry.levels < 2 {
        return;
    }
    construction(model, "Storey Floor", &["Gypsum", "Sheathing"]);
    construction(model, "Storey Ceiling", &["Sheathing", "Gypsum"]);
    for (level, z) in geometry.storey_floors().enumerate() {
        let floor = format!("Living Floor {}", level + 2);
        let ceiling = format!("Living Ceiling {}", level + 1);
        let down = geometry.facing_down(z);
        surface(model, &floor, LIVING, "Floor", "Storey Floor", Faces::Surface(&ceiling), &down);
        let up = geometry.facing_up(z);
        surface(model, &ceiling, LIVING, "Ceiling", "Storey Ceiling", Faces::Surface(&floor), &up);
    }
}

fn partitions(model: &mut Model, house: &House) {
    construction(model, "Partition", &["Gypsum"]);
    let mass = json!({
        "zone_or_zonelist_name": LIVING,
        "construction_name": "Partition",
        "surface_area": 2.0 * PARTITIONS * house.floor_area,
    });
    model.insert("InternalMass", "Partitions", mass);
}

fn wall_name(side: Side) -> String {
    format!("Living {} Wall", side.name())
}
