//! Templates that die, hang or fail, in every phase.

use std::time::{Duration, Instant};

use b2b_building::BuildingType;
use b2b_dataset::{BuildingName, Catalog, Placement};
use b2b_energyplus::install::{Engine, Quiet};
use b2b_env::{Environment, EpisodeConfig, Error, Task};
use b2b_workers::{
    Autoreset, Episode, EpisodeSetting, Launcher, Source, VecEnv, WorkerOptions, Workers, recv,
};
use rustix::process::Signal;

use crate::case::Case;
use crate::workers::{DAY, dice, kill, options, setting, shed, signal, started, steps, vec_env};

/// Sends a signal to the template while it prepares, `times` times, and waits for the preparation.
fn prepare_under_fire(
    workers: &Workers,
    setting: &EpisodeSetting,
    sent: Signal,
    times: usize,
) -> Result<(), Error> {
    std::thread::scope(|scope| {
        let archer = scope.spawn(|| {
            let mut hit = Vec::new();
            while hit.len() < times {
                for process in workers.template_processes() {
                    if !hit.contains(&process) {
                        std::thread::sleep(Duration::from_millis(50));
                        signal(process, sent);
                        hit.push(process);
                    }
                }
                std::thread::sleep(Duration::from_millis(5));
            }
        });
        let outcome = workers.prepare(setting).map(|_| ());
        archer.join().unwrap();
        outcome
    })
}

#[test]
fn a_template_killed_during_preparation_is_prepared_again() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let setting = setting(&case, DAY);
    prepare_under_fire(&workers, &setting, Signal::KILL, 1).unwrap();
    let mut episode = started(&workers, &setting);
    let mut dice = dice(&episode.spaces().action);
    steps(&mut episode, &mut dice, 5);
}

#[test]
fn a_template_killed_twice_while_it_prepares_is_an_error_without_side_effects() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let setting = setting(&case, DAY);
    let error = prepare_under_fire(&workers, &setting, Signal::KILL, 2).unwrap_err();
    assert!(matches!(error, Error::Lost { .. }));
    assert!(error.to_string().contains("SIGKILL"), "{error}");
    assert!(workers.template_processes().is_empty(), "the dead template is dropped");
    started(&workers, &setting);
}

#[test]
fn a_template_that_hangs_during_preparation_is_prepared_again() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let limit = WorkerOptions { preparation_time_limit: Duration::from_secs(20), ..options(&case) };
    let workers = Workers::new(limit).unwrap();
    let setting = setting(&case, DAY);
    let began = Instant::now();
    prepare_under_fire(&workers, &setting, Signal::STOP, 1).unwrap();
    assert!(began.elapsed() > Duration::from_secs(20));
    started(&workers, &setting);
}

#[test]
fn a_killed_template_is_replaced_and_its_episodes_continue() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let setting = setting(&case, DAY);
    let mut episode = started(&workers, &setting);
    let template = workers.template_processes()[0];
    kill(template);
    let other = started(&workers, &setting);
    assert_ne!(workers.template_processes()[0], template);
    assert_eq!(episode.observation(), other.observation());
    let mut dice = dice(&episode.spaces().action);
    steps(&mut episode, &mut dice, 5);
}

#[test]
fn a_stopped_template_is_replaced_after_the_time_limit() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let limit = WorkerOptions { step_time_limit: Duration::from_secs(2), ..options(&case) };
    let workers = Workers::new(limit).unwrap();
    let setting = setting(&case, DAY);
    workers.prepare(&setting).unwrap();
    let template = workers.template_processes()[0];
    signal(template, Signal::STOP);
    started(&workers, &setting);
    assert_ne!(workers.template_processes()[0], template);
}

#[test]
fn episodes_that_wait_for_a_killed_template_begin_from_the_next() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let setting = setting(&case, DAY);
    let mut episodes: Vec<Episode> = (0..6).map(|_| workers.episode(&setting).unwrap()).collect();
    for pause in [0, 1, 2, 4, 8] {
        episodes.iter_mut().for_each(|episode| episode.begin().unwrap());
        std::thread::sleep(Duration::from_millis(pause));
        kill(workers.template_processes()[0]);
        let mut ready = Vec::new();
        recv(&mut episodes, 6, &mut ready).unwrap();
        assert_eq!(ready, [0, 1, 2, 3, 4, 5]);
        assert!(episodes.iter().all(|episode| episode.lost().is_none()));
    }
}

#[test]
fn the_error_for_a_building_that_cannot_be_prepared_says_why() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let setting = EpisodeSetting::new(shed(&case), setting(&case, DAY).episode);
    let workers = Workers::new(options(&case)).unwrap();
    let error = workers.episode(&setting).unwrap_err().to_string();
    assert!(error.contains("Shed") && error.contains("no controllable system"), "{error}");
    let mut vec: VecEnv = vec_env(&case, vec![setting; 2], Autoreset::NextStep);
    assert!(vec.reset(0).unwrap_err().to_string().contains("no controllable system"));
}

#[test]
fn the_error_for_a_program_that_is_not_a_worker_names_it() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    for program in ["/no/such/program", "/bin/true"] {
        let other = WorkerOptions { launcher: Launcher::new(program), ..options(&case) };
        let error = Workers::new(other).unwrap().prepare(&setting(&case, DAY)).unwrap_err().to_string();
        assert!(error.contains(program), "{error}");
    }
}

#[test]
fn an_invalid_setting_is_rejected_before_a_process_starts() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let mut setting = setting(&case, DAY);
    setting.episode.steps_per_hour = 7;
    assert!(matches!(workers.prepare(&setting), Err(Error::StepsPerHour(7))));
    assert!(workers.template_processes().is_empty());
}

#[test]
fn every_task_has_its_own_template() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let first = setting(&case, DAY);
    let mut second = first.clone();
    second.episode.task = "constant:18".parse().unwrap();
    for (setting, templates) in [(&first, 1), (&first.clone(), 1), (&second, 2)] {
        workers.prepare(setting).unwrap();
        assert_eq!(workers.template_processes().len(), templates);
    }
}

#[test]
fn a_building_keeps_the_sizes_for_its_own_weather_in_another() {
    let catalog = Catalog::open(&mut Quiet).unwrap();
    let name = BuildingName::Type(BuildingType::SingleFamilyHouse);
    let found = catalog.find(&name, &Placement::default(), &mut Quiet).unwrap();
    let (weather, period) = (found.weather.clone(), DAY.parse().unwrap());
    let episode = EpisodeConfig { weather, period, steps_per_hour: 12, task: Task::default() };
    let own = EpisodeSetting::new(Source::from(found), episode);
    let models = Engine::ensure(&mut Quiet).unwrap().models.unwrap();
    let mut other = own.clone();
    other.episode.weather =
        models.parent().unwrap().join("weather/USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw");
    let launcher = Launcher::new(env!("CARGO_BIN_EXE_b2b-worker"));
    let options = WorkerOptions::new(launcher, catalog.library().path());
    // In separate processes, so that neither is prepared from the other.
    let [own, other] = [own, other].map(|setting| {
        let mut episode = started(&Workers::new(options.clone()).unwrap(), &setting);
        let building = std::sync::Arc::clone(&episode.spaces().building);
        (building, episode.reset().unwrap().to_vec())
    });
    assert!(own.0 == other.0, "it has other sizes");
    assert_ne!(own.1, other.1, "the weather is another");
}
