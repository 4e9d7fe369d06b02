//! Target temperatures: constant, by occupancy, or drawn at random for every zone and day.

pub(crate) mod band;
pub(crate) mod calendar;

use std::str::FromStr;

use b2b_base::random::{standard_normal, uniform};
use b2b_building::{BuildingType, Class, Day};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use self::band::{Band, Bands, NextPair, Pair};
use self::calendar::{Moment, Season, Seasons};
use crate::Result;
use crate::limits::within;
use crate::random::stream;

/// Target temperatures, °C (paper, section on tasks).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "mode", rename_all = "snake_case", deny_unknown_fields)]
#[serde(expecting = "an object with the `mode` constant, occupancy, random or band")]
pub enum Setpoints {
    /// One target for all zones at all times.
    Constant {
        /// Target.
        #[serde(default = "comfortable")]
        target: f64,
    },
    /// Target by simulated occupancy of the zone.
    Occupancy {
        /// Target when occupied.
        #[serde(default = "comfortable")]
        occupied: f64,
        /// Target when unoccupied, December to February; June to August in the south.
        #[serde(default = "winter")]
        winter: f64,
        /// Target when unoccupied, June to August; December to February in the south.
        #[serde(default = "summer")]
        summer: f64,
        /// Target when unoccupied, other months.
        #[serde(default = "comfortable")]
        otherwise: f64,
    },
    /// Drawn for every zone and day; equal seeds give equal targets.
    Random {
        /// Random seed.
        #[serde(default)]
        seed: u64,
        /// Distributions to draw from. Default: the distributions of the building type, or of offices without a type.
        #[serde(default)]
        day: Option<RandomDay>,
    },
    /// A heating and a cooling setpoint for every zone: the operation tasks.
    Band {
        /// Source of the setpoints.
        #[serde(default)]
        band: Band,
    },
}

/// Distributions of the targets of a day.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RandomDay {
    /// Arrival of the occupants.
    pub arrival: RandomHour,
    /// Departure of the occupants.
    pub departure: RandomHour,
    /// Range of the target when occupied, °C; uniform.
    pub occupied: [f64; 2],
    /// Largest offset of the target when unoccupied, K; uniform, downward in winter, upward in summer, to both sides in
    /// other months.
    pub offset: f64,
}

/// A normal distribution of hours of the day, clamped to a range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RandomHour {
    /// Mean, h.
    pub mean: f64,
    /// Standard deviation, h.
    pub deviation: f64,
    /// Earliest, h.
    pub earliest: f64,
    /// Latest, h.
    pub latest: f64,
}

/// Range of targets when unoccupied, °C.
const RANDOM_LIMITS: [f64; 2] = [14.0, 30.0];

fn comfortable() -> f64 {
    21.0
}

fn winter() -> f64 {
    18.0
}

fn summer() -> f64 {
    26.0
}

impl RandomDay {
    /// Returns the distributions of the paper's implementation for a building type.
    pub fn of(building_type: BuildingType) -> Self {
        let Day { arrival, departure, occupied, offset } = building_type.data().day;
        let hour =
            |[mean, deviation, earliest, latest]: [f64; 4]| RandomHour { mean, deviation, earliest, latest };
        Self { arrival: hour(arrival), departure: hour(departure), occupied, offset }
    }

    /// Returns the distributions for the type of a class; offices for `None`.
    pub(crate) fn of_class(class: Option<Class>) -> Self {
        Self::of(class.map_or(BuildingType::OfficeSmall, |class| class.building_type))
    }

    fn check(&self) -> Result<()> {
        for RandomHour { mean, deviation, earliest, latest } in [self.arrival, self.departure] {
            within("deviation", deviation, 0.0, 24.0)?;
            within("earliest", earliest, 0.0, 24.0)?;
            within("latest", latest, earliest, 24.0)?;
            within("mean", mean, 0.0, 24.0)?;
        }
        let [low, high] = self.occupied;
        within("occupied", low, 0.0, 50.0)?;
        within("occupied", high, low, 50.0)?;
        within("offset", self.offset, 0.0, 20.0)
    }
}

