use std::collections::{BTreeMap, BTreeSet};

use super::*;

/// Header of Montréal's weather file.
pub(crate) const MONTREAL: &str = include_str!("../../climate/tests/data/montreal_header.epw");

fn count<K: Ord>(keys: impl Iterator<Item = K>) -> BTreeMap<K, usize> {
    let mut counts = BTreeMap::new();
    keys.for_each(|key| *counts.entry(key).or_default() += 1);
    counts
}

fn commercial() -> impl Iterator<Item = BuildingType> {
    BuildingType::ALL.into_iter().filter(|each| *each != BuildingType::SingleFamilyHouse)
}

#[test]
fn the_dataset_has_a_thousand_buildings_of_each_type_and_all_differ() {
    assert_eq!(all().count(), 6000);
    for building_type in BuildingType::ALL {
        for (row, number) in rows(building_type).iter().zip(1..) {
            assert_eq!(row.id, BuildingId::new(building_type, number).unwrap());
            assert_eq!(row.building.building_type(), building_type);
            assert_eq!(super::row(row.id), row);
        }
    }
    let different: BTreeSet<String> = all().map(|row| format!("{:?}", row.building)).collect();
    assert_eq!(different.len(), 6000);
}

#[test]
fn every_place_has_62_or_63_buildings_of_a_type_and_a_tenth_are_for_tests() {
    for building_type in commercial() {
        let rows = rows(building_type);
        let places = count(rows.iter().map(|row| row.building.place()));
        assert_eq!(places.len(), 16);
        assert!(places.values().all(|n| [62, 63].contains(n)), "{places:?}");
        let test = rows.iter().filter(|row| row.split == Split::Test);
        let test = count(test.map(|row| row.building.place()));
        assert_eq!(test.values().sum::<usize>(), 100);
        assert!(test.values().all(|n| [6, 7].contains(n)), "{test:?}");
    }
}

#[test]
fn every_region_has_a_tenth_of_its_houses_for_tests() {
    let rows = rows(BuildingType::SingleFamilyHouse);
    let regions = count(rows.iter().map(|row| row.building.place()));
    let test = rows.iter().filter(|row| row.split == Split::Test);
    let test = count(test.map(|row| row.building.place()));
    assert_eq!((regions.len(), test.len()), (15, 15));
    assert_eq!(test.values().sum::<usize>(), 100);
    for (region, houses) in regions {
        assert!((test[region] as f64 - houses as f64 / 10.0).abs() < 1.0, "{region}: {houses}");
    }
}

#[test]
fn the_small_test_has_eight_test_buildings_of_a_type_one_in_each_climate_zone() {
    for building_type in BuildingType::ALL {
        let small: Vec<_> = rows(building_type).iter().filter(|row| row.test_small).collect();
        assert_eq!(small.len(), 8);
        assert!(small.iter().all(|row| row.split == Split::Test));
        let zone = |building: &Building| Some(building.location().ashrae_zone()?[..1].to_owned());
        let zones: BTreeSet<_> = small.iter().filter_map(|row| zone(&row.building)).collect();
        assert_eq!(zones.len(), if building_type == BuildingType::SingleFamilyHouse { 0 } else { 8 });
    }
}

/// Nearly half of the homes are empty on a weekday at noon: 0.49 in the time-use diaries of McKenna, Krawczynski and
/// Thomson (2015), weighted by the sizes of these households.
#[test]
fn most_houses_are_empty_at_some_hour_of_the_week() {
    let houses = rows(BuildingType::SingleFamilyHouse).iter().map(|row| match &row.building {
        Building::House(sample) => sample.house.draw_household(),
        Building::Commercial { .. } => unreachable!(),
    });
    let households: Vec<_> = houses.collect();
    let share = |empty: &dyn Fn(&crate::house::Household) -> bool| {
        households.iter().filter(|household| empty(household)).count() as f64 / households.len() as f64
    };
    let ever = share(&|household| (0..7).any(|day| household.at_home(day).contains(&0)));
    let noon = (0..5).map(|day| share(&|household| household.at_home(day)[50] == 0)).sum::<f64>() / 5.0;
    let night = share(&|household| household.at_home(1)[12] == 0);
    println!("ever {ever}, at noon {noon}, at night {night}");
    assert!(ever > 0.95 && (0.42..0.56).contains(&noon) && night == 0.0, "{ever} {noon} {night}");
}

/// Every tenth of a range holds about a tenth of the buildings, in every climate.
#[test]
fn parameters_fill_their_ranges() {
    for building_type in commercial() {
        let mut tenths = [[0; 10]; 9];
        for row in rows(building_type) {
            let Building::Commercial { location, parameters, .. } = &row.building else { unreachable!() };
            let bounds = crate::commercial::bounds(building_type, location.ashrae_zone().unwrap()).unwrap();
            for ((value, bound), tenths) in parameters.values().iter().zip(&bounds).zip(&mut tenths) {
                let share = (value - bound.low) / (bound.high - bound.low);
                tenths[((share * 10.0) as usize).min(9)] += 1;
            }
        }
        for (name, tenths) in crate::commercial::bounds(building_type, "5B").unwrap().iter().zip(&tenths) {
            assert!(tenths.iter().all(|n| (95..=105).contains(n)), "{building_type} {name:?}: {tenths:?}");
        }
    }
}

/// `b2b dataset manifest --out crates/dataset/data` writes it.
#[test]
fn the_shipped_manifest_equals_the_generated_one() {
    let checked_in = include_str!("../data/v1.csv");
    let generated = manifest(all()).to_csv();
    let different = generated.lines().zip(checked_in.lines()).find(|(new, old)| new != old);
    assert_eq!(different, None, "generated, checked in");
    assert!(generated == checked_in);
}

/// Parameters are rounded before use, so the manifest has every digit.
#[test]
fn the_manifest_shows_every_digit_of_every_parameter() {
    let table = manifest(rows(BuildingType::OfficeSmall));
    let column = table.columns.iter().position(|column| column.name == "window_u").unwrap();
    for (cells, row) in table.rows.iter().zip(rows(BuildingType::OfficeSmall)) {
        let Building::Commercial { parameters, .. } = &row.building else { unreachable!() };
        assert_eq!(cells[column].parse::<f64>().unwrap(), parameters.window_u);
        assert!(cells[column].len() <= 6, "{}", cells[column]);
    }
}

#[test]
fn no_cell_of_the_manifest_needs_quotes() {
    for row in manifest(all()).rows {
        assert!(row.iter().all(|cell| !cell.contains([',', '"', '\n'])), "{row:?}");
    }
}

#[test]
fn the_year_among_the_attributes_is_the_one_that_the_page_says() {
    let page = include_str!("../../../docs/training_reference.md");
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let said = "The year among the attributes is a house's year of construction, a commercial building's code year, \
                or 0 for your own model.";
    assert!(page.contains(said));
    for row in all() {
        let year = row.building.origin().year;
        match &row.building {
            Building::House(sample) => assert_eq!(year, Some(sample.year), "{}", row.id),
            Building::Commercial { .. } => assert_eq!(year, Some(2019), "{}", row.id),
        }
    }
    let own = "m.idf".parse().unwrap();
    assert_eq!(Placement::default().origin(&own).year, None);
}
