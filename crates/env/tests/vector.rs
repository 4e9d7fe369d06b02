//! Environments in processes of their own, on the real engine.
#![cfg(target_os = "linux")]

mod common;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use b2b_building::{BuildingType, Model, PreparedBuilding};
use b2b_dataset::{Catalog, Places, Split};
use b2b_env::vector::{
    AnyOf, Autoreset, Buildings, Fixed, Launcher, Live, Pool, PoolOptions, Population, Setting, Source,
    Start, VecEnv, VecEnvOptions, Windows,
};
use b2b_env::{ActionSpace, Env, Error};
use common::{Case, Dice};
use rustix::process::{Pid, Signal, kill_process};

const DAY: &str = "01-10..01-10";

fn options(case: &Case) -> PoolOptions {
    PoolOptions::new(Launcher::new(env!("CARGO_BIN_EXE_b2b-worker")), case.library.path())
}

fn setting(case: &Case, period: &str) -> Setting {
    Setting {
        source: Arc::new(Source::Prepared(Box::new((*case.building).clone()))),
        episode: case.env(period).episode().clone(),
    }
}

fn vec_env(case: &Case, settings: Vec<Setting>, autoreset: Autoreset) -> VecEnv {
    let options = VecEnvOptions { pool: options(case), autoreset, widths: None };
    VecEnv::new(settings.len(), Box::new(Fixed(settings)), options).unwrap()
}

/// An episode begun and standing.
fn standing(pool: &mut Pool, setting: &Setting) -> Live {
    let template = pool.prepare(setting).unwrap();
    let mut live = pool.begin(template, Start::default()).unwrap();
    pool.wait(std::slice::from_mut(&mut live), 1).unwrap();
    assert_eq!(live.lost(), None);
    live
}

fn dice(space: &ActionSpace) -> Dice {
    Dice::new(space, 1)
}

/// Observations and penalties of so many steps, or to the end.
fn steps(pool: &mut Pool, live: &mut Live, dice: &mut Dice, steps: usize) -> Vec<u64> {
    let mut trace = Vec::new();
    let mut observation = vec![0.0; live.spaces().observation.len()];
    for _ in 0..steps {
        pool.send(live, dice.roll()).unwrap();
        pool.wait(std::slice::from_mut(live), 1).unwrap();
        assert_eq!(live.lost(), None);
        pool.observation(live, &mut observation);
        let reward = pool.reward(live);
        let penalties = [reward.temperature_penalty, reward.energy_penalty];
        trace.extend(observation.iter().chain(&penalties).map(|value| value.to_bits()));
        if live.is_truncated() {
            break;
        }
    }
    trace
}

/// The same of an environment in this process, from its first step to its last.
fn fresh(env: &mut Env, dice: &mut Dice) -> Vec<u64> {
    let mut trace = Vec::new();
    env.reset().unwrap();
    loop {
        let step = env.step(dice.roll()).unwrap();
        let penalties = [step.reward.temperature_penalty, step.reward.energy_penalty];
        trace.extend(step.observation.iter().chain(&penalties).map(|value| value.to_bits()));
        if step.truncated {
            return trace;
        }
    }
}

fn signal(process: u32, signal: Signal) {
    kill_process(Pid::from_raw(process as i32).unwrap(), signal).unwrap();
}

/// Whether a process is there, and no zombie.
fn is_alive(process: u32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    stat.rsplit(')').next().is_some_and(|rest| !rest.is_empty() && !rest.starts_with(" Z"))
}

fn copies_continue_bit_for_bit(building_type: BuildingType) {
    let period = "01-10..01-12";
    let case = Case::at_home(building_type);
    let mut env = case.env(period);
    let mut same = dice(env.action_space());
    let expected = fresh(&mut env, &mut same);
    let row = env.observation_space().len() + 2;

    let mut pool = Pool::new(options(&case)).unwrap();
    let mut live = standing(&mut pool, &setting(&case, period));
    let mut first = dice(env.action_space());
    let mut trace = steps(&mut pool, &mut live, &mut first, 400);
    let mut snapshot = pool.snapshot(&live).unwrap();
    pool.wait(std::slice::from_mut(&mut snapshot), 1).unwrap();
    trace.extend(steps(&mut pool, &mut live, &mut first, usize::MAX));
    assert!(trace == expected, "an episode copied from a template differs");
    assert_eq!(pool.metrics(&live).unwrap(), *env.metrics());

    let mut branches = pool.branch(&snapshot, 2).unwrap();
    pool.wait(&mut branches, 2).unwrap();
    for live in &mut branches {
        let mut dice = dice(env.action_space());
        (0..400).for_each(|_| _ = dice.roll());
        let rest = steps(&mut pool, live, &mut dice, usize::MAX);
        assert!(rest == expected[400 * row..], "an episode that goes on from a snapshot differs");
    }
}

