//! `b2b bench vector`: the cost of many parallel environments.

use std::io::{BufRead, BufReader, Write};
use std::process::{ChildStdin, ChildStdout, Stdio};
use std::time::Instant;

use anyhow::{Context, Result};
use b2b_building::{BuildingType, Date, RunPeriod};
use b2b_dataset::BuildingName;
use b2b_env::{Env, Environment, Task};
use b2b_workers::{ActionProcess, EpisodeSetting, Fixed, VecEnv, Workers};
use cpu_time::ProcessTime;
use serde::{Deserialize, Serialize};

use super::process::{cpu_seconds, private_mb, proportional_mb};
use super::statistics::{median, percentile};
use crate::arguments::location::Location;
use crate::program;
use crate::program::prepare::Prepared;
use crate::terminal::progress::spinner;
use crate::terminal::table::Table;
use crate::terminal::{interrupt, stdout};

/// Measure throughput, resets and memory of many environments at once
///
/// Every environment runs in its own process, copied from a template at the end of warm-up. Every actuator is held
/// at the middle of its range. The batch alternates in rounds with single environments, one process per processor and
/// all at the same time, so that other load affects both alike; rates are medians over the rounds.
#[derive(clap::Args)]
#[command(after_help = "\
Columns:
  steps/CPU s      steps of all environments per CPU time of their processes and of this one
  single           steps per CPU time of single environments
  ratio            steps/CPU s divided by single
  single, cold     single with a cold processor cache at every step, and the ratio to it
  steps/s          steps of all environments per wall-clock second
  owner (µs)       CPU time of this process per step of an environment
  reset (ms)       from reset to the first observation: median and 99th percentile
  fresh (CPU ms)   CPU time of a reset without a template
  private (MB)     memory that an environment shares with no other, at the end
  template (MB)    proportional memory (PSS) of a template without copies

Examples:
  b2b bench vector
  b2b bench vector --type OfficeSmall --environments 4 --days 5 --json")]
pub struct Arguments {
    /// Building types, or buildings of the dataset such as OfficeSmall-0042 [default: every type]
    #[arg(long = "type", value_name = "BUILDING", num_args = 1..)]
    buildings: Vec<BuildingName>,
    /// Number of environments
    #[arg(long, default_value_t = 14, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    environments: u32,
    /// Simulated days, from 1 January
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u32).range(2..=182))]
    days: u32,
    /// Number of resets to measure
    #[arg(long, default_value_t = 200, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    resets: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

const STEPS_PER_HOUR: u32 = 12;
/// Steps of each environment per round.
const ROUND: usize = 96;

/// Measurements of one building.
#[derive(Serialize)]
struct MeasuredBatch {
    #[serde(rename = "type")]
    building: String,
    environments: u32,
    steps_per_cpu_s: f64,
    single_steps_per_cpu_s: f64,
    /// The same with a cold processor cache at every step.
    single_cold_steps_per_cpu_s: f64,
    ratio: f64,
    ratio_to_cold: f64,
    steps_per_s: f64,
    /// CPU time of this process per step of an environment, microseconds.
    owner_us_per_step: f64,
    reset_ms_p50: f64,
    reset_ms_p99: f64,
    fresh_reset_cpu_ms: f64,
    private_mb_per_env: f64,
    template_mb: f64,
}

/// Runs the command.
pub fn bench(arguments: &Arguments) -> Result<()> {
    let types = BuildingType::ALL.map(BuildingName::Type);
    let buildings = if arguments.buildings.is_empty() { &types[..] } else { &arguments.buildings };
    let mut measured = Vec::new();
    for building in buildings {
        measured.push(measure(building, arguments)?);
    }
    if arguments.json { stdout::print_json(&measured) } else { stdout::print(&text(&measured)) }
}

fn measure(building: &BuildingName, arguments: &Arguments) -> Result<MeasuredBatch> {
    let prepared = Prepared::new(building, &Location::default(), arguments.json)?;
    let spinner = spinner(format!("{} environments of {building}", arguments.environments), arguments.json);
    let period = period(arguments.days);
    let fresh = (0..3).map(|_| fresh_reset_ms(&prepared, period)).collect::<Result<_>>()?;
    let setting = prepared.setting(prepared.episode(period, STEPS_PER_HOUR, Task::default()));
    let (resets, template_mb) = resets(&prepared, &setting, arguments.resets)?;
    let rates = Rates::measure(&prepared, setting, building, arguments)?;
    spinner.finish_and_clear();
    Ok(MeasuredBatch {
        building: building.to_string(),
        environments: arguments.environments,
        steps_per_cpu_s: median(rates.batch.clone()),
        single_steps_per_cpu_s: median(rates.single.clone()),
        single_cold_steps_per_cpu_s: median(rates.cold.clone()),
        ratio: ratio(&rates.batch, &rates.single),
        ratio_to_cold: ratio(&rates.batch, &rates.cold),
        steps_per_s: median(rates.per_second),
        owner_us_per_step: median(rates.owner_us),
        reset_ms_p50: percentile(resets.clone(), 50),
        reset_ms_p99: percentile(resets, 99),
        fresh_reset_cpu_ms: median(fresh),
        private_mb_per_env: rates.private_mb,
        template_mb,
    })
}

