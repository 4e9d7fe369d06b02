//! `b2b check`: sizing and simulation of dataset buildings.

use anyhow::{Context, Result};
use b2b_base::parallel;
use b2b_building::{Conditioning, PreparedBuilding, RunPeriod};
use b2b_dataset::{BuildingId, BuildingName, Catalog};
use b2b_env::{Spaces, Task, Term, Trajectory};
use serde::Serialize;

use crate::arguments::buildings::DatasetBuildings;
use crate::arguments::controller::{Parameters, reactive};
use crate::arguments::jobs::Jobs;
use crate::arguments::location::Location;
use crate::program::prepare::Prepared;
use crate::rollout::Rollout;
use crate::terminal::exit_code::ExitCode;
use crate::terminal::progress::{Download, counter};
use crate::terminal::table::Table;
use crate::terminal::{interrupt, stdout};
use crate::{program, with_causes};

/// Size and simulate dataset buildings and report failures
///
/// Runs each building under the reactive controller with its default parameters, by default for a winter week and a
/// summer week. A building fails if EnergyPlus stops or reports a severe error, if a heated zone falls below 12 °C, or
/// if a cooled zone rises above 32 °C. Exits with code 1 if any building fails.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b check                                      the 48 buildings of test_small
  b2b check --split test --jobs 8
  b2b check --split all --period 01-15..01-15    one day in all 6,000 buildings; takes hours
  b2b check OfficeSmall-0042 Warehouse-0007 --json"
)]
pub struct Arguments {
    #[command(flatten)]
    buildings: DatasetBuildings,
    /// Run period; repeat the option for several
    #[arg(long = "period", value_name = "PERIOD", default_values = WEEKS)]
    periods: Vec<RunPeriod>,
    #[command(flatten)]
    jobs: Jobs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The default run periods: a winter week and a summer week.
const WEEKS: [&str; 2] = ["01-08..01-14", "07-08..07-14"];
const STEPS_PER_HOUR: u32 = 12;
/// Lowest temperature allowed in a heated zone, °C.
const MIN_TEMPERATURE: f64 = 12.0;
/// Highest temperature allowed in a cooled zone, °C.
const MAX_TEMPERATURE: f64 = 32.0;

/// The result of a building.
#[derive(Serialize)]
struct Report {
    id: String,
    place: String,
    /// Error that prevented the simulation.
    error: Option<String>,
    episodes: Vec<Outcome>,
    passed: bool,
}

/// The result of an episode.
#[derive(Serialize)]
struct Outcome {
    period: String,
    severes: usize,
    /// The first severe message.
    severe_message: Option<String>,
    rms_deviation_k: f64,
    /// HVAC electricity over the run period.
    electricity_kwh_per_m2: f64,
    /// Non-electric HVAC energy over the run period.
    gas_kwh_per_m2: f64,
    /// Minimum over the heated zones.
    coldest: Extreme,
    /// Maximum over the cooled zones.
    warmest: Extreme,
}

/// An extreme temperature and the zone where it occurred.
#[derive(Serialize)]
struct Extreme {
    zone: String,
    temperature_c: f64,
}

/// Runs the command.
pub fn check(arguments: &Arguments) -> Result<ExitCode> {
    let reports = arguments.reports()?;
    stdout::print_result(arguments.json, &reports, || text(&reports))?;
    let passed = reports.iter().all(|report| report.passed);
    Ok(ExitCode::of(passed))
}

impl Arguments {
    /// Checks the buildings, each in its own worker processes.
    fn reports(&self) -> Result<Vec<Report>> {
        let ids = self.buildings.ids()?;
        let catalog = program::catalog(&mut Download::new(self.json))?;
        let bar = counter(ids.len(), "buildings", self.json);
        let reports = parallel::map(self.jobs.count()?, &ids, |id| {
            let report = Report::of(&catalog, *id, &self.periods);
            bar.inc(1);
            report
        });
        bar.finish_and_clear();
        reports
    }
}

impl Report {
    /// Checks a building. Errors only if the user interrupts.
    fn of(catalog: &Catalog, id: BuildingId, periods: &[RunPeriod]) -> Result<Self> {
        interrupt::check()?;
        let outcome = episodes(catalog, id, periods);
        interrupt::check()?;
        let place = b2b_dataset::row(id).building.place().to_owned();
        let (episodes, error) = match outcome {
            Ok(episodes) => (episodes, None),
            Err(error) => (Vec::new(), Some(with_causes(&error))),
        };
        let passed = error.is_none() && episodes.iter().all(Outcome::passed);
        Ok(Self { id: id.to_string(), place, error, episodes, passed })
    }
}

impl Outcome {
    fn of(spaces: &Spaces, rollout: Rollout) -> Result<Self> {
        let (building, Rollout { metrics, engine, trajectory, .. }) = (&spaces.building, &rollout);
        let coldest = |a: &f64, b: &f64| a.total_cmp(b);
        let warmest = |a: &f64, b: &f64| b.total_cmp(a);
        let heated = |conditioning| conditioning != Conditioning::None;
        let cooled = |conditioning| conditioning == Conditioning::HeatingAndCooling;
        Ok(Self {
            period: spaces.episode.period.to_string(),
            severes: engine.severes,
            severe_message: engine.severe_messages.first().cloned(),
            rms_deviation_k: metrics.rms_deviation(),
            electricity_kwh_per_m2: metrics.total(Term::Electricity) / 1000.0,
            gas_kwh_per_m2: metrics.total(Term::Gas) / 1000.0,
            coldest: extreme(building, trajectory, heated, coldest)?,
            warmest: extreme(building, trajectory, cooled, warmest)?,
        })
    }

