//! Latin hypercube samples of buildings, with parameters rounded to the decimals of the manifest.

mod heating;
pub(crate) mod hypercube;
pub(crate) mod split;

use std::sync::Arc;

use b2b_building::{BuildingType, Parameter};
use b2b_climate::{Location, Place, Region, WeatherFile};

use rand_chacha::rand_core::Rng;

use self::hypercube::latin_hypercube;
use super::setting::{self, FOUNDATIONS, rounded, rounded_within};
use super::{Building, Setting};
use crate::commercial::{self, CommercialParameters};
use crate::house::{DIMENSIONS, FixedProperties, Heater, Heating, House, HouseSample, NUMBERS, Vintage};
use crate::{Error, Result};
use b2b_base::random::stream;

/// Decimals of the commercial parameters, in their order. The window-to-wall ratio of a warehouse is less than 1 %.
const DECIMALS: [i32; 9] = [4, 4, 4, 4, 5, 4, 4, 4, 1];

/// Coordinate of the heating system of a house.
const SYSTEM: usize = 15;

/// The stream of the seeds of households, distinct from the hypercube's streams.
const HOUSEHOLDS: u64 = 2000;

/// The places or regions from which a sample is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Places {
    /// The dataset's places: the 16 places in the United States, or the regions by their share of the stock.
    All,
    /// These places or regions, in equal numbers.
    Named(Vec<String>),
    /// The places of these weather files, in equal numbers.
    Files(Vec<Arc<WeatherFile>>),
}

/// Draws `count` buildings of a type; each seed has its own Latin hypercube.
///
/// # Errors
/// [`b2b_climate::Error::UnknownPlace`] for an unknown place, or an unknown region for houses;
/// [`Error::UnknownParameter`], [`Error::Setting`] and [`Error::Parameter`] (within [`Error::AtPlace`] if it
/// depends on the climate) for an invalid setting; [`Error::ClimateZone`] for a weather file in a zone without
/// requirements in the code.
pub fn sample(
    building_type: BuildingType,
    count: usize,
    seed: u64,
    places: &Places,
    settings: &[Setting],
) -> Result<Vec<Building>> {
    draw(building_type, building_type.name(), count, seed, places, settings)
}

/// [`sample`] with a named random stream.
pub(super) fn draw(
    building_type: BuildingType,
    name: &str,
    count: usize,
    seed: u64,
    places: &Places,
    settings: &[Setting],
) -> Result<Vec<Building>> {
    setting::check(settings, building_type)?;
    let locations = locations(building_type, places)?;
    if building_type == BuildingType::SingleFamilyHouse {
        let points = latin_hypercube::<DIMENSIONS>(name, seed, count);
        let mut households = stream(name, seed, HOUSEHOLDS);
        return points
            .iter()
            .map(|point| house(point, households.next_u64(), &locations, settings))
            .collect();
    }
    let points = latin_hypercube::<10>(name, seed, count);
    points.iter().map(|point| commercial(building_type, point, &locations, settings)).collect()
}

/// The locations; empty for houses in all of Québec.
fn locations(building_type: BuildingType, places: &Places) -> Result<Vec<Location>> {
    let house = building_type == BuildingType::SingleFamilyHouse;
    match places {
        Places::All if house => Ok(Vec::new()),
        Places::All => Ok(Place::benchmark().iter().map(Location::Place).collect()),
        Places::Named(names) if house => {
            names.iter().map(|name| Ok(Location::Region(Region::find(name)?))).collect()
        }
        Places::Named(names) => names.iter().map(|name| Ok(Location::Place(Place::find(name)?))).collect(),
        Places::Files(files) => Ok(files.iter().cloned().map(Location::File).collect()),
    }
}

/// Draws a commercial building. The first coordinate is the place: as an axis of the hypercube it gives every place the
/// same number of buildings.
fn commercial(
    building_type: BuildingType,
    point: &[f64; 10],
    locations: &[Location],
    settings: &[Setting],
) -> Result<Building> {
    let [place, unit @ ..] = *point;
    let location = nth(locations, place);
    let zone = location.ashrae_zone().unwrap_or_default();
    let drawn = CommercialParameters::from_unit(unit, building_type, zone)?;
    let bounds = commercial::bounds(building_type, zone)?;
    let mut values = drawn.values();
    for (index, value) in values.iter_mut().enumerate() {
        let (bound, decimals) = (bounds[index], DECIMALS[index]);
        *value = match setting::of(settings, bound.name) {
            Some(setting) => {
                setting.number(unit[index], decimals, bound).map_err(|source| at(location, source))?
            }
            None => rounded_within(*value, decimals, bound.low, bound.high),
        };
    }
    let parameters = CommercialParameters::from_values(values);
    Ok(Building::Commercial { building_type, location: location.clone(), parameters })
}

