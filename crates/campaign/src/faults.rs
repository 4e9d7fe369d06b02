//! Signals and resource limits at random times: a command must end in time and leave nothing behind, and the same
//! command must then complete the work with the same bytes.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::Result;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rustix::process::{Pid, Signal, kill_process};

use crate::Campaign;
use crate::mutation::pick;
use crate::program::{Ended, Program, words};

/// Time limit for a command to end after a fault.
const LIMIT: Duration = Duration::from_secs(120);

/// A resumable command, and the file by which its result is checked.
struct Job {
    name: &'static str,
    arguments: &'static str,
    result: &'static str,
}

const JOBS: [Job; 3] = [
    Job {
        name: "evaluate",
        arguments: "evaluate SingleFamilyHouse-0018 Warehouse-0001 --policy reactive --period 01-01..01-02 --jobs 2 \
                    --out out",
        result: "out/episodes.parquet",
    },
    Job { name: "generate", arguments: "generate Warehouse --count 6 --out out", result: "out/manifest.csv" },
    Job {
        name: "run",
        arguments: "run SingleFamilyHouse --period 01-01..01-03 --out out",
        result: "out/trajectory.parquet",
    },
];

/// A fault.
#[derive(Clone, Copy, Debug)]
enum Fault {
    /// A signal to the command itself.
    Signal(Signal),
    /// A signal to one of its processes, chosen at random.
    Member(Signal),
    /// A stop of all its processes for two seconds.
    Pause,
    /// A `ulimit` command.
    Limit(&'static str),
}

const FAULTS: [Fault; 11] = [
    Fault::Signal(Signal::INT),
    Fault::Signal(Signal::TERM),
    Fault::Signal(Signal::KILL),
    Fault::Member(Signal::KILL),
    Fault::Member(Signal::SEGV),
    Fault::Member(Signal::TERM),
    Fault::Pause,
    // Blocks of 512 bytes.
    Fault::Limit("ulimit -f 100"),
    Fault::Limit("ulimit -f 2000"),
    Fault::Limit("ulimit -n 24"),
    Fault::Limit("ulimit -v 3000000"),
];

impl Fault {
    fn name(self) -> String {
        match self {
            Self::Signal(signal) => format!("signal {} to the command", signal.as_raw()),
            Self::Member(signal) => format!("signal {} to any of its processes", signal.as_raw()),
            Self::Pause => "a pause".into(),
            Self::Limit(limit) => limit.into(),
        }
    }

    fn limits(self) -> &'static str {
        if let Self::Limit(limits) = self { limits } else { "" }
    }

    /// Returns whether the fault may kill the command, so that it cannot clean up.
    fn kills(self) -> bool {
        match self {
            Self::Signal(signal) => signal == Signal::KILL,
            Self::Member(_) => true,
            Self::Limit(_) | Self::Pause => false,
        }
    }
}

/// Attacks jobs until a deadline.
pub fn attack(Campaign { program, material, deadline, mut random, ledger }: Campaign<'_>) -> Result<()> {
    let mut whole = Vec::new();
    for job in &JOBS {
        let folder = material.path(&format!("whole-{}", job.name));
        std::fs::create_dir(&folder)?;
        let began = Instant::now();
        program.must(&folder, job.arguments)?;
        whole.push((std::fs::read(folder.join(job.result))?, began.elapsed()));
    }
    while Instant::now() < deadline {
        let number = random.random_range(0..JOBS.len());
        let (job, fault) = (&JOBS[number], *pick(&FAULTS, &mut random));
        let (expected, time) = &whole[number];
        let kind = format!("{}: {}", job.name, fault.name());
        let folder = tempfile::tempdir()?;
        let moment = time.mul_f64(random.random_range(0.0..1.1));
        let (ended, may_be_killed) = struck(program, job, fault, moment, folder.path(), &mut random)?;
        let broken = match ended.broken(may_be_killed) {
            Some(why) => Some(why),
            None => not_completed(program, job, folder.path(), expected)?,
        };
        let broken = broken.map(|why| format!("{why}\nafter {moment:?}"));
        ledger.judge(&kind, broken, ended.code(), folder.path())?;
    }
    Ok(())
}

/// Runs a job with a fault after some time. Also returns whether the fault may have killed the command.
fn struck(
    program: &Program,
    job: &Job,
    fault: Fault,
    moment: Duration,
    folder: &Path,
    random: &mut ChaCha8Rng,
) -> Result<(Ended, bool)> {
    let mut run = program.start(folder, fault.limits(), &words(job.arguments))?;
    std::thread::sleep(moment);
    let processes = if run.has_ended()? { Vec::new() } else { run.processes() };
    // Fails if the process has just ended.
    let send = |process, signal| {
        let _ = kill_process(process, signal);
    };
    let mut may_be_killed = fault.kills();
    match (fault, &processes[..]) {
        (_, []) | (Fault::Limit(_), _) => {}
        (Fault::Signal(signal), [command, ..]) => {
            may_be_killed |= !catches(*command, signal);
            send(*command, signal);
        }
        (Fault::Member(signal), all) => send(*pick(all, random), signal),
        (Fault::Pause, all) => {
            all.iter().for_each(|process| send(*process, Signal::STOP));
            std::thread::sleep(Duration::from_secs(2));
            all.iter().for_each(|process| send(*process, Signal::CONT));
        }
    }
    Ok((run.end(LIMIT + moment)?, may_be_killed))
}

/// Returns whether a process handles a signal. One that has just started does not yet.
fn catches(process: Pid, signal: Signal) -> bool {
    let status =
        std::fs::read_to_string(format!("/proc/{}/status", process.as_raw_nonzero())).unwrap_or_default();
    let mask =
        status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigCgt:")?.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal.as_raw() - 1) & 1 == 1)
}

/// Runs a job again. Returns an error message unless it completes with the expected result.
fn not_completed(program: &Program, job: &Job, folder: &Path, expected: &[u8]) -> Result<Option<String>> {
    let again = program.run(folder, &words(job.arguments), LIMIT)?;
    Ok(match (again.broken(false), again.code()) {
        (Some(why), _) => Some(format!("the repeated command: {why}")),
        (None, Some(0)) if std::fs::read(folder.join(job.result))? == expected => None,
        (None, Some(0)) => Some(format!("the repeated command writes a different {}", job.result)),
        (None, code) => Some(format!("the repeated command ends with {code:?}: {}", again.errors)),
    })
}
