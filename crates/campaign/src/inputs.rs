//! Damaged files, given to every file reader, which must return without a panic.
//!
//! The readers run in their own process, because a stack overflow aborts it. The file being read is always on disk.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use b2b_agent::Agent;
use b2b_benchmark::Problem;
use b2b_building::import;
use b2b_climate::{EpwFile, Site};
use b2b_control::ReactiveParameters;
use b2b_energyplus::Library;
use b2b_energyplus::install::{Engine, Quiet};
use b2b_env::Task;
use b2b_evaluate::{ActionScale, OnnxPolicy, panic_message};
use b2b_learn::offline::Dataset;
use b2b_learn::train::TrainConfig;
use cpu_time::ProcessTime;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

use crate::Campaign;
use crate::ledger::{Outcome, copy};
use crate::material::Material;
use crate::mutation::mutate;

/// Limit of CPU time for reading a file.
const LIMIT: Duration = Duration::from_secs(20);
/// Wall-clock limit for reading a file, generous for a shared machine.
const WAIT: Duration = Duration::from_secs(180);
/// Duration of a reader process.
const SLICE: Duration = Duration::from_secs(20);
const ORDER: &str = "B2B_CAMPAIGN_ORDER";

/// A reader of files.
struct Reader {
    name: &'static str,
    /// The file that it reads, in its own folder.
    file: PathBuf,
    /// A valid file.
    valid: Vec<u8>,
    /// Reads the file, and returns whether it was accepted.
    read: Box<dyn Fn() -> bool>,
}

/// The task of a reader process.
pub struct Order {
    material: PathBuf,
    work: PathBuf,
    seed: u64,
}

impl Order {
    /// Returns the order of this process, if it is a reader process.
    pub fn of_this_process() -> Option<Self> {
        let text = std::env::var(ORDER).ok()?;
        let [seed, material, work] = text.splitn(3, ' ').collect::<Vec<_>>().try_into().ok()?;
        Some(Self { material: material.into(), work: work.into(), seed: seed.parse().ok()? })
    }
}

/// Runs reader processes until a deadline.
pub fn attack(Campaign { material, deadline, mut random, ledger, .. }: Campaign<'_>) -> Result<()> {
    while Instant::now() < deadline {
        let work = tempfile::tempdir()?;
        let seed: u64 = random.random();
        let order = format!("{seed} {} {}", material.path("").display(), work.path().display());
        let status = Command::new(std::env::current_exe()?).env(ORDER, order).status()?;
        let counts = std::fs::read_to_string(work.path().join("counts")).unwrap_or_default();
        for line in counts.lines() {
            let Some((kind, numbers)) = line.rsplit_once(": ") else { continue };
            let numbers: Vec<usize> = numbers.split(' ').filter_map(|number| number.parse().ok()).collect();
            let [accepted, rejected] = numbers[..] else { continue };
            ledger.count(kind, Outcome::Accepted, accepted);
            ledger.count(kind, Outcome::Rejected, rejected);
        }
        if !status.success() {
            let current = std::fs::read_to_string(work.path().join("current")).unwrap_or_default();
            let (kind, why) = current.split_once('\n').unwrap_or((&current, ""));
            let why = if why.is_empty() { format!("the process ended: {status}") } else { why.to_owned() };
            ledger.find(kind, &format!("{why}\nseed {seed}"), &[&work.path().join(kind)])?;
        }
    }
    Ok(())
}

/// Gives damaged files to the readers in this process, for a limited time or until the first finding.
pub fn attack_here(order: &Order) -> Result<ExitCode> {
    let readers = readers(&Material::open(&order.material)?, &order.work)?;
    let mut counts = vec![[0_usize; 2]; readers.len()];
    let mut random = ChaCha8Rng::seed_from_u64(order.seed);
    let deadline = Instant::now() + SLICE;
    // Findings are reported by the parent.
    std::panic::set_hook(Box::new(|_| ()));
    let current = order.work.join("current");
    while Instant::now() < deadline {
        let number = random.random_range(0..readers.len());
        let reader = &readers[number];
        std::fs::write(&reader.file, mutate(&reader.valid, &mut random))?;
        std::fs::write(&current, reader.name)?;
        match within_limit(reader, &current) {
            Ok(accepted) => counts[number][usize::from(!accepted)] += 1,
            Err(panic) => {
                std::fs::write(&current, format!("{}\npanic: {panic}", reader.name))?;
                write_counts(order, &readers, &counts)?;
                return Ok(ExitCode::FAILURE);
            }
        }
    }
    write_counts(order, &readers, &counts)?;
    Ok(ExitCode::SUCCESS)
}

/// Returns whether the file was accepted, or the message of a panic. Ends this process after a limit of time.
fn within_limit(reader: &Reader, current: &Path) -> Result<bool, String> {
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let (name, done) = (reader.name, &done);
        let watch = scope.spawn(move || {
            let (began, used) = (Instant::now(), ProcessTime::now());
            while !done.load(Ordering::Acquire) {
                if used.elapsed() > LIMIT || began.elapsed() > WAIT {
                    let _ = std::fs::write(current, format!("{name}\nnot read in {LIMIT:?} of CPU time"));
                    std::process::exit(1);
                }
                std::thread::park_timeout(Duration::from_secs(1));
            }
        });
        let outcome = catch_unwind(AssertUnwindSafe(|| (reader.read)()));
        done.store(true, Ordering::Release);
        watch.thread().unpark();
        outcome.map_err(|panic| panic_message(&*panic).to_owned())
    })
}

