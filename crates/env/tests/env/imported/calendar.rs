//! The calendar of a user's model: the days of the week of a measured year, 29 February and New Year.

use std::path::{Path, PathBuf};

use b2b_building::{BuildingType, Controls};
use b2b_env::Env;
use serde_json::{Value, json};

use crate::case::Case;
use crate::models::room::room;

/// Writes Chicago's weather with the year 2020; its 29 February is like the 28th, but at 7 °C.
fn measured(folder: &Path) -> PathBuf {
    let chicago = Case::of_user(&room(), Controls::default()).weather;
    let bytes = std::fs::read(chicago).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    let mut written = String::new();
    let mut day = Vec::new();
    for line in text.lines() {
        let columns: Vec<&str> = line.split(',').collect();
        let is_row = columns[0].parse::<u32>().is_ok();
        if is_row && columns[1..3] == ["3", "1"] {
            day.drain(..).for_each(|row: String| written += &row);
        }
        let line = match is_row {
            true => format!("2020,{}", columns[1..].join(",")),
            false => line.replace("SAVINGS,No", "SAVINGS,Yes"),
        };
        written += &format!("{line}\n");
        if is_row && columns[1..3] == ["2", "28"] {
            let (before, after) = (columns[3..6].join(","), columns[7..].join(","));
            day.push(format!("2020,2,29,{before},7.0,{after}\n"));
        }
    }
    let path = folder.join("2020.epw");
    std::fs::write(&path, written).unwrap();
    path
}

/// The room, held at 21 °C on weekdays from 8 to 18 h, and closed on 1 January.
fn office() -> Value {
    let mut model = room();
    model["Schedule:Constant"].as_object_mut().unwrap().remove("Warm");
    let fields = [
        "Through: 12/31",
        "For: Weekdays",
        "Until: 8:00",
        "15",
        "Until: 18:00",
        "21",
        "Until: 24:00",
        "15",
        "For: AllOtherDays",
        "Until: 24:00",
        "15",
    ];
    model["Schedule:Compact"] = json!({"Warm": {"data": fields.map(|field| json!({"field": field}))}});
    model["RunPeriodControl:SpecialDays"] =
        json!({"New Year": {"start_date": "January 1", "duration": 1, "special_day_type": "Holiday"}});
    model
}

/// Returns day of the week, day of the year, holiday, heating setpoint and outdoor temperature at noon of every day,
/// and hours to the next change of the setpoint as known at the beginning.
fn noons(env: &mut Env) -> (Vec<[f64; 5]>, f64) {
    let slots = env.observation_space().slots();
    let slot = |name: &str| slots.iter().position(|slot| slot.name.starts_with(name)).unwrap();
    let named =
        ["day of week", "day of year", "holiday", "Room band heating setpoint", "outdoor air temperature"]
            .map(slot);
    let next = slot("Room hours to next band");
    let action = env.action_space().low().to_vec();
    let hours = env.reset().unwrap()[next];
    let mut days = Vec::new();
    for step in 1..=env.episode_steps() {
        let observation = env.step(&action).unwrap().observation;
        if step % 288 == 144 {
            days.push(named.map(|slot| observation[slot]));
        }
    }
    (days, hours)
}

#[test]
fn a_measured_leap_year_has_its_weekdays_its_29_february_and_a_new_year() {
    let folder = tempfile::tempdir().unwrap();
    let case = Case::of_user_in(&office(), Controls::default(), measured(folder.path()));
    let (days, hours) = noons(&mut case.env_for("02-28..03-01", "operate+tou+preview"));
    let of = |days: &[[f64; 5]], value: usize| days.iter().map(|day| day[value]).collect::<Vec<_>>();
    assert_eq!(of(&days, 0), [4.0, 5.0, 6.0], "28 February 2020 was a Friday");
    assert_eq!(of(&days, 1), [59.0, 60.0, 61.0]);
    assert_eq!((of(&days, 3), hours), (vec![21.0, 15.0, 15.0], 8.0));
    assert_eq!(days[1][4], 7.0, "the weather of 29 February");

    let (days, _) = noons(&mut case.env_for("12-31..01-02", "operate+tou+preview"));
    assert_eq!(of(&days, 0), [3.0, 4.0, 5.0], "31 December 2020 was a Thursday");
    assert_eq!(of(&days, 1), [366.0, 1.0, 2.0]);
    assert_eq!((of(&days, 2), of(&days, 3)), (vec![0.0, 1.0, 0.0], vec![21.0, 15.0, 15.0]));
}

