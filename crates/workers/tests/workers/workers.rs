//! Settings and workers of the tests.

use std::path::Path;

use b2b_building::{Controls, Model};
use b2b_env::{ActionSpace, Environment};
use b2b_workers::{
    Autoreset, Episode, EpisodeSetting, Fixed, Launcher, Source, VecEnv, VecEnvOptions, WorkerOptions,
    Workers,
};
use rustix::process::{Pid, Signal, kill_process};

use crate::case::{Case, Dice};

pub const DAY: &str = "01-10..01-10";

pub fn options(case: &Case) -> WorkerOptions {
    WorkerOptions::new(Launcher::new(env!("CARGO_BIN_EXE_b2b-worker")), case.library.path())
}

pub fn setting(case: &Case, period: &str) -> EpisodeSetting {
    let source = Source::Prepared(Box::new((*case.building).clone()));
    EpisodeSetting::new(source, case.env(period).episode().clone())
}

/// A model without a controllable system, which cannot be prepared.
pub fn shed(case: &Case) -> Source {
    let model = Model::from_epjson(r#"{"Zone": {"Z": {}}}"#, Path::new("empty.epJSON")).unwrap();
    let (name, weather) = ("Shed".into(), case.weather.clone());
    Source::Model {
        name,
        class: None,
        prototype: false,
        own: false,
        controls: Controls::default(),
        model: model.into(),
        weather,
    }
}

pub fn vec_env(case: &Case, settings: Vec<EpisodeSetting>, autoreset: Autoreset) -> VecEnv {
    let options = VecEnvOptions { workers: options(case), autoreset, widths: None };
    VecEnv::new(settings.len(), Box::new(Fixed(settings)), options).unwrap()
}

/// An episode after its reset.
pub fn started(workers: &Workers, setting: &EpisodeSetting) -> Episode {
    let mut episode = workers.episode(setting).unwrap();
    episode.reset().unwrap();
    episode
}

pub fn dice(space: &ActionSpace) -> Dice {
    Dice::new(space, 1)
}

/// Observations and penalties of `steps` steps, or to the end.
pub fn steps(environment: &mut dyn Environment, dice: &mut Dice, steps: usize) -> Vec<u64> {
    let mut trace = Vec::new();
    for _ in 0..steps {
        let step = environment.step(dice.roll()).unwrap();
        let penalties = [step.reward.temperature_penalty, step.reward.energy_penalty];
        trace.extend(step.observation.iter().chain(&penalties).map(|value| value.to_bits()));
        if step.truncated {
            break;
        }
    }
    trace
}

/// A whole episode from its reset.
pub fn whole(environment: &mut dyn Environment, dice: &mut Dice) -> Vec<u64> {
    environment.reset().unwrap();
    steps(environment, dice, usize::MAX)
}

pub fn signal(process: u32, signal: Signal) {
    kill_process(Pid::from_raw(process as i32).unwrap(), signal).unwrap();
}

/// Kills a process and waits until it has ended.
pub fn kill(process: u32) {
    signal(process, Signal::KILL);
    while is_alive(process) {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

/// Returns whether a process exists and is not a zombie.
pub fn is_alive(process: u32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    stat.rsplit(')').next().is_some_and(|rest| !rest.is_empty() && !rest.starts_with(" Z"))
}
