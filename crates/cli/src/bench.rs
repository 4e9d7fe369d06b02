//! `b2b bench`: what a step costs, and how much of it is the engine.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Result, bail};
use b2b_building::hvac::{Actuator, Quantity};
use b2b_building::{BuildingType, Date, RunPeriod};
use b2b_energyplus::{Event, Run, Simulation};
use b2b_env::{Env, Task};
use cpu_time::ProcessTime;
use serde::Serialize;
use tempfile::TempDir;

use crate::prepare::{BuildingName, Location, Prepared};
use crate::table::Table;
use crate::{interrupt, stdout};

/// Measure what a step costs
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Speed(SpeedArguments),
}

/// CPU time of a step: the bare engine, the engine stopped at every step, the whole environment
///
/// The three run the same model with every actuator held at the middle of its bounds; only the steps
/// after warm-up count. The three take turns within a round; times and ratios are medians over the
/// rounds. It is CPU time, not time on the clock, but a busy machine still shows through its shared
/// caches: give more rounds.
#[derive(clap::Args)]
#[command(after_help = "\
Columns, milliseconds of CPU time a step:
  engine     EnergyPlus runs through without a stop
  advance    EnergyPlus stops at the end of every step, nothing is read (Simulation::advance)
  env        action, step, observation, reward (Env::step)

Examples:
  b2b bench speed
  b2b bench speed --type OfficeSmall --type Warehouse --days 30 --rounds 5 --json")]
struct SpeedArguments {
    /// Building types, or buildings of the dataset such as OfficeSmall-0042 [default: every type]
    #[arg(long = "type", value_name = "BUILDING", num_args = 1..)]
    buildings: Vec<BuildingName>,
    /// Days from 1 January
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=365))]
    days: u32,
    /// Measurements of each kind
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

const STEPS_PER_HOUR: u32 = 12;

/// CPU time of a step of one building type, ms, and its ratios to the bare engine; medians over the rounds.
#[derive(Serialize)]
struct Speed {
    #[serde(rename = "type")]
    building: String,
    engine_ms: f64,
    advance_ms: f64,
    env_ms: f64,
    advance_to_engine: f64,
    env_to_engine: f64,
    steps: usize,
}

/// Runs the command.
pub fn bench(arguments: &Arguments) -> Result<()> {
    let What::Speed(arguments) = &arguments.what;
    let types = BuildingType::ALL.map(BuildingName::Type);
    let buildings = if arguments.buildings.is_empty() { &types[..] } else { &arguments.buildings };
    let mut speeds = Vec::new();
    for building in buildings {
        speeds.push(speed(*building, arguments)?);
    }
    if arguments.json { stdout::print_json(&speeds) } else { stdout::print(&text(&speeds)) }
}