#[test]
fn a_run_begins_on_the_weekday_that_the_model_gives() {
    let mut model = office();
    model["RunPeriod"] = json!({"R": {"begin_month": 1, "begin_day_of_month": 1, "end_month": 12,
        "end_day_of_month": 31, "day_of_week_for_start_day": "Thursday"}});
    let case = Case::of_user(&model, Controls::default());
    let (days, _) = noons(&mut case.env_for("01-01..01-04", "operate+tou+preview"));
    let of = |value: usize| days.iter().map(|day| day[value]).collect::<Vec<_>>();
    assert_eq!(of(0), [3.0, 4.0, 5.0, 6.0], "Thursday to Sunday");
    assert_eq!(of(2), [1.0, 0.0, 0.0, 0.0], "New Year");
    assert_eq!(of(3), [15.0, 21.0, 15.0, 15.0], "the engine's schedule of weekdays");
}

/// Chicago's weather at the same latitude south of the equator.
fn southern(folder: &Path) -> PathBuf {
    let chicago = Case::of_user(&room(), Controls::default()).weather;
    let bytes = std::fs::read(chicago).unwrap();
    let text = String::from_utf8_lossy(&bytes).replacen(",41.98,", ",-41.98,", 1);
    let path = folder.join("southern.epw");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn targets_and_clothing_follow_the_seasons_of_the_south() {
    let folder = tempfile::tempdir().unwrap();
    let both = |model: &Value| {
        let weather = southern(folder.path());
        let south = Case::of_user_in(model, Controls::default(), weather);
        [Case::of_user(model, Controls::default()), south]
    };
    // The target and the reward of the first step of a January night at the same temperature.
    let first = |case: &Case, task: &str| {
        let mut env = case.env_for("01-09..01-09", task);
        let slots = env.observation_space().slots();
        let target = slots.iter().position(|slot| slot.name == "Room target");
        let temperature = slots.iter().position(|slot| slot.name == "Room air temperature").unwrap();
        env.reset().unwrap();
        let step = env.step(&[20.0, 24.0]).unwrap();
        (target.map(|slot| step.observation[slot]), step.observation[temperature], step.reward.total())
    };
    let targets = both(&room()).map(|case| first(&case, "occupancy").0);
    assert_eq!(targets, [Some(18.0), Some(26.0)], "targets of an empty room");
    let mut occupied = room();
    occupied["Schedule:Constant"]["Seated"] = json!({"hourly_value": 120.0});
    occupied["People"] = json!({"P": {
        "zone_or_zonelist_or_space_or_spacelist_name": "Room", "number_of_people": 4,
        "number_of_people_schedule_name": "Single Heating", "activity_level_schedule_name": "Seated"}});
    let [(_, north, light), (_, south, heavy)] = both(&occupied).map(|case| first(&case, "constant+pmv"));
    assert!((north - south).abs() < 0.1, "{north} and {south} °C");
    assert!(light > heavy, "rewards {light} and {heavy}: summer clothing is colder at {south} °C");
}

#[test]
fn a_generated_building_stays_in_its_year() {
    let case = Case::at_home(BuildingType::Warehouse);
    let refused = |period| case.try_env(period, "constant".parse().unwrap()).unwrap_err().to_string();
    assert!(refused("12-27..01-09").contains("end the period on 12-31"), "{}", refused("12-27..01-09"));
    assert!(refused("02-28..02-29").contains("02-29"), "{}", refused("02-28..02-29"));
}
