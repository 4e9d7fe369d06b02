//! Statements of the documentation about episodes, checked with the numbers in it.

use std::sync::Arc;

use crate::case::{Case, random_episode};
use b2b_building::{BuildingType, Date};
use b2b_climate::EpwFile;
use b2b_dataset::{Catalog, Placement};
use b2b_energyplus::install::Quiet;
use b2b_env::{Env, EpisodeConfig};

const DATASET: &str = include_str!("../../../../docs/dataset.md");
const STEP: &str = include_str!("../../../../docs/concepts/step.md");
const TASKS: &str = include_str!("../../../../docs/tasks.md");

/// Returns the numbers that follow some words in a page.
fn numbers_behind(page: &str, words: &str) -> Vec<f64> {
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let (_, rest) = page.split_once(words).unwrap_or_else(|| panic!("the page does not say `{words}`"));
    rest.split(|c: char| !c.is_ascii_digit() && c != '.').filter_map(|word| word.parse().ok()).collect()
}

/// Returns the largest deviation of a controlled zone from a constant target at the beginning of 1 January, K.
fn first_deviation(env: &mut Env) -> f64 {
    let zones: Vec<usize> = env.metrics().zones.iter().map(|zone| zone.slot).collect();
    let first = env.reset().unwrap();
    zones.into_iter().map(|slot| (first[slot] - 21.0).abs()).fold(0.0, f64::max)
}

#[test]
fn episodes_begin_as_near_their_target_as_the_page_says() {
    let said =
        numbers_behind(STEP, "every episode begins near its target: with constant targets on 1 January,");
    let [farthest, far, buildings, beyond] = said[..4] else { panic!("{said:?}") };
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let mut deviations = Vec::new();
    for row in BuildingType::ALL.into_iter().flat_map(b2b_dataset::rows).filter(|row| row.test_small) {
        let name = row.id.to_string().parse().unwrap();
        let found = catalog.find(&name, &Placement::default(), &mut Quiet).unwrap();
        let (weather, period) = (found.weather.clone(), "01-01..01-01".parse().unwrap());
        let building = Arc::new(found.prepare(catalog.library()).unwrap());
        let episode =
            EpisodeConfig { weather, period, steps_per_hour: 12, task: "constant".parse().unwrap() };
        let mut env = Env::new(catalog.library().clone(), building, episode).unwrap();
        deviations.push(first_deviation(&mut env));
    }
    let measured = [
        deviations.iter().copied().fold(0.0, f64::max),
        deviations.iter().filter(|deviation| **deviation > beyond).count() as f64,
        deviations.len() as f64,
    ];
    let said = [farthest, far, buildings];
    assert_eq!(measured.map(|value| (10.0 * value).round() / 10.0), said, "{deviations:.2?}");
}

#[test]
fn the_first_observation_has_the_weather_of_the_hour_that_the_page_says() {
    let [hour, ..] = numbers_behind(STEP, "its weather is")[..] else { panic!() };
    let case = Case::at_home(BuildingType::OfficeSmall);
    let dry_bulbs = EpwFile::open(&case.weather).unwrap().record().unwrap().dry_bulbs();
    for (period, day) in [("01-03..01-03", 2), ("07-09..07-09", 189)] {
        let mut env = case.env(period);
        let slot =
            env.observation_space().slots().iter().position(|slot| slot.name == "outdoor air temperature");
        let observed = env.reset().unwrap()[slot.unwrap()];
        let of_file = dry_bulbs[day * 24 + hour as usize - 1];
        assert!((observed - of_file).abs() < 0.05, "{period}: {observed} °C observed, {of_file} in the file");
    }
}

#[test]
fn zones_that_are_never_occupied_are_listed_as_the_page_says() {
    for (building_type, words, zones) in [
        (BuildingType::Warehouse, "most of a warehouse", vec!["Zone2 Fine Storage", "Zone3 Bulk Storage"]),
        (BuildingType::RetailStandalone, "the entry of a store", vec!["Front_Entry"]),
        (BuildingType::OfficeSmall, "", vec![]),
    ] {
        assert!(TASKS.contains(words), "{words}");
        let env = Case::at_home(building_type).env_for("01-03..01-03", "occupancy");
        let listed: Vec<&str> = env.never_occupied().collect();
        assert_eq!(listed, zones, "{building_type}");
    }
}

#[test]
fn an_office_is_empty_on_the_weekdays_that_the_page_lists_as_holidays() {
    const MONTHS: [&str; 12] = [
        "January",
        "February",
        "March",
        "April",
        "May",
        "June",
        "July",
        "August",
        "September",
        "October",
        "November",
        "December",
    ];
    let page = DATASET.split_whitespace().collect::<Vec<_>>().join(" ");
    let (_, listed) = page.split_once("so eight fall on weekdays: ").unwrap();
    let (listed, _) = listed.split_once('.').unwrap();
    let holidays: Vec<_> = listed
        .replace(" and ", ", ")
        .split(", ")
        .map(|date| {
            let (day, month) = date.split_once(' ').unwrap();
            let month = MONTHS.iter().position(|name| *name == month).unwrap() + 1;
            format!("{month:02}-{day:0>2}")
        })
        .collect();
    assert_eq!(holidays.len(), 8);
    let days = holidays.iter().map(|date| date.parse::<Date>().unwrap().day_of_year());
    let case = Case::at_home(BuildingType::OfficeSmall);
    let calendar = case.building.calendar();
    let weekdays = case.building.holidays.iter().copied().filter(|day| calendar.weekday(*day) < 5);
    assert!(days.clone().eq(weekdays));
    for day in days {
        let spans = case.building.years.iter().flat_map(|year| year.spans_of(day));
        assert!(spans.clone().count() > 0 && spans.clone().all(|span| !span.people), "day {day}");
    }
    // 16 January is a holiday, the day after is not.
    let mut env = case.env_for("01-16..01-17", "operate");
    let slot = |name: &str| env.observation_space().slots().iter().position(|slot| slot.name == name);
    let [holiday, occupancy] = ["holiday", "Core_ZN occupancy"].map(|name| slot(name).unwrap());
    let trajectory = random_episode(&mut env, 1);
    let (holidays, occupancies): (Vec<f64>, Vec<f64>) =
        trajectory.observed(holiday).zip(trajectory.observed(occupancy)).unzip();
    assert!(holidays[..287].iter().all(|value| *value == 1.0) && !occupancies[..287].contains(&1.0));
    assert!(holidays[287..].iter().all(|value| *value == 0.0) && occupancies[287..].contains(&1.0));
}
