//! The bands of households, for houses whose thermostats have no setpoints.
//!
//! The generated houses are controlled through their air, so their thermostats are set to values that no zone reaches.
//! The setpoints that people would choose are drawn from surveys, with the name of the house as the seed:
//!
//! | what | values | source |
//! |---|---|---|
//! | heating while awake and at home | 20 to 22 °C in steps of 0.5 K | Statistics Canada, 11-402-x (2009): most set 20 to 22 °C awake |
//! | heating at night | as by day, or 2 to 4 K lower in 53 % of the houses | the same: 53 % lower it at night, most to 16 to 18 °C |
//! | heating while nobody is at home | as by day, or 2 to 3 K lower in half of the houses | utilities' advice: at most 3 K; with heat pumps, large setbacks call for backup heat |
//! | cooling | 24 to 25.5 °C; 2 to 3 K higher while nobody is at home in half of the houses | ResStock, owner-occupied detached houses with central cooling: 75 to 78 °F |
//! | night | from 22:00 or 23:00 to 6:00 or 7:00 | engineering judgment |

use b2b_base::digest::seed_of;
use b2b_base::random::{stream, uniform};
use rand_chacha::ChaCha8Rng;

use super::{Span, ZoneYear, schedules::PER_DAY};
use crate::{Controls, Model};

/// Name of the `Building` object of a generated house that is not in a file of its own.
pub const UNNAMED_HOUSE: &str = "House";

/// Setpoints at or below the first (heating) and at or above the second (cooling), °C, are out of reach.
const OUT_OF_REACH: [f64; 2] = [10.0, 40.0];
/// Class of the object with the name of a model.
const CLASS: &str = "Building";
/// Name of the random stream.
const STREAM: &str = "household band";
/// Share of the households that lower heating at night.
const LOWER_AT_NIGHT: f64 = 0.53;
/// Share of the households that save while nobody is at home.
const SAVE_WHEN_AWAY: f64 = 0.5;

/// The setpoints of a household, °C.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Household {
    day: [f64; 2],
    night: [f64; 2],
    away: [f64; 2],
    /// Hours at which the day begins and ends.
    awake: [f64; 2],
}

impl Household {
    /// Draws the setpoints of a house, with its name as the seed.
    fn of(name: &str) -> Self {
        let mut random = stream(STREAM, seed_of(name), 0);
        let heating = step(&mut random, 20.0, 0.5, 5);
        let cooling = step(&mut random, 24.0, 0.5, 4);
        let lower = share(&mut random, LOWER_AT_NIGHT, 2.0, 5);
        let away = share(&mut random, SAVE_WHEN_AWAY, 2.0, 3);
        let rise = share(&mut random, SAVE_WHEN_AWAY, 2.0, 3);
        Self {
            day: [heating, cooling],
            night: [heating - lower, cooling],
            away: [heating - away, cooling + rise],
            awake: [step(&mut random, 6.0, 1.0, 2), step(&mut random, 22.0, 1.0, 2)],
        }
    }

    /// Returns the setpoints at an hour of the day.
    fn at(&self, hour: f64, people: bool) -> [f64; 2] {
        let awake = (self.awake[0]..self.awake[1]).contains(&hour);
        match (awake, people) {
            (false, _) => self.night,
            (true, true) => self.day,
            (true, false) => self.away,
        }
    }
}

/// Draws one of `count` values from `low` in equal steps.
fn step(random: &mut ChaCha8Rng, low: f64, by: f64, count: u32) -> f64 {
    low + by * (uniform(random) * f64::from(count)).floor()
}

/// Draws one of `count` values from `low` in steps of half a kelvin for a share of the households, and 0 for the
/// others.
fn share(random: &mut ChaCha8Rng, share: f64, low: f64, count: u32) -> f64 {
    let saves = uniform(random) < share;
    let value = step(random, low, 0.5, count);
    if saves { value } else { 0.0 }
}

/// Returns the name from which a household is drawn: the model's own, wherever its file is, or the building's, under all
/// controls.
pub(super) fn name<'a>(building: &'a str, model: &'a Model) -> &'a str {
    let own = model.objects(CLASS).into_iter().next().map(|(name, _)| name);
    own.filter(|name| *name != UNNAMED_HOUSE).unwrap_or_else(|| Controls::common_name(building))
}

