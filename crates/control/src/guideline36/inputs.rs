//! The points of zones and site from an observation.

use b2b_building::Conditioning;
use b2b_climate::EpwFile;
use b2b_env::{Bands, Spaces, Target};

use super::points::{NextBand, ZoneInput};

/// Half of the band around a target, K: the guideline's minimum distance between setpoints (5.3.2) is 0.5 K.
const HALF_BAND: f64 = 0.25;
/// Days of the year in winter and in summer.
const SEASONS: [u32; 2] = [10, 190];

/// Where the points of zones and site are in the observation.
#[derive(Clone, Debug)]
pub(super) struct Inputs {
    /// The controlled zones, in model order.
    zones: Vec<ZoneSlots>,
    /// The bands of the zones, as a building management system knows them; `None` in a task with targets.
    bands: Option<Bands>,
    outdoor_temperature: usize,
    day_of_year: usize,
    time_of_day: usize,
}

/// Where the points of a zone are in the observation.
#[derive(Clone, Copy, Debug)]
struct ZoneSlots {
    temperature: usize,
    target: Target,
    /// Slot of the occupancy; a task without it counts as always occupied.
    occupancy: Option<usize>,
    cools: bool,
}

impl Inputs {
    pub(super) fn new(spaces: &Spaces) -> Self {
        let space = &spaces.observation;
        let zone = |(controlled, index): (usize, usize)| ZoneSlots {
            temperature: space.zone_temperatures().start + index,
            target: space.target(controlled),
            occupancy: space.occupancy(controlled),
            cools: spaces.building.zones[index].conditioning == Conditioning::HeatingAndCooling,
        };
        let zones = spaces.controlled_zones().enumerate().map(zone).collect();
        Self {
            zones,
            bands: Bands::of(spaces),
            outdoor_temperature: space.outdoor_temperature(),
            day_of_year: space.day_of_year(),
            time_of_day: space.time_of_day(),
        }
    }

    /// Returns whether the band of a controlled zone changes within a week of winter or summer.
    pub(super) fn band_changes(&self, controlled: usize) -> bool {
        let changes = |bands: &Bands| SEASONS.iter().any(|day| bands.next(controlled, *day, 0.0).is_some());
        self.bands.as_ref().is_some_and(changes)
    }

    /// Writes the points of the zones; returns the outdoor temperature, °C. Allocates nothing once `points` has room
    /// for all.
    pub(super) fn read(&self, observation: &[f64], points: &mut Vec<ZoneInput>) -> f64 {
        points.clear();
        let (day, hour) = (observation[self.day_of_year] as u32, observation[self.time_of_day]);
        let zones = self.zones.iter().enumerate();
        points.extend(zones.map(|(controlled, zone)| match &self.bands {
            None => zone.read(observation),
            Some(bands) => {
                let next = bands.next(controlled, day, hour).map(|next| NextBand {
                    hours: next.hours,
                    heating: next.pair.heating,
                    cooling: next.pair.cooling,
                });
                zone.read_band(observation, next)
            }
        }));
        observation[self.outdoor_temperature]
    }
}

impl ZoneSlots {
    fn read(&self, observation: &[f64]) -> ZoneInput {
        let target = self.target.of(observation);
        ZoneInput {
            temperature: observation[self.temperature],
            heating: target - HALF_BAND,
            cooling: if self.cools { target + HALF_BAND } else { f64::INFINITY },
            people: self.occupancy.is_none_or(|slot| observation[slot] > 0.5),
            next: None,
        }
    }

    fn read_band(&self, observation: &[f64], next: Option<NextBand>) -> ZoneInput {
        let pair = self.target.pair_of(observation, true);
        ZoneInput { heating: pair.heating, cooling: pair.cooling, next, ..self.read(observation) }
    }
}

/// Returns the ASHRAE climate zone of an episode's weather file, if it has one.
pub(super) fn climate_zone(spaces: &Spaces) -> Option<String> {
    Some(EpwFile::open(&spaces.episode.weather).ok()?.year().ok()??.zone())
}
