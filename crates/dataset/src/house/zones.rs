//! The zones, the heated one first.

use b2b_building::Model;
use serde_json::json;

use super::geometry::Geometry;

/// The heated zone.
pub const LIVING: &str = "Living";
/// The vented zone under the roof.
pub const ATTIC: &str = "Attic";
/// The vented zone under the floor of a house on a crawlspace.
pub const CRAWLSPACE: &str = "Crawlspace";
/// The zone of an unheated garage.
pub const GARAGE: &str = "Garage";

/// Ratio of the heat capacity of the heated zone's air and furnishings to its air alone. Without it, full power changes
/// the air temperature by 1 K in one step (measured); simulation practice for houses is 3 to 15 (engineering judgment).
const CAPACITY_MULTIPLIER: f64 = 7.0;

pub(super) fn add(model: &mut Model, geometry: &Geometry) {
    let living = json!({
        "idf_order": 1,
        "volume": geometry.living_volume(),
    });
    model.insert("Zone", LIVING, living);
    let crawlspace = geometry.crawlspace.map(|_| (CRAWLSPACE, geometry.crawlspace_volume()));
    let garage = geometry.garage.then(|| (GARAGE, geometry.garage_volume()));
    let unheated = [Some((ATTIC, geometry.attic_volume())), crawlspace, garage];
    for (order, (name, volume)) in (2..).zip(unheated.into_iter().flatten()) {
        let zone = json!({"idf_order": order, "volume": volume, "part_of_total_floor_area": "No"});
        model.insert("Zone", name, zone);
    }
    let furnishings = json!({
        "zone_or_zonelist_name": LIVING,
        "temperature_capacity_multiplier": CAPACITY_MULTIPLIER,
    });
    let class = "ZoneCapacitanceMultiplier:ResearchSpecial";
    model.insert(class, "Furnishings", furnishings);
}
