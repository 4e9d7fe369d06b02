//! Buildings drawn from the dataset and from the generator.

use std::sync::Arc;

use b2b_building::BuildingType;
use b2b_dataset::{Catalog, Control, Places, Split};
use b2b_workers::{
    Autoreset, Buildings, Launcher, Population, VecEnv, VecEnvOptions, Windows, WorkerOptions,
};

use crate::workers::DAY;

/// Names of the consecutive buildings in each of two environments, and their first observations.
fn drawn(population: Population, seed: u64) -> Vec<(String, Vec<u64>)> {
    let catalog = Arc::new(Catalog::open(&mut b2b_energyplus::install::Quiet).unwrap());
    let options =
        WorkerOptions::new(Launcher::new(env!("CARGO_BIN_EXE_b2b-worker")), catalog.library().path());
    let sampler = Buildings {
        catalog,
        population,
        control: Control::default(),
        period: DAY.parse().unwrap(),
        steps_per_hour: 4,
        task: b2b_env::Task::default(),
    };
    let sampler = Windows { of: sampler, days: (1, 1), starts: 1 };
    let options = VecEnvOptions { workers: options, autoreset: Autoreset::SameStep, widths: Some((2, 20)) };
    let mut vec = VecEnv::new(2, Box::new(sampler), options).unwrap();
    vec.reset(seed).unwrap();
    let mut seen = Vec::new();
    for step in 0..=96 {
        if step % 96 == 0 {
            for environment in 0..2 {
                assert_eq!(vec.lost(environment), None);
                let spaces = vec.spaces(environment).unwrap();
                let row = &vec.observations()[environment * 20..][..spaces.observation.len()];
                seen.push((spaces.building.name.clone(), row.iter().map(|value| value.to_bits()).collect()));
            }
        }
        if step < 96 {
            vec.step(&[0.1, 25.0, 0.1, 25.0]).unwrap();
        }
    }
    seen
}

#[test]
fn every_episode_draws_a_building_from_a_split_or_the_generator() {
    let house = BuildingType::SingleFamilyHouse;
    let test = drawn(Population::of_split(house, Split::Test), 3);
    let names: std::collections::BTreeSet<_> = test.iter().map(|(name, _)| name).collect();
    assert!(names.len() >= 3, "{names:?}");
    for name in names {
        let row = b2b_dataset::row(name.parse().unwrap());
        assert_eq!(row.split, Split::Test, "{name}");
    }
    let generated = || Population::Generated {
        building_type: house,
        places: Places::Named(vec!["Estrie".into()]),
        settings: vec!["floor_area=100..120".parse().unwrap()],
    };
    let (one, again) = (drawn(generated(), 5), drawn(generated(), 5));
    assert_eq!(one, again);
    assert_ne!(one[0].1, one[1].1);
    assert!(one.iter().all(|(name, _)| name.starts_with("SingleFamilyHouse-seed")));
}
