//! Buildings drawn by Latin hypercube, with parameters of as many decimals as the manifest gives.

use super::Building;
use super::hypercube::latin_hypercube;
use crate::climate::{Place, Region};
use crate::commercial::{self, CommercialParameters};
use crate::house::{DIMENSIONS, Heater, Heating, House, HouseSample};
use crate::{BuildingType, Result};

/// Decimals of the commercial parameters, in their order. The window-to-wall ratio of a warehouse is less than 1 %.
const DECIMALS: [i32; 8] = [4, 4, 4, 5, 4, 4, 4, 1];

/// Places and regions that a sample may be restricted to.
#[derive(Clone, Debug, PartialEq)]
pub enum Places {
    /// As in the dataset: the 16 places in the United States, or every region by its share of the stock.
    All,
    /// These, in equal numbers.
    Named(Vec<String>),
}

/// `count` buildings of a type, by a Latin hypercube of their own for each seed.
///
/// # Errors
/// [`crate::Error::UnknownPlace`] for a name that is no place, or no region where the type is the house.
pub fn sample(
    building_type: BuildingType,
    count: usize,
    seed: u64,
    places: &Places,
) -> Result<Vec<Building>> {
    draw(building_type, building_type.name(), count, seed, places)
}

/// [`sample`] by the stream of a name.
pub(super) fn draw(
    building_type: BuildingType,
    stream: &str,
    count: usize,
    seed: u64,
    places: &Places,
) -> Result<Vec<Building>> {
    if building_type == BuildingType::SingleFamilyHouse {
        let regions = regions(places)?;
        let points = latin_hypercube::<DIMENSIONS>(stream, seed, count);
        return points.iter().map(|point| house(point, &regions)).collect();
    }
    let places = commercial_places(places)?;
    let points = latin_hypercube::<9>(stream, seed, count);
    points.iter().map(|point| commercial(building_type, point, &places)).collect()
}

fn commercial_places(places: &Places) -> Result<Vec<&'static Place>> {
    match places {
        Places::All => Ok(Place::benchmark().iter().collect()),
        Places::Named(names) => names.iter().map(|name| Place::find(name)).collect(),
    }
}

/// None for all.
fn regions(places: &Places) -> Result<Vec<&'static Region>> {
    match places {
        Places::All => Ok(Vec::new()),
        Places::Named(names) => names.iter().map(|name| Region::find(name)).collect(),
    }
}

