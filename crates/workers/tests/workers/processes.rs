//! System resources that a set of workers needs, and files and processes that it leaves.

#![allow(unsafe_code, reason = "`fork`")]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use b2b_building::BuildingType;
use b2b_energyplus::Confinement;
use b2b_env::Environment;
use b2b_workers::{AnyOf, Autoreset, VecEnv, VecEnvOptions, Windows, WorkerOptions, Workers};
use rustix::process::{Pid, Resource, Rlimit, Signal};

use crate::case::Case;
use crate::workers::{DAY, dice, is_alive, options, setting, signal, started, steps, vec_env};

/// Makes the kernel refuse a system call for this thread and its future children.
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
    // Other system calls skip the two lines before the last.
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
        let workers = Workers::new(options(&case)).unwrap();
        let why = workers.episode(&setting(&case, DAY)).unwrap().reset().unwrap_err().to_string();
        assert!(why.contains("cannot copy") && why.contains("temporarily unavailable"), "{why}");
    })
    .join()
    .unwrap();
}

#[test]
fn a_refused_copy_of_an_episode_is_reported_and_the_episode_continues() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let mut episode = started(&workers, &setting(&case, DAY));
    let process = Pid::from_raw(episode.process().unwrap() as i32);
    // It cannot open another file, as every copy must.
    let none = Rlimit { current: Some(0), maximum: Some(0) };
    rustix::process::prlimit(process, Resource::Nofile, none).unwrap();
    for error in [episode.branch(2).map(drop), episode.snapshot().map(drop)] {
        let why = error.unwrap_err().to_string();
        assert!(why.contains("cannot copy") && why.contains("open files"), "{why}");
    }
    let action = episode.spaces().action.low().to_vec();
    episode.step(&action).unwrap();
}

#[test]
fn a_worker_without_a_handle_is_not_dead() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let mut episode = workers.episode(&setting(&case, DAY)).unwrap();
    let episode = std::thread::spawn(move || {
        refuse(libc::SYS_pidfd_open, 0, libc::EMFILE);
        episode.reset().unwrap();
        let process = episode.process().unwrap();
        signal(process, Signal::STOP);
        // It is checked while it is busy.
        let waker = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(300));
            signal(process, Signal::CONT);
        });
        let action = episode.spaces().action.low().to_vec();
        episode.step(&action).unwrap();
        waker.join().unwrap();
        episode
    });
    let episode = episode.join().unwrap();
    let process = episode.process().unwrap();
    drop((episode, workers));
    assert!(!is_alive(process), "its handle was opened in the end");
}

#[test]
fn a_refused_preparation_releases_its_slot_once() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let (refused, its_setting) = (workers.clone(), setting(&case, DAY));
    std::thread::spawn(move || {
        refuse(libc::SYS_pidfd_open, 0, libc::EMFILE);
        let error = refused.prepare(&its_setting).unwrap_err().to_string();
        assert!(error.contains("a handle of a process"), "{error}");
    })
    .join()
    .unwrap();
    let mut episodes = [(); 3].map(|()| started(&workers, &setting(&case, DAY)));
    let mut processes = workers.template_processes();
    processes.extend(episodes.iter().map(|episode| episode.process().unwrap()));
    processes.sort_unstable();
    processes.dedup();
    assert_eq!(processes.len(), 4);
    let action = episodes[0].spaces().action.low().to_vec();
    for episode in &mut episodes {
        episode.step(&action).unwrap();
    }
}

#[test]
fn full_shared_memory_is_reported() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    std::thread::spawn(move || {
        refuse(libc::SYS_fallocate, 0, libc::ENOSPC);
        let error = Workers::new(options(&case)).unwrap_err().to_string();
        assert!(error.contains("memory to share") && error.contains("No space left"), "{error}");
    })
    .join()
    .unwrap();
}

/// Not a test: an owner that prints its processes and waits to be killed.
#[test]
#[ignore = "started by the test below"]
fn an_owner_to_be_killed() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let mut vec = vec_env(&case, vec![setting(&case, DAY); 2], Autoreset::NextStep);
    vec.reset(0).unwrap();
    let workers = (0..2).map(|index| vec.process(index).unwrap());
    for process in workers.chain(vec.workers().template_processes()) {
        println!("process {process}");
    }
    println!("folder {}", vec.workers().folder().display());
    std::thread::sleep(Duration::from_secs(60));
}

