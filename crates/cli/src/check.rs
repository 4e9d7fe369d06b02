//! `b2b check`: whether buildings of the dataset can be sized, run and held.

use std::process::ExitCode;

use anyhow::{Context, Result};
use b2b_building::{Conditioning, PreparedBuilding, RunPeriod};
use b2b_dataset::{BuildingId, BuildingName};
use b2b_energyplus::Level;
use b2b_env::{Env, Task, Trajectory};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::controller::{Parameters, reactive};
use crate::generate::Part;
use crate::prepare::{Location, Prepared};
use crate::progress::counter;
use crate::run::roll_out;
use crate::table::Table;
use crate::{child, interrupt, stdout};

/// Size and run buildings of the dataset, and tell which fail
///
/// Each is sized and runs, by default, a winter week and a summer week under the reactive controller with its
/// default parameters. It fails when EnergyPlus stops or has a severe message, when a zone with heating is
/// under 12 °C, or when a zone with cooling is over 32 °C. Exit code 1 when one fails.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b check                            the 48 buildings of the small test
  b2b check --split test --jobs 8
  b2b check --split all --period 01-15..01-15    one day of all 6,000: hours
  b2b check OfficeSmall-0042 Warehouse-0007 --json")]
pub struct Arguments {
    /// Buildings [default: those of --split]
    #[arg(value_name = "ID")]
    ids: Vec<BuildingId>,
    /// Part of the dataset
    #[arg(long, value_enum, default_value = "test_small", conflicts_with = "ids")]
    split: Part,
    /// Days that each runs: can be given more than once
    #[arg(long = "period", value_name = "DAYS", default_values = WEEKS)]
    periods: Vec<RunPeriod>,
    /// Buildings at a time, each in a process of its own [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    jobs: Option<u32>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Check one building in this process, and print its episodes as JSON
    #[arg(long, hide = true, value_name = "ID", conflicts_with_all = ["ids", "split", "jobs"])]
    one: Option<BuildingId>,
}

/// What is run by default: a winter week and a summer week.
const WEEKS: [&str; 2] = ["01-08..01-14", "07-08..07-14"];
const STEPS_PER_HOUR: u32 = 12;
/// No zone with heating is colder, °C.
const COLDEST: f64 = 12.0;
/// No zone with cooling is warmer, °C.
const WARMEST: f64 = 32.0;

/// What became of a building.
#[derive(Serialize)]
struct Report {
    id: String,
    place: String,
    /// Why it could not be run.
    error: Option<String>,
    episodes: Vec<Outcome>,
    passed: bool,
}

/// What became of an episode.
#[derive(Serialize, Deserialize)]
struct Outcome {
    period: String,
    severes: usize,
    /// First severe message.
    severe_message: Option<String>,
    rms_deviation_k: f64,
    /// HVAC electricity over the period.
    electricity_kwh_per_m2: f64,
    /// HVAC gas over the period.
    gas_kwh_per_m2: f64,
    coldest: Extreme,
    /// Of the zones with cooling.
    warmest: Extreme,
}

/// The coldest or the warmest of some zones.
#[derive(Serialize, Deserialize)]
struct Extreme {
    zone: String,
    temperature_c: f64,
}

/// Runs the command.
pub fn check(arguments: &Arguments) -> Result<ExitCode> {
    if let Some(id) = arguments.one {
        stdout::print(&serde_json::to_string(&episodes(id, &arguments.periods)?)?)?;
        return Ok(ExitCode::SUCCESS);
    }
    let reports = arguments.reports()?;
    if arguments.json {
        stdout::print_json(&reports)?
    } else {
        stdout::print(&text(&reports))?
    }
    let passed = reports.iter().all(|report| report.passed);
    Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

impl Arguments {
    /// One process a building: the engine runs once at a time in a process.
    fn reports(&self) -> Result<Vec<Report>> {
        let ids = self.ids();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.jobs.unwrap_or(0) as usize).build()?;
        let bar = counter(ids.len(), "buildings", self.json);
        let reports = pool.install(|| {
            ids.par_iter()
                .map(|id| {
                    let report = Report::of(*id, &self.periods);
                    bar.inc(1);
                    report
                })
                .collect()
        });
        bar.finish_and_clear();
        reports
    }

    fn ids(&self) -> Vec<BuildingId> {
        if !self.ids.is_empty() {
            return self.ids.clone();
        }
        b2b_dataset::all().filter(|row| self.split.has(row)).map(|row| row.id).collect()
    }
}

impl Report {
    /// An error only when the user interrupts, or when no process can be started.
    fn of(id: BuildingId, periods: &[RunPeriod]) -> Result<Self> {
        interrupt::check()?;
        let outcome = run_in_process(id, periods)?;
        let place = b2b_dataset::row(id).building.place().to_owned();
        let (episodes, error) = match outcome {
            Ok(episodes) => (episodes, None),
            Err(error) => (Vec::new(), Some(error)),
        };
        let passed = error.is_none() && episodes.iter().all(Outcome::passed);
        Ok(Self { id: id.to_string(), place, error, episodes, passed })
    }
}