/// Returns the median ratio of the rounds.
fn ratio(batch: &[f64], single: &[f64]) -> f64 {
    median(batch.iter().zip(single).map(|(batch, single)| batch / single).collect())
}

fn period(days: u32) -> RunPeriod {
    RunPeriod::new(Date::of_day(1), Date::of_day(days))
}

/// Returns the CPU time of a reset without a template, ms.
fn fresh_reset_ms(prepared: &Prepared, period: RunPeriod) -> Result<f64> {
    interrupt::check()?;
    let mut env = prepared.env(period, STEPS_PER_HOUR, Task::default())?;
    let before = ProcessTime::now();
    env.reset()?;
    Ok(before.elapsed().as_secs_f64() * 1e3)
}

/// Returns the wall-clock times of resets from a template, ms, and the template's memory, MB.
fn resets(prepared: &Prepared, setting: &EpisodeSetting, count: u32) -> Result<(Vec<f64>, f64)> {
    let workers = Workers::new(prepared.worker_options())?;
    let mut episode = workers.episode(setting)?;
    let process = *workers.template_processes().first().context("the template is gone")?;
    let template_mb = proportional_mb(process)?;
    let mut times = Vec::new();
    for _ in 0..count {
        let start = Instant::now();
        episode.reset()?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok((times, template_mb))
}

/// Steps per CPU time and per wall-clock time of each round, and the memory of an environment.
struct Rates {
    batch: Vec<f64>,
    single: Vec<f64>,
    cold: Vec<f64>,
    per_second: Vec<f64>,
    owner_us: Vec<f64>,
    private_mb: f64,
}

impl Rates {
    fn measure(
        prepared: &Prepared,
        setting: EpisodeSetting,
        building: &BuildingName,
        arguments: &Arguments,
    ) -> Result<Self> {
        let count = arguments.environments as usize;
        let mut batch = VecEnv::new(count, Box::new(Fixed(vec![setting])), prepared.vec_env_options())?;
        batch.reset(0)?;
        let spaces = batch.spaces(0).context("no environment was reset")?;
        let actions = spaces.action.middle().repeat(count);
        let whole = spaces.episode_steps();
        let processors = std::thread::available_parallelism()?.get();
        let mut singles = (0..processors)
            .map(|_| Single::start(building, 2 * arguments.days))
            .collect::<Result<Vec<_>>>()?;
        let processes: Vec<u32> = (0..count).filter_map(|index| batch.process(index)).collect();
        let cpu = || processes.iter().map(|process| cpu_seconds(*process)).sum::<Result<f64>>();
        let mut rates = Self {
            batch: vec![],
            single: vec![],
            cold: vec![],
            per_second: vec![],
            owner_us: vec![],
            private_mb: 0.0,
        };
        // The last step ends the processes, and their CPU time is no longer readable.
        for round in 0..(whole - 1) / ROUND {
            interrupt::check()?;
            let [single, cold] = [Cache::Warm, Cache::Cold].map(|cache| Single::round(&mut singles, cache));
            let (before, owner, start) = (cpu()?, ProcessTime::now(), Instant::now());
            (0..ROUND).try_for_each(|_| batch.step(&actions))?;
            let (clock, owner) = (start.elapsed().as_secs_f64(), owner.elapsed().as_secs_f64());
            let steps = (ROUND * count) as f64;
            // The first rounds still copy the template's memory.
            if round >= (whole / ROUND / 10).max(3) {
                rates.single.push(single?);
                rates.cold.push(cold?);
                rates.batch.push(steps / (cpu()? - before + owner));
                rates.per_second.push(steps / clock);
                rates.owner_us.push(owner / steps * 1e6);
            }
        }
        let private = processes.iter().map(|process| private_mb(*process)).sum::<Result<f64>>()?;
        rates.private_mb = private / count as f64;
        Ok(rates)
    }
}

/// The processor cache of a single environment at a step.
#[derive(Clone, Copy)]
enum Cache {
    /// Holds the memory of its last step.
    Warm,
    /// Holds other memory, as in a batch.
    Cold,
}

impl Cache {
    fn name(self) -> &'static str {
        match self {
            Self::Warm => "warm",
            Self::Cold => "cold",
        }
    }
}