    fn passed(&self) -> bool {
        let held =
            self.coldest.temperature_c >= MIN_TEMPERATURE && self.warmest.temperature_c <= MAX_TEMPERATURE;
        self.severes == 0 && held
    }
}

/// Returns the temperature that is first by `order`, over all steps and the zones whose conditioning matches `of`.
/// Observations begin with the zone temperatures.
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
        extremes.min_by(|a, b| order(&a.0, &b.0)).context("no zone has this equipment")?;
    Ok(Extreme { zone, temperature_c })
}

/// Sizes a building and runs its episodes.
fn episodes(catalog: &Catalog, id: BuildingId, periods: &[RunPeriod]) -> Result<Vec<Outcome>> {
    let prepared = Prepared::of(catalog, &BuildingName::Id(id), &Location::default(), true)?;
    periods.iter().map(|period| run_episode(&prepared, *period)).collect()
}

fn run_episode(prepared: &Prepared, period: RunPeriod) -> Result<Outcome> {
    let spaces = prepared.spaces(period, STEPS_PER_HOUR, Task::default())?;
    let mut controller = reactive(&spaces, &Parameters::Default)?;
    Outcome::of(&spaces, prepared.roll_out(&spaces, &mut controller, true)?)
}

fn text(reports: &[Report]) -> String {
    let mut table = Table::new([
        "building",
        "place",
        "period",
        "coldest zone (°C)",
        "warmest zone (°C)",
        "RMS deviation (K)",
        "HVAC electricity (kWh/m²)",
        "HVAC non-electric (kWh/m²)",
        "severe messages",
        "result",
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
                if episode.passed() { "passed" } else { "FAILED" }.into(),
            ]);
        }
    }
    let failed: Vec<_> = reports.iter().filter(|report| !report.passed).collect();
    let reasons: String = failed.iter().map(|report| format!("\n{}", failure(report))).collect();
    format!("{}\n\n{} buildings checked, {} failed{reasons}", table.text(), reports.len(), failed.len())
}

/// Returns a line with the reasons why a building failed.
fn failure(report: &Report) -> String {
    let mut reasons: Vec<String> = report.error.iter().cloned().collect();
    for episode in report.episodes.iter().filter(|episode| !episode.passed()) {
        let Outcome { period, coldest, warmest, severe_message, .. } = episode;
        if coldest.temperature_c < MIN_TEMPERATURE {
            reasons.push(format!("{period}: {} falls to {:.1} °C", coldest.zone, coldest.temperature_c));
        }
        if warmest.temperature_c > MAX_TEMPERATURE {
            reasons.push(format!("{period}: {} rises to {:.1} °C", warmest.zone, warmest.temperature_c));
        }
        reasons.extend(severe_message.iter().map(|message| format!("{period}: {message}")));
    }
    format!("  {} in {}: {}", report.id, report.place, reasons.join("; "))
}