#[test]
fn copies_of_the_house_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::SingleFamilyHouse);
}

#[test]
fn copies_of_the_small_office_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::OfficeSmall);
}

#[test]
fn copies_of_the_medium_office_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::OfficeMedium);
}

#[test]
fn copies_of_the_shop_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::RetailStandalone);
}

#[test]
fn copies_of_the_restaurant_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::RestaurantFastFood);
}

#[test]
fn copies_of_the_warehouse_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::Warehouse);
}

/// The rows of actions of a batch, from a stream of dice for each environment.
fn roll(vec: &VecEnv, dice: &mut [Dice]) -> Vec<f64> {
    let width = vec.widths().0;
    let mut actions = vec![0.0; width * vec.len()];
    for (row, dice) in actions.chunks_exact_mut(width).zip(dice) {
        let action = dice.roll();
        row[..action.len()].copy_from_slice(action);
    }
    actions
}

#[test]
fn the_next_episode_begins_with_the_step_after_the_last_and_is_the_same_bit_for_bit() {
    const DAYS: &str = "01-10..01-11";
    let cases = BuildingType::ALL.map(Case::at_home);
    let mut envs = cases.each_ref().map(|case| case.env(DAYS));
    let expected = envs.each_mut().map(|env| fresh(env, &mut dice(&env.action_space().clone())));
    let settings = cases.iter().map(|case| setting(case, DAYS)).collect();
    let mut vec = vec_env(&cases[0], settings, Autoreset::NextStep);
    vec.reset(0).unwrap();
    let width = vec.widths().1;
    for episode in 0..2 {
        if episode > 0 {
            vec.step(&vec![f64::NAN; vec.widths().0 * vec.len()]).unwrap();
            assert_eq!(vec.truncated(), [false; 6]);
        }
        let mut dice: Vec<Dice> = envs.iter().map(|env| dice(env.action_space())).collect();
        let mut traces = envs.each_ref().map(|_| Vec::new());
        for _ in 0..576 {
            let actions = roll(&vec, &mut dice);
            vec.step(&actions).unwrap();
            for (index, (env, trace)) in envs.iter().zip(&mut traces).enumerate() {
                let row = &vec.observations()[index * width..][..width];
                let (observation, padding) = row.split_at(env.observation_space().len());
                assert!(padding.iter().all(|value| *value == 0.0));
                let reward = vec.rewards()[index];
                let penalties = [reward.temperature_penalty, reward.energy_penalty];
                trace.extend(observation.iter().chain(&penalties).map(|value| value.to_bits()));
            }
        }
        assert_eq!(vec.truncated(), [true; 6]);
        for (index, env) in envs.iter().enumerate() {
            assert!(traces[index] == expected[index], "{:?} in episode {episode}", BuildingType::ALL[index]);
            assert_eq!(vec.final_metrics(index), Some(env.metrics()));
        }
    }
}

#[test]
fn the_next_episode_may_begin_within_the_last_step() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut vec = vec_env(&case, vec![setting(&case, DAY)], Autoreset::SameStep);
    vec.reset(0).unwrap();
    let first = vec.observations().to_vec();
    let mut dice = [dice(&vec.spaces(0).unwrap().action)];
    for _ in 0..288 {
        let actions = roll(&vec, &mut dice);
        vec.step(&actions).unwrap();
    }
    assert_eq!(vec.truncated(), [true]);
    assert_eq!(vec.observations(), first);
    assert_ne!(vec.final_observation(0), first);
    assert_eq!(vec.final_metrics(0).unwrap().steps, 288);
    let actions = roll(&vec, &mut dice);
    vec.step(&actions).unwrap();
    assert_eq!(vec.truncated(), [false]);
}

