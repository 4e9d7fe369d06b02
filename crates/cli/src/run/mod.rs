//! `b2b run`: one episode, its metrics, its trajectory and its plot.

pub mod operation;
mod operation_text;
mod picture;
pub mod summary;
pub mod trajectory_file;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use anyhow::{Result, bail};
use b2b_building::{Period, RunPeriod};
use b2b_control::Case;
use b2b_dataset::BuildingName;
use b2b_env::{DecisionLog, Inputs, Resource, Spaces, Task, Trajectory};
use serde_json::Value;

use crate::arguments::controller::{Chosen, ControllerArguments};
use crate::arguments::location::Location;
use crate::arguments::task;
use crate::output_folder::{self, OutputFolder, path_in_name};
use crate::program::prepare::Prepared;
use crate::rollout::Rollout;
use crate::terminal::{interrupt, stdout};
use summary::{RunInfo, Summary};
use trajectory_file::Identity;

/// Steps per hour without an argument.
const STEPS_PER_HOUR: u32 = 12;

/// Run an episode, print its metrics, and write its trajectory and a plot
///
/// Writes three files: trajectory.parquet (one row per step), summary.json (what --json prints) and picture.html
/// (interactive time series, opens offline in any browser; an agent is drawn beside the baseline).
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_help = HELP.as_str())]
pub struct Arguments {
    /// Building type (`b2b list`), dataset building such as OfficeSmall-0042, or model file (.idf, .epJSON)
    #[arg(value_name = "BUILDING")]
    building: BuildingName,
    #[command(flatten)]
    location: Location,
    /// Run period: winter, summer, full_year or MM-DD..MM-DD (both days included; may span New Year); peak-heating,
    /// typical-heating, peak-cooling, typical-cooling or mixed: two weeks chosen from the weather
    #[arg(long, default_value_t = Period::WINTER, value_name = "PERIOD")]
    period: Period,
    /// Run only the first N hours of the run period (a multiple of 24)
    #[arg(long, value_name = "N")]
    hours: Option<u32>,
    #[command(flatten)]
    controller: ControllerArguments,
    /// Zone time steps per hour; one time step is one environment step
    #[arg(long, default_value_t = STEPS_PER_HOUR, value_name = "N")]
    steps_per_hour: u32,
    /// Task: operate (comfort bands and costs), the paper's constant, occupancy or random targets, or a JSON file (see
    /// below) [default: operate; the agent's own with an agent]
    #[arg(long, value_name = "TASK", value_parser = Task::from_text)]
    task: Option<Task>,
    /// Output folder [default: in b2b-out, named after building, place, period, controller and what is not the default
    /// of the other arguments]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print one JSON object instead of the text report
    #[arg(long)]
    json: bool,
}

static HELP: LazyLock<String> = LazyLock::new(|| EXAMPLES.replace("{resources}", &Resource::spelled()));

const EXAMPLES: &str = "\
Examples:
  b2b run OfficeSmall
  b2b run OfficeSmall-0042 --period summer
  b2b run OfficeSmall --period peak-cooling --controller own
  b2b run OfficeSmall --task operate:21-24/15.6-28+tou   another band, and prices by the hour
  b2b run OfficeSmall --task occupancy+energy0.5  a task of the paper; its baseline is reactive
  b2b run Warehouse --place Miami --period summer --task constant:23
  b2b run OfficeSmall --task random:7             setpoints drawn per zone and day with seed 7
  b2b run OfficeSmall --task occupancy+pmv+cost2  thermal sensation (PMV) plus 2 × energy cost
  b2b run OfficeSmall --task mine.json            any parameters; --json prints the task of a run
  b2b run RestaurantFastFood --period 01-01..01-07 --controller random --seed 7
  b2b run OfficeSmall --controller planner --hours 24
  b2b run OfficeSmall-0509 --controller runs/x    an agent, drawn beside the baseline
  b2b run RetailStandalone --weather my.epw --json > result.json
  b2b run my.idf --weather my.epw                 your own building; see `b2b import --help`

