//! The ground: steady conductances to the monthly temperature of the soil.
//!
//! EnergyPlus's Kiva is more detailed, but the state of its ground depends on the start day of a run: the floor loss in
//! one July week was measured at 95 W in a run started in January and 1298 W in one started that week.

use b2b_building::Model;
use b2b_climate::Site;
use serde_json::json;

use super::construction::FILM_WALL;
use super::surface::{Faces, surface};
use crate::ground_temperatures;
use crate::house::geometry::{Geometry, Side};
use crate::house::parameters::{Foundation, House};
use crate::house::zones::{CRAWLSPACE, GARAGE, LIVING};

/// Wall of a crawlspace without insulation: 0.2 m of concrete, W/m²K.
const BARE_WALL_C: f64 = 8.65;
/// Conductivity of soil, W/m·K (ASHRAE Fundamentals, residential loads: 1.4).
const SOIL_CONDUCTIVITY: f64 = 1.4;
/// Resistance of a basement floor with its film, m²K/W (ASHRAE Fundamentals, residential loads: 0.26).
const FLOOR_RESISTANCE: f64 = 0.26;
/// F-factor of an unheated slab, W/m·K, by resistance of 0.6 m of vertical insulation at its edge, m²K/W (ASHRAE
/// 90.1 Table A6.3, R 0 to 20).
const SLAB_F: [(f64, f64); 6] =
    [(0.0, 1.264), (0.88, 1.004), (1.32, 0.969), (1.76, 0.935), (2.64, 0.900), (3.52, 0.883)];

pub(crate) fn add(model: &mut Model, house: &House, geometry: &Geometry, site: &Site) {
    temperatures(model, site);
    match house.foundation {
        Foundation::Basement => {
            floor(model, house, geometry);
            basement_walls(model, house, geometry);
        }
        Foundation::Slab => floor(model, house, geometry),
        Foundation::Crawlspace => crawlspace(model, geometry),
    }
    if geometry.garage {
        garage(model, geometry);
    }
}

/// Heat loss through the floor and the walls under grade per degree between room and soil, W/K.
pub(crate) fn conductance(house: &House, geometry: &Geometry) -> f64 {
    let floor = floor_f(house, geometry) * geometry.exposed_perimeter();
    match house.foundation {
        Foundation::Slab => floor,
        Foundation::Basement => {
            let resistance = house.effective_foundation_resistance() + soil_resistance(geometry);
            floor + geometry.perimeter() * geometry.depth() / resistance
        }
        // Its floor loses to the crawlspace, not to the soil.
        Foundation::Crawlspace => 0.0,
    }
}

/// Heat loss of the floor per length of perimeter, W/m·K.
fn floor_f(house: &House, geometry: &Geometry) -> f64 {
    match house.foundation {
        Foundation::Slab => slab_f(house.effective_foundation_resistance()),
        Foundation::Basement => {
            basement_floor_u(geometry) * geometry.footprint() / geometry.exposed_perimeter()
        }
        Foundation::Crawlspace => SLAB_F[0].1,
    }
}

/// Mean U of a basement floor through the soil, W/m²K (ASHRAE Fundamentals, residential loads; Latta and Boileau
/// 1969).
fn basement_floor_u(geometry: &Geometry) -> f64 {
    let (width, depth) = (geometry.width, geometry.depth());
    let start = depth / 2.0 + SOIL_CONDUCTIVITY * FLOOR_RESISTANCE / std::f64::consts::PI;
    let log = libm::log((width / 2.0 + start) / start);
    2.0 * SOIL_CONDUCTIVITY / (std::f64::consts::PI * width) * log
}

fn slab_f(resistance: f64) -> f64 {
    let last = SLAB_F[SLAB_F.len() - 1].1;
    SLAB_F.windows(2).find(|pair| resistance <= pair[1].0).map_or(last, |pair| {
        let ((r0, f0), (r1, f1)) = (pair[0], pair[1]);
        f0 + (f1 - f0) * (resistance - r0) / (r1 - r0)
    })
}

/// Resistance of the soil outside a wall, m²K/W, as EnergyPlus adds it to a C-factor wall.
fn soil_resistance(geometry: &Geometry) -> f64 {
    0.0607 + 0.3479 * geometry.depth()
}

fn temperatures(model: &mut Model, site: &Site) {
    model.insert(
        "Site:GroundTemperature:FCfactorMethod",
        "Ground",
        ground_temperatures::monthly_fields(site),
    );
}

fn floor(model: &mut Model, house: &House, geometry: &Geometry) {
    let factor = floor_f(house, geometry);
    f_factor(model, "Floor", geometry.footprint(), geometry.exposed_perimeter(), factor);
    let vertices = geometry.facing_down(geometry.floor);
    surface(model, "Living Floor", LIVING, "Floor", "Floor", Faces::Ground, &vertices);
}

/// A floor on the ground: area m², exposed perimeter m, heat loss W/m·K.
fn f_factor(model: &mut Model, name: &str, area: f64, perimeter: f64, factor: f64) {
    let construction = json!({"area": area, "perimeterexposed": perimeter, "f_factor": factor});
    model.insert("Construction:FfactorGroundFloor", name, construction);
}

/// Bare soil and bare walls under the house.
fn crawlspace(model: &mut Model, geometry: &Geometry) {
    let Some(soil) = geometry.crawlspace else { return };
    let name = "Crawlspace Ground";
    f_factor(model, name, geometry.footprint(), geometry.perimeter(), SLAB_F[0].1);
    let vertices = geometry.facing_down(soil);
    surface(model, name, CRAWLSPACE, "Floor", name, Faces::Ground, &vertices);
    let name = "Crawlspace Buried Wall";
    let construction = json!({"height": -soil, "c_factor": BARE_WALL_C});
    model.insert("Construction:CfactorUndergroundWall", name, construction);
    for side in Side::ALL {
        let wall = format!("Crawlspace {} Buried Wall", side.name());
        let vertices = geometry.wall(side, soil, 0.0);
        surface(model, &wall, CRAWLSPACE, "Wall", name, Faces::Ground, &vertices);
    }
}

/// A slab without insulation.
fn garage(model: &mut Model, geometry: &Geometry) {
    let block = geometry.garage_block();
    f_factor(model, "Garage Slab", block.area(), block.perimeter_but_west(), SLAB_F[0].1);
    let vertices = block.facing_down(0.0);
    surface(model, "Garage Slab", GARAGE, "Floor", "Garage Slab", Faces::Ground, &vertices);
}

/// A C-factor excludes films.
fn basement_walls(model: &mut Model, house: &House, geometry: &Geometry) {
    let construction = json!({
        "height": geometry.depth(),
        "c_factor": 1.0 / (house.effective_foundation_resistance() - FILM_WALL),
    });
    let name = "Basement Wall";
    model.insert("Construction:CfactorUndergroundWall", name, construction);
    for side in Side::ALL {
        let wall = format!("Living {} Basement Wall", side.name());
        let vertices = geometry.wall(side, geometry.floor, 0.0);
        surface(model, &wall, LIVING, "Wall", name, Faces::Ground, &vertices);
    }
}
