//! Files of tariffs and emission profiles: the shipped ones, and the errors for bad ones.

use crate::common::{assert_cost, day};
use b2b_tariff::{Carrier, Emissions, Moment, Tariff};

/// A tariff with two seasons, events and a demand charge. Tests name its lines by number.
const TARIFF: &str = r#"title = "Test"
place = "Nowhere"
customers = "any"
currency = "USD"
source = { document = "none", date = "2026" }

[electricity]
daylight_time = true
holidays = ["07-04"]

[[electricity.energy]]
name = "winter"
dates = "10-01..05-31"
price = 0.10

[[electricity.energy]]
name = "summer day"
dates = "06-01..09-30"
days = "weekdays"
hours = ["8-20"]
price = 0.20

[[electricity.energy]]
name = "summer night"
dates = "06-01..09-30"
price = 0.05

[[electricity.demand]]
name = "demand"
price = 5.0

[electricity.events]
price = 0.50
dates = "12-01..03-31"
hours = ["6-10"]
most_per_day = 1
most_hours = 100
notice = 15
"#;

/// Returns the error for the tariff with one text replaced by another.
fn with(from: &str, to: &str) -> String {
    assert!(TARIFF.contains(from), "{from}");
    let parsed = Tariff::parse("test", "test.toml", &TARIFF.replacen(from, to, 1));
    parsed.err().map_or_else(|| "accepted".to_owned(), |error| error.to_string())
}

#[track_caller]
fn assert_said(said: &str, line: usize, words: &[&str]) {
    assert!(said.starts_with(&format!("test.toml:{line}: ")), "line {line}: {said}");
    for word in words {
        assert!(said.contains(word), "`{word}`: {said}");
    }
}

#[test]
fn a_tariff_without_a_january_is_refused_with_the_dates() {
    assert_eq!(with("10-01..05-31", "10-01..05-31"), "accepted");
    let said = with("10-01..05-31", "02-01..05-31, 10-01..12-31");
    assert_said(&said, 11, &["no energy price from 01-01", "to 01-31", "[[electricity.energy]]"]);
}

#[test]
fn missing_hours_are_refused_with_the_first() {
    let said = with("hours = [\"8-20\"]\nprice = 0.20", "hours = [\"8-20\"]\nprice = 0.20");
    assert_eq!(said, "accepted");
    let said = with(
        "dates = \"06-01..09-30\"\nprice = 0.05",
        "dates = \"06-01..09-30\"\nhours = [\"0-8\", \"20-23\"]\nprice = 0.05",
    );
    assert_said(&said, 11, &["06-01", "09-30", "weekdays, 23:00"]);
}

#[test]
fn overlapping_hours_are_refused_with_both_names() {
    let said = with("dates = \"06-01..09-30\"\nprice = 0.05", "hours = [\"19-21\"]\nprice = 0.05");
    assert_said(&said, 23, &["`summer night`", "06-01", "19:00", "`summer day`"]);
    // Two entries for the rest of the same dates.
    let said = with("dates = \"06-01..09-30\"\nprice = 0.05", "dates = \"05-01..09-30\"\nprice = 0.05");
    assert_said(&said, 23, &["`summer night`", "05-01", "`winter`"]);
}

#[test]
fn events_without_a_notice_are_refused() {
    assert_said(&with("notice = 15\n", ""), 32, &["`notice`", "the day before", "notice = 15"]);
    assert_said(&with("notice = 15", "notice = 25"), 32, &["`notice`"]);
    assert_said(&with("most_hours = 100", "most_hours = 0"), 32, &["no event"]);
}

