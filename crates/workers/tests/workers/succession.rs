//! Many consecutive buildings in few processes.

use std::sync::Arc;

use b2b_building::BuildingType;
use b2b_dataset::{BuildingId, Catalog, Control, Split};
use b2b_env::Task;
use b2b_workers::{
    Autoreset, Buildings, Draw, EpisodeSetting, Kept, Launcher, Population, Sampler, VecEnv, VecEnvOptions,
    Weighted, Windows, WithFaults, WithTask, WorkerOptions, Workers,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::workers::{DAY, is_alive};

const HOUSE: BuildingType = BuildingType::SingleFamilyHouse;

fn options(catalog: &Catalog) -> WorkerOptions {
    WorkerOptions::new(Launcher::new(env!("CARGO_BIN_EXE_b2b-worker")), catalog.library().path())
}

fn catalog() -> Arc<Catalog> {
    Arc::new(Catalog::open(&mut b2b_energyplus::install::Quiet).unwrap())
}

fn houses(catalog: &Arc<Catalog>, population: Population) -> Buildings {
    let task = Task::default();
    Buildings {
        catalog: Arc::clone(catalog),
        population,
        control: Control::default(),
        period: DAY.parse().unwrap(),
        steps_per_hour: 4,
        task,
    }
}

fn settings(catalog: &Arc<Catalog>, numbers: std::ops::Range<u32>) -> Vec<EpisodeSetting> {
    let of = houses(catalog, Population::Ids(Vec::new()));
    let setting = |number: u32| {
        let id: BuildingId = format!("SingleFamilyHouse-{number}").parse().unwrap();
        of.setting(id.to_string(), &b2b_dataset::row(id).building).unwrap()
    };
    numbers.map(setting).collect()
}

/// The building of each environment in several episodes.
fn succession(envs: &mut VecEnv, seed: u64, episodes: usize) -> Vec<Vec<String>> {
    envs.reset(seed).unwrap();
    let actions = vec![0.1; envs.len() * envs.widths().0];
    let mut seen = Vec::new();
    for _ in 0..episodes {
        let name = |index| envs.spaces(index).unwrap().building.name.clone();
        seen.push((0..envs.len()).map(name).collect());
        (0..96).for_each(|_| envs.step(&actions).unwrap());
    }
    seen
}

#[test]
fn the_buildings_of_an_environment_depend_on_the_seed_and_change_after_k_episodes() {
    let catalog = catalog();
    let make = || {
        let of = houses(&catalog, Population::of_split(HOUSE, Split::Train));
        let workers = WorkerOptions { template_memory: 0, preparations: 1, ..options(&catalog) };
        let options = VecEnvOptions { workers, autoreset: Autoreset::SameStep, widths: Some((2, 20)) };
        VecEnv::new(2, Box::new(Kept::new(of, 2)), options).unwrap()
    };
    let mut envs = make();
    let first = succession(&mut envs, 3, 4);
    for environment in 0..2 {
        let names: Vec<_> = first.iter().map(|names| &names[environment]).collect();
        assert!(names[0] == names[1] && names[1] != names[2] && names[2] == names[3]);
    }
    let statistics = envs.statistics();
    assert!(statistics.building_changes >= 4 && statistics.waits <= statistics.building_changes);
    // Each environment has the templates of its building and of the next.
    assert!(envs.workers().template_processes().len() <= 4);
    assert_eq!(first[..1], succession(&mut envs, 3, 1), "the same seed");
    assert_eq!(first[..3], succession(&mut make(), 3, 3), "in other processes");
    assert_ne!(first[..1], succession(&mut envs, 4, 1));
}

#[test]
fn concurrent_preparations_are_limited() {
    let catalog = catalog();
    let workers = Workers::new(WorkerOptions { preparations: 2, ..options(&catalog) }).unwrap();
    let settings = settings(&catalog, 20..24);
    std::thread::scope(|scope| {
        let prepared = scope.spawn(|| workers.prepare_all(&settings).unwrap().len());
        let mut largest = 0;
        while !prepared.is_finished() {
            largest = largest.max(workers.preparing_processes().len());
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        assert_eq!((prepared.join().unwrap(), largest), (4, 2));
    });
    assert_eq!(workers.template_processes().len(), 4);
}

#[test]
fn a_template_without_users_is_ended() {
    let catalog = catalog();
    let workers = WorkerOptions { template_memory: 0, ..options(&catalog) };
    let options = VecEnvOptions { workers, autoreset: Autoreset::SameStep, widths: None };
    let settings = settings(&catalog, 30..33);
    let mut order = (0..settings.len()).cycle();
    let sampler = move |_: usize, _: &mut ChaCha8Rng| {
        let setting = settings[order.next().unwrap_or(0)].clone();
        Ok(Draw { setting, steps: None })
    };
    let mut envs = VecEnv::new(1, Box::new(sampler), options).unwrap();
    envs.reset(0).unwrap();
    let actions = vec![0.1; envs.widths().0];
    let mut templates = Vec::new();
    for _ in 0..4 {
        (0..96).for_each(|_| envs.step(&actions).unwrap());
        templates.extend(envs.workers().template_processes());
        assert!(envs.workers().template_processes().len() <= 3);
    }
    let current = envs.workers().template_processes();
    assert!(templates.iter().filter(|process| !current.contains(process)).all(|process| !is_alive(*process)));
}

#[test]
fn types_are_drawn_by_weight_and_tasks_with_equal_probability() {
    let catalog = catalog();
    let of = |building_type| {
        let population = Population::of_split(building_type, Split::Train);
        Box::new(houses(&catalog, population)) as Box<dyn Sampler>
    };
    let types = Weighted::new(vec![(3.0, of(HOUSE)), (1.0, of(BuildingType::Warehouse))]).unwrap();
    let tasks = ["constant", "occupancy"].map(|task| task.parse().unwrap()).to_vec();
    let mut sampler = Windows { of: WithTask { of: types, tasks }, days: (1, 1), starts: 1 };
    let mut random = ChaCha8Rng::from_seed([7; 32]);
    let draws: Vec<_> = (0..200).map(|_| sampler.draw(0, &mut random).unwrap().setting).collect();
    let houses =
        draws.iter().filter(|setting| setting.source.name().starts_with("SingleFamilyHouse")).count();
    let constant = draws.iter().filter(|setting| setting.episode.task == Task::default()).count();
    assert!((130..170).contains(&houses) && (75..125).contains(&constant), "{houses} {constant}");
    let weights = |weight| Weighted::new(vec![(weight, of(HOUSE))]).map(|_| ()).unwrap_err().to_string();
    assert!(weights(-1.0).contains("-1") && weights(0.0).contains('0'));
}

#[test]
fn faults_are_kept_as_long_as_a_building() {
    let catalog = catalog();
    let mut faulty = houses(&catalog, Population::of_split(HOUSE, Split::Train));
    faulty.task = "constant+bias0.5".parse().unwrap();
    faulty.task.faults.seed = 40;
    let mut sampler = WithFaults::new(Kept::new(faulty, 3), 4, 3);
    let mut random = ChaCha8Rng::from_seed([7; 32]);
    let draws: Vec<_> = (0..300).map(|_| sampler.draw(0, &mut random).unwrap().setting).collect();
    let mut seeds = [0; 4];
    for kept in draws.chunks(3) {
        let seed = kept[0].episode.task.faults.seed;
        seeds[usize::try_from(seed - 41).unwrap()] += 1;
        let same = |each: &EpisodeSetting| {
            each.source.name() == kept[0].source.name() && each.episode.task.faults.seed == seed
        };
        assert!(kept.iter().all(same));
    }
    assert!(seeds.iter().all(|count| (10..40).contains(count)), "{seeds:?}");
}

#[test]
fn the_representatives_of_houses_have_every_number_of_zones() {
    let catalog = catalog();
    let workers = Workers::new(options(&catalog)).unwrap();
    let population = Population::of_split(HOUSE, Split::Train);
    let of = houses(&catalog, population.clone());
    let generated = Population::Generated {
        building_type: HOUSE,
        places: b2b_dataset::Places::All,
        settings: Vec::new(),
    };
    for population in [population, generated] {
        let representatives = population.representatives().unwrap();
        let setting =
            |(name, building): &(String, b2b_dataset::Building)| of.setting(name.clone(), building).unwrap();
        let settings: Vec<_> = representatives.iter().map(setting).collect();
        let spaces = workers.spaces(&settings).unwrap();
        let mut widths: Vec<_> = spaces.iter().map(|spaces| spaces.observation.len()).collect();
        widths.sort_unstable();
        assert_eq!(widths, [9, 10, 10, 11]);
    }
    // Already prepared, they need no process.
    let again = Workers::new(options(&catalog)).unwrap();
    let (name, building) = of.population.representatives().unwrap().remove(0);
    again.spaces(&[of.setting(name, &building).unwrap()]).unwrap();
    assert!(again.template_processes().is_empty());
}
