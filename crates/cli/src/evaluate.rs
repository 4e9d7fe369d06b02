//! `b2b evaluate`: a policy on many buildings.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;

use anyhow::Result;
use b2b_benchmark::statistics::{Aggregate, Interval};
use b2b_benchmark::{
    ActionScale, Baselines, Episode, Evaluation, Folder, Group, Policy, Progress, Results, Subject, Summary,
};
use b2b_building::{BuildingType, RunPeriod};
use b2b_dataset::{BuildingName, Catalog};
use b2b_env::Task;
use b2b_env::vector::Launcher;
use indicatif::ProgressBar;

use crate::generate::{self, Part};
use crate::prepare::Location;
use crate::progress::{Download, counter};
use crate::table::Table;
use crate::{interrupt, run, stdout};

/// Evaluate a policy on many buildings, against the reactive controllers
///
/// Runs every building under every task, run period and seed, each episode in a process of its own, and writes
/// episodes.parquet (one row an episode), summary.json (what --json prints) and report.html (opens in any browser,
/// needs no network). Every episode is kept as it ends: the same command goes on where it was interrupted. A score is
/// the return over that of the reactive controllers for the same episode: lower is better, below 1 beats them. Exit
/// code 1 when an episode is lost.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Buildings: ids, types or model files [default: those of --split]
    #[arg(value_name = "BUILDING")]
    buildings: Vec<BuildingName>,
    /// Who acts: reactive, random, constant, planner, or an ONNX file
    #[arg(long, value_name = "POLICY")]
    policy: String,
    /// What the numbers of an ONNX policy mean
    #[arg(long, value_enum, default_value_t = Actions::Rescaled)]
    actions: Actions,
    /// Part of the dataset
    #[arg(long, value_enum, default_value = "test_small", conflicts_with = "buildings")]
    split: Part,
    /// Only buildings of these types
    #[arg(long = "type", value_name = "TYPE", num_args = 1.., conflicts_with = "buildings")]
    types: Vec<BuildingType>,
    #[command(flatten)]
    location: Location,
    /// What is asked: see `b2b run --help`
    #[arg(long = "task", value_name = "TASK", num_args = 1.., default_values = ["constant"], value_parser = run::task)]
    tasks: Vec<Task>,
    /// Days: winter, summer, full_year or MM-DD..MM-DD
    #[arg(long = "period", value_name = "DAYS", num_args = 1.., default_values_t = [RunPeriod::WINTER])]
    periods: Vec<RunPeriod>,
    /// Seeds of the policy, an episode each
    #[arg(long = "seed", value_name = "N", num_args = 1.., default_values_t = [0])]
    seeds: Vec<u64>,
    /// Zone time steps an hour
    #[arg(long, default_value_t = 12, value_name = "N")]
    steps_per_hour: u32,
    /// Episodes at a time [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    jobs: Option<u32>,
    /// Folder of the results
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Print one JSON object instead of a summary for people
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  b2b evaluate --policy reactive --out b2b-out/reactive          the 48 buildings of the small test, winter
  b2b evaluate --policy ppo.onnx --type OfficeSmall --task constant occupancy --period winter summer --out ppo
  b2b evaluate --policy random --seed 0 1 2 --split test --out random
  b2b evaluate --policy planner OfficeSmall-0042 --period 01-01..01-01 --out planner

An ONNX policy takes one float32 array [1, observation], the numbers as `b2b show BUILDING --observations` lists them
and without any scaling, and gives one [1, action]: -1 is the lowest and 1 the highest value of an actuator, or physical
units with --actions physical.";

/// What the numbers of an ONNX policy mean.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub enum Actions {
    /// From -1 to 1, for the lowest and the highest value of an actuator
    Rescaled,
    /// Physical units
    Physical,
}

impl Actions {
    /// For the crate that reads the file.
    pub fn scale(self) -> ActionScale {
        match self {
            Self::Rescaled => ActionScale::Rescaled,
            Self::Physical => ActionScale::Physical,
        }
    }
}