fn write_counts(order: &Order, readers: &[Reader], counts: &[[usize; 2]]) -> Result<()> {
    let line =
        |(reader, counts): (&Reader, &[usize; 2])| format!("{}: {} {}\n", reader.name, counts[0], counts[1]);
    let text: String = readers.iter().zip(counts).map(line).collect();
    std::fs::write(order.work.join("counts"), text).context("cannot write the counts")
}

/// Returns a reader of a single file. `read` returns whether it accepts the file.
fn of_file(
    work: &Path,
    name: &'static str,
    file: &str,
    valid: Vec<u8>,
    read: impl Fn(&Path) -> bool + 'static,
) -> Result<Reader> {
    let folder = work.join(name);
    std::fs::create_dir_all(&folder)?;
    let file = folder.join(file);
    let path = file.clone();
    Ok(Reader { name, file, valid, read: Box::new(move || read(&path)) })
}

/// Returns a reader of a folder in which one file is damaged. `read` returns whether it accepts the folder.
fn of_folder(
    work: &Path,
    name: &'static str,
    source: &Path,
    file: &str,
    read: impl Fn(&Path) -> bool + 'static,
) -> Result<Reader> {
    let folder = work.join(name);
    copy(source, &folder)?;
    // Digests would reveal the damage before anything is parsed.
    let _ = std::fs::remove_file(folder.join(b2b_base::digest_list::DIGESTS));
    let file = folder.join(file);
    let valid = std::fs::read(&file).with_context(|| format!("cannot read {}", file.display()))?;
    let valid = without_seal(valid);
    Ok(Reader { name, file, valid, read: Box::new(move || read(&folder)) })
}

/// Returns the description of an agent in the earlier format, which does not state its own digest; other files
/// unchanged.
fn without_seal(content: Vec<u8>) -> Vec<u8> {
    match String::from_utf8(content) {
        Ok(text) => text.replacen("\"format\": 2,", "\"format\": 1,", 1).into_bytes(),
        Err(binary) => binary.into_bytes(),
    }
}

/// Writes the hash of an agent's weights into its description, which would reveal damage before they are parsed.
fn with_hash_of_weights(folder: &Path) -> Result<()> {
    let path = folder.join(b2b_agent::INFO);
    let mut info: serde_json::Value = serde_json::from_slice(&std::fs::read(&path)?)?;
    let weights = std::fs::read(folder.join("weights.safetensors"))?;
    (info["format"], info["weights"]) = (json!(1), json!(b2b_base::digest::sha256(weights)));
    Ok(std::fs::write(&path, info.to_string())?)
}

fn readers(material: &Material, work: &Path) -> Result<Vec<Reader>> {
    let library = Library::load(&Engine::ensure(&mut Quiet)?.library)?;
    let json = |value: serde_json::Value| value.to_string().into_bytes();
    let model = std::fs::read(material.models().first().context("no model was generated")?)?;
    let task =
        json!({"setpoints": {"mode": "occupancy", "summer": 27}, "energy_weight": 0.5, "comfort_band": 0.5});
    let parameters = json!({"unitary": {"min_flow": 0.2, "gains": {"proportional": 0.3, "integral": 0.1}}});
    let problem = serde_json::to_vec(&Problem::all()[0])?;
    let weather = material.bytes("weather.epw")?;
    let header = weather.split_inclusive(|byte| *byte == b'\n').take(8).collect::<Vec<_>>().concat();
    let onnx = |path: &Path| OnnxPolicy::read(path, ActionScale::Rescaled).is_ok();
    let agent = |path: &Path| Agent::read(path).is_ok();
    let dataset = |path: &Path| Dataset::open(path).is_ok_and(|dataset| dataset.read(0).is_ok());
    let episodes = |path: &Path| File::open(path).is_ok_and(|file| b2b_evaluate::read_episodes(file).is_ok());
    Ok(vec![
        of_file(work, "model", "m.epJSON", model, move |path| import::read(path, &library, false).is_ok())?,
        of_file(work, "weather: site", "w.epw", header, |path| Site::read(path).is_ok())?,
        of_file(work, "weather: degree days", "w.epw", weather, |path| {
            EpwFile::open(path)
                .is_ok_and(|file| file.degree_days().is_ok_and(|days| days.heating.is_finite()))
        })?,
        of_file(work, "task", "task.json", json(task), |path| Task::read(path).is_ok())?,
        of_file(work, "parameters", "parameters.json", json(parameters), |path| {
            ReactiveParameters::read(path).is_ok()
        })?,
        of_file(work, "problem", "problem.json", problem, |path| Problem::read(path).is_ok())?,
        of_file(
            work,
            "training configuration",
            "train.toml",
            material.bytes("agent/config.toml")?,
            |path| TrainConfig::default().with_file(path, &[]).is_ok_and(|config| config.check().is_ok()),
        )?,
        of_file(
            work,
            "table of episodes",
            "episodes.parquet",
            material.bytes("evaluation/episodes.parquet")?,
            episodes,
        )?,
        of_file(work, "ONNX", "agent.onnx", material.bytes("agent.onnx")?, onnx)?,
        of_folder(work, "agent.json", &material.path("agent"), "agent.json", agent)?,
        of_folder(work, "weights", &material.path("agent"), "weights.safetensors", |folder| {
            with_hash_of_weights(folder).is_ok() && Agent::read(folder).is_ok()
        })?,
        of_folder(work, "offline metadata", &material.path("offline-v0"), "data/metadata.json", dataset)?,
        of_folder(work, "offline episode", &material.path("offline-v0"), "data/0/metadata.json", dataset)?,
        of_folder(work, "offline steps", &material.path("offline-v0"), "data/0/part-0.parquet", dataset)?,
    ])
}
