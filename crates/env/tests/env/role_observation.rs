//! The fixed width of houses' observations.

use std::path::Path;
use std::sync::Arc;

use crate::case::Case;
use b2b_building::{BuildingType, Class};
use b2b_climate::{Place, Site};
use b2b_dataset::Preparation;
use b2b_dataset::house::{Foundation, House, house};
use b2b_energyplus::Library;
use b2b_energyplus::install::{Engine, Quiet};
use b2b_env::{EpisodeConfig, RoleObservation, Spaces, Task};

fn spaces(parameters: &House, task: &str, library: &Library, weather: &Path) -> Spaces {
    let model = house(parameters, &Site::read(weather).unwrap()).unwrap();
    let building = Preparation::new("house", model).run(weather, library).unwrap();
    let building = building.of_class(Some(Class::new(BuildingType::SingleFamilyHouse, None)));
    let (period, task) = ("01-03..01-03".parse().unwrap(), task.parse::<Task>().unwrap());
    let episode = EpisodeConfig { weather: weather.to_owned(), period, steps_per_hour: 12, task };
    Spaces::new(Arc::new(building), episode)
}

/// Slot names and values of the fixed-width observation, for an observation whose values are slot numbers.
fn row(spaces: &Spaces) -> Vec<(String, f64)> {
    let form = RoleObservation::of(spaces).unwrap();
    let own: Vec<f64> = (100..).map(f64::from).take(spaces.observation.len()).collect();
    let mut row = vec![f64::NAN; RoleObservation::WIDTH];
    form.write(&own, &mut row);
    form.slots().iter().map(|slot| slot.name.clone()).zip(row).collect()
}

#[test]
fn every_role_has_the_same_slot_in_every_house_and_task() {
    let library = Library::load(&Engine::ensure(&mut Quiet).unwrap().library).unwrap();
    let weather = Place::find("Montreal").unwrap().epw(&mut Quiet).unwrap();
    let bare = House { foundation: Foundation::Slab, ..House::default() };
    let full = House { foundation: Foundation::Crawlspace, garage: true, ..House::default() };
    let mut names = Vec::new();
    for (parameters, zones, present) in [(bare, 2, [1.0, 1.0, 0.0, 0.0]), (full, 4, [1.0; 4])] {
        for task in ["constant", "occupancy"] {
            let spaces = spaces(&parameters, task, &library, &weather);
            let row = row(&spaces);
            assert_eq!(row.len(), RoleObservation::WIDTH);
            assert!(row.iter().all(|(_, value)| value.is_finite()));
            let value = |name: &str| row.iter().find(|(each, _)| each == name).unwrap().1;
            assert_eq!(value("living air temperature"), 100.0);
            assert_eq!(value("outdoor air temperature"), f64::from(100 + zones));
            assert_eq!(value("garage air temperature"), if zones == 4 { 103.0 } else { 0.0 });
            let target = if task == "constant" { 21.0 } else { f64::from(100 + zones + 8) };
            assert_eq!(value("living target"), target);
            assert_eq!(row[13..].iter().map(|(_, value)| *value).collect::<Vec<_>>(), present);
            names.push(row.into_iter().map(|(name, _)| name).collect::<Vec<_>>());
        }
    }
    assert!(names.iter().all(|each| *each == names[0]), "{names:?}");
}

#[test]
fn other_types_have_no_role_observation() {
    let case = Case::at_home(BuildingType::OfficeSmall);
    assert!(RoleObservation::of(case.env("01-03..01-03").spaces()).is_none());
}
