//! Design heat loss and gain, and the equipment sized for them.
//!
//! Uses steady-state conductances and the site's design temperatures, similar to CSA F280, without thermal storage.

use b2b_climate::{DesignDay, Site};

use super::capacities::Capacities;
use crate::house::gains;
use crate::house::geometry::{Geometry, Side};
use crate::house::parameters::{Foundation, House};
use crate::house::shell::{ground, infiltration};

/// Room temperature of the calculation, °C: winter and summer.
const INDOOR: [f64; 2] = [21.0, 24.0];
/// Wind where the station has no record, m/s: winter and summer (ASHRAE Fundamentals: 6.7 and 3.4).
const WIND: [f64; 2] = [6.7, 3.4];
/// Heat capacity of air at 20 °C and sea level, J/m³K.
const AIR: f64 = 1.204 * 1006.0;
/// Sun on a vertical surface at the worst hour, W/m²: mean of the four sides in July at 45° north (ASHRAE
/// Fundamentals, clear sky).
const SUN: f64 = 400.0;
/// Share of the sun transmitted by blinds (ASHRAE Fundamentals, interior attenuation).
const BLINDS: f64 = 0.8;
/// Sol-air excess of walls and of a vented attic over outdoor air in summer, K (engineering judgment).
const SOL_AIR: [f64; 2] = [5.0, 15.0];
/// Sensible share of the summer load (AHRI-rated coils: 0.7 to 0.8).
pub(crate) const SENSIBLE: f64 = 0.75;
/// Supply air over room air at full heat, K: 45 °C into 21 °C.
const SUPPLY_RISE: f64 = 24.0;
/// Design flow per cooling capacity, m³/s per W (AHRI practice: 400 cfm per ton).
const FLOW_PER_CAPACITY: f64 = 5.37e-5;

impl Capacities {
    /// Sizes equipment to hold 21 °C on the cold design day with furnace or backup only and 24 °C on the hot one, with
    /// the oversizing of the house.
    ///
    /// The flow carries the backup's heat at 45 °C and the cooling at 400 cfm per ton; cooling and heat pump have the
    /// capacity of that flow at 400 cfm per ton.
    pub fn for_design_days(house: &House, site: &Site) -> Self {
        let backup = house.heating_oversizing * heat_loss(house, site);
        let cooling = house.cooling_oversizing * heat_gain(house, site) / SENSIBLE;
        let flow = (backup / (AIR * SUPPLY_RISE)).max(cooling * FLOW_PER_CAPACITY);
        let heat_pump = flow / FLOW_PER_CAPACITY;
        Self { flow, cooling: heat_pump, heating: heat_pump, backup }
    }
}

/// Heat loss on the cold design day, without sun and people, W.
pub(crate) fn heat_loss(house: &House, site: &Site) -> f64 {
    let geometry = Geometry::new(house);
    let difference = INDOOR[0] - site.heating.dry_bulb;
    let soil = site.ground_temperatures.iter().copied().fold(f64::INFINITY, f64::min);
    let envelope = walls(house, &geometry) + ceiling(house, &geometry) + windows(house, &geometry);
    let air = outdoor_air(house, &geometry, &site.heating, difference, WIND[0]);
    let loss = (envelope + air) * difference + ground::conductance(house, &geometry) * (INDOOR[0] - soil);
    loss.max(0.0)
}

/// Heat gain on the hot design day, W; the ground is left out. The latent heat of people and appliances is counted like
/// sensible heat.
pub(crate) fn heat_gain(house: &House, site: &Site) -> f64 {
    let geometry = Geometry::new(house);
    let difference = site.cooling.dry_bulb - INDOOR[1];
    let air = outdoor_air(house, &geometry, &site.cooling, difference, WIND[1]);
    let sun = SUN * BLINDS * house.window_shgc * house.window_to_wall * geometry.wall_area();
    let gain = walls(house, &geometry) * (difference + SOL_AIR[0])
        + ceiling(house, &geometry) * (difference + SOL_AIR[1])
        + (windows(house, &geometry) + air) * difference
        + sun
        + gains::mean(house);
    gain.max(0.0)
}

/// Conductance of walls, foundation above grade and a floor over a crawlspace, W/K. Garage and crawlspace are taken
/// at outdoor temperature.
fn walls(house: &House, geometry: &Geometry) -> f64 {
    let opaque = geometry.wall_area() * (1.0 - house.window_to_wall) + garage_wall(geometry);
    let foundation = match house.foundation {
        Foundation::Basement => geometry.perimeter() * geometry.sill,
        Foundation::Slab => 0.0,
        Foundation::Crawlspace => geometry.footprint(),
    };
    opaque / house.effective_wall_resistance() + foundation / house.effective_foundation_resistance()
}

/// Area of the wall between house and garage, m².
fn garage_wall(geometry: &Geometry) -> f64 {
    let sides = Side::ALL.into_iter().filter(|side| geometry.has_garage(*side));
    sides.map(|side| geometry.length_of(side) * (geometry.garage_top() - geometry.sill)).sum()
}

/// Conductance of the top ceiling, the attic taken at outdoor temperature, W/K.
fn ceiling(house: &House, geometry: &Geometry) -> f64 {
    geometry.footprint() / house.effective_attic_resistance()
}

fn windows(house: &House, geometry: &Geometry) -> f64 {
    house.window_u * house.window_to_wall * geometry.wall_area()
}

/// Heat that infiltration and ventilation carry per degree, W/K.
fn outdoor_air(house: &House, geometry: &Geometry, day: &DesignDay, difference: f64, usual_wind: f64) -> f64 {
    let wind = day.wind_speed.unwrap_or(usual_wind);
    let leaks = infiltration::flow(house, geometry, difference, wind);
    // The flow is outdoor air, denser in the cold.
    let density = 293.15 / (273.15 + day.dry_bulb);
    AIR * density * (leaks + house.unrecovered_ventilation() / 1000.0)
}