/// Runs the command.
pub fn evaluate(arguments: &Arguments) -> Result<ExitCode> {
    let policy = arguments.policy()?;
    let episodes = arguments.episodes();
    let folder = Folder::open(&arguments.out, policy.as_ref(), &episodes)?;
    let catalog = Catalog::open(&mut Download::new(arguments.json))?;
    fetch_weather(&episodes, arguments.json)?;
    let evaluation = evaluation(&catalog, arguments.jobs)?;
    let baselines = Baselines::open()?;
    let bars = Bars::new(arguments.json);
    let results = Results::of(&evaluation, &folder, &episodes, policy.as_ref(), &baselines, &bars)?;
    drop(bars);
    let summary = results.summary(policy.as_ref());
    let files = results.write(&folder, &summary)?;
    if arguments.json {
        stdout::print_json(&summary)?
    } else {
        stdout::print(&text(&summary, &files))?
    }
    Ok(if summary.lost.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

impl Arguments {
    fn policy(&self) -> Result<Box<dyn Policy>> {
        Ok(<dyn Policy>::named(&self.policy, self.actions.scale())?)
    }

    /// Building by building: what one was prepared for serves all its episodes.
    fn episodes(&self) -> Vec<Episode> {
        let mut episodes = Vec::new();
        for name in self.names() {
            let subject = Subject { name, placement: self.location.placement() };
            for period in &self.periods {
                for task in &self.tasks {
                    for seed in &self.seeds {
                        let (subject, task) = (subject.clone(), task.clone());
                        let (period, seed, steps_per_hour) = (*period, *seed, self.steps_per_hour);
                        let episode = Episode { subject, task, period, seed, steps_per_hour };
                        episodes.push(episode);
                    }
                }
            }
        }
        episodes
    }

    fn names(&self) -> Vec<BuildingName> {
        if !self.buildings.is_empty() {
            return self.buildings.clone();
        }
        names(self.split, &self.types)
    }
}

/// Buildings of a part of the dataset: all types, or these.
pub fn names(split: Part, types: &[BuildingType]) -> Vec<BuildingName> {
    let wanted = |row: &&b2b_dataset::Row| {
        split.has(row) && (types.is_empty() || types.contains(&row.id.building_type()))
    };
    b2b_dataset::all().filter(wanted).map(|row| BuildingName::Id(row.id)).collect()
}

/// Downloads first, so that they are seen and can be interrupted. A building of no dataset fetches its own later.
pub fn fetch_weather(episodes: &[Episode], quiet: bool) -> Result<()> {
    let of_dataset = |episode: &Episode| match episode.subject.name {
        BuildingName::Id(id) => Some(&b2b_dataset::row(id).building),
        BuildingName::Type(_) | BuildingName::Model(_) => None,
    };
    generate::fetch_weather(episodes.iter().filter_map(of_dataset), quiet)
}

/// How episodes are run by this program.
pub fn evaluation(catalog: &Catalog, jobs: Option<u32>) -> Result<Evaluation<'_>> {
    let jobs = match jobs {
        Some(jobs) => jobs as usize,
        None => std::thread::available_parallelism()?.get(),
    };
    let launcher = Launcher::this_program()?;
    Ok(Evaluation { catalog, launcher, jobs, interrupted: interrupt::requested })
}

/// A bar of simulated days for each stage.
pub struct Bars {
    quiet: bool,
    bar: Mutex<ProgressBar>,
}

impl Bars {
    /// Shows nothing when `quiet`.
    pub fn new(quiet: bool) -> Self {
        Self { quiet, bar: Mutex::new(ProgressBar::hidden()) }
    }

    fn with(&self, what: impl FnOnce(&mut ProgressBar)) {
        what(&mut self.bar.lock().unwrap_or_else(std::sync::PoisonError::into_inner));
    }
}

impl Progress for Bars {
    fn begin(&self, what: &str, episodes: usize, days: u64) {
        self.with(|bar| {
            bar.finish_and_clear();
            if episodes > 0 {
                *bar = counter(days as usize, &format!("simulated days of {episodes} {what}"), self.quiet);
            }
        });
    }

    fn day(&self) {
        self.with(|bar| bar.inc(1));
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        self.with(|bar| bar.finish_and_clear());
    }
}

/// For people.
fn text(summary: &Summary, files: &[PathBuf]) -> String {
    let mut text = String::new();
    for window in &summary.windows {
        let groups = || window.types.iter().chain((window.types.len() > 1).then_some(&window.all));
        let episodes: usize = groups().take(window.types.len()).map(Group::episodes).sum();
        text += &format!(
            "{} on {episodes} episodes, {}, task {}: normalised scores, lower is better, 1 is the reactive controllers\n\n",
            summary.policy, window.period, window.task
        );
        text += &table(groups());
        text += "\n\n  in brackets: 95 % intervals of a bootstrap over episodes, stratified by type\n\n";
    }
    for lost in &summary.lost {
        text += &format!("lost: {lost}\n");
    }
    if !summary.lost.is_empty() {
        text += "  the same command runs them once more\n\n";
    }
    let files: Vec<_> = files.iter().map(|file| format!("  {}", file.display())).collect();
    text + &files.join("\n")
}

fn table<'a>(groups: impl Iterator<Item = &'a Group>) -> String {
    let mut table = Table::new([
        "type",
        "episodes",
        "interquartile mean",
        "median",
        "mean",
        "beat 1",
        "RMS, K",
        "kWh/m²",
        "travel/d",
    ]);
    for group in groups {
        let interval = |of: fn(&Aggregate) -> Interval| {
            group.scores.as_ref().map(of).map_or("–".into(), |value| value.to_string())
        };
        let beats = group.scores.as_ref().map(Aggregate::beats_baseline_percent);
        table.row([
            group.name.clone(),
            group.episodes().to_string(),
            interval(|scores| scores.interquartile_mean),
            interval(|scores| scores.median),
            interval(|scores| scores.mean),
            beats.map_or("–".into(), |share| format!("{share:.0} %")),
            format!("{:.2}", group.rms_deviation_k),
            format!("{:.2}", group.energy_wh_m2 / 1000.0),
            format!("{:.1}", group.daily_travel),
        ]);
    }
    table.text()
}