#[test]
fn processes_and_folder_of_a_killed_owner_are_removed_within_two_seconds() {
    let mut owner = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "processes::an_owner_to_be_killed", "--ignored", "--nocapture"])
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

/// Not a test: an owner with a short time limit that prints the stopped process for which it waits, first for a copy
/// and then for a step.
#[test]
#[ignore = "started by the test below"]
fn an_owner_to_be_stopped() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let limit = WorkerOptions { step_time_limit: Duration::from_secs(2), ..options(&case) };
    let workers = Workers::new(limit).unwrap();
    let mut episode = workers.episode(&setting(&case, DAY)).unwrap();
    let stop = |process: u32| {
        signal(process, Signal::STOP);
        println!("waits for {process}");
    };
    stop(workers.template_processes()[0]);
    episode.reset().unwrap();
    stop(episode.process().unwrap());
    let mut dice = dice(&episode.spaces().action);
    steps(&mut episode, &mut dice, usize::MAX);
    println!("the end");
}

#[test]
fn an_owner_that_was_stopped_for_longer_than_the_limit_continues_its_episodes() {
    let mut owner = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "processes::an_owner_to_be_stopped", "--ignored", "--nocapture"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = Vec::new();
    for line in BufReader::new(owner.stdout.take().unwrap()).lines() {
        let line = line.unwrap();
        if let Some((_, process)) = line.split_once("waits for ") {
            std::thread::sleep(Duration::from_millis(300));
            signal(owner.id(), Signal::STOP);
            std::thread::sleep(Duration::from_secs(3));
            signal(owner.id(), Signal::CONT);
            // The owner checks first.
            std::thread::sleep(Duration::from_millis(300));
            signal(process.parse().unwrap(), Signal::CONT);
        }
        said.push(line);
    }
    assert!(owner.wait().unwrap().success(), "{said:?}");
    assert!(said.iter().any(|line| line == "the end"), "{said:?}");
}

#[test]
fn no_process_or_file_is_left_behind() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let sampler = Windows { of: AnyOf(vec![setting(&case, "01-10..01-12")]), days: (1, 1), starts: 3 };
    let options = VecEnvOptions { workers: options(&case), autoreset: Autoreset::NextStep, widths: None };
    let mut vec = VecEnv::new(2, Box::new(sampler), options).unwrap();
    vec.reset(0).unwrap();
    let action = vec.spaces(0).unwrap().action.low().to_vec();
    let actions = [action.clone(), action].concat();
    let mut processes: Vec<u32> = Vec::new();
    for _ in 0..4 {
        (0..2).for_each(|index| processes.push(vec.process(index).unwrap()));
        (0..289).for_each(|_| vec.step(&actions).unwrap());
    }
    processes.extend(vec.workers().template_processes());
    let folder = vec.workers().folder();
    assert!(folder.exists());
    drop(vec);
    assert!(!folder.exists());
    assert!(processes.iter().all(|process| !is_alive(*process)));
}

#[test]
fn workers_are_confined_where_the_kernel_can() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let mut episode = workers.episode(&setting(&case, DAY)).unwrap();
    episode.reset().unwrap();
    let confined = |process: u32| {
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
        // Landlock requires that a process can never gain privileges.
        status.lines().any(|line| line == "NoNewPrivs:\t1")
    };
    let expected = Confinement::available() != Confinement::None;
    let processes = workers.template_processes().into_iter().chain(episode.process());
    for process in processes {
        assert_eq!(confined(process), expected);
    }
    assert!(!confined(std::process::id()));
}

#[test]
fn a_fork_of_the_owner_leaves_the_workers_alone() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let mut episode = workers.episode(&setting(&case, DAY)).unwrap();
    episode.reset().unwrap();
    let action = episode.spaces().action.low().to_vec();
    // SAFETY: the child drops its handles and ends.
    match unsafe { libc::fork() } {
        0 => {
            drop((episode, workers));
            // SAFETY: ends the child without running anything of the test.
            unsafe { libc::_exit(0) }
        }
        child => {
            let mut status = 0;
            // SAFETY: `child` is a child of this process.
            assert_eq!(unsafe { libc::waitpid(child, &mut status, 0) }, child);
            assert_eq!(status, 0);
        }
    }
    episode.step(&action).unwrap();
    assert!(workers.folder().exists());
}