impl Model {
    /// Gives a generated house a name, from which its household is drawn wherever its file is.
    pub fn name_house(&mut self, name: &str) {
        if let Some(fields) = self.remove(CLASS, UNNAMED_HOUSE) {
            self.insert(CLASS, Controls::common_name(name), fields.into());
        }
    }
}

/// Gives the household's setpoints to the zones whose thermostat is always out of reach.
pub(super) fn furnish(building: &str, years: Vec<ZoneYear>) -> Vec<ZoneYear> {
    let household = Household::of(building);
    let furnish = |year: ZoneYear| if is_out_of_reach(&year) { furnished(&year, &household) } else { year };
    years.into_iter().map(furnish).collect()
}

/// Returns whether no zone reaches the setpoints.
fn is_out_of_reach(year: &ZoneYear) -> bool {
    let [low, high] = OUT_OF_REACH;
    let beyond = |span: &Span| {
        span.heating.is_some_and(|heating| heating <= low)
            && span.cooling.is_some_and(|cooling| cooling >= high)
    };
    year.spans().all(beyond)
}

fn furnished(year: &ZoneYear, household: &Household) -> ZoneYear {
    ZoneYear::of_samples(year.days.len(), PER_DAY, |index| {
        let (day, hour) = (index / PER_DAY, 24.0 * (index % PER_DAY) as f64 / PER_DAY as f64);
        let people = year.at(day as u32 + 1, hour).people;
        let [heating, cooling] = household.at(hour, people);
        Span { from: hour, heating: Some(heating), cooling: Some(cooling), people }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn households() -> Vec<Household> {
        (0..1000).map(|number| Household::of(&format!("SingleFamilyHouse-{number:04}"))).collect()
    }

    #[test]
    fn households_follow_the_surveys() {
        let all = households();
        let share = |condition: &dyn Fn(&Household) -> bool| {
            all.iter().filter(|household| condition(household)).count() as f64 / all.len() as f64
        };
        // Three standard errors of a share of 0.5 among 1000 are 0.047.
        assert!((share(&|h| h.night[0] < h.day[0]) - LOWER_AT_NIGHT).abs() < 0.047);
        assert!((share(&|h| h.away[0] < h.day[0]) - SAVE_WHEN_AWAY).abs() < 0.047);
        for household in &all {
            let Household { day, night, away, .. } = household;
            assert!((20.0..=22.0).contains(&day[0]) && (24.0..=25.5).contains(&day[1]), "{household:?}");
            assert!(night[0] >= 16.0 && night[0] <= day[0] && away[0] >= 17.0, "{household:?}");
            assert!(away[1] <= 28.5 && away[1] >= day[1], "{household:?}");
        }
        assert_eq!(Household::of("A"), Household::of("A"));
        assert_ne!(Household::of("A"), Household::of("B"));
    }

    #[test]
    fn a_household_is_the_same_under_all_controls_and_in_a_file_of_any_name() {
        let mut model = Model::default();
        model.insert(CLASS, UNNAMED_HOUSE, serde_json::json!({"north_axis": 30}));
        assert_eq!(name("SingleFamilyHouse-0018", &model), "SingleFamilyHouse-0018");
        assert_eq!(name("SingleFamilyHouse-0018+setpoints", &model), "SingleFamilyHouse-0018");
        model.name_house("SingleFamilyHouse-0018");
        assert_eq!(name("mine", &model), "SingleFamilyHouse-0018");
        model.name_house("other");
        assert_eq!(name("mine", &model), "SingleFamilyHouse-0018", "it keeps its name");
        assert_eq!(model.require(CLASS, "SingleFamilyHouse-0018").unwrap()["north_axis"], 30);
    }

    #[test]
    fn only_a_thermostat_out_of_reach_gets_a_households_setpoints() {
        let year = |heating, cooling| {
            ZoneYear::of_samples(365, PER_DAY, |index| Span {
                from: 0.0,
                heating: Some(heating),
                cooling,
                people: index % PER_DAY > 60,
            })
        };
        let hall = year(10.0, None);
        let house = year(5.0, Some(90.0));
        let [kept, drawn] = furnish("House", vec![hall.clone(), house]).try_into().unwrap();
        assert_eq!(kept, hall);
        let household = Household::of("House");
        assert_eq!(drawn.at(1, 18.0).heating, Some(household.day[0]));
        assert_eq!(drawn.at(1, 12.0).cooling, Some(household.away[1]));
        assert_eq!(drawn.at(1, 3.0).heating, Some(household.night[0]));
    }
}
