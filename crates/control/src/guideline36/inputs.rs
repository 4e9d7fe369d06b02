//! The points of zones and site from an observation.

use b2b_building::PreparedBuilding;
use b2b_climate::EpwFile;
use b2b_env::{ObservationSpace, Spaces, Target};

use super::points::{SiteInput, ZoneInput};
use super::zone::demand::DemandLevel;

/// Half of the band around a target, K: the least distance between setpoints that the guideline allows (5.3.2) is 0.5 K.
const HALF_BAND: f64 = 0.25;

/// Where the points of a zone are in the observation.
#[derive(Clone, Copy, Debug)]
pub(super) struct ZoneSlots {
    temperature: usize,
    target: Target,
    /// Slot of the occupancy; a task without it counts as always occupied.
    occupancy: Option<usize>,
    cools: bool,
}

impl ZoneSlots {
    /// Returns the slots of a zone, given its indices among all and among the controlled zones.
    pub(super) fn of(space: &ObservationSpace, index: usize, controlled: usize, cools: bool) -> Self {
        Self {
            temperature: space.zone_temperatures().start + index,
            target: space.target(controlled),
            occupancy: space.occupancy(controlled),
            cools,
        }
    }

    /// Returns the points of the zone.
    pub(super) fn read(&self, observation: &[f64]) -> ZoneInput {
        let target = self.target.of(observation);
        ZoneInput {
            temperature: observation[self.temperature],
            heating: target - HALF_BAND,
            cooling: if self.cools { target + HALF_BAND } else { f64::INFINITY },
            people: self.occupancy.is_none_or(|slot| observation[slot] > 0.5),
            next: None,
        }
    }
}

/// Where the points of the site are in the observation.
#[derive(Clone, Copy, Debug)]
pub(super) struct SiteSlots {
    outdoor_temperature: usize,
    demand: DemandLevel,
}

impl SiteSlots {
    pub(super) fn of(space: &ObservationSpace, demand: DemandLevel) -> Self {
        Self { outdoor_temperature: space.outdoor_temperature(), demand }
    }

    /// Returns the points of the site.
    pub(super) fn read(&self, observation: &[f64]) -> SiteInput {
        SiteInput { outdoor_temperature: observation[self.outdoor_temperature], demand: self.demand }
    }
}

/// Returns the ASHRAE climate zone of an episode's weather file, if it has one.
pub(super) fn climate_zone(spaces: &Spaces) -> Option<String> {
    Some(EpwFile::open(&spaces.episode.weather).ok()?.year()?.zone())
}

/// Returns whether a unit of a building has an economizer.
pub(super) fn has_economizer(building: &PreparedBuilding) -> bool {
    let controllers = building.model().objects("Controller:OutdoorAir");
    controllers.iter().any(|(_, fields)| {
        let control = fields.get("economizer_control_type").and_then(|control| control.as_str());
        control.is_some_and(|control| !control.eq_ignore_ascii_case("NoEconomizer"))
    })
}