impl Default for Setpoints {
    fn default() -> Self {
        Self::Constant { target: comfortable() }
    }
}

impl FromStr for Setpoints {
    type Err = ();

    fn from_str(text: &str) -> std::result::Result<Self, ()> {
        let (mode, value) = text.split_once(':').map_or((text, None), |(mode, value)| (mode, Some(value)));
        match (mode, value) {
            ("constant", None) => Ok(Self::default()),
            ("constant", Some(target)) => Ok(Self::Constant { target: target.parse().map_err(|_| ())? }),
            ("occupancy", None) => Ok(Self::Occupancy {
                occupied: comfortable(),
                winter: winter(),
                summer: summer(),
                otherwise: comfortable(),
            }),
            ("random", None) => Ok(Self::Random { seed: 0, day: None }),
            ("random", Some(seed)) => Ok(Self::Random { seed: seed.parse().map_err(|_| ())?, day: None }),
            ("operate", None) => Ok(Self::Band { band: Band::Own }),
            ("operate", Some(pairs)) => Ok(Self::Band { band: presence_pairs(pairs).ok_or(())? }),
            _ => Err(()),
        }
    }
}

/// Reads `21-24/15.6-28`: heating and cooling setpoints with people and without.
fn presence_pairs(text: &str) -> Option<Band> {
    let pair = |text: &str| {
        let (heating, cooling) = text.split_once('-')?;
        Some([heating.parse().ok()?, cooling.parse().ok()?])
    };
    let (occupied, unoccupied) = text.split_once('/')?;
    Some(Band::Presence { occupied: pair(occupied)?, unoccupied: pair(unoccupied)? })
}

impl Setpoints {
    /// Returns the target of all zones if it is constant, °C.
    pub fn constant_target(&self) -> Option<f64> {
        match *self {
            Self::Constant { target } => Some(target),
            Self::Occupancy { .. } | Self::Random { .. } | Self::Band { .. } => None,
        }
    }

    /// Returns whether zones have a heating and a cooling setpoint instead of a target.
    pub fn is_band(&self) -> bool {
        matches!(self, Self::Band { .. })
    }

    pub(crate) fn check(&self) -> Result<()> {
        let target = |name, value| within(name, value, 0.0, 50.0);
        match *self {
            Self::Constant { target: value } => target("target", value),
            Self::Occupancy { occupied, winter, summer, otherwise } => {
                target("occupied", occupied)?;
                target("winter", winter)?;
                target("summer", summer)?;
                target("otherwise", otherwise)
            }
            Self::Random { day, .. } => day.map_or(Ok(()), |day| day.check()),
            Self::Band { ref band } => band.check(),
        }
    }
}

/// The task's targets for a zone in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    /// Whether the zone counts as occupied.
    pub(crate) occupied: bool,
    /// Target, °C; the middle of a band.
    pub(crate) target: f64,
    /// Setpoints; both equal the target in tasks without bands.
    pub(crate) pair: Pair,
}

impl Asked {
    /// The value before the first observation.
    pub(crate) const UNKNOWN: Self =
        Self { occupied: false, target: f64::NAN, pair: Pair { heating: f64::NAN, cooling: f64::NAN } };
}

/// The targets of an episode: a function of zone, moment and, unless drawn at random, the people in the simulation.
#[derive(Clone, Debug)]
pub(crate) struct Targets {
    setpoints: Setpoints,
    bands: Option<Bands>,
    seasons: Seasons,
    day: RandomDay,
    /// The plan drawn for each zone, with its day.
    drawn: Vec<(u32, Plan)>,
}

/// Occupancy and targets of a zone on a day.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Plan {
    arrival: f64,
    departure: f64,
    occupied: f64,
    unoccupied: f64,
}

