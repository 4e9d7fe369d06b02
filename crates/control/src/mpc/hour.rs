//! An hour of a building, as its management system sees it.

use b2b_building::hvac::Sequence;
use b2b_env::{Bands, Spaces, Target};

/// Outdoor temperature at which cooling is counted as at its usual efficiency, °C.
const MILD: f64 = 20.0;
/// Difference of outdoor temperatures that counts as 1, K.
const OUTDOOR_UNIT: f64 = 10.0;
/// Hours of a day.
const DAY: f64 = 24.0;

/// A zone at the beginning of an hour: air temperature, heating and cooling setpoint, °C; the last is infinite without
/// cooling.
pub(super) type ZoneState = [f64; 3];

/// Conditions and outcomes of an hour.
#[derive(Clone, Debug, Default)]
pub(super) struct Hour {
    /// Hour of the day.
    pub(super) of_day: usize,
    /// Outdoor temperature at its beginning, °C.
    pub(super) outdoor: f64,
    /// Mean solar radiation, W/m².
    pub(super) radiation: f64,
    /// Mean heating setpoint at its beginning, °C.
    pub(super) setpoint: f64,
    /// Mean occupancy at its beginning.
    pub(super) occupancy: f64,
    pub(super) zones: Vec<ZoneState>,
    /// Heat that each unit delivered, in several forms.
    pub(super) delivered: Vec<f64>,
    /// The level of every shift: 0 is the guideline's choice, otherwise 1 plus the level's index.
    pub(super) levels: Vec<usize>,
    /// Penalty of the resource, usually cost.
    pub(super) cost: f64,
    /// Penalty of discomfort.
    pub(super) discomfort: f64,
    /// Deviation outside the band, K·h per zone.
    pub(super) deviation: f64,
}

/// Where the values are in observations and actions.
#[derive(Clone, Debug)]
pub(super) struct Site {
    zones: Vec<ZoneSlots>,
    units: Vec<UnitSlots>,
    outdoor_temperature: usize,
    time_of_day: usize,
    day_of_year: usize,
    days_of_year: u32,
    hours_per_step: f64,
}

#[derive(Clone, Copy, Debug)]
struct ZoneSlots {
    temperature: usize,
    target: Target,
    occupancy: Option<usize>,
}

/// A unit of a single zone: its actions, and the temperature of its zone.
#[derive(Clone, Copy, Debug)]
struct UnitSlots {
    flow: usize,
    supply_temperature: usize,
    temperature: usize,
}

impl Site {
    /// Forms of a unit's heat.
    const FORMS: usize = 8;

    pub(super) fn of(spaces: &Spaces) -> Self {
        let space = &spaces.observation;
        let temperature = |zone: usize| space.zone_temperatures().start + zone;
        let zone = |(controlled, index): (usize, usize)| ZoneSlots {
            temperature: temperature(index),
            target: space.target(controlled),
            occupancy: space.occupancy(controlled),
        };
        let units =
            spaces.building.laid_out_systems().filter_map(|(system, layout)| match system.sequence() {
                Sequence::SingleZone { .. } => Some(UnitSlots {
                    flow: layout.actions.start,
                    supply_temperature: layout.actions.start + 1,
                    temperature: temperature(layout.zones[0].index),
                }),
                _ => None,
            });
        Self {
            zones: spaces.controlled_zones().enumerate().map(zone).collect(),
            units: units.collect(),
            outdoor_temperature: space.outdoor_temperature(),
            time_of_day: space.time_of_day(),
            day_of_year: space.day_of_year(),
            days_of_year: spaces.episode.period.calendar().days(),
            hours_per_step: 1.0 / f64::from(spaces.episode.steps_per_hour),
        }
    }

    /// Returns the day of the year and the hour of the day.
    pub(super) fn time(&self, observation: &[f64]) -> (u32, f64) {
        (observation[self.day_of_year] as u32, observation[self.time_of_day])
    }

    /// Returns the outdoor temperature, °C.
    pub(super) fn outdoor(&self, observation: &[f64]) -> f64 {
        observation[self.outdoor_temperature]
    }

    /// Returns the mean heating setpoint, °C.
    pub(super) fn heating_setpoint(&self, observation: &[f64]) -> f64 {
        let heating = |zone: &ZoneSlots| zone.target.pair_of(observation, true).heating;
        self.zones.iter().map(heating).sum::<f64>() / self.zones.len() as f64
    }

    /// Returns the mean heating setpoint of the schedules at an hour from the beginning of a day on, °C.
    pub(super) fn scheduled_setpoint(&self, bands: &Bands, day_of_year: u32, hour: f64) -> f64 {
        let later = (hour / DAY).floor();
        let day = (day_of_year - 1 + later as u32) % self.days_of_year + 1;
        let heating = |zone: usize| bands.at(zone, day, hour - DAY * later, false).heating;
        (0..self.zones.len()).map(heating).sum::<f64>() / self.zones.len() as f64
    }

    /// Begins an hour with the levels of the shifts.
    pub(super) fn begin(&self, observation: &[f64], levels: &[usize]) -> Hour {
        let state = |zone: &ZoneSlots| {
            let band = zone.target.pair_of(observation, true);
            [observation[zone.temperature], band.heating, band.cooling]
        };
        let people = |zone: &ZoneSlots| zone.occupancy.map_or(0.0, |slot| observation[slot].clamp(0.0, 1.0));
        Hour {
            of_day: observation[self.time_of_day].round() as usize % 24,
            outdoor: self.outdoor(observation),
            setpoint: self.heating_setpoint(observation),
            occupancy: self.zones.iter().map(people).sum::<f64>() / self.zones.len() as f64,
            zones: self.zones.iter().map(state).collect(),
            delivered: vec![0.0; self.units.len() * Self::FORMS],
            levels: levels.to_vec(),
            ..Hour::default()
        }
    }

    /// Adds the deviation outside the band after a step.
    pub(super) fn deviate(&self, observation: &[f64], hour: &mut Hour) {
        let outside = |zone: &ZoneSlots| {
            zone.target.pair_of(observation, true).deviation(observation[zone.temperature]).abs()
        };
        let mean = self.zones.iter().map(outside).sum::<f64>() / self.zones.len() as f64;
        hour.deviation += mean * self.hours_per_step;
    }

    /// Adds the heat that the units deliver by an action.
    pub(super) fn deliver(&self, observation: &[f64], action: &[f64], hour: &mut Hour) {
        let outdoor = hour.outdoor / OUTDOOR_UNIT;
        for (unit, forms) in self.units.iter().zip(hour.delivered.chunks_exact_mut(Self::FORMS)) {
            let flow = action[unit.flow];
            let heat = flow * (action[unit.supply_temperature] - observation[unit.temperature]);
            let (heating, cooling) = (heat.max(0.0), (-heat).max(0.0));
            let runs = f64::from(u8::from(flow > 0.0));
            let own = [
                heating,
                cooling,
                heating * heating,
                cooling * cooling,
                heating * outdoor,
                cooling * (hour.outdoor - MILD) / OUTDOOR_UNIT,
                runs,
                runs * outdoor,
            ];
            forms.iter_mut().zip(own).for_each(|(form, own)| *form += own * self.hours_per_step);
        }
    }
}