#[test]
fn what_has_no_effect_is_refused() {
    assert_said(&with("\"8-20\"", ""), 16, &["`summer day` is the price of no time", "remove it"]);
    let whole_days = with("days = \"weekdays\"\nhours = [\"8-20\"]", "hours = [\"0-24\"]");
    assert_said(&whole_days, 22, &["`summer night` is the price of no time"]);
    let demand = |also: &str| with("price = 5.0", &format!("price = 5.0\n{also}"));
    assert_said(&demand("hours = []"), 28, &["`demand` has no `hours`", "leave `hours` out"]);
    let ratchet = "dates = '06-01..09-30'\nratchet = { share = 0.65, dates = '12-01..03-31' }";
    assert_said(&demand(ratchet), 28, &["`demand` has a ratchet without effect"]);
    assert_said(&with("most_hours = 100", "most_hours = 3"), 32, &["no longer than `most_hours`"]);
    assert_said(&with("\"6-10\"", "\"6-10\", \"9-12\""), 32, &["do not overlap"]);
    let blocks = "[electricity.blocks]\nper = 'month'\nup_to = [1000]\n\n[electricity.events]";
    assert_said(&with("[electricity.events]", blocks), 32, &["[electricity.blocks] has no effect"]);
}

#[test]
fn negative_prices_are_refused_but_a_market_may_have_them() {
    assert_said(&with("price = 0.05", "price = -0.05"), 23, &["`summer night`", "-0.05", "hourly"]);
    assert_said(&with("price = 0.50", "price = -0.50"), 32, &["`event`", "-0.5"]);
    assert_said(&with("price = 5.0", "price = -5.0"), 28, &["`demand`", "-5"]);
    let hourly = format!("hourly = [{}]", ["-0.02"; 24].join(", "));
    assert_eq!(with("price = 0.10", &hourly), "accepted");
    assert_said(&with("price = 0.10", "hourly = [0.1, 0.2]"), 11, &["`winter`", "24"]);
}

#[test]
fn misspelled_keys_and_values_are_refused_with_their_lines() {
    assert_said(&with("price = 0.20", "prise = 0.20"), 21, &["`prise`", "did you mean `price`?"]);
    assert_said(&with("\"weekdays\"", "\"weekday\""), 19, &["`weekday`", "did you mean `weekdays`?"]);
    assert_said(&with("\"8-20\"", "\"20-8\""), 20, &["`20-8`", "16-20"]);
    assert_said(&with("\"06-01..09-30\"", "\"06-01..09-31\""), 18, &["`06-01..09-31`", "MM-DD..MM-DD"]);
    assert_said(&with("\"07-04\"", "\"fifth Monday of May\""), 9, &["fifth Monday of May", "last Monday"]);
    assert_said(&with("price = 0.10\n", ""), 11, &["`winter`", "`price` or `hourly`"]);
    assert_said(&with("price = 0.10", "price = [0.1, 0.2]"), 11, &["2 prices for 1 blocks"]);
    let excess = "price = 5.0\nexcess_over = \"demnad\"";
    assert_said(&with("price = 5.0", excess), 28, &["excess_over", "another demand charge"]);
    assert_said(&with("currency = \"USD\"", "currency = 3"), 4, &["string"]);
}

#[test]
fn a_file_that_is_not_toml_is_refused_with_its_line() {
    assert_said(&with("place = \"Nowhere\"", "place = "), 2, &[]);
}

#[test]
fn a_users_file_is_named_by_its_errors_and_its_tariff() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, TARIFF).unwrap();
    assert_eq!(Tariff::named(path.to_str().unwrap()).unwrap().name, "mine");
    std::fs::write(&path, TARIFF.replace("price = 0.20", "price = -1")).unwrap();
    let said = Tariff::read(&path).err().unwrap().to_string();
    assert!(said.starts_with(&format!("{}:16: ", path.display())), "{said}");
    let said = Tariff::read(&folder.path().join("none.toml")).err().unwrap().to_string();
    assert!(said.contains("none.toml"), "{said}");
}

#[test]
fn an_unknown_name_gets_the_nearest() {
    let said = Tariff::named("hq-flexd").err().unwrap().to_string();
    assert!(said.contains("unknown tariff `hq-flexd` (did you mean `hq-flex-d`?)"), "{said}");
    let said = Emissions::named("frcc-averge").err().unwrap().to_string();
    assert!(said.contains("emission profile") && said.contains("`frcc-average`"), "{said}");
}