Operation tasks keep people comfortable at low cost. They are written operate[:HEATING-COOLING/HEATING-COOLING][+TARIFF]
[+preview]...: the bands of the building's own thermostats, or the given ones with people and without; a tariff by name or
as a TOML file; a look ahead in the observation; and further options (docs/operation.md). Their baseline is guideline36.

Tracking tasks hold a target, as in the paper (Taboga et al., 2026). They are written
SETPOINTS[+COMFORT][+RESOURCE][+VENTILATION][+PRESENCE][+FAULT...]. Their baseline is reactive. The six tasks of the paper
are constant, occupancy and random, each with and without +energy0.5.
  SETPOINTS    constant (21 °C), constant:C, occupancy (21 °C while occupied; unoccupied 18 °C from December
               to February and 26 °C from June to August, south of the equator the reverse), random, random:SEED
  COMFORT      squared deviation from the setpoint (default); +deadband or +deadbandD: squared deviation
               beyond 1 K or D K; +pmv: predicted mean vote (ISO 7730)
  RESOURCE     {resources}: W times the energy (relative to the mean use of the reactive
               controllers), cost, emissions or increase in peak demand of each step
  VENTILATION  an interlock supplies outdoor air while people are present (default); +free-ventilation: no minimum
  PRESENCE     the number of people follows the model's schedules (default); +presenceH: each person comes and
               goes at random, with a correlation time of H hours
  FAULT        +noiseK, +biasK: errors of the temperature sensors; +stuckP: actuators are stuck with
               probability P; +foulingS: coils lose a share S of their range; +own-faults: every building has its own

On one machine, the same arguments give the same episode bit for bit: compare trajectory_hash.";

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let summary = carry_out(arguments)?;
    stdout::print_result(arguments.json, &summary, || summary.text())
}

/// Runs the episode and writes its files.
pub fn carry_out(arguments: &Arguments) -> Result<Summary> {
    let task = arguments.controller.task(arguments.task.as_ref())?;
    let chosen = arguments.controller.chosen(&task);
    let (building, location, quiet) = (&arguments.building, &arguments.location, arguments.json);
    let prepared = Prepared::under(chosen.controls(), building, location, quiet)?;
    let period = arguments.run_period(&prepared)?;
    let spaces = Arc::new(prepared.spaces(period, arguments.steps_per_hour, task)?);
    let folder = arguments.folder(&prepared.place, period, &chosen, &spaces.episode.task);
    output_folder::refuse_others(&folder, "b2b run")?;
    let folder = OutputFolder::claim(&folder)?;
    let mut controller = chosen.build(&prepared, &spaces, quiet)?;
    let rollout = prepared.roll_out(&spaces, controller.as_mut(), quiet)?;
    let baseline = chosen.is_agent().then(|| Baseline::run(&prepared, &spaces, quiet)).transpose()?;

    let author = Author {
        place: prepared.place,
        controller: chosen.name(),
        parameters: chosen.parameters(&spaces)?,
        seed: chosen.seed(),
    };
    let summary = author.write(&folder, &spaces, &rollout, baseline.as_ref())?;
    interrupt::check()?;
    folder.keep()?;
    Ok(summary)
}

/// The same episode under the baseline of its task.
pub struct Baseline {
    /// Name of the controller.
    pub name: &'static str,
    /// The episode.
    pub rollout: Rollout,
}

impl Baseline {
    fn run(prepared: &Prepared, spaces: &Spaces, quiet: bool) -> Result<Self> {
        let task = &spaces.episode.task;
        let kind = b2b_control::baseline(task);
        let values = kind.tuned(&spaces.building, task);
        let mut controller = kind.make(&Case { spaces, action: &spaces.action, seed: 0, values: &values })?;
        Ok(Self { name: kind.name(), rollout: prepared.roll_out(spaces, controller.as_mut(), quiet)? })
    }
}

/// Properties of a run that are not part of the environment.
pub struct Author {
    /// Name of the place, or of the weather file.
    pub place: String,
    /// Name of the controller.
    pub controller: String,
    /// Its parameters, unless they are those that it has without an argument.
    pub parameters: Option<Value>,
    /// Random seed of the controller.
    pub seed: u64,
}

