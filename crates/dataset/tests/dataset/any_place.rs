//! Buildings at a place defined only by its weather file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use b2b_building::BuildingType;
use b2b_climate::{Place, WeatherFile};
use b2b_dataset::{Places, Preparation, archetype, sample};
use b2b_energyplus::Library;
use b2b_energyplus::install::{Engine, Quiet};

/// Buffalo's weather file, without the design conditions of its header.
fn undesigned(folder: &Path) -> PathBuf {
    let path = Place::find("Buffalo").unwrap().epw(&mut Quiet).unwrap();
    let text = String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned();
    let (before, after) = text.split_once("DESIGN CONDITIONS").unwrap();
    let (_, after) = after.split_once('\n').unwrap();
    let path = folder.join("somewhere.epw");
    std::fs::write(&path, format!("{before}DESIGN CONDITIONS,0\n{after}")).unwrap();
    path
}

/// The hours of a typical year include its extremes to within about 2 K, so sizes are similar; and the models run.
#[test]
fn a_building_is_sized_by_the_hours_of_a_file_without_design_conditions() {
    let engine = Engine::ensure(&mut Quiet).unwrap();
    let library = Library::load(&engine.library).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let known = Place::find("Buffalo").unwrap().epw(&mut Quiet).unwrap();
    for building_type in [BuildingType::RetailStandalone, BuildingType::SingleFamilyHouse] {
        let prototype = archetype::prototype(building_type, &engine, &library).unwrap();
        let [with, without] = [known.clone(), undesigned(folder.path())].map(|path| {
            let file = Arc::new(WeatherFile::read(&path, None).unwrap());
            assert_eq!(file.ashrae_zone, "5A");
            let places = Places::Files(vec![Arc::clone(&file)]);
            let building = sample(building_type, 1, 0, &places, &[]).unwrap().remove(0);
            let model = building.model(&prototype, &file.site).unwrap();
            Preparation::new("b", model).run(&path, &library).unwrap()
        });
        assert_eq!(with.conditioned_floor_area, without.conditioned_floor_area);
        for (with, without) in with.actuators().zip(without.actuators()) {
            let ratio = without.high / with.high;
            assert!((0.7..1.4).contains(&ratio), "{building_type} {}: {ratio}", with.key);
        }
    }
}
