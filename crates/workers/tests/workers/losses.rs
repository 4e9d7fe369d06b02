//! Workers that die, hang or fail.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use b2b_building::{BuildingType, PreparedBuilding};
use b2b_env::{Environment, Error};
use b2b_workers::{
    Autoreset, Draw, EpisodeSetting, Fixed, Source, VecEnv, VecEnvOptions, WorkerOptions, Workers,
};
use rand_chacha::ChaCha8Rng;
use rustix::process::Signal;

use crate::case::Case;
use crate::workers::{DAY, kill, options, setting, shed, signal, started};

/// Stops the first of two during a step: the other is not affected, and the first restarts.
fn a_lost_episode_is_reported(what: impl Fn(u32), limit: Duration, why: &str) {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = WorkerOptions { step_time_limit: limit, ..options(&case) };
    let options = VecEnvOptions { workers, autoreset: Autoreset::NextStep, widths: None };
    let settings = vec![setting(&case, DAY); 2];
    let mut vec = VecEnv::new(2, Box::new(Fixed(settings)), options).unwrap();
    vec.reset(0).unwrap();
    let action = vec.spaces(0).unwrap().action.low().to_vec();
    let before = vec.observations().to_vec();
    signal(vec.process(0).unwrap(), Signal::STOP);
    (0..2).for_each(|index| vec.send(index, &action).unwrap());
    what(vec.process(0).unwrap());
    let mut back = Vec::new();
    vec.recv(2, &mut back).unwrap();
    assert_eq!(vec.truncated(), [true, false]);
    assert!(vec.lost(0).unwrap().contains(why), "{:?}", vec.lost(0));
    assert_eq!((vec.lost(1), vec.final_metrics(0)), (None, None));
    let width = vec.widths().1;
    assert_eq!(vec.final_observation(0), &before[..width], "where it was last seen");
    vec.step(&[action.clone(), action].concat()).unwrap();
    assert_eq!((vec.lost(0), vec.truncated()), (None, &[false, false][..]));
    assert_eq!(vec.observations()[..width], before[..width], "it does not begin anew");
}

#[test]
fn a_worker_killed_in_mid_step_costs_only_its_episode() {
    a_lost_episode_is_reported(
        |process| signal(process, Signal::KILL),
        Duration::from_secs(30),
        "signal: 9 (SIGKILL)",
    );
}

#[test]
fn a_worker_that_hangs_costs_only_its_episode() {
    a_lost_episode_is_reported(|_| {}, Duration::from_millis(300), "took longer than 300ms");
}

#[test]
fn the_next_draw_survives_a_lost_episode() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let (setting, draws) = (setting(&case, DAY), Arc::new(AtomicUsize::new(0)));
    let counted = Arc::clone(&draws);
    let sampler = move |_: usize, _: &mut ChaCha8Rng| {
        counted.fetch_add(1, Ordering::Relaxed);
        Ok(Draw { setting: setting.clone(), steps: None })
    };
    let options = VecEnvOptions { workers: options(&case), autoreset: Autoreset::NextStep, widths: None };
    let mut vec = VecEnv::new(1, Box::new(sampler), options).unwrap();
    vec.reset(0).unwrap();
    assert_eq!(draws.load(Ordering::Relaxed), 2, "this episode and the next");
    let action = vec.spaces(0).unwrap().action.low().to_vec();
    kill(vec.process(0).unwrap());
    vec.step(&action).unwrap();
    assert!(vec.lost(0).is_some());
    vec.step(&action).unwrap();
    assert_eq!((vec.lost(0), draws.load(Ordering::Relaxed)), (None, 3));
}