impl Author {
    /// Writes an episode that ran to its end to a folder, like `b2b run`. Returns the files.
    ///
    /// # Errors
    /// The reason why the folder cannot be written.
    pub fn write_episode(self, folder: &Path, spaces: &Spaces, rollout: &Rollout) -> Result<Vec<PathBuf>> {
        let folder = OutputFolder::claim(folder)?;
        let summary = self.write(&folder, spaces, rollout, None)?;
        folder.keep()?;
        Ok(summary.info.files)
    }

    /// Writes the steps of an episode to a folder, without metrics, which only a complete episode has. Returns the
    /// files.
    ///
    /// # Errors
    /// The reason why the folder cannot be written.
    pub fn write_steps(
        self,
        folder: &Path,
        spaces: &Spaces,
        trajectory: &Trajectory,
    ) -> Result<Vec<PathBuf>> {
        let identity = Identity {
            place: self.place,
            controller: self.controller,
            weather_sha256: Inputs::of(spaces)?.weather_sha256,
            trajectory_hash: trajectory.hash(),
            discomfort: None,
            resource: None,
        };
        let folder = OutputFolder::claim(folder)?;
        let files = folder.destinations(&[trajectory_file::NAME]);
        folder.write(trajectory_file::NAME, |file| {
            trajectory_file::write(file, spaces, trajectory, &DecisionLog::default(), identity)
        })?;
        folder.keep()?;
        Ok(files)
    }

    fn write(
        self,
        folder: &OutputFolder,
        spaces: &Spaces,
        rollout: &Rollout,
        baseline: Option<&Baseline>,
    ) -> Result<Summary> {
        let Self { place, controller, parameters, seed } = self;
        let files = folder.destinations(&[trajectory_file::NAME, Summary::NAME, picture::NAME]);
        let summary = Summary::of(spaces, rollout, RunInfo { place, controller, parameters, seed, files })?;
        folder.write(trajectory_file::NAME, |file| {
            let Rollout { trajectory, decisions, .. } = rollout;
            trajectory_file::write(file, spaces, trajectory, decisions, summary.identity())
        })?;
        folder.write(picture::NAME, |file| picture::write(file, spaces, rollout, baseline, &summary))?;
        let json = summary.json()?;
        folder.write(Summary::NAME, |file| Ok(file.write_all(&json)?))?;
        Ok(summary)
    }
}

impl Arguments {
    /// Returns the run period, shortened to `--hours`.
    fn run_period(&self, prepared: &Prepared) -> Result<RunPeriod> {
        let Prepared { building, weather, .. } = prepared;
        let period = self.period.in_weather(weather)?;
        let Some(hours) = self.hours else { return Ok(period) };
        building.check_period(period)?;
        let period = building.in_its_calendar(period);
        let (days, whole) = (hours / 24, period.days());
        if hours % 24 != 0 || days == 0 || days > whole {
            bail!("--hours {hours}: expected a multiple of 24, at most {} for {}", whole * 24, self.period);
        }
        Ok(period.part(0, days))
    }

    /// Returns the output folder.
    fn folder(&self, place: &str, period: RunPeriod, chosen: &Chosen<'_>, task: &Task) -> PathBuf {
        self.out.clone().unwrap_or_else(|| {
            let placement = self.location.placement();
            let place = placement.weather.as_deref().map_or_else(|| place.replace(' ', "_"), path_in_name);
            let building = match &self.building {
                BuildingName::Model(path) => path_in_name(path),
                BuildingName::Type(_) | BuildingName::Id(_) => self.building.to_string(),
            };
            let control = placement.control.suffix();
            let mut name =
                format!("{building}{control}-{place}-{period}-{}{}", chosen.name(), chosen.variant());
            if placement.keep_design_days {
                name += "-own-design-days";
            }
            if self.steps_per_hour != STEPS_PER_HOUR {
                name += &format!("-{}-per-hour", self.steps_per_hour);
            }
            if *task != task::usual() {
                name += &format!("-{task}").replace([':', '#', '/'], "_");
            }
            PathBuf::from("b2b-out").join(name)
        })
    }
}
