//! `b2b run`: one episode, summed up, drawn and kept.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use b2b_building::{Date, RunPeriod};
use b2b_control::Controller;
use b2b_dataset::BuildingName;
use b2b_env::{Env, Task, Trajectory};
use cpu_time::ProcessTime;

use crate::controller::{Kind, Parameters};
use crate::output_folder::OutputFolder;
use crate::prepare::{Location, Prepared};
use crate::progress::{Days, date_text};
use crate::summary::{About, Summary};
use crate::{interrupt, picture, stdout, trajectory_file};

/// Run one episode and show what came of it
///
/// Prints a summary and writes three files: trajectory.parquet (one row a step), summary.json
/// (what --json prints) and picture.html (opens in any browser, needs no network).
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Building type (`b2b list`), building of the dataset such as OfficeSmall-0042, or model file (.idf, .epJSON)
    #[arg(value_name = "BUILDING")]
    building: BuildingName,
    #[command(flatten)]
    location: Location,
    /// Days: winter, summer, full_year or MM-DD..MM-DD, both included
    #[arg(long, default_value_t = RunPeriod::WINTER, value_name = "DAYS")]
    period: RunPeriod,
    /// Only the first so many hours of it, whole days
    #[arg(long, value_name = "N")]
    hours: Option<u32>,
    /// Who acts
    #[arg(long, value_enum, default_value_t = Kind::Reactive)]
    controller: Kind,
    /// Parameters of the reactive controller: default, tuned (to the building's type and climate zone), or a JSON file
    #[arg(long, default_value = "tuned", value_name = "WHICH")]
    parameters: Parameters,
    /// Seed of the random controller
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Zone time steps an hour, each one step of the environment
    #[arg(long, default_value_t = 12, value_name = "N")]
    steps_per_hour: u32,
    /// What is asked: constant, occupancy or random, with +energyW for a weight W of energy; or a JSON file
    #[arg(long, default_value = "constant", value_name = "TASK", value_parser = task)]
    task: Task,
    /// Folder for the files [default: b2b-out/BUILDING-PLACE-DAYS-CONTROLLER, and -TASK]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print one JSON object instead of a summary for people
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  b2b run OfficeSmall
  b2b run OfficeSmall-0042 --period summer
  b2b run Warehouse --place Miami --period summer --task constant:23
  b2b run OfficeSmall --task occupancy+energy0.5
  b2b run OfficeSmall --task random:7             targets drawn for every zone and day, by seed 7
  b2b run OfficeSmall --task occupancy+pmv+cost2  thermal sensation against 2 times the bill
  b2b run OfficeSmall --task mine.json            any numbers: --json prints the task of a run
  b2b run RestaurantFastFood --period 01-01..01-07 --controller random --seed 7
  b2b run OfficeSmall --controller planner --hours 24
  b2b run RetailStandalone --weather my.epw --json > result.json
  b2b run my.idf --weather my.epw          a building of yours: see `b2b import --help`

Tasks: the paper's are constant, occupancy and random, each with and without +energy0.5.
  setpoints  constant (21 °C), constant:C, occupancy (21 °C with people in the zone; without, 18 °C
             December to February and 26 °C June to August), random, random:SEED
  comfort    squared deviation from target; +deadband, +deadbandK: outside 1 K, or K; +pmv: the predicted
             mean vote of ISO 7730
  saving     +energyW, +costW, +carbonW, +peakW: W times what a step uses, costs, emits, or adds to the peak

The same arguments give the same episode, bit for bit: compare trajectory_hash.";

/// A task by its spelling, or from a JSON file.
pub fn task(text: &str) -> b2b_env::Result<Task> {
    let path = Path::new(text);
    if path.extension().is_some_and(|extension| extension == "json") {
        Task::read(path)
    } else {
        text.parse()
    }
}