fn at(location: &Location, source: Error) -> Error {
    let zone = location.ashrae_zone().unwrap_or_default().to_owned();
    Error::AtPlace { place: location.name().to_owned(), zone, source: Box::new(source) }
}

fn house(
    point: &[f64; DIMENSIONS],
    household: u64,
    locations: &[Location],
    settings: &[Setting],
) -> Result<Building> {
    let [first, last] = Vintage::YEARS.map(f64::from);
    let year = |setting: &Setting| setting.whole(point[1], Parameter::new("year", "1", first, last));
    let given = FixedProperties {
        year: setting::of(settings, "year").map(year).transpose()?,
        foundation: setting::of(settings, "foundation").map(|each| each.word(&FOUNDATIONS)).transpose()?,
    };
    let mut sample = HouseSample::from_unit_with(point, &given)?;
    if !locations.is_empty() {
        sample.location = nth(locations, point[0]).clone();
    }
    let house = &mut sample.house;
    house.household = household;
    round(house);
    if let Some(setting) = setting::of(settings, "storeys") {
        house.storeys = setting.whole(point[3], House::STOREYS)?;
    }
    if let Some(setting) = setting::of(settings, "garage") {
        house.garage = setting.word(&[("true", true), ("false", false)])?;
    }
    for number in &NUMBERS {
        if let Some(setting) = setting::of(settings, number.name()) {
            let share = point[number.coordinate];
            let bound = number.field.parameter;
            let value = match number.decimals {
                0 => f64::from(setting.whole(share, bound)?),
                decimals => setting.number(share, decimals, bound)?,
            };
            number.field.set(house, value);
        }
    }
    house.heating = heating::set(house.heating, point[SYSTEM], settings)?;
    Ok(Building::House(sample))
}

/// The element at a relative position in a list.
fn nth<T>(list: &[T], share: f64) -> &T {
    &list[((share * list.len() as f64) as usize).min(list.len() - 1)]
}

/// Rounds the numbers of a house; bounds are not checked because rounding takes no drawn value past them.
fn round(house: &mut House) {
    for number in &NUMBERS {
        number.field.set(house, rounded(number.field.of(house), number.decimals));
    }
    match &mut house.heating {
        Heating::HeatPump { cop, cutoff, backup } => {
            (*cop, *cutoff) = (rounded(*cop, 3), rounded(*cutoff, 1));
            round_heater(backup);
        }
        Heating::Furnace(heater) => round_heater(heater),
    }
}