/// What 200 steps of mixed buildings in random windows come to.
fn mixed(seed: u64) -> Vec<u64> {
    let cases = [BuildingType::SingleFamilyHouse, BuildingType::RestaurantFastFood].map(Case::at_home);
    let settings = cases.iter().map(|case| setting(case, "01-10..01-20")).collect();
    let sampler = Windows { of: AnyOf(settings), days: (1, 2), starts: 2 };
    let options =
        VecEnvOptions { pool: options(&cases[0]), autoreset: Autoreset::NextStep, widths: Some((8, 16)) };
    let mut vec = VecEnv::new(3, Box::new(sampler), options).unwrap();
    vec.reset(seed).unwrap();
    let mut trace: Vec<u64> = Vec::new();
    for _ in 0..700 {
        let middle = |index| {
            let space = &vec.spaces(index).unwrap().action;
            let mut row: Vec<f64> =
                space.low().iter().zip(space.high()).map(|(l, h)| 0.5 * (l + h)).collect();
            row.resize(8, 0.0);
            row
        };
        let actions: Vec<f64> = (0..3).flat_map(middle).collect();
        vec.step(&actions).unwrap();
        trace.extend(vec.observations().iter().map(|value| value.to_bits()));
    }
    trace
}

#[test]
fn what_is_drawn_depends_on_the_seed_alone() {
    let first = mixed(3);
    assert!(first == mixed(3));
    assert!(first != mixed(4));
}

#[test]
fn the_first_that_are_ready_are_received_while_another_stands_still() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut vec = vec_env(&case, vec![setting(&case, DAY); 3], Autoreset::NextStep);
    vec.reset(0).unwrap();
    let action = vec.spaces(0).unwrap().action.low().to_vec();
    signal(vec.process(1).unwrap(), Signal::STOP);
    (0..3).for_each(|index| vec.send(index, &action).unwrap());
    let mut back = Vec::new();
    vec.recv(2, &mut back).unwrap();
    assert_eq!(back, [0, 2]);
    assert!(vec.send(1, &action).unwrap_err().to_string().contains("busy"));
    signal(vec.process(1).unwrap(), Signal::CONT);
    vec.recv(1, &mut back).unwrap();
    assert_eq!(back, [1]);
}

#[test]
fn an_action_that_is_no_number_is_refused_before_any_environment_moves() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut vec = vec_env(&case, vec![setting(&case, DAY); 2], Autoreset::NextStep);
    vec.reset(0).unwrap();
    let width = vec.widths().0;
    let mut actions = [vec.spaces(0).unwrap().action.low(), vec.spaces(1).unwrap().action.low()].concat();
    actions[width] = f64::NAN;
    assert!(matches!(vec.step(&actions), Err(Error::ActionNotFinite { .. })));
    assert!(matches!(vec.step(&actions[1..]), Err(Error::ActionLength { .. })));
    actions[width] = 0.0;
    vec.step(&actions).unwrap();
}

/// Kills the first of two in mid-step; the other goes on, and the first begins anew.
fn a_lost_episode_is_reported(what: impl Fn(u32), time_out: Duration, why: &str) {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let pool = PoolOptions { time_out, ..options(&case) };
    let options = VecEnvOptions { pool, autoreset: Autoreset::NextStep, widths: None };
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
    vec.step(&[action.clone(), action].concat()).unwrap();
    assert_eq!((vec.lost(0), vec.truncated()), (None, &[false, false][..]));
    let width = vec.widths().1;
    assert_eq!(vec.observations()[..width], before[..width], "it does not begin anew");
}

#[test]
fn a_worker_killed_in_mid_step_costs_its_episode_alone() {
    a_lost_episode_is_reported(|process| signal(process, Signal::KILL), Duration::from_secs(30), "killed");
}

#[test]
fn a_worker_that_hangs_costs_its_episode_alone() {
    a_lost_episode_is_reported(|_| {}, Duration::from_millis(300), "took longer than 300ms");
}

#[test]
fn a_template_that_is_killed_is_made_again() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut pool = Pool::new(options(&case)).unwrap();
    let setting = setting(&case, DAY);
    let mut live = standing(&mut pool, &setting);
    let template = pool.template_processes()[0];
    signal(template, Signal::KILL);
    while is_alive(template) {
        std::thread::sleep(Duration::from_millis(1));
    }
    let other = standing(&mut pool, &setting);
    assert_ne!(pool.template_processes()[0], template);
    let (mut first, mut second) = (vec![0.0; 11], vec![0.0; 11]);
    let width = live.spaces().observation.len();
    pool.observation(&live, &mut first[..width]);
    pool.observation(&other, &mut second[..width]);
    assert_eq!(first, second);
    let mut dice = dice(&live.spaces().action.clone());
    steps(&mut pool, &mut live, &mut dice, 5);
}