/// An episode that ran to its end.
pub struct Rollout {
    /// Every step.
    pub trajectory: Trajectory,
    /// The controlled zones in which nobody ever is.
    pub never_occupied: Vec<String>,
    /// CPU time within `Env::reset` and `Env::step`: the engine, and what the environment adds to it.
    pub env_cpu: Duration,
    /// Time on the clock, from the first step to the last.
    pub wall: Duration,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let prepared = Prepared::new(&arguments.building, &arguments.location, arguments.json)?;
    let period = arguments.days()?;
    let mut env = prepared.env(period, arguments.steps_per_hour, arguments.task.clone())?;
    let folder = OutputFolder::stage(&arguments.folder(&prepared.place, period))?;
    let mut controller =
        arguments.controller.build(&prepared, &env, &arguments.parameters, arguments.seed, arguments.json)?;
    let rollout = roll_out(&mut env, controller.as_mut(), arguments.json)?;

    let about = About {
        place: prepared.place,
        controller: arguments.controller.name(),
        seed: arguments.seed,
        files: folder.destinations(&[trajectory_file::NAME, Summary::NAME, picture::NAME]),
    };
    let summary = Summary::of(&env, &rollout, about)?;
    folder.write(trajectory_file::NAME, |file| {
        trajectory_file::write(file, &env, &rollout.trajectory, &summary)
    })?;
    folder.write(picture::NAME, |file| picture::write(file, &env, &rollout.trajectory, &summary))?;
    folder.write(Summary::NAME, |file| Ok(serde_json::to_writer_pretty(file, &summary)?))?;
    interrupt::check()?;
    folder.keep()?;
    if arguments.json { stdout::print_json(&summary) } else { stdout::print(&summary.text()) }
}

impl Arguments {
    /// The days that are run.
    fn days(&self) -> Result<RunPeriod> {
        let Some(hours) = self.hours else { return Ok(self.period) };
        let (days, whole) = (hours / 24, self.period.days());
        if hours % 24 != 0 || days == 0 || days > whole {
            bail!("--hours {hours}: give a multiple of 24, up to {} for {}", whole * 24, self.period);
        }
        let first = self.period.first();
        Ok(RunPeriod::new(first, Date::of_day(first.day_of_year() + days - 1))?)
    }

    fn folder(&self, place: &str, period: RunPeriod) -> PathBuf {
        self.out.clone().unwrap_or_else(|| {
            let place = place.replace(' ', "_");
            let mut name = format!("{}-{place}-{period}-{}", self.building, self.controller.name());
            if self.task != Task::default() {
                name += &format!("-{}", self.task).replace([':', '#'], "_");
            }
            PathBuf::from("b2b-out").join(name)
        })
    }
}

/// Runs an episode to its end, or to an interrupt.
pub fn roll_out(env: &mut Env, controller: &mut dyn Controller, quiet: bool) -> Result<Rollout> {
    let days = Days::new(env.episode().period, env.episode().steps_per_hour, quiet);
    let mut trajectory = Trajectory::for_episode(env.spaces());
    let mut action = vec![0.0; env.action_space().len()];
    let mut env_cpu = Duration::ZERO;
    controller.reset();
    let before = ProcessTime::now();
    env.reset()?;
    env_cpu += before.elapsed();
    let never_occupied = env.never_occupied().map(str::to_owned).collect();
    let mut observation = env.observation();
    days.start();
    let start = Instant::now();
    loop {
        if interrupt::requested() {
            let steps = trajectory.len();
            bail!("interrupted after {steps} steps ({})", date_text(days.date(steps)));
        }
        controller.act(observation, &mut action);
        let before = ProcessTime::now();
        let step = env.step(&action)?;
        env_cpu += before.elapsed();
        trajectory.push(&step);
        days.step(trajectory.len());
        if step.truncated {
            return Ok(Rollout { trajectory, never_occupied, env_cpu, wall: start.elapsed() });
        }
        observation = step.observation;
    }
}