impl Targets {
    /// The targets of a number of controlled zones, with the bands of a task that has them, the building's class and
    /// the seasons of its site.
    pub(crate) fn new(
        setpoints: &Setpoints,
        bands: Option<Bands>,
        class: Option<Class>,
        zones: usize,
        seasons: Seasons,
    ) -> Self {
        let own = match setpoints {
            Setpoints::Random { day, .. } => *day,
            _ => None,
        };
        Self {
            setpoints: setpoints.clone(),
            bands,
            seasons,
            day: own.unwrap_or_else(|| RandomDay::of_class(class)),
            drawn: vec![(0, Plan::default()); zones],
        }
    }

    /// Returns the targets of a zone at a moment. `people` is whether the simulated zone has people; random setpoints
    /// draw occupancy and ignore it.
    pub(crate) fn at(&mut self, zone: usize, moment: Moment, people: bool) -> Asked {
        if let Some(bands) = &self.bands {
            let pair = bands.at(zone, moment.day_of_year, moment.hour, people);
            return Asked { occupied: people, target: pair.middle(), pair };
        }
        let (occupied, target) = self.target(zone, moment, people);
        Asked { occupied, target, pair: Pair { heating: target, cooling: target } }
    }

    /// Returns the next change of a zone's setpoints in a task with bands.
    pub(crate) fn next(&self, zone: usize, day_of_year: u32, hour: f64) -> Option<NextPair> {
        self.bands.as_ref()?.next(zone, day_of_year, hour)
    }

    fn target(&mut self, zone: usize, moment: Moment, people: bool) -> (bool, f64) {
        match self.setpoints {
            Setpoints::Band { .. } => unreachable!("tasks with bands have them"),
            Setpoints::Constant { target } => (people, target),
            Setpoints::Occupancy { occupied, .. } if people => (true, occupied),
            Setpoints::Occupancy { winter, summer, otherwise, .. } => {
                let target = match self.seasons.on(moment.day_of_year) {
                    Season::Winter => winter,
                    Season::Summer => summer,
                    Season::Between => otherwise,
                };
                (false, target)
            }
            Setpoints::Random { seed, .. } => {
                let (day, plan) = &mut self.drawn[zone];
                if *day != moment.day_of_year {
                    let season = self.seasons.on(moment.day_of_year);
                    (*day, *plan) =
                        (moment.day_of_year, self.day.draw(seed, zone, moment.day_of_year, season));
                }
                let occupied = (plan.arrival..plan.departure).contains(&moment.hour);
                (occupied, if occupied { plan.occupied } else { plan.unoccupied })
            }
        }
    }
}

impl RandomDay {
    /// Draws the plan of a zone and day from its own random stream.
    fn draw(&self, seed: u64, zone: usize, day_of_year: u32, season: Season) -> Plan {
        let mut random = stream(seed, zone as u64 * 1000 + u64::from(day_of_year));
        let arrival = self.arrival.draw(&mut random);
        let departure = self.departure.draw(&mut random);
        let [low, high] = self.occupied;
        let occupied = low + (high - low) * uniform(&mut random);
        let offset = match season {
            Season::Winter => -self.offset * uniform(&mut random),
            Season::Summer => self.offset * uniform(&mut random),
            Season::Between => self.offset * (2.0 * uniform(&mut random) - 1.0),
        };
        let unoccupied = (occupied + offset).clamp(RANDOM_LIMITS[0], RANDOM_LIMITS[1]);
        Plan { arrival, departure, occupied, unoccupied }
    }
}