fn round_heater(heater: &mut Heater) {
    if let Heater::Fuel { efficiency } = heater {
        *efficiency = rounded(*efficiency, 3);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::house::Foundation;
    use b2b_energyplus::install::Quiet;

    #[test]
    fn every_sampled_building_is_within_the_bounds_of_its_type() {
        for building_type in BuildingType::ALL {
            for building in sample(building_type, 400, 3, &Places::All, &[]).unwrap() {
                match building {
                    Building::Commercial { location, parameters, .. } => {
                        parameters.check(building_type, location.ashrae_zone().unwrap()).unwrap();
                    }
                    Building::House(sample) => sample.house.check().unwrap(),
                }
            }
        }
    }

    #[test]
    fn named_places_have_equal_numbers_of_buildings() {
        let named = |names: [&str; 2]| Places::Named(names.map(str::to_owned).to_vec());
        for (building_type, names) in [
            (BuildingType::Warehouse, ["Miami", "Montréal"]),
            (BuildingType::SingleFamilyHouse, ["Estrie", "Laval"]),
        ] {
            let buildings = sample(building_type, 10, 0, &named(names), &[]).unwrap();
            for name in names {
                assert_eq!(buildings.iter().filter(|each| each.place() == name).count(), 5);
            }
        }
        let error =
            sample(BuildingType::SingleFamilyHouse, 1, 0, &named(["Miami", "Laval"]), &[]).unwrap_err();
        assert!(error.to_string().contains("Estrie"), "{error}");
        let error = sample(BuildingType::Warehouse, 1, 0, &named(["Dever", "Miami"]), &[]).unwrap_err();
        assert!(error.to_string().contains("Denver"), "{error}");
    }

    #[test]
    fn a_parameter_out_of_bounds_is_reported_by_the_model() {
        let mut building =
            sample(BuildingType::SingleFamilyHouse, 1, 0, &Places::All, &[]).unwrap().remove(0);
        if let Building::House(sample) = &mut building {
            sample.house.window_u = f64::NAN;
        }
        let header = crate::tests::MONTREAL;
        let site = b2b_climate::Site::from_epw(header, std::path::Path::new("a.epw")).unwrap();
        let error = building.model(&b2b_building::Model::default(), &site).unwrap_err();
        assert!(error.to_string().contains("window_u"), "{error}");
    }

    #[test]
    fn an_empty_sample_is_empty() {
        assert_eq!(sample(BuildingType::Warehouse, 0, 0, &Places::All, &[]).unwrap(), Vec::new());
    }

    fn set(text: &[&str]) -> Vec<Setting> {
        text.iter().map(|text| text.parse().unwrap()).collect()
    }

    fn houses(settings: &[&str]) -> Vec<HouseSample> {
        let houses = sample(BuildingType::SingleFamilyHouse, 40, 0, &Places::All, &set(settings)).unwrap();
        let house = |building| match building {
            Building::House(sample) => sample,
            Building::Commercial { .. } => unreachable!(),
        };
        houses.into_iter().map(house).collect()
    }

    #[test]
    fn a_set_parameter_is_exact_and_a_narrowed_one_fills_its_range() {
        let drawn = |settings: &[&str]| -> Vec<CommercialParameters> {
            let buildings = sample(BuildingType::OfficeMedium, 40, 5, &Places::All, &set(settings)).unwrap();
            let parameters = |building: &Building| match building {
                Building::Commercial { parameters, .. } => *parameters,
                Building::House(_) => unreachable!(),
            };
            buildings.iter().map(parameters).collect()
        };
        let (all, some) = (drawn(&[]), drawn(&["window_to_wall=0.40", "infiltration=0.5..1.2"]));
        let mut infiltration: Vec<f64> = some.iter().map(|each| each.infiltration).collect();
        infiltration.sort_by(f64::total_cmp);
        for (rank, value) in infiltration.iter().enumerate() {
            let slice = 0.7 / 40.0;
            assert!(
                (value - 0.5 - slice * (rank as f64 + 0.5)).abs() <= slice / 2.0 + 1e-4,
                "{rank}: {value}"
            );
        }
        for (all, some) in all.iter().zip(&some) {
            assert_eq!(some.window_to_wall, 0.40);
            let infiltration = some.infiltration;
            assert_eq!(*some, CommercialParameters { window_to_wall: 0.40, infiltration, ..*all });
        }
    }

    #[test]
    fn the_error_of_a_parameter_that_a_climate_does_not_allow_has_the_place() {
        let ask = |text: &str| sample(BuildingType::Warehouse, 50, 0, &Places::All, &set(&[text]));
        let said = ask("infiltration=0.5..1.7").unwrap_err().to_string();
        for word in ["`infiltration`", "1.7", "1.2", "Great Falls", "zone 6B"] {
            assert!(said.contains(word), "{said}");
        }
        assert!(ask("infiltration=0.5..1.2").is_ok());
    }

    #[test]
    fn dependent_parameters_follow_a_set_parameter_of_a_house() {
        for sample in houses(&["year=2015..2020", "foundation=slab", "floor_area=123.45"]) {
            assert!((2015..=2020).contains(&sample.year) && sample.vintage == Vintage::From2013);
            assert_eq!((sample.house.foundation, sample.house.floor_area), (Foundation::Slab, 123.45));
            // New houses are insulated like new houses.
            assert!(sample.house.attic_resistance > 7.0, "{}", sample.house.attic_resistance);
            sample.house.check().unwrap();
        }
        let garages = houses(&["garage=true", "storeys=2", "occupants=1..3"]);
        assert!(garages.iter().all(|sample| sample.house.garage && sample.house.storeys == 2));
        assert!(garages.iter().all(|sample| [1.0, 2.0, 3.0].contains(&sample.house.occupants)));
    }

    #[test]
    fn invalid_settings_are_rejected() {
        let ask = |of, text: &str| sample(of, 0, 0, &Places::All, &set(&[text])).is_err();
        assert!(ask(BuildingType::SingleFamilyHouse, "wall_u=1"));
        assert!(ask(BuildingType::Warehouse, "windows=1"));
    }

    #[test]
    fn buildings_are_located_at_the_place_of_their_weather_file() {
        let path = Place::find("Buffalo").unwrap().epw(&mut Quiet).unwrap();
        let file = |zone| Arc::new(WeatherFile::read(&path, zone).unwrap());
        for building_type in [BuildingType::RetailStandalone, BuildingType::SingleFamilyHouse] {
            for building in sample(building_type, 5, 0, &Places::Files(vec![file(None)]), &[]).unwrap() {
                assert_eq!(building.location().ashrae_zone(), Some("5A"));
                assert!(building.place().contains("Buffalo"));
            }
        }
        let hot = Places::Files(vec![file(Some("0A"))]);
        let error = sample(BuildingType::Warehouse, 1, 0, &hot, &[]).unwrap_err().to_string();
        assert!(error.contains("`0A`"), "{error}");
        assert!(sample(BuildingType::SingleFamilyHouse, 1, 0, &hot, &[]).is_ok());
    }
}
