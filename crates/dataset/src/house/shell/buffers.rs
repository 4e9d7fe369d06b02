//! The unheated zones adjacent to the house: a vented crawlspace under it and a garage on its east side.
//!
//! Surfaces between them and the house are insulated; their outdoor surfaces are not. Their floors are in
//! [`super::ground`], their openings in [`super::infiltration`].

use b2b_building::Model;

use super::construction::{CONCRETE, FILM_WALL, GYPSUM, SHEATHING, construction, insulation};
use super::surface::{Faces, surface};
use crate::house::geometry::{Geometry, Side};
use crate::house::parameters::{Foundation, House};
use crate::house::zones::{CRAWLSPACE, GARAGE, LIVING};

/// Film of each side of a floor, m²K/W (ASHRAE Fundamentals, still air, downward flow).
pub(crate) const FILM_FLOOR: f64 = 0.16;

pub(crate) fn add(model: &mut Model, house: &House, geometry: &Geometry) {
    if geometry.crawlspace.is_some() {
        CONCRETE.add(model);
        construction(model, "Bare Wall", &["Concrete"]);
        crawlspace(model, geometry);
        floor_over_crawlspace(model, house, geometry);
    }
    if geometry.garage {
        garage(model, geometry);
        wall_to_garage(model, house, geometry);
        foundation_to_garage(model, house, geometry);
    }
}

fn crawlspace(model: &mut Model, geometry: &Geometry) {
    for side in Side::ALL.into_iter().filter(|side| !geometry.has_garage(*side)) {
        let name = format!("Crawlspace {} Wall", side.name());
        let vertices = geometry.wall(side, 0.0, geometry.sill);
        surface(model, &name, CRAWLSPACE, "Wall", "Bare Wall", Faces::Outdoors, &vertices);
    }
}

fn floor_over_crawlspace(model: &mut Model, house: &House, geometry: &Geometry) {
    let others = 2.0 * FILM_FLOOR + SHEATHING.resistance();
    insulation(model, "Floor Insulation", house.effective_foundation_resistance() - others);
    construction(model, "Floor", &["Floor Insulation", "Sheathing"]);
    construction(model, "Crawlspace Ceiling", &["Sheathing", "Floor Insulation"]);
    let (floor, ceiling) = ("Living Floor", "Crawlspace Ceiling");
    let down = geometry.facing_down(geometry.floor);
    surface(model, floor, LIVING, "Floor", "Floor", Faces::Surface(ceiling), &down);
    let up = geometry.facing_up(geometry.floor);
    surface(model, ceiling, CRAWLSPACE, "Ceiling", ceiling, Faces::Surface(floor), &up);
}

/// The garage: a shell of sheathing, whose door counts as wall.
fn garage(model: &mut Model, geometry: &Geometry) {
    construction(model, "Garage Wall", &["Siding", "Sheathing"]);
    construction(model, "Garage Roof", &["Shingles", "Sheathing"]);
    let (block, top) = (geometry.garage_block(), geometry.garage_top());
    for side in [Side::South, Side::East, Side::North] {
        let name = format!("Garage {} Wall", side.name());
        let vertices = block.wall(side, 0.0, top);
        surface(model, &name, GARAGE, "Wall", "Garage Wall", Faces::Outdoors, &vertices);
    }
    let up = block.facing_up(top);
    surface(model, "Garage Roof", GARAGE, "Roof", "Garage Roof", Faces::Outdoors, &up);
}

fn wall_to_garage(model: &mut Model, house: &House, geometry: &Geometry) {
    let others = 2.0 * (FILM_WALL + GYPSUM.resistance());
    insulation(model, "Garage Insulation", house.effective_wall_resistance() - others);
    construction(model, "Wall to Garage", &["Gypsum", "Garage Insulation", "Gypsum"]);
    let name = "Wall to Garage";
    shared(model, geometry, LIVING, [name, name], [geometry.sill, geometry.garage_top()]);
}

/// The above-grade part of the foundation next to the garage.
fn foundation_to_garage(model: &mut Model, house: &House, geometry: &Geometry) {
    let levels = [0.0, geometry.sill];
    match house.foundation {
        Foundation::Basement => {
            let inward = "Foundation Wall to House";
            construction(model, inward, &["Gypsum", "Foundation Insulation", "Concrete"]);
            shared(model, geometry, LIVING, ["Foundation Wall", inward], levels);
        }
        Foundation::Crawlspace => shared(model, geometry, CRAWLSPACE, ["Bare Wall", "Bare Wall"], levels),
        Foundation::Slab => {}
    }
}

/// A wall between a zone of the house and the garage, between two levels, with its construction from either side.
fn shared(model: &mut Model, geometry: &Geometry, zone: &str, built: [&str; 2], [bottom, top]: [f64; 2]) {
    let (ours, theirs) = (format!("{zone} {} to Garage", built[0]), format!("Garage {} to {zone}", built[1]));
    let out = geometry.wall(Side::East, bottom, top);
    surface(model, &ours, zone, "Wall", built[0], Faces::Surface(&theirs), &out);
    let back = geometry.garage_block().wall(Side::West, bottom, top);
    surface(model, &theirs, GARAGE, "Wall", built[1], Faces::Surface(&ours), &back);
}
