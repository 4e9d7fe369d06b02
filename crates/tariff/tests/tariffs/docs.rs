//! The lists and the example in docs/tariffs.md match the data.
//!
//! `B2B_RECORD_DOCS=1 cargo test -p b2b-tariff docs` writes the lists.

use std::fmt::Write;
use std::path::PathBuf;

use b2b_tariff::{Carrier, Customers, Emissions, Moment, Prices, Tariff};

use crate::common::YEAR;

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/tariffs.md")
}

#[test]
fn the_page_of_tariffs_lists_the_shipped_ones() {
    let page = std::fs::read_to_string(path()).unwrap();
    let expected = with_table(&with_table(&page, &tariffs()), &profiles());
    if std::env::var_os("B2B_RECORD_DOCS").is_some() {
        std::fs::write(path(), &expected).unwrap();
    }
    let remedy = "run `B2B_RECORD_DOCS=1 cargo test -p b2b-tariff docs`";
    assert!(std::fs::read_to_string(path()).unwrap() == expected, "docs/tariffs.md is out of date: {remedy}");
}

fn tariffs() -> String {
    let mut table = String::from(
        "| tariff | utility and rate | place | for | has | in force |\n|---|---|---|---|---|---|\n",
    );
    for tariff in Tariff::names().map(|name| Tariff::named(name).unwrap()) {
        let whom = match tariff.customers {
            Customers::Homes => "homes",
            Customers::Businesses => "businesses",
            Customers::Any => "comparisons",
        };
        let Tariff { name, title, place, source, .. } = &tariff;
        let traits = tariff.traits().join(", ");
        let date = linked(&source.date, source.url.as_deref());
        writeln!(table, "| `{name}` | {title} | {place} | {whom} | {traits} | {date} |").unwrap();
    }
    table
}

fn profiles() -> String {
    let mut table = String::from("| profile | of | year |\n|---|---|---|\n");
    for profile in Emissions::names().map(|name| Emissions::named(name).unwrap()) {
        let Emissions { name, title, place, source, .. } = &profile;
        let date = linked(&source.date, source.url.as_deref());
        writeln!(table, "| `{name}` | {title}: {place} | {date} |").unwrap();
    }
    table
}

/// Returns the date of a source, with a link to its document if that has an address.
fn linked(date: &str, url: Option<&str>) -> String {
    url.map_or_else(|| date.to_owned(), |url| format!("[{date}]({url})"))
}

/// Returns a page with the table that has the same header replaced.
fn with_table(page: &str, table: &str) -> String {
    let header = table.lines().next().unwrap();
    let begin = page.find(header).unwrap_or_else(|| panic!("docs/tariffs.md has no table `{header}`"));
    let end = page[begin..].find("\n\n").map_or(page.len(), |length| begin + length + 1);
    format!("{}{table}{}", &page[..begin], &page[end..])
}

/// Returns the TOML examples of the page.
fn examples() -> [String; 2] {
    let page = std::fs::read_to_string(path()).unwrap();
    let blocks = page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap().to_owned());
    blocks.collect::<Vec<_>>().try_into().unwrap()
}

#[test]
fn the_example_of_an_emission_profile_is_valid() {
    let [_, example] = examples();
    let of = |text: &str| Emissions::parse("example", "docs/tariffs.md", text);
    let (noon, profile) = (Moment { day: 1, hour: 12.0 }, of(&example).unwrap());
    assert_eq!([Carrier::Electricity, Carrier::Gas].map(|carrier| profile.at(carrier, noon)), [0.373, 0.181]);
    let said = |from, to| of(&example.replace(from, to)).unwrap_err().to_string();
    assert!(said("gas = 0.181", "gas = 181").contains("`gas` is 181; expected 0 to 2 kg/kWh"));
    assert!(said("flat = 373", "flat = 373000").contains("373000 kg/MWh; expected numbers of 0 to 3000"));
}

#[test]
fn the_example_of_a_tariff_is_valid() {
    let [example, _] = examples();
    let tariff = Tariff::parse("example", "docs/tariffs.md", &example).unwrap();
    assert!(tariff.has_events() && tariff.has_demand_charge() && tariff.needs_temperatures());
    let events = tariff.events(YEAR, &[-20.0; 365]);
    assert!(!events.is_empty());
    Prices::new(tariff, YEAR, &events, Some(&[0.0; 8760])).unwrap();
}

#[test]
fn the_page_of_tariffs_has_at_most_900_words_beside_its_tables() {
    let page = std::fs::read_to_string(path()).unwrap();
    let words: usize =
        page.lines().filter(|line| !line.starts_with('|')).map(|line| line.split_whitespace().count()).sum();
    assert!(words <= 900, "{words} words");
}