impl RandomHour {
    fn draw(&self, random: &mut ChaCha8Rng) -> f64 {
        (self.mean + self.deviation * standard_normal(random)).clamp(self.earliest, self.latest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(day_of_year: u32, hour: f64) -> Moment {
        Moment { day_of_year, hour }
    }

    #[test]
    fn an_unoccupied_zone_is_set_back_by_season() {
        let mut targets = Targets::new(&"occupancy".parse().unwrap(), None, None, 1, Seasons::default());
        assert_eq!(targets.target(0, moment(10, 3.0), true), (true, 21.0));
        for (day, target) in [(10, 18.0), (100, 21.0), (200, 26.0), (300, 21.0)] {
            assert_eq!(targets.target(0, moment(day, 3.0), false), (false, target));
        }
    }

    /// Checks limits and means of a season's plans, and the independence of zones and days.
    #[test]
    fn random_days_follow_their_distributions() {
        let of = RandomDay::of(BuildingType::Warehouse);
        let plans = |days: std::ops::Range<u32>| -> Vec<Plan> {
            days.flat_map(|day| (0..20).map(move |zone| of.draw(7, zone, day, Seasons::default().on(day))))
                .collect()
        };
        let (winter, summer, spring) = (plans(1..59), plans(152..243), plans(60..151));
        let mean = |plans: &[Plan], value: fn(&Plan) -> f64| {
            plans.iter().map(value).sum::<f64>() / plans.len() as f64
        };
        for plan in winter.iter().chain(&summer).chain(&spring) {
            assert!((5.0..=9.0).contains(&plan.arrival) && (15.0..=21.0).contains(&plan.departure));
            assert!((18.0..=22.0).contains(&plan.occupied) && (14.0..=30.0).contains(&plan.unoccupied));
        }
        assert!(winter.iter().all(|plan| plan.unoccupied <= plan.occupied));
        assert!(summer.iter().all(|plan| plan.unoccupied >= plan.occupied));
        // Four standard errors: 0.5 h / √1160 and 1.15 K / √1160.
        assert!((mean(&winter, |plan| plan.arrival) - 6.5).abs() < 0.06);
        assert!((mean(&winter, |plan| plan.departure) - 18.0).abs() < 0.06);
        assert!((mean(&winter, |plan| plan.occupied) - 20.0).abs() < 0.14);
        assert!((mean(&winter, |plan| plan.occupied - plan.unoccupied) - 2.0).abs() < 0.14);
        assert!(mean(&spring, |plan| plan.occupied - plan.unoccupied).abs() < 0.22);
        let spread = mean(&winter, |plan| (plan.arrival - 6.5).powi(2)).sqrt();
        assert!((spread - 0.5).abs() < 0.05, "{spread}");
        let mut different: Vec<u64> = winter.iter().map(|plan| plan.occupied.to_bits()).collect();
        different.sort_unstable();
        different.dedup();
        assert_eq!(different.len(), winter.len());
    }

    #[test]
    fn a_random_target_depends_only_on_seed_zone_and_time() {
        let random = |seed: u64| {
            Targets::new(&Setpoints::Random { seed, day: None }, None, None, 5, Seasons::default())
        };
        let (mut forward, mut backward) = (random(3), random(3));
        let moments: Vec<_> =
            (1..40).flat_map(|day| [6.0, 12.0, 23.0].map(|hour| moment(day, hour))).collect();
        let there: Vec<_> = moments.iter().map(|at| forward.target(2, *at, false)).collect();
        let back: Vec<_> = moments.iter().rev().map(|at| backward.target(2, *at, true)).collect();
        assert!(there.iter().eq(back.iter().rev()));
        assert!(there.chunks(3).all(|day| !day[0].0 && day[1].0 && !day[2].0), "occupied at noon only");
        let mut other = random(4);
        assert!(moments.iter().zip(&there).any(|(at, target)| other.target(2, *at, false) != *target));
    }

    #[test]
    fn a_building_without_a_type_has_the_hours_of_offices() {
        let warehouse = Class::new(BuildingType::Warehouse, Some("5B"));
        assert_eq!(RandomDay::of_class(Some(warehouse)), RandomDay::of(BuildingType::Warehouse));
        assert_eq!(RandomDay::of_class(None), RandomDay::of(BuildingType::OfficeSmall));
    }
}
