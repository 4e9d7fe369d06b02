//! The calendar of a user's model: the days of the week of its run period or of a measured year, and 29 February.

use b2b_base::calendar::{Calendar, is_leap_year, weekday_of_new_year};
use b2b_climate::Site;

use crate::model::{Fields, Model, number, text};
use crate::run_period::WEEKDAYS;

/// Returns the calendar of a model in a weather file.
///
/// The run period of the model gives the days of the week, by its first day or by its year, as in the engine; without
/// one, the year of the rows of the weather file, if they have one in common; otherwise, they are as in generated
/// buildings. There is a 29 February if the weather file has it.
pub fn of(model: &Model, site: &Site) -> Calendar {
    let leap = site.has_leap_day;
    let weekday = of_model(model, leap).or_else(|| site.year.map(weekday_of_new_year));
    Calendar::new(weekday.unwrap_or_else(|| Calendar::default().weekday(1)), leap)
}

/// Returns a note on the calendar of a model if it is not the one of generated buildings.
pub fn note(model: &Model, site: &Site) -> Option<String> {
    let calendar = of(model, site);
    let name = |day: u32| WEEKDAYS[day as usize];
    let begins = calendar.weekday(1);
    let from_model = of_model(model, calendar.is_leap()).is_some();
    let source = match (from_model, site.year) {
        (true, _) => "by the model's run period".to_owned(),
        (false, Some(year)) => format!("as in {year}, the year of the weather file"),
        (false, None) => "by default".to_owned(),
    };
    let of_weather = site.year.filter(|year| from_model && weekday_of_new_year(*year) != begins);
    let ignored = of_weather.map(|year| {
        format!(
            "1 January is a {} by the model's run period, not a {} as in {year}, the year of the weather file: give the run \
             period that year for its days of the week",
            name(begins),
            name(weekday_of_new_year(year))
        )
    });
    let usual = Calendar::default();
    let differs = ignored.is_none() && begins != usual.weekday(1);
    let weekdays = differs.then(|| format!("1 January is a {}, {source}", name(begins)));
    let leap = calendar.is_leap().then(|| "the year has a 29 February, like the weather file".to_owned());
    let notes: Vec<String> = ignored.into_iter().chain(weekdays).chain(leap).collect();
    (!notes.is_empty()).then(|| notes.join("; "))
}

/// Returns a warning if the engine skips the 29 February of a weather file.
pub fn skipped_leap_day(site: &Site) -> Option<String> {
    let later = match site.year {
        Some(year) if is_leap_year(year) => {
            format!(", and weekdays after it are a day earlier than in {year}")
        }
        _ => String::new(),
    };
    site.skips_leap_day.then(|| {
        format!(
            "the weather file has a 29 February, but its header says that leap days are not observed: the day is \
             skipped{later}; to keep it, set the first field of HOLIDAYS/DAYLIGHT SAVINGS to Yes"
        )
    })
}

/// Returns the day of the week of 1 January by the run periods of a model, if one gives it.
fn of_model(model: &Model, leap: bool) -> Option<u32> {
    model.objects("RunPeriod").into_iter().find_map(|(_, fields)| new_year(fields, leap))
}

/// Returns the day of the week of 1 January in the year of a run period, with or without 29 February, if it gives one.
fn new_year(fields: &Fields, leap: bool) -> Option<u32> {
    let whole = |field| number(fields, field).map(|number| number as u32);
    let given = text(fields, "day_of_week_for_start_day");
    let named = given.and_then(|given| WEEKDAYS.iter().position(|day| day.eq_ignore_ascii_case(given)));
    let first = [whole("begin_month").unwrap_or(1), whole("begin_day_of_month").unwrap_or(1)];
    let weekday = match (whole("begin_year"), named) {
        (Some(year), _) => {
            let calendar = Calendar::of_year(year);
            calendar.weekday(calendar.day(first)?)
        }
        (None, named) => named? as u32,
    };
    let day = Calendar::new(0, leap).day(first)?;
    Some((weekday + 371 - (day - 1)) % 7)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_run_period_gives_its_weekdays_by_its_year_or_by_name() {
        let of = |fields: serde_json::Value, leap| new_year(fields.as_object().unwrap(), leap);
        let in_february =
            json!({"begin_month": 2, "begin_day_of_month": 1, "day_of_week_for_start_day": "thursday"});
        assert_eq!(of(in_february, false), Some(0), "1 February is a Thursday if 1 January is a Monday");
        let in_july = json!({"begin_month": 7, "begin_day_of_month": 1, "begin_year": 2020});
        assert_eq!(of(in_july.clone(), true), Some(2));
        assert_eq!(of(in_july, false), Some(3), "without 29 February, 1 July is a Wednesday as in 2020");
        let both = json!({"begin_month": 1, "begin_day_of_month": 1, "begin_year": 2018,
            "day_of_week_for_start_day": "Friday"});
        assert_eq!(of(both, false), Some(0), "the engine corrects a day that is not the year's");
        assert_eq!(of(json!({"begin_month": 1, "begin_day_of_month": 1}), false), None);
    }
}
