use super::*;

/// The values after the dry bulb: a low dew point, a pressure of 10⁵ Pa and ones.
const REST: &str = ",-90,1,1e5,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1";

/// An EPW text with rows of these days, from 0 in a year without 29 February, each with a number of rows an hour.
fn text(days: impl IntoIterator<Item = usize>, intervals: u32, value: impl Fn(usize) -> String) -> String {
    let mut text = "LOCATION,A\n".to_owned() + &"header\n".repeat(6);
    text += &format!("DATA PERIODS,1,{intervals},Data,Sunday, 1/ 1,12/31\n");
    for day in days {
        let (mut month, mut date) = (0, day as u32 + 1);
        while date > MONTH_DAYS[month] {
            date -= MONTH_DAYS[month];
            month += 1;
        }
        for row in 0..24 * intervals {
            let (hour, minute) = (row / intervals + 1, (row % intervals + 1) * 60 / intervals);
            let dry_bulb = value(day * 24 * intervals as usize + row as usize);
            text += &format!("2005,{},{date},{hour},{minute},flags,{dry_bulb}{REST}\n", month + 1);
        }
    }
    text
}

fn of(days: impl IntoIterator<Item = usize>, value: impl Fn(usize) -> String) -> String {
    text(days, 1, value)
}

fn why(text: &str) -> String {
    Record::read(text).unwrap_err()
}

/// A temperature that identifies the day of a row: its number over 10, °C.
fn day_number(row: usize) -> String {
    format!("{:.1}", (row / 24) as f64 / 10.0)
}

#[test]
fn a_year_from_july_to_june_has_every_hour_at_its_date() {
    let calendar = Record::read(&of(0..365, day_number)).unwrap();
    let turned = Record::read(&of((181..365).chain(0..181), day_number)).unwrap();
    assert_eq!(turned.dry_bulbs(), calendar.dry_bulbs());
    assert_eq!(turned.dry_bulbs()[..2], [0.0, 0.0]);
    assert!(turned.is_whole_year() && turned.span() == Some([182, 181]));
    assert_eq!(turned.monthly_dry_bulbs(), calendar.monthly_dry_bulbs());
}

#[test]
fn a_missing_temperature_is_the_last_one_before_it_and_6_degrees_at_the_start() {
    let value = |row: usize| match row {
        0 | 30 | 31 => "99.9".to_owned(),
        row => row.to_string(),
    };
    let dry_bulbs = Record::read(&of(0..2, value)).unwrap().dry_bulbs();
    assert_eq!([0, 1, 29, 30, 31, 32].map(|hour| dry_bulbs[hour]), [6.0, 1.0, 29.0, 29.0, 29.0, 32.0]);
}

#[test]
fn hours_of_quarter_hourly_rows_end_with_the_fourth() {
    let record = Record::read(&text(0..1, 4, |row| format!("{:.2}", row as f64 / 4.0))).unwrap();
    assert_eq!((record.intervals(), record.dry_bulbs().len()), (4, 8760));
    assert_eq!(record.dry_bulbs()[..3], [0.75, 1.75, 2.75]);
}

/// A day of rows whose values are the numbers of their columns, from 0.
fn numbered_columns(intervals: u32) -> String {
    let rest: String = (7..35).map(|column| format!(",{column}")).collect();
    text(0..1, intervals, |_| "6".to_owned()).replace(REST, &rest.replace(",9,", ",1e5,"))
}

#[test]
fn every_value_is_read_from_its_column() {
    for intervals in [1, 4] {
        let record = Record::read(&numbered_columns(intervals)).unwrap();
        let hour = record.hours()[0];
        let air = [hour.dry_bulb, hour.dew_point, hour.relative_humidity, hour.wind_speed];
        assert_eq!(air, [6.0, 7.0, 8.0, 21.0]);
        let radiation = [hour.radiation, hour.direct_radiation, hour.diffuse_radiation];
        assert_eq!(radiation, [13.0, 14.0, 15.0]);
    }
}

#[test]
fn a_missing_value_before_the_first_is_the_engine_s() {
    let text = numbered_columns(1);
    let missing = text.replacen("6,7,8,", "99.9,99.9,999,", 1).replacen(",13,14,15,", ",9999,9999,9999,", 1);
    let hour = Record::read(&missing.replacen(",20,21,", ",20,999,", 1)).unwrap().hours()[0];
    assert_eq!([hour.dew_point, hour.relative_humidity, hour.wind_speed], [3.0, 50.0, 2.5]);
    assert_eq!([hour.direct_radiation, hour.diffuse_radiation], [0.0, 0.0]);
}

#[test]
fn a_day_that_is_not_in_the_file_is_as_the_nearest() {
    let january = Record::read(&of(0..31, day_number)).unwrap();
    assert!(!january.is_whole_year());
    assert!(january.has([1, 31]) && !january.has([2, 1]));
    assert_eq!([31, 364].map(|day| january.dry_bulbs()[24 * day]), [3.0, 0.0]);
}