#[test]
fn every_shipped_file_is_read_and_has_a_source() {
    for name in Tariff::names() {
        let tariff = Tariff::named(name).unwrap();
        assert!(!tariff.source.document.is_empty() && tariff.source.url.is_some(), "{name}");
    }
    for name in Emissions::names() {
        let profile = Emissions::named(name).unwrap();
        assert!(!profile.source.document.is_empty(), "{name}");
    }
    assert!(Tariff::names().count() >= 11 && Emissions::names().count() >= 12);
}

#[test]
fn every_file_of_the_data_is_shipped() {
    let data = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let stems = |folder: &str| {
        let entries = std::fs::read_dir(data.join(folder)).unwrap();
        entries.map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
    };
    for name in ["generic", "hydro_quebec", "united_states"]
        .iter()
        .flat_map(|folder| stems(&format!("tariffs/{folder}")))
    {
        assert!(Tariff::names().any(|known| known == name), "{name}");
    }
    for name in stems("emissions") {
        assert!(Emissions::names().any(|known| known == name), "{name}");
    }
}

#[test]
fn emissions_follow_season_and_hour_and_their_annual_means() {
    let at = |name: &str, month, hour| {
        Emissions::named(name).unwrap().at(Carrier::Electricity, Moment { day: day(month, 15), hour })
    };
    assert_cost(at("frcc-average", 1, 9.5), 0.219);
    assert_cost(at("frcc-average", 12, 9.5), 0.219);
    assert_cost(at("frcc-average", 7, 18.0), 0.536);
    assert_cost(at("mrow-marginal", 4, 0.0), 0.351);
    assert_cost(at("alaska", 4, 0.0), 0.487);
    assert_cost(at("quebec", 4, 0.0), 0.00036);
    let means = [
        ("frcc", 370.2, 464.4),
        ("srso", 389.4, 469.1),
        ("nyst", 221.1, 179.7),
        ("mrow", 305.9, 299.8),
        ("rmpa", 552.3, 261.1),
    ];
    for (region, average, marginal) in means {
        for (rate, expected) in [("average", average), ("marginal", marginal)] {
            let profile = Emissions::named(&format!("{region}-{rate}")).unwrap();
            let hours =
                (1..=365).flat_map(|day| (0..24).map(move |hour| Moment { day, hour: f64::from(hour) }));
            let mean = hours.map(|at| profile.at(Carrier::Electricity, at)).sum::<f64>() / 8760.0 * 1000.0;
            assert!((mean - expected).abs() < 1.0, "{region}-{rate}: {mean}, expected {expected}");
        }
    }
}

#[test]
fn emissions_of_fuels_match_tasks_without_a_profile() {
    let us = Emissions::named("us").unwrap();
    let at = |fuel| us.at(fuel, Moment { day: 1, hour: 0.0 });
    assert_eq!(
        [Carrier::Gas, Carrier::Propane, Carrier::FuelOil, Carrier::OtherFuel].map(at),
        [0.181, 0.215, 0.252, 0.320]
    );
    assert_cost(at(Carrier::DistrictHeating), 0.181 / 0.8);
    assert_cost(at(Carrier::DistrictCooling), 0.373 / 5.0);
}

#[test]
fn a_profile_needs_all_seasons_or_one_value() {
    let text = "title = \"a\"\nplace = \"b\"\nrate = \"average\"\nsource = { document = \"c\", date = \"d\" }\n[electricity]\n";
    let said = |rest: &str| {
        let parsed = Emissions::parse("test", "test.toml", &format!("{text}{rest}"));
        parsed.err().map_or_else(|| "accepted".to_owned(), |error| error.to_string())
    };
    assert_eq!(said("flat = 100"), "accepted");
    assert_said(&said(""), 5, &["`flat`", "`winter`"]);
    assert_said(&said("flat = -1"), 5, &["-1"]);
    assert_said(&said("flat = 1\nwintr = 3"), 7, &["did you mean `winter`?"]);
    assert_said(&said("flat = 1\n[fuels]\ngas = -2"), 7, &["`gas`", "-2"]);
}