impl Outcome {
    fn of(env: &Env, trajectory: &Trajectory) -> Result<Self> {
        let building = env.building();
        let severe = env.messages().at_least(Level::Severe).next().map(|message| message.text.clone());
        let coldest = |a: &f64, b: &f64| a.total_cmp(b);
        let warmest = |a: &f64, b: &f64| b.total_cmp(a);
        let heated = |conditioning| conditioning != Conditioning::None;
        let cooled = |conditioning| conditioning == Conditioning::HeatingAndCooling;
        Ok(Self {
            period: env.episode().period.to_string(),
            severes: env.message_count(Level::Severe),
            severe_message: severe,
            rms_deviation_k: env.metrics().rms_deviation(),
            electricity_kwh_per_m2: env.metrics().electricity / 1000.0,
            gas_kwh_per_m2: env.metrics().gas / 1000.0,
            coldest: extreme(building, trajectory, heated, coldest)?,
            warmest: extreme(building, trajectory, cooled, warmest)?,
        })
    }

    fn passed(&self) -> bool {
        let held = self.coldest.temperature_c >= COLDEST && self.warmest.temperature_c <= WARMEST;
        self.severes == 0 && held
    }
}

/// The first in order among the temperatures of some zones. Observations begin with the zones.
fn extreme(
    building: &PreparedBuilding,
    trajectory: &Trajectory,
    of: impl Fn(Conditioning) -> bool,
    order: impl Fn(&f64, &f64) -> std::cmp::Ordering,
) -> Result<Extreme> {
    let zones = building.zones.iter().enumerate().filter(|(_, zone)| of(zone.conditioning));
    let extremes =
        zones.filter_map(|(slot, zone)| Some((trajectory.observed(slot).min_by(&order)?, zone.name.clone())));
    let (temperature_c, zone) =
        extremes.min_by(|a, b| order(&a.0, &b.0)).context("no zone has such equipment")?;
    Ok(Extreme { zone, temperature_c })
}

/// Sizes a building and runs its episodes here.
fn episodes(id: BuildingId, periods: &[RunPeriod]) -> Result<Vec<Outcome>> {
    let prepared = Prepared::new(&BuildingName::Id(id), &Location::default(), true)?;
    periods.iter().map(|period| run_episode(&prepared, *period)).collect()
}

fn run_episode(prepared: &Prepared, period: RunPeriod) -> Result<Outcome> {
    let mut env = prepared.env(period, STEPS_PER_HOUR, Task::default())?;
    let mut controller = reactive(&env, &Parameters::Default)?;
    let rollout = roll_out(&mut env, &mut controller, true)?;
    Outcome::of(&env, &rollout.trajectory)
}

/// The episodes of a building in a process of its own, or what that process said when it failed.
fn run_in_process(id: BuildingId, periods: &[RunPeriod]) -> Result<Result<Vec<Outcome>, String>> {
    let arguments = ["check".to_owned(), "--one".to_owned(), id.to_string()];
    let periods = periods.iter().map(|period| format!("--period={period}"));
    match child::run(arguments.into_iter().chain(periods))? {
        Ok(text) => Ok(Ok(serde_json::from_str(&text)?)),
        Err(complaint) => Ok(Err(complaint)),
    }
}

fn text(reports: &[Report]) -> String {
    let mut table = Table::new([
        "building",
        "place",
        "days",
        "coldest, °C",
        "warmest, °C",
        "RMS, K",
        "electricity, kWh/m²",
        "gas, kWh/m²",
        "severe",
        "",
    ]);
    for report in reports {
        for episode in &report.episodes {
            table.row([
                report.id.clone(),
                report.place.clone(),
                episode.period.clone(),
                format!("{:.1}", episode.coldest.temperature_c),
                format!("{:.1}", episode.warmest.temperature_c),
                format!("{:.2}", episode.rms_deviation_k),
                format!("{:.2}", episode.electricity_kwh_per_m2),
                format!("{:.2}", episode.gas_kwh_per_m2),
                episode.severes.to_string(),
                if episode.passed() { "" } else { "failed" }.into(),
            ]);
        }
    }
    let failed: Vec<_> = reports.iter().filter(|report| !report.passed).collect();
    let why: String = failed.iter().map(|report| format!("\n{}", why(report))).collect();
    format!("{}\n\n{} buildings, {} failed{why}", table.text(), reports.len(), failed.len())
}

/// One line on a building that failed.
fn why(report: &Report) -> String {
    let mut reasons: Vec<String> = report.error.iter().cloned().collect();
    for episode in report.episodes.iter().filter(|episode| !episode.passed()) {
        let Outcome { period, coldest, warmest, severe_message, .. } = episode;
        if coldest.temperature_c < COLDEST {
            reasons.push(format!("{period}: {} is at {:.1} °C", coldest.zone, coldest.temperature_c));
        }
        if warmest.temperature_c > WARMEST {
            reasons.push(format!("{period}: {} is at {:.1} °C", warmest.zone, warmest.temperature_c));
        }
        reasons.extend(severe_message.iter().map(|message| format!("{period}: {message}")));
    }
    format!("  {} in {}: {}", report.id, report.place, reasons.join("; "))
}