#[test]
fn a_leap_day_counts_in_means_and_in_the_year_of_a_calendar_that_has_it() {
    let leap_day = of([58], |_| "9.0".to_owned()).replace("2005,2,28,", "2005,2,29,");
    let (_, leap_day) = leap_day.split_once("12/31\n").unwrap();
    let first = of(0..59, |_| "0.0".to_owned());
    let (_, rest) = of(59..365, |_| "0.0".to_owned())
        .split_once("12/31\n")
        .map(|(a, b)| (a.len(), b.to_owned()))
        .unwrap();
    let record = Record::read(&(first + leap_day + &rest)).unwrap();
    assert_eq!(record.hours().len(), 8784);
    assert!(record.dry_bulbs().iter().all(|value| *value == 0.0));
    assert_eq!(record.monthly_dry_bulbs().unwrap()[1], 9.0 / 29.0);
    let leap_year = record.dry_bulbs_in(Calendar::new(2, true));
    assert!(record.has([2, 29]) && leap_year.len() == 8784);
    assert_eq!([59, 60, 61].map(|day| leap_year[24 * (day - 1)]), [0.0, 9.0, 0.0]);
}

#[test]
fn days_out_of_order_and_hours_from_0_are_errors_with_their_line() {
    let gap = why(&of([0, 2], day_number));
    assert!(gap.starts_with("line 33: 01-03 follows 01-01"), "{gap}");
    let zero = why(&of([0], day_number).replacen(",1,60,", ",0,60,", 1));
    assert!(zero.starts_with("line 9: hour 0; expected hour 1"), "{zero}");
    assert!(why(&of([0], day_number).replace("2005,1,1,", "2005,2,30,")).contains("month 2 and day 30"));
}

#[test]
fn a_truncated_file_is_an_error_with_its_last_day() {
    let whole = of(0..2, day_number);
    let rows: Vec<&str> = whole.lines().collect();
    let cut = why(&(rows[..8 + 30].join("\n")));
    assert!(cut.contains("the last day, 01-02, has 6 of 24 rows"), "{cut}");
    let short = why(&whole[..whole.len() - 5]);
    assert!(short.contains("line 56: 33 columns instead of 35 as before: it is truncated"), "{short}");
}

#[test]
fn only_the_columns_of_the_engine_are_needed() {
    let first_27 = of(0..1, day_number).replace(REST, &REST[..REST.len() - ",1".len() * 8]);
    assert_eq!(Record::read(&first_27).unwrap().hours().len(), 24);
    let first_26 = why(&first_27.replace(",1\n", "\n"));
    assert!(first_26.contains("26 columns instead of at least 27"), "{first_26}");
    assert!(why(&of(0..1, |_| "nan".to_owned())).contains("line 9: column 7 is `nan`"));
}

#[test]
fn a_value_that_is_not_plausible_is_an_error_with_its_limits() {
    let hot = why(&of(0..1, |_| "300".to_owned()));
    assert!(hot.contains("line 9: the dry-bulb temperature (°C) is 300; expected -90 to 60"), "{hot}");
    let hint = why(&of(0..1, |_| "300".to_owned()).replace("LOCATION,A", "a"));
    assert!(hint.ends_with("an EPW file begins with LOCATION"), "{hint}");
    assert!(why(&text(0..0, 7, day_number)).contains("a number that divides 60"));
}

#[test]
fn a_value_in_another_unit_is_an_error() {
    let of = |column: &str, value: &str| why(&numbered_columns(1).replacen(column, value, 1));
    let dew_point = of(",6,7,", ",6,12,");
    assert!(dew_point.contains("the dew point is 12 °C, above the dry bulb of 6 °C"), "{dew_point}");
    let pressure = of(",1e5,", ",1013,");
    assert!(pressure.contains("the pressure (Pa) is 1013; expected 31000 to 120000"), "{pressure}");
    let kilojoules = of(",13,14,", ",13,3402,");
    assert!(
        kilojoules.contains("the direct normal radiation is 3402 W/m²; expected 0 to 2000"),
        "{kilojoules}"
    );
}

#[test]
fn a_value_that_is_missing_for_hours_is_an_error() {
    let between = |rows: std::ops::Range<usize>| {
        let gap = move |row: usize| if rows.contains(&row) { "99.9".to_owned() } else { "0".to_owned() };
        Record::read(&of(0..2, gap))
    };
    assert!(between(20..26).is_ok());
    let hours = between(20..27).unwrap_err();
    let expected = "line 35: the dry-bulb temperature (°C) is missing for more than 6 hours";
    assert!(hours.starts_with(expected), "{hours}");
    let sun = |night: &str| {
        let night = numbered_columns(1).replacen(",15,", night, 4).replacen(",15,", ",9999,", 6);
        Record::read(&night)
    };
    assert!(sun(",0,").is_ok());
    assert!(sun(",9999,").unwrap_err().starts_with("line 15: the diffuse horizontal radiation is missing"));
}