#[test]
fn an_engine_that_stops_says_why() {
    let case = Case::at_home(BuildingType::OfficeMedium);
    // A heating setpoint above the cooling setpoint ends the engine's run.
    let text = serde_json::to_string(&*case.building).unwrap().replace("\"high\":30.0", "\"high\":95.0");
    let building: PreparedBuilding = serde_json::from_str(&text).unwrap();
    let setting = Setting { source: Arc::new(Source::Prepared(building.into())), ..setting(&case, DAY) };
    let mut pool = Pool::new(options(&case)).unwrap();
    let mut live = standing(&mut pool, &setting);
    let highest = live.spaces().action.high().to_vec();
    for _ in 0..2 {
        if pool.send(&mut live, &highest).is_ok() {
            pool.wait(std::slice::from_mut(&mut live), 1).unwrap();
        }
    }
    assert!(live.lost().unwrap().contains("DualSetPointWithDeadBand"), "{:?}", live.lost());
}

#[test]
fn a_building_that_cannot_be_prepared_says_why() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let model = Model::from_epjson(r#"{"Zone": {"Z": {}}}"#, Path::new("empty.epJSON")).unwrap();
    let source =
        Source::Model { name: "Shed".into(), class: None, prototype: false, own: false, model: model.into() };
    let setting = Setting { source: Arc::new(source), ..setting(&case, DAY) };
    let mut pool = Pool::new(options(&case)).unwrap();
    let template = pool.prepare(&setting).unwrap();
    let error = pool.begin(template, Start::default()).unwrap_err().to_string();
    assert!(error.contains("Shed") && error.contains("no controllable system"), "{error}");
    let mut vec = vec_env(&case, vec![setting], Autoreset::NextStep);
    assert!(vec.reset(0).unwrap_err().to_string().contains("no controllable system"));
}

#[test]
fn a_program_that_is_no_worker_is_named() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let missing = PoolOptions { launcher: Launcher::new("/no/such/program"), ..options(&case) };
    let error = Pool::new(missing).unwrap().prepare(&setting(&case, DAY)).unwrap_err().to_string();
    assert!(error.contains("/no/such/program"), "{error}");
    let other = PoolOptions { launcher: Launcher::new("/bin/true"), ..options(&case) };
    let mut pool = Pool::new(other).unwrap();
    let template = pool.prepare(&setting(&case, DAY)).unwrap();
    assert!(pool.spaces(template).unwrap_err().to_string().contains("/bin/true"));
}

/// Has the kernel refuse a system call with an error to this thread and to what it starts from now on.
fn refuse(call: libc::c_long, when_first_argument_lacks: u32, error: libc::c_int) {
    let load = (libc::BPF_LD | libc::BPF_W | libc::BPF_ABS) as u16;
    let equal = (libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K) as u16;
    let has = (libc::BPF_JMP | libc::BPF_JSET | libc::BPF_K) as u16;
    let end = (libc::BPF_RET | libc::BPF_K) as u16;
    let line = |code, jt, jf, k| libc::sock_filter { code, jt, jf, k };
    let mut filter = [
        line(load, 0, 0, 0),
        line(equal, 0, 2, call as u32),
        line(load, 0, 0, 16),
        line(has, 0, 1, when_first_argument_lacks),
        line(end, 0, 0, libc::SECCOMP_RET_ALLOW),
        line(end, 0, 0, libc::SECCOMP_RET_ERRNO | error as u32),
    ];
    // Another system call jumps over the last two lines but one.
    filter[1].jf = 2;
    let program = libc::sock_fprog { len: filter.len() as u16, filter: filter.as_mut_ptr() };
    // SAFETY: the program is well formed and outlives the calls.
    unsafe {
        assert_eq!(libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), 0);
        assert_eq!(libc::prctl(libc::PR_SET_SECCOMP, libc::SECCOMP_MODE_FILTER, &program), 0);
    }
}

#[test]
fn a_refused_fork_is_reported() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    std::thread::spawn(move || {
        refuse(libc::SYS_clone, libc::CLONE_VM as u32, libc::EAGAIN);
        let mut pool = Pool::new(options(&case)).unwrap();
        let template = pool.prepare(&setting(&case, DAY)).unwrap();
        let mut live = pool.begin(template, Start::default()).unwrap();
        pool.wait(std::slice::from_mut(&mut live), 1).unwrap();
        let why = live.lost().unwrap();
        assert!(why.contains("cannot be copied") && why.contains("temporarily unavailable"), "{why}");
    })
    .join()
    .unwrap();
}

#[test]
fn shared_memory_that_is_full_is_reported() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    std::thread::spawn(move || {
        refuse(libc::SYS_fallocate, 0, libc::ENOSPC);
        let error = Pool::new(options(&case)).unwrap_err().to_string();
        assert!(error.contains("memory to share") && error.contains("No space left"), "{error}");
    })
    .join()
    .unwrap();
}