#[test]
fn an_episode_keeps_its_end_if_the_next_is_lost_within_the_same_step() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let shed = EpisodeSetting::new(shed(&case), setting(&case, DAY).episode);
    let mut settings = vec![setting(&case, DAY)].into_iter();
    let sampler = move |_: usize, _: &mut ChaCha8Rng| {
        Ok(Draw { setting: settings.next().unwrap_or_else(|| shed.clone()), steps: None })
    };
    let options = VecEnvOptions { workers: options(&case), autoreset: Autoreset::SameStep, widths: None };
    let mut vec = VecEnv::new(1, Box::new(sampler), options).unwrap();
    vec.reset(0).unwrap();
    let action = vec.spaces(0).unwrap().action.low().to_vec();
    (0..288).for_each(|_| vec.step(&action).unwrap());
    assert!(vec.lost(0).unwrap().contains("no controllable system"), "{:?}", vec.lost(0));
    assert_eq!(vec.final_metrics(0).unwrap().steps, 288);
    assert_eq!((vec.truncated(), vec.final_observation(0)), (&[true][..], vec.observations()));
    // The next episode is lost without an end.
    vec.step(&action).unwrap();
    assert!(vec.lost(0).is_some() && vec.final_metrics(0).is_none());
}

#[test]
fn a_stopped_engine_reports_the_reason() {
    let case = Case::at_home(BuildingType::OfficeMedium);
    // A heating setpoint above the cooling setpoint ends the engine's run.
    let text = serde_json::to_string(&*case.building).unwrap().replace("\"high\":30.0", "\"high\":95.0");
    let building: PreparedBuilding = serde_json::from_str(&text).unwrap();
    let setting = EpisodeSetting::new(Source::Prepared(building.into()), setting(&case, DAY).episode);
    let workers = Workers::new(options(&case)).unwrap();
    let mut episode = started(&workers, &setting);
    let highest = episode.spaces().action.high().to_vec();
    let outcome = (0..2).find_map(|_| episode.step(&highest).err());
    let why = outcome.unwrap().to_string();
    assert!(why.contains("DualSetPointWithDeadBand"), "{why}");
    assert!(episode.lost().is_some());
}

#[test]
fn the_error_for_a_crash_has_the_signal_and_the_last_output() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let mut episode = started(&workers, &setting(&case, DAY));
    let process = episode.process().unwrap();
    let log = std::fs::read_dir(workers.folder()).unwrap().map(|entry| entry.unwrap().path());
    let newest = log.filter(|path| path.extension().is_some_and(|extension| extension == "log"));
    let newest = newest.max_by_key(|path| path.metadata().unwrap().modified().unwrap()).unwrap();
    std::fs::write(newest, "free(): invalid pointer\n").unwrap();
    // A sent SIGSEGV would be ignored once, because Rust's handler waits for a second fault.
    signal(process, Signal::ABORT);
    let action = episode.spaces().action.low().to_vec();
    let error = episode.step(&action).unwrap_err();
    let text = error.to_string();
    assert!(matches!(error, Error::Lost { .. }));
    assert!(text.contains("SIGABRT") && text.contains("free(): invalid pointer"), "{text}");
    assert!(text.contains(&process.to_string()), "{text}");
    episode.reset().unwrap();
    episode.step(&action).unwrap();
}

#[test]
fn a_stopped_worker_counts_as_hung_and_is_killed() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let limit = WorkerOptions { step_time_limit: Duration::from_millis(300), ..options(&case) };
    let workers = Workers::new(limit).unwrap();
    let mut episode = started(&workers, &setting(&case, DAY));
    let process = episode.process().unwrap();
    signal(process, Signal::STOP);
    let action = episode.spaces().action.low().to_vec();
    let text = episode.step(&action).unwrap_err().to_string();
    assert!(text.contains("took longer than 300ms"), "{text}");
    let killed = std::time::Instant::now();
    while crate::workers::is_alive(process) {
        assert!(killed.elapsed() < Duration::from_secs(1), "it is still there");
    }
}

#[test]
fn the_error_for_a_copy_of_a_dead_episode_says_why() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let episode = started(&workers, &setting(&case, DAY));
    kill(episode.process().unwrap());
    let text = episode.branch(3).unwrap_err().to_string();
    assert!(text.contains("SIGKILL"), "{text}");
}
