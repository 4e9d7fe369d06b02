//! The calendar of a model and of its weather, next to the calendar of episodes.

use b2b_climate::Site;

use crate::Date;
use crate::model::{Fields, Model, number, text};
use crate::run_period::WEEKDAYS;

/// Returns warnings if days of the week, in the run period of a model or in the year of its weather, are not those of
/// episodes.
pub fn warnings(model: &Model, site: &Site) -> Vec<String> {
    let begins = |day: u32| format!("begins on a {}", WEEKDAYS[day as usize]);
    let ours = Date::of_day(1).weekday();
    let differs = |day: &u32| *day != ours;
    let of_model =
        model.objects("RunPeriod").into_iter().find_map(|(_, fields)| new_year(fields)).filter(differs);
    let of_model = of_model.map(|day| {
        format!("the year of the model's run period {}; every episode's year {}", begins(day), begins(ours))
    });
    let of_weather = site.year.map(|year| (year, weekday_of_new_year(year))).filter(|(_, day)| differs(day));
    let of_weather = of_weather.map(|(year, day)| {
        format!(
            "{year}, the year of the weather file, {}; every episode's year {}",
            begins(day),
            begins(ours)
        )
    });
    of_model.into_iter().chain(of_weather).collect()
}

/// Returns the day of the week of 1 January in the year of a run period, if it gives one.
fn new_year(fields: &Fields) -> Option<u32> {
    let whole = |field| number(fields, field).map(|number| number as u32);
    let given = text(fields, "day_of_week_for_start_day");
    let day = given.and_then(|given| WEEKDAYS.iter().position(|day| day.eq_ignore_ascii_case(given)));
    match (day, whole("begin_year")) {
        (Some(day), _) => {
            let first = Date::new(whole("begin_month")?, whole("begin_day_of_month")?).ok()?;
            Some(first.new_year_if_on(day as u32))
        }
        (None, year) => year.map(weekday_of_new_year),
    }
}

/// Returns the day of the week of 1 January, 0 (Monday) to 6 (Sunday), in the Gregorian calendar.
fn weekday_of_new_year(year: u32) -> u32 {
    let before = year.max(1) - 1;
    // 1 January of the year 1 was a Monday.
    (before + before / 4 - before / 100 + before / 400) % 7
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn the_first_of_january_has_the_weekday_of_its_year() {
        assert_eq!([2017, 2018, 2020, 2024].map(weekday_of_new_year), [6, 0, 2, 0]);
    }

    #[test]
    fn a_run_period_gives_its_weekdays_by_name_or_by_its_year() {
        let of = |fields: serde_json::Value| new_year(fields.as_object().unwrap());
        let in_february =
            json!({"begin_month": 2, "begin_day_of_month": 1, "day_of_week_for_start_day": "thursday"});
        assert_eq!(of(in_february), Some(0), "1 February is a Thursday if 1 January is a Monday");
        assert_eq!(of(json!({"begin_month": 7, "begin_day_of_month": 1, "begin_year": 2020})), Some(2));
        assert_eq!(of(json!({"begin_month": 1, "begin_day_of_month": 1})), None);
    }
}
