//! The points of zones and site from an observation.

use b2b_building::PreparedBuilding;
use b2b_climate::EpwFile;
use b2b_env::{Bands, ObservationSpace, Spaces, Target};

use super::points::{NextBand, SiteInput, ZoneInput};
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
    /// Index among the controlled zones.
    controlled: usize,
}

/// The bands of a building's zones with the slots of the time, as a building management system knows them.
#[derive(Clone, Debug)]
pub(super) struct Schedules {
    /// `None` in a task with targets.
    bands: Option<Bands>,
    day_of_year: usize,
    time_of_day: usize,
}

impl Schedules {
    pub(super) fn of(spaces: &Spaces) -> Self {
        let space = &spaces.observation;
        Self {
            bands: Bands::new(&spaces.episode.task.setpoints, &spaces.building),
            day_of_year: space.day_of_year(),
            time_of_day: space.time_of_day(),
        }
    }

    /// Returns the next change of a controlled zone's setpoints.
    fn next(&self, zone: usize, observation: &[f64]) -> Option<NextBand> {
        let (day, hour) = (observation[self.day_of_year] as u32, observation[self.time_of_day]);
        let next = self.bands.as_ref()?.next(zone, day, hour)?;
        Some(NextBand { hours: next.hours, heating: next.pair.heating, cooling: next.pair.cooling })
    }
}

impl ZoneSlots {
    /// Returns the slots of a zone, given its indices among all and among the controlled zones.
    pub(super) fn of(space: &ObservationSpace, index: usize, controlled: usize, cools: bool) -> Self {
        Self {
            temperature: space.zone_temperatures().start + index,
            target: space.target(controlled),
            occupancy: space.occupancy(controlled),
            cools,
            controlled,
        }
    }

    /// Returns the points of the zone.
    pub(super) fn read(&self, observation: &[f64], schedules: &Schedules) -> ZoneInput {
        let has_bands = schedules.bands.is_some();
        let mut pair = self.target.pair_of(observation, has_bands);
        if !has_bands {
            pair.heating -= HALF_BAND;
            pair.cooling = if self.cools { pair.cooling + HALF_BAND } else { f64::INFINITY };
        }
        ZoneInput {
            temperature: observation[self.temperature],
            heating: pair.heating,
            cooling: pair.cooling,
            people: self.occupancy.is_none_or(|slot| observation[slot] > 0.5),
            next: schedules.next(self.controlled, observation),
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
