use std::sync::LazyLock;

use b2b_energyplus::install::{Cache, Quiet};

use super::months::{DAYS, HOURS, mean, range, spread};
use super::sky::suns;
use super::*;
use crate::epw::column;
use crate::{Place, Site, sun};

/// Montréal's typical year, from the user's cache.
fn base() -> String {
    let path = Place::find("Montréal").unwrap().epw_in(&Cache::from_env().unwrap(), &mut Quiet).unwrap();
    std::fs::read_to_string(path).unwrap()
}

/// Every station with its morphed text.
static MORPHED: LazyLock<Vec<(&Station, String)>> = LazyLock::new(|| {
    let base = base();
    Station::all().iter().map(|station| (station, morph(&base, station).unwrap())).collect()
});

/// The hours of an EPW text, with 0 for the flags.
fn hours(text: &str) -> Vec<Vec<f64>> {
    let hour = |line: &str| line.split(',').map(|v| v.trim().parse().unwrap_or(0.0)).collect();
    text.lines().skip(8).map(hour).collect()
}

fn of_month(hours: &[Vec<f64>], month: usize, column: usize) -> Vec<f64> {
    hours.iter().filter(|h| h[1] == month as f64 + 1.0).map(|h| h[column]).collect()
}

fn close(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() <= tolerance, "{what}: {a} is not {b}");
}

/// One test, because each test runs in its own process and would morph all stations again.
#[test]
fn the_weather_of_every_station_matches_its_normals_and_is_physical() {
    every_morphed_month_matches_the_normals_of_its_station();
    heating_degree_days_follow_from_the_normals();
    humidity_is_physical_and_sunlight_adds_up();
    the_header_says_that_the_file_is_morphed();
}

fn every_morphed_month_matches_the_normals_of_its_station() {
    for (station, text) in MORPHED.iter() {
        assert_eq!(Record::of(text, Path::new(station.name)).unwrap().hours().len(), HOURS);
        let hours = hours(text);
        for (month, normals) in station.months.iter().enumerate() {
            let what = format!("{} month {}", station.name, month + 1);
            let values = |column| of_month(&hours, month, column);
            let dry_bulb = values(column::DRY_BULB);
            close(mean(&dry_bulb), normals.dry_bulb, 0.05, &what);
            close(spread(&dry_bulb), normals.daily_spread, 0.05, &what);
            close(range(&dry_bulb), normals.daily_range, 0.05, &what);
            close(mean(&values(column::DEW_POINT)), normals.dew_point, 0.1, &what);
            close(mean(&values(column::WIND)), normals.wind_speed, 0.05, &what);
            let sun = values(column::GLOBAL).iter().sum::<f64>() / DAYS[month] as f64;
            close(sun / normals.global_horizontal, 1.0, 0.005, &what);
        }
    }
}

/// From November to March no day reaches 18 °C, so that the months' means give the degree-days.
fn heating_degree_days_follow_from_the_normals() {
    const COLD: [usize; 5] = [0, 1, 2, 10, 11];
    for (station, text) in MORPHED.iter() {
        let hours = hours(text);
        let days = |month| {
            let dry_bulb = of_month(&hours, month, column::DRY_BULB);
            dry_bulb.chunks(24).map(|day| (18.0 - mean(day)).max(0.0)).sum::<f64>()
        };
        let expected: f64 =
            COLD.iter().map(|&month| (18.0 - station.months[month].dry_bulb) * DAYS[month] as f64).sum();
        let found: f64 = COLD.iter().map(|&month| days(month)).sum();
        close(found / expected, 1.0, 0.003, station.name);
    }
}