fn speed(building: BuildingName, arguments: &SpeedArguments) -> Result<Speed> {
    const WAYS: [fn(&Bench) -> Result<Duration>; 3] = [Bench::bare_engine, Bench::advance, Bench::env];
    let bench = Bench::new(building, arguments)?;
    let mut rounds = Vec::new();
    for round in 0..arguments.rounds as usize {
        let mut ms = [0.0; 3];
        for k in 0..WAYS.len() {
            // Each way is first, second and third in turn: a machine that grows slower favours none.
            let way = (round + k) % WAYS.len();
            ms[way] = WAYS[way](&bench)?.as_secs_f64() * 1e3 / bench.steps() as f64;
        }
        rounds.push(ms);
    }
    let of_rounds = |value: fn(&[f64; 3]) -> f64| median(rounds.iter().map(value).collect());
    Ok(Speed {
        building: building.to_string(),
        engine_ms: of_rounds(|ms| ms[0]),
        advance_ms: of_rounds(|ms| ms[1]),
        env_ms: of_rounds(|ms| ms[2]),
        advance_to_engine: of_rounds(|ms| ms[1] / ms[0]),
        env_to_engine: of_rounds(|ms| ms[2] / ms[0]),
        steps: bench.steps(),
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// One building, run in three ways.
struct Bench {
    prepared: Prepared,
    period: RunPeriod,
    model: PathBuf,
    /// Holds the model file.
    _folder: TempDir,
}

impl Bench {
    fn new(building: BuildingName, arguments: &SpeedArguments) -> Result<Self> {
        let prepared = Prepared::new(building, &Location::default(), arguments.json)?;
        let period = RunPeriod::new(Date::of_day(1), Date::of_day(arguments.days))?;
        let folder = tempfile::Builder::new().prefix("b2b-bench-").tempdir()?;
        let model = folder.path().join("model.epJSON");
        std::fs::write(&model, prepared.building.model_for(period, STEPS_PER_HOUR).to_epjson())?;
        Ok(Self { prepared, period, model, _folder: folder })
    }

    fn steps(&self) -> usize {
        (self.period.days() * 24 * STEPS_PER_HOUR) as usize
    }

    /// EnergyPlus without a stop.
    fn bare_engine(&self) -> Result<Duration> {
        let mut simulation = self.start(|run| run.uninterrupted())?;
        let start = ProcessTime::now();
        let end = simulation.advance()?;
        let time = start.elapsed();
        match end {
            None => Ok(time),
            Some(event) => bail!("an uninterrupted run stopped at {event:?}"),
        }
    }

    /// EnergyPlus with a stop at the end of every step.
    fn advance(&self) -> Result<Duration> {
        let mut simulation = self.start(|run| run)?;
        let start = ProcessTime::now();
        let mut steps = 0;
        while simulation.advance()?.is_some() {
            steps += 1;
        }
        let time = start.elapsed();
        if steps != self.steps() {
            bail!("the engine took {steps} steps instead of {}", self.steps());
        }
        Ok(time)
    }

    /// The environment.
    fn env(&self) -> Result<Duration> {
        let mut env = self.prepared.env(self.period, STEPS_PER_HOUR, Task::default())?;
        let action = middle(&env);
        env.reset()?;
        let start = ProcessTime::now();
        while !env.step(&action)?.truncated {}
        Ok(start.elapsed())
    }

    /// A run at the end of warm-up, with every actuator at the middle of its bounds.
    fn start(&self, stops: impl FnOnce(Run) -> Run) -> Result<Simulation> {
        interrupt::check()?;
        let run = stops(Run::new(&self.model, &self.prepared.weather));
        let mut simulation = run.start(&self.prepared.library)?;
        // The engine takes a damper's first value for its least opening, which is 0 in the prepared model.
        self.hold_middle(&mut simulation, |actuator| actuator.quantity != Quantity::DamperOpening)?;
        match simulation.advance()? {
            Some(Event::WarmedUp) => {}
            other => bail!("the engine stood at {other:?} instead of at the end of warm-up"),
        }
        self.hold_middle(&mut simulation, |_| true)?;
        Ok(simulation)
    }

    fn hold_middle(&self, simulation: &mut Simulation, which: impl Fn(&Actuator) -> bool) -> Result<()> {
        for each in self.prepared.building.actuators().filter(|actuator| which(actuator)) {
            let actuator = simulation.actuator(&each.component, &each.control, &each.key)?;
            simulation.set(actuator, (each.low + each.high) / 2.0 * each.scale);
        }
        Ok(())
    }
}

fn middle(env: &Env) -> Vec<f64> {
    let space = env.action_space();
    space.low().iter().zip(space.high()).map(|(low, high)| (low + high) / 2.0).collect()
}

fn text(speeds: &[Speed]) -> String {
    let mut table =
        Table::new(["type", "engine, ms", "advance, ms", "env, ms", "advance/engine", "env/engine", "steps"]);
    for speed in speeds {
        table.row([
            speed.building.clone(),
            format!("{:.4}", speed.engine_ms),
            format!("{:.4}", speed.advance_ms),
            format!("{:.4}", speed.env_ms),
            format!("{:.3}", speed.advance_to_engine),
            format!("{:.3}", speed.env_to_engine),
            speed.steps.to_string(),
        ]);
    }
    table.text()
}
