//! `b2b bench speed`: the cost of a step, and the engine's share of it.

use anyhow::{Result, bail};
use b2b_building::hvac::{Actuator, Quantity};
use b2b_building::{BuildingType, Date, RunPeriod};
use b2b_dataset::BuildingName;
use b2b_energyplus::{Event, Run, Simulation};
use b2b_env::{Band, Env, Task};
use cpu_time::ProcessTime;
use serde::Serialize;
use tempfile::TempDir;

use super::statistics::{mean_and_deviation, median};
use crate::arguments::location::Location;
use crate::program::prepare::Prepared;
use crate::terminal::table::Table;
use crate::terminal::{interrupt, stdout};

/// Measure the CPU time of a step: bare engine, engine suspended at every step, whole environment of two tasks
///
/// Four runs of the same model, with every actuator held at the middle of its range, alternate in one process: one
/// simulated day each, in changing order, so that other load affects all alike. Times and ratios are medians
/// over the days. The first two days, which warm-up still affects, are excluded.
#[derive(clap::Args)]
#[command(after_help = "\
Columns, CPU time per step in milliseconds:
  engine     EnergyPlus simulates the day without being suspended
  advance    EnergyPlus is suspended at the end of every step, nothing is read (Simulation::advance)
  env        action, step, observation and reward (Env::step) of a tracking task, `constant`
  operation  the same of a task of operation, `operate`
  mean, standard deviation: of 10,000 single steps of the environment, in a separate episode

Examples:
  b2b bench speed
  b2b bench speed --type OfficeSmall --type Warehouse --days 60 --json")]
