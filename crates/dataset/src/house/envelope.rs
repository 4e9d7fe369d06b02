//! Materials, constructions and surfaces above the ground.
//!
//! An effective resistance includes films, as NBC 9.36 counts it. Layers that have mass are written as they are;
//! one layer without mass makes up the rest.

use b2b_building::Model;
use serde_json::{Value, json};

use super::geometry::{Point, Side};
use super::{ATTIC, Foundation, Geometry, House, LIVING, ground};

/// Film of a wall's outside, m²K/W (ASHRAE Fundamentals, winter wind).
pub(super) const FILM_OUTSIDE: f64 = 0.03;
/// Film of a wall's inside, m²K/W (ASHRAE Fundamentals, still air, horizontal flow).
pub(super) const FILM_WALL: f64 = 0.12;
/// Film of each side of the attic floor, m²K/W (ASHRAE Fundamentals, still air, upward flow).
pub(super) const FILM_CEILING: f64 = 0.11;
/// Least resistance of a layer that EnergyPlus accepts without mass, m²K/W.
const LEAST_RESISTANCE: f64 = 0.01;
/// Area of partitions per heated floor area (engineering judgement).
const PARTITIONS: f64 = 1.0;

/// A layer with mass: name, thickness m, conductivity W/m·K, density kg/m³, specific heat J/kg·K, roughness, solar
/// absorptance. Properties: ASHRAE Fundamentals, chapter 26.
pub(super) struct Layer(&'static str, f64, f64, f64, f64, &'static str, f64);

const SIDING: Layer = Layer("Siding", 0.0127, 0.094, 540.0, 1210.0, "MediumSmooth", 0.6);
pub(super) const SHEATHING: Layer = Layer("Sheathing", 0.0127, 0.12, 540.0, 1210.0, "MediumSmooth", 0.7);
const SHINGLES: Layer = Layer("Shingles", 0.006, 0.081, 1120.0, 1260.0, "VeryRough", 0.9);
pub(super) const GYPSUM: Layer = Layer("Gypsum", 0.0127, 0.16, 800.0, 1090.0, "Smooth", 0.5);
pub(super) const CONCRETE: Layer = Layer("Concrete", 0.2, 1.73, 2240.0, 900.0, "Rough", 0.65);

impl Layer {
    pub(super) fn resistance(&self) -> f64 {
        self.1 / self.2
    }

    pub(super) fn add(&self, model: &mut Model) {
        let material = json!({
            "thickness": self.1,
            "conductivity": self.2,
            "density": self.3,
            "specific_heat": self.4,
            "roughness": self.5,
            "solar_absorptance": self.6,
        });
        model.insert("Material", self.0, material);
    }
}

pub(super) fn add(model: &mut Model, house: &House, geometry: &Geometry) {
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

pub(super) fn insulation(model: &mut Model, name: &str, resistance: f64) {
    let material = json!({
        "roughness": "MediumRough",
        "thermal_resistance": resistance.max(LEAST_RESISTANCE),
    });
    model.insert("Material:NoMass", name, material);
}

/// A construction, its layers from outside to inside.
pub(super) fn construction(model: &mut Model, name: &str, layers: &[&str]) {
    let mut fields = json!({"outside_layer": layers[0]});
    for (index, layer) in layers.iter().enumerate().skip(1) {
        fields[format!("layer_{}", index + 1)] = json!(layer);
    }
    model.insert("Construction", name, fields);
}

/// What is on the other side of a surface.
pub(super) enum Faces<'a> {
    /// Sun and wind.
    Outdoors,
    /// Soil.
    Ground,
    /// A surface of another zone.
    Surface(&'a str),
}

pub(super) fn surface(
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
        Faces::Ground => (ground::CONDITION, "", "NoSun", "NoWind"),
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