/// The first coordinate is the place: as an axis of the hypercube, it gives every place the same number.
fn commercial(building_type: BuildingType, point: &[f64; 9], places: &[&'static Place]) -> Result<Building> {
    let [place, unit @ ..] = *point;
    let place = nth(places, place);
    let drawn = CommercialParameters::from_unit(unit, building_type, place.ashrae_zone)?;
    let bounds = commercial::bounds(building_type, place.ashrae_zone)?;
    let mut values = drawn.values();
    for ((value, bound), decimals) in values.iter_mut().zip(&bounds).zip(DECIMALS) {
        *value = rounded_within(*value, decimals, bound.low, bound.high);
    }
    Ok(Building::Commercial { building_type, place, parameters: CommercialParameters::from_values(values) })
}

fn house(point: &[f64; DIMENSIONS], regions: &[&'static Region]) -> Result<Building> {
    let mut sample = HouseSample::from_unit(point)?;
    if !regions.is_empty() {
        sample.region = nth(regions, point[0]);
    }
    round(&mut sample.house);
    Ok(Building::House(sample))
}

/// The element at a share of the way through a list.
fn nth<T: Copy>(list: &[T], share: f64) -> T {
    list[((share * list.len() as f64) as usize).min(list.len() - 1)]
}

/// The bounds of a house are far from what is drawn.
fn round(house: &mut House) {
    for (value, decimals) in [
        (&mut house.floor_area, 1),
        (&mut house.aspect, 3),
        (&mut house.orientation, 1),
        (&mut house.wall_resistance, 3),
        (&mut house.attic_resistance, 3),
        (&mut house.foundation_resistance, 3),
        (&mut house.air_changes_50, 3),
        (&mut house.window_to_wall, 4),
        (&mut house.window_u, 3),
        (&mut house.window_shgc, 3),
        (&mut house.appliance_use, 3),
        (&mut house.ventilation, 2),
        (&mut house.heat_recovery, 3),
        (&mut house.cooling_cop, 3),
        (&mut house.heating_oversizing, 3),
        (&mut house.cooling_oversizing, 3),
    ] {
        *value = rounded(*value, decimals);
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

/// The nearest number of so many decimals: the one that its decimal text reads back as, since whole numbers and powers
/// of ten are exact and division rounds correctly.
fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = power_of_ten(decimals);
    (value * scale).round() / scale
}

/// [`rounded`], or the neighbour that is within the bounds.
fn rounded_within(value: f64, decimals: i32, low: f64, high: f64) -> f64 {
    let (near, scale) = (rounded(value, decimals), power_of_ten(decimals));
    if near < low {
        (value * scale).ceil() / scale
    } else if near > high {
        (value * scale).floor() / scale
    } else {
        near
    }
}

fn power_of_ten(decimals: i32) -> f64 {
    (0..decimals).fold(1.0, |power, _| power * 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sampled_building_is_within_the_bounds_of_its_type() {
        for building_type in BuildingType::ALL {
            for building in sample(building_type, 400, 3, &Places::All).unwrap() {
                match building {
                    Building::Commercial { place, parameters, .. } => {
                        parameters.check(building_type, place.ashrae_zone).unwrap();
                    }
                    Building::House(sample) => sample.house.check().unwrap(),
                }
            }
        }
    }

    #[test]
    fn named_places_share_the_buildings_equally() {
        let named = |names: [&str; 2]| Places::Named(names.map(str::to_owned).to_vec());
        for (building_type, names) in [
            (BuildingType::Warehouse, ["Miami", "Montréal"]),
            (BuildingType::SingleFamilyHouse, ["Estrie", "Laval"]),
        ] {
            let buildings = sample(building_type, 10, 0, &named(names)).unwrap();
            for name in names {
                assert_eq!(buildings.iter().filter(|each| each.place() == name).count(), 5);
            }
        }
        let error = sample(BuildingType::SingleFamilyHouse, 1, 0, &named(["Miami", "Laval"])).unwrap_err();
        assert!(error.to_string().contains("Estrie"), "{error}");
        let error = sample(BuildingType::Warehouse, 1, 0, &named(["Dever", "Miami"])).unwrap_err();
        assert!(error.to_string().contains("Denver"), "{error}");
    }

    #[test]
    fn rounding_stays_within_bounds() {
        assert_eq!(rounded_within(1.635264, 3, 1.635264, 2.0), 1.636);
        assert_eq!(rounded_within(1.9999, 3, 1.0, 1.9999), 1.999);
        assert_eq!(rounded_within(1.2344, 3, 1.0, 2.0), 1.234);
    }

    #[test]
    fn a_custom_parameter_out_of_bounds_is_named_when_the_model_is_made() {
        let mut building = sample(BuildingType::SingleFamilyHouse, 1, 0, &Places::All).unwrap().remove(0);
        if let Building::House(sample) = &mut building {
            sample.house.window_u = f64::NAN;
        }
        let header = crate::climate::site::tests::MONTREAL;
        let site = crate::climate::Site::from_epw(header, std::path::Path::new("a.epw")).unwrap();
        let error = building.model(&crate::Model::default(), &site).unwrap_err();
        assert!(error.to_string().contains("window_u"), "{error}");
    }

    #[test]
    fn an_empty_sample_is_empty() {
        assert_eq!(sample(BuildingType::Warehouse, 0, 0, &Places::All).unwrap(), Vec::new());
    }
}