/// Size of the memory that replaces the content of a processor's own cache, bytes.
const OTHERS: usize = 8 << 20;

/// Name of the action that runs a single environment.
pub(crate) const SINGLE: &str = "single";

/// The order of a single environment.
#[derive(Serialize, Deserialize)]
pub(crate) struct SingleOrder {
    building: String,
    days: u32,
}

/// A single environment in its own process.
struct Single {
    ask: ChildStdin,
    answers: BufReader<ChildStdout>,
    _process: ActionProcess,
}

impl Single {
    fn start(building: &BuildingName, days: u32) -> Result<Self> {
        let order = SingleOrder { building: building.to_string(), days };
        let mut process = ActionProcess::start(&program::launcher(), SINGLE, &order, |command| {
            command.stdin(Stdio::piped()).stdout(Stdio::piped());
        })
        .context("cannot start a process")?;
        let ask = process.child().stdin.take().context("no pipe")?;
        let answers = BufReader::new(process.child().stdout.take().context("no pipe")?);
        let mut single = Self { ask, answers, _process: process };
        single.answer()?;
        Ok(single)
    }

    /// Runs a round in all processes at once. Returns the steps per CPU second of one process.
    fn round(singles: &mut [Self], cache: Cache) -> Result<f64> {
        for single in &mut *singles {
            writeln!(single.ask, "{}", cache.name()).context("a single environment has ended")?;
        }
        let seconds = singles.iter_mut().map(Self::answer).sum::<Result<f64>>()?;
        Ok((ROUND * singles.len()) as f64 / seconds)
    }

    fn answer(&mut self) -> Result<f64> {
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        line.trim().parse().context("a single environment has ended")
    }

    /// Runs a round. Returns its CPU time, s, without the time to replace the cache before each step.
    fn steps(env: &mut Env, action: &[f64], others: &mut [u8]) -> Result<f64> {
        let mut seconds = 0.0;
        for _ in 0..ROUND {
            others.iter_mut().step_by(64).for_each(|line| *line = line.wrapping_add(1));
            let before = ProcessTime::now();
            env.step(action)?;
            seconds += before.elapsed().as_secs_f64();
        }
        Ok(seconds)
    }
}

/// Carries out the order of a single environment: reports when it is ready, then runs a round for each line of standard
/// input and reports its CPU time.
pub(crate) fn serve_single(order: &SingleOrder) -> Result<String> {
    let prepared = Prepared::new(&order.building.parse()?, &Location::default(), true)?;
    let mut env = prepared.env(period(order.days), STEPS_PER_HOUR, Task::default())?;
    let action = env.action_space().middle();
    env.reset()?;
    println!("0");
    let mut others = vec![0u8; 0];
    for line in std::io::stdin().lock().lines() {
        others.resize(if line? == Cache::Cold.name() { OTHERS } else { 0 }, 0);
        println!("{}", Single::steps(&mut env, &action, &mut others)?);
    }
    Ok(String::new())
}

fn text(measured: &[MeasuredBatch]) -> String {
    let mut table = Table::new([
        "building",
        "N",
        "steps/CPU s",
        "single",
        "ratio",
        "single, cold",
        "ratio",
        "steps/s",
        "owner (µs)",
        "reset (ms)",
        "99 % (ms)",
        "fresh (CPU ms)",
        "private (MB)",
        "template (MB)",
    ]);
    for each in measured {
        table.row([
            each.building.clone(),
            each.environments.to_string(),
            format!("{:.0}", each.steps_per_cpu_s),
            format!("{:.0}", each.single_steps_per_cpu_s),
            format!("{:.3}", each.ratio),
            format!("{:.0}", each.single_cold_steps_per_cpu_s),
            format!("{:.3}", each.ratio_to_cold),
            format!("{:.0}", each.steps_per_s),
            format!("{:.1}", each.owner_us_per_step),
            format!("{:.1}", each.reset_ms_p50),
            format!("{:.1}", each.reset_ms_p99),
            format!("{:.0}", each.fresh_reset_cpu_ms),
            format!("{:.0}", each.private_mb_per_env),
            format!("{:.0}", each.template_mb),
        ]);
    }
    table.text()
}