fn humidity_is_physical_and_sunlight_adds_up() {
    for (station, text) in MORPHED.iter() {
        let place =
            sun::Position { latitude: station.latitude, longitude: station.longitude, time_zone: -5.0 };
        let suns = suns(place);
        for (hour, sun) in hours(text).iter().zip(suns) {
            let what = format!("{} {}-{} {}h", station.name, hour[1], hour[2], hour[3]);
            assert!(hour[column::DEW_POINT] <= hour[column::DRY_BULB], "{what}");
            assert!((0.0..=100.0).contains(&hour[column::HUMIDITY]), "{what}");
            let (beam, diffuse) = (hour[column::BEAM], hour[column::DIFFUSE]);
            close(diffuse + beam * sun.cosine, hour[column::GLOBAL], 0.16, &what);
            assert!((0.0..1200.0).contains(&beam) && diffuse >= 0.0, "{what}: {beam}");
            assert!((60.0..500.0).contains(&hour[column::INFRARED]), "{what}: {}", hour[column::INFRARED]);
            assert!((80_000.0..106_000.0).contains(&hour[column::PRESSURE]), "{what}");
            assert!((0.0..40.0).contains(&hour[column::WIND]), "{what}");
            assert!((-55.0..42.0).contains(&hour[column::DRY_BULB]), "{what}: {}", hour[column::DRY_BULB]);
        }
    }
}

#[test]
fn morphing_to_the_same_station_changes_little() {
    let base = base();
    let station = Station::find("CAN_PQ_Montreal.Intl.AP.716270_CWEC").unwrap();
    let (before, after) = (hours(&base), hours(&morph(&base, station).unwrap()));
    let rms = |column: usize| {
        let squares = before.iter().zip(&after).map(|(b, a)| (b[column] - a[column]).powi(2));
        (squares.sum::<f64>() / HOURS as f64).sqrt()
    };
    for (column, tolerance) in [
        (column::DRY_BULB, 0.1),
        (column::DEW_POINT, 0.2),
        (column::HUMIDITY, 2.5),
        (column::PRESSURE, 1.0),
        (column::INFRARED, 5.0),
        (column::GLOBAL, 15.0),
        // Hours scatter around the Erbs correlation.
        (column::DIFFUSE, 60.0),
        (column::WIND, 0.1),
    ] {
        let rms = rms(column);
        println!("column {column}: {rms:.2}");
        assert!(rms < tolerance, "column {column}: {rms}");
    }
}

fn the_header_says_that_the_file_is_morphed() {
    let base = base();
    let station = Station::find("CAN_QC_BAGOTVILLE-A_7060400_CWEC").unwrap();
    let text = morph(&base, station).unwrap();
    let site = Site::from_epw(&text, Path::new("a.epw")).unwrap();
    assert!(site.name.contains("morphed"), "{}", site.name);
    assert_eq!((site.latitude, site.longitude, site.elevation), (48.33, -71.0, 159.1));
    assert_eq!((site.heating.dry_bulb, site.heating.wind_speed), (-29.8, Some(2.8)));
    assert_eq!((site.cooling.dry_bulb, site.cooling.daily_range), (29.3, 10.3));
    let before = Site::from_epw(&base, Path::new("a.epw")).unwrap();
    let shift = mean(&site.ground_temperatures) - mean(&before.ground_temperatures);
    assert!((-4.5..-2.0).contains(&shift), "{shift}");
    assert!(text.contains("Morphed from Montreal Int'l (WMO 716270)"));
}

#[test]
fn a_station_without_design_conditions_gets_them_from_its_hours() {
    let station = Station::find("CAN_QC_SEPT-ILES-A_7047911_CWEC").unwrap();
    let text = morph(&base(), station).unwrap();
    let site = Site::from_epw(&text, Path::new("a.epw")).unwrap();
    assert!((-35.0..-24.0).contains(&site.heating.dry_bulb), "{}", site.heating.dry_bulb);
    assert!(text.contains("no design conditions published"));
}

/// If this hash changes, either [`MORPH_VERSION`] must change, or the machine computes different bits.
#[test]
fn the_bytes_do_not_depend_on_the_machine() {
    let station = Station::find("CAN_QC_GASPE-A_7052601_CWEC").unwrap();
    let text = morph(&base(), station).unwrap();
    // FNV-1a.
    let hash = text
        .bytes()
        .fold(0xcbf29ce484222325u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100000001b3));
    assert_eq!(format!("{hash:016x}"), "1b06f8889a4035a7");
}

#[test]
fn a_truncated_base_is_rejected() {
    let base = base();
    let cut: String = base.split_inclusive('\n').take(5000).collect();
    let error = morph(&cut, &Station::all()[0]).unwrap_err();
    assert!(error.to_string().contains("8760 hours of a common year"), "{error}");
}