pub struct Arguments {
    /// Building types, or buildings of the dataset such as OfficeSmall-0042 [default: every type]
    #[arg(long = "type", value_name = "BUILDING", num_args = 1..)]
    buildings: Vec<BuildingName>,
    /// Number of simulated days, from 1 January
    #[arg(long, default_value_t = DAYS, value_parser = clap::value_parser!(u32).range(4..=365))]
    days: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Number of simulated days by default.
const DAYS: u32 = 16;
const STEPS_PER_HOUR: u32 = 12;
const STEPS_PER_DAY: u32 = 24 * STEPS_PER_HOUR;
/// Number of days that are excluded.
const FIRST_DAYS: u32 = 2;
/// Number of steps that are measured one by one, as in the paper.
const SINGLE_STEPS: u32 = 10_000;
/// Number of ways to run the model.
const MODES: usize = 4;

/// CPU time of a step of one building, ms, and its ratios to the bare engine; medians over the days.
#[derive(Serialize)]
struct StepCost {
    #[serde(rename = "type")]
    building: String,
    engine_ms: f64,
    advance_ms: f64,
    env_ms: f64,
    operation_ms: f64,
    advance_to_engine: f64,
    env_to_engine: f64,
    operation_to_env: f64,
    steps: u32,
    /// Mean and standard deviation of single steps of the environment.
    env_mean_ms: f64,
    env_deviation_ms: f64,
}

/// Runs the command.
pub fn bench(arguments: &Arguments) -> Result<()> {
    let types = BuildingType::ALL.map(BuildingName::Type);
    let buildings = if arguments.buildings.is_empty() { &types[..] } else { &arguments.buildings };
    let speeds = speeds(buildings, arguments.days, arguments.json)?;
    if arguments.json { stdout::print_json(&speeds) } else { stdout::print(&text(&speeds)) }
}

/// Returns what the command prints with `--json` for buildings of some types.
pub(crate) fn speed_json(types: &[String]) -> Result<String> {
    let buildings = types.iter().map(|name| Ok(name.parse()?)).collect::<Result<Vec<_>>>()?;
    Ok(serde_json::to_string_pretty(&speeds(&buildings, DAYS, true)?)?)
}

fn speeds(buildings: &[BuildingName], days: u32, quiet: bool) -> Result<Vec<StepCost>> {
    buildings.iter().map(|building| speed(building, days, quiet)).collect()
}

fn speed(building: &BuildingName, simulated: u32, quiet: bool) -> Result<StepCost> {
    let prepared = Prepared::new(building, &Location::default(), quiet)?;
    let mut days = Vec::new();
    for first in 0..MODES {
        let mut runs = Runs::start(&prepared, simulated, first)?;
        for day in 0..simulated {
            interrupt::check()?;
            let ms = runs.one_day_each(day as usize)?;
            if day >= FIRST_DAYS {
                days.push(ms);
            }
        }
    }
    let (env_mean_ms, env_deviation_ms) = mean_and_deviation(&single_steps(&prepared)?);
    let of_days = |value: fn(&[f64; MODES]) -> f64| median(days.iter().map(value).collect());
    Ok(StepCost {
        building: building.to_string(),
        engine_ms: of_days(|ms| ms[0]),
        advance_ms: of_days(|ms| ms[1]),
        env_ms: of_days(|ms| ms[2]),
        operation_ms: of_days(|ms| ms[3]),
        advance_to_engine: of_days(|ms| ms[1] / ms[0]),
        env_to_engine: of_days(|ms| ms[2] / ms[0]),
        operation_to_env: of_days(|ms| ms[3] / ms[2]),
        steps: MODES as u32 * (simulated - FIRST_DAYS) * STEPS_PER_DAY,
        env_mean_ms,
        env_deviation_ms,
    })
}

/// Returns the CPU time of each of [`SINGLE_STEPS`] steps of an environment, ms.
fn single_steps(prepared: &Prepared) -> Result<Vec<f64>> {
    let days = FIRST_DAYS + SINGLE_STEPS.div_ceil(STEPS_PER_DAY);
    let period = RunPeriod::new(Date::of_day(1), Date::of_day(days));
    let mut env = prepared.env(period, STEPS_PER_HOUR, Task::default())?;
    env.reset()?;
    let action = env.action_space().middle();
    let mut times = Vec::with_capacity(SINGLE_STEPS as usize);
    for step in 0..FIRST_DAYS * STEPS_PER_DAY + SINGLE_STEPS {
        let start = ProcessTime::now();
        env.step(&action)?;
        if step >= FIRST_DAYS * STEPS_PER_DAY {
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
        if step % STEPS_PER_DAY == 0 {
            interrupt::check()?;
        }
    }
    Ok(times)
}

/// One building, run in all modes at once, in the order of the table's columns.
struct Runs {
    modes: [Mode; MODES],
    /// Holds the model file.
    _folder: TempDir,
}

enum Mode {
    /// Stops once a day.
    Engine(Simulation),
    /// Stops at every step.
    Advance(Simulation),
    /// The environment, with its action.
    Env(Box<Env>, Vec<f64>),
}

impl Runs {
    /// Starts the runs, up to the end of warm-up, one after another beginning with `first`: a run that reuses
    /// memory freed by others is slower, so each mode is first once.
    fn start(prepared: &Prepared, days: u32, first: usize) -> Result<Self> {
        let period = RunPeriod::new(Date::of_day(1), Date::of_day(days));
        let folder = b2b_base::scratch::temporary_folder("b2b-bench-")?;
        let model = folder.path().join("model.epJSON");
        std::fs::write(&model, prepared.building.model_for(period, STEPS_PER_HOUR).to_epjson())?;
        let run = |every| warmed_up(prepared, Run::new(&model, &prepared.weather).stop_every(every));
        let start = |mode| -> Result<Mode> {
            Ok(match mode {
                0 => Mode::Engine(run(STEPS_PER_DAY)?),
                1 => Mode::Advance(run(1)?),
                _ => {
                    let task = if mode == 2 { Task::default() } else { Task::operate(Band::Own) };
                    let mut env = prepared.env(period, STEPS_PER_HOUR, task)?;
                    env.reset()?;
                    let action = env.action_space().middle();
                    Mode::Env(Box::new(env), action)
                }
            })
        };
        let [a, b, c, d] = std::array::from_fn(|turn| start((first + turn) % MODES));
        let mut modes = [a?, b?, c?, d?];
        modes.rotate_right(first);
        Ok(Self { modes, _folder: folder })
    }

    /// Simulates one day in each mode, in an order that changes daily. Returns the CPU times of a step, ms.
    fn one_day_each(&mut self, day: usize) -> Result<[f64; MODES]> {
        let mut ms = [0.0; MODES];
        for turn in 0..MODES {
            let mode = (day + turn) % MODES;
            let start = ProcessTime::now();
            self.modes[mode].one_day()?;
            ms[mode] = start.elapsed().as_secs_f64() * 1e3 / f64::from(STEPS_PER_DAY);
        }
        Ok(ms)
    }
}

impl Mode {
    fn one_day(&mut self) -> Result<()> {
        match self {
            Mode::Engine(simulation) => step(simulation),
            Mode::Advance(simulation) => (0..STEPS_PER_DAY).try_for_each(|_| step(simulation)),
            Mode::Env(env, action) => (0..STEPS_PER_DAY).try_for_each(|_| Ok(env.step(action).map(drop)?)),
        }
    }
}

fn step(simulation: &mut Simulation) -> Result<()> {
    match simulation.advance()? {
        Some(Event::Step) => Ok(()),
        other => bail!("the engine is at {other:?}, expected the end of a step"),
    }
}

/// Returns a run at the end of warm-up, with every actuator at the middle of its bounds.
fn warmed_up(prepared: &Prepared, run: Run) -> Result<Simulation> {
    let mut simulation = run.start(&prepared.library)?;
    // The engine uses a damper's first value as its minimum opening, which is 0 in the prepared model.
    hold_middle(prepared, &mut simulation, |actuator| actuator.quantity != Quantity::DamperOpening)?;
    match simulation.advance()? {
        Some(Event::WarmedUp) => {}
        other => bail!("the engine is at {other:?}, expected the end of warm-up"),
    }
    hold_middle(prepared, &mut simulation, |_| true)?;
    Ok(simulation)
}

fn hold_middle(
    prepared: &Prepared,
    simulation: &mut Simulation,
    which: impl Fn(&Actuator) -> bool,
) -> Result<()> {
    for each in prepared.building.actuators().filter(|actuator| which(actuator)) {
        let actuator = simulation.actuator(&each.component, &each.control, &each.key)?;
        simulation.set(actuator, (each.low + each.high) / 2.0 * each.scale);
    }
    Ok(())
}

fn text(speeds: &[StepCost]) -> String {
    let mut table = Table::new([
        "building",
        "engine (ms)",
        "advance (ms)",
        "env (ms)",
        "operation (ms)",
        "advance/engine",
        "env/engine",
        "operation/env",
        "steps",
        "mean of a step (ms)",
        "standard deviation (ms)",
    ]);
    for speed in speeds {
        table.row([
            speed.building.clone(),
            format!("{:.4}", speed.engine_ms),
            format!("{:.4}", speed.advance_ms),
            format!("{:.4}", speed.env_ms),
            format!("{:.4}", speed.operation_ms),
            format!("{:.3}", speed.advance_to_engine),
            format!("{:.3}", speed.env_to_engine),
            format!("{:.3}", speed.operation_to_env),
            speed.steps.to_string(),
            format!("{:.4}", speed.env_mean_ms),
            format!("{:.4}", speed.env_deviation_ms),
        ]);
    }
    table.text()
}