/// Not a test: an owner of processes that tells which, and waits to be killed.
#[test]
#[ignore = "started by the test below"]
fn an_owner_to_be_killed() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut vec = vec_env(&case, vec![setting(&case, DAY); 2], Autoreset::NextStep);
    vec.reset(0).unwrap();
    let workers = (0..2).map(|index| vec.process(index).unwrap());
    for process in workers.chain(vec.pool().template_processes()) {
        println!("process {process}");
    }
    println!("folder {}", vec.pool().folder().display());
    std::thread::sleep(Duration::from_secs(60));
}

#[test]
fn when_the_owner_is_killed_its_processes_and_its_folder_go_within_two_seconds() {
    let mut owner = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "an_owner_to_be_killed", "--ignored", "--nocapture"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut processes, mut folder) = (Vec::new(), String::new());
    for line in BufReader::new(owner.stdout.take().unwrap()).lines() {
        let line = line.unwrap();
        if let Some(process) = line.strip_prefix("process ") {
            processes.push(process.parse().unwrap());
        }
        if let Some(path) = line.strip_prefix("folder ") {
            folder = path.to_owned();
            break;
        }
    }
    assert_eq!(processes.len(), 3);
    assert!(processes.iter().all(|process| is_alive(*process)) && Path::new(&folder).exists());
    owner.kill().unwrap();
    owner.wait().unwrap();
    let killed = Instant::now();
    while processes.iter().any(|process| is_alive(*process)) || Path::new(&folder).exists() {
        assert!(killed.elapsed() < Duration::from_secs(2), "something is left");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn nothing_is_left_behind() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let sampler = Windows { of: AnyOf(vec![setting(&case, "01-10..01-12")]), days: (1, 1), starts: 3 };
    let options = VecEnvOptions { pool: options(&case), autoreset: Autoreset::NextStep, widths: None };
    let mut vec = VecEnv::new(2, Box::new(sampler), options).unwrap();
    vec.reset(0).unwrap();
    let action = vec.spaces(0).unwrap().action.low().to_vec();
    let actions = [action.clone(), action].concat();
    let mut processes: Vec<u32> = Vec::new();
    for _ in 0..4 {
        (0..2).for_each(|index| processes.push(vec.process(index).unwrap()));
        (0..289).for_each(|_| vec.step(&actions).unwrap());
    }
    processes.extend(vec.pool().template_processes());
    let folder = vec.pool().folder().to_owned();
    assert!(folder.exists());
    drop(vec);
    assert!(!folder.exists());
    assert!(processes.iter().all(|process| !is_alive(*process)));
}

#[test]
fn a_task_is_part_of_what_a_template_is_of() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut pool = Pool::new(options(&case)).unwrap();
    let first = setting(&case, DAY);
    let mut second = first.clone();
    second.episode.task = "constant:18".parse().unwrap();
    let [one, same, other] = [&first, &first.clone(), &second].map(|setting| pool.prepare(setting).unwrap());
    assert_eq!(one, same);
    assert_ne!(one, other);
}

/// Names of the buildings that come one after another in each of two environments, and the first observation of each.
fn drawn(population: Population, seed: u64) -> Vec<(String, Vec<u64>)> {
    let catalog = Arc::new(Catalog::open(&mut b2b_energyplus::install::Quiet).unwrap());
    let options = PoolOptions::new(Launcher::new(env!("CARGO_BIN_EXE_b2b-worker")), catalog.library().path());
    let sampler = Buildings {
        catalog,
        population,
        period: DAY.parse().unwrap(),
        steps_per_hour: 12,
        task: b2b_env::Task::default(),
    };
    let sampler = Windows { of: sampler, days: (1, 1), starts: 1 };
    let options = VecEnvOptions { pool: options, autoreset: Autoreset::SameStep, widths: Some((2, 20)) };
    let mut vec = VecEnv::new(2, Box::new(sampler), options).unwrap();
    vec.reset(seed).unwrap();
    let mut seen = Vec::new();
    for step in 0..=288 {
        if step % 288 == 0 {
            for environment in 0..2 {
                assert_eq!(vec.lost(environment), None);
                let spaces = vec.spaces(environment).unwrap();
                let row = &vec.observations()[environment * 20..][..spaces.observation.len()];
                seen.push((spaces.building.name.clone(), row.iter().map(|value| value.to_bits()).collect()));
            }
        }
        if step < 288 {
            vec.step(&[0.1, 25.0, 0.1, 25.0]).unwrap();
        }
    }
    seen
}

#[test]
fn buildings_are_drawn_anew_from_a_split_or_from_the_generator() {
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
