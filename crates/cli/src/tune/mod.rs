//! `b2b tune`: the parameters of the reactive controllers, found on training buildings.

mod check;
mod compare;

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use b2b_building::{BuildingType, Class, RunPeriod};
use b2b_control::tune::{self, Outcome, Plan, Rollouts};
use b2b_control::{ReactiveParameters, Tuned};
use b2b_dataset::{BuildingId, Catalog};
use b2b_env::Task;
use b2b_env::vector::{Launcher, PoolOptions};
use indicatif::ProgressBar;

use crate::output_folder::OutputFolder;
use crate::progress::{Download, counter};
use crate::table::Table;
use crate::{interrupt, stdout};

/// Tune the reactive controllers on training buildings
///
/// For each type and climate zone: Bayesian optimisation of eight parameters, on training buildings over a winter and a
/// summer week, with targets by occupancy and energy not counted. The score is the 25th percentile over the
/// buildings of the return in times what the default parameters lose: -1 is as good as they are, 0 is perfect. The best
/// is chosen among those with which no building's actuators go more than five times their range a day, or no further than
/// under the defaults; it is never worse than these. Every evaluation is kept in a file: the same arguments go on where they
/// stood. The parameters that ship with this program are FOLDER/tuned.json of a run with the defaults of the options.
#[derive(clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "\
Examples:
  b2b tune                                       every type and zone: an hour or two
  b2b tune --type OfficeSmall --zone 5
  b2b tune --type SingleFamilyHouse --buildings 8 --evaluations 50 --seed 1 --out mine
  b2b tune check --type SingleFamilyHouse        whether what is shipped comes out again
  b2b tune compare --type OfficeSmall            before and after, on buildings that tuning has not seen
  b2b run OfficeSmall --parameters mine.json     with parameters of your own"
)]
pub struct Arguments {
    #[command(subcommand)]
    instead: Option<Instead>,
    #[command(flatten)]
    groups: Groups,
    /// Training buildings of each type and zone
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    buildings: u32,
    /// Sets of parameters that are tried, the defaults first
    #[arg(long, default_value_t = 16, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    evaluations: u32,
    /// Seed of the buildings and of the search
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Days that each building runs: can be given more than once
    #[arg(long = "period", value_name = "DAYS", default_values = WEEKS)]
    periods: Vec<RunPeriod>,
    /// Folder for the evaluations and tuned.json
    #[arg(long, default_value = "b2b-tuning", value_name = "FOLDER")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(clap::Subcommand)]
enum Instead {
    Check(check::Arguments),
    Compare(compare::Arguments),
}

/// A winter week and a summer week.
const WEEKS: [&str; 2] = ["01-08..01-14", "07-08..07-14"];
/// What is asked while tuning.
const TASK: &str = "occupancy";
/// The files of results.
const TUNED: &str = "tuned.json";
const ENERGY: &str = "energy_scale.json";

/// The energy scale of a class: what it uses under its tuned controllers.
#[derive(serde::Serialize)]
struct Energy<'a> {
    class: Class,
    /// HVAC energy of a step, Wh/m².
    energy_scale: f64,
    command: &'a str,
}

impl<'a> Energy<'a> {
    fn of(tuned: &'a Tuned) -> Self {
        Self { class: tuned.class, energy_scale: tuned.measured.energy, command: &tuned.command }
    }
}

/// Runs the command.
pub fn tune(arguments: &Arguments) -> Result<()> {
    match &arguments.instead {
        Some(Instead::Check(arguments)) => return check::check(arguments),
        Some(Instead::Compare(arguments)) => return compare::compare(arguments),
        None => {}
    }
    let classes = arguments.groups.classes()?;
    let folder = arguments.out.join("evaluations");
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("the folder {} cannot be written", folder.display()))?;
    let mut download = Download::new(arguments.json);
    let catalog = Catalog::open(&mut download)?;
    let bar = counter(classes.len() * arguments.evaluations as usize, "evaluations", arguments.json);
    let mut found = Vec::new();
    for class in classes {
        found.push(arguments.tune_one(&catalog, class, &folder, &bar)?);
        write(&arguments.out, &found)?;
    }
    bar.finish_and_clear();
    if arguments.json { stdout::print_json(&found) } else { stdout::print(&arguments.text(&found)) }
}

impl Arguments {
    fn tune_one(&self, catalog: &Catalog, class: Class, folder: &Path, bar: &ProgressBar) -> Result<Tuned> {
        let task: Task = TASK.parse()?;
        let ids = tune::training_buildings(class, self.buildings as usize, self.seed)?;
        let plan = Plan::new(class, &ids, &self.periods, &task, self.seed);
        let file = folder.join(format!("{}.jsonl", class.to_string().replace(" in zone ", "-")));
        let before = bar.position();
        // Made when they are first needed: a plan that is done needs no engine.
        let mut kept = None;
        let evaluate = |parameters: &ReactiveParameters| {
            let ready = match &mut kept {
                Some(ready) => ready,
                none => none.insert(rollouts(catalog, &ids, &self.periods, std::slice::from_ref(&task))?),
            };
            let episodes = ready.run(parameters)?;
            Ok(episodes.iter().map(|episodes| Outcome::of(episodes)).collect())
        };
        let done = |evaluations: usize, _: f64| bar.set_position(before + evaluations as u64);
        let evaluations = self.evaluations as usize;
        let tuned = tune::tune(&plan, evaluations, &file, &self.command(class), evaluate, done);
        interrupt::check()?;
        tuned.with_context(|| format!("{class} cannot be tuned"))
    }

    /// The command that tunes one class so.
    fn command(&self, class: Class) -> String {
        let zone = class.climate_zone.map(|zone| format!(" --zone {zone}")).unwrap_or_default();
        let mut command = format!(
            "b2b tune --type {}{zone} --buildings {} --evaluations {} --seed {}",
            class.building_type, self.buildings, self.evaluations, self.seed
        );
        let periods: Vec<String> = self.periods.iter().map(RunPeriod::to_string).collect();
        if periods != WEEKS {
            periods.iter().for_each(|period| command += &format!(" --period {period}"));
        }
        command
    }

    fn text(&self, found: &[Tuned]) -> String {
        let mut table = Table::new([
            "type",
            "zone",
            "buildings",
            "evaluations",
            "score, default -1",
            "penalty before, K²",
            "after, K²",
            "travel before, 1/d",
            "after, 1/d",
            "energy, Wh/m²",
        ]);
        for tuned in found {
            table.row([
                tuned.class.building_type.to_string(),
                tuned.class.climate_zone.map_or_else(String::new, |zone| zone.to_string()),
                tuned.buildings.len().to_string(),
                tuned.evaluations.to_string(),
                format!("{:.3}", tuned.measured.score),
                format!("{:.3}", tuned.measured.default_penalty),
                format!("{:.3}", tuned.measured.penalty),
                format!("{:.2}", tuned.measured.default_daily_travel),
                format!("{:.2}", tuned.measured.daily_travel),
                format!("{:.3}", tuned.measured.energy),
            ]);
        }
        format!("{}\n\n  {}", table.text(), self.out.join(TUNED).display())
    }
}

/// The groups that are meant.
#[derive(clap::Args)]
struct Groups {
    /// Building types [default: every type]
    #[arg(long = "type", value_name = "TYPE", num_args = 1..)]
    types: Vec<BuildingType>,
    /// Climate zones, 1 to 8 [default: all]; houses have one group
    #[arg(long = "zone", value_name = "ZONE", num_args = 1.., value_parser = clap::value_parser!(u8).range(1..=8))]
    zones: Vec<u8>,
}

impl Groups {
    /// The classes of these types and zones; all where none is given.
    fn classes(&self) -> Result<Vec<Class>> {
        let asked = |class: &Class| {
            (self.types.is_empty() || self.types.contains(&class.building_type))
                && class.climate_zone.is_none_or(|zone| self.zones.is_empty() || self.zones.contains(&zone))
        };
        let classes: Vec<_> = Class::all().filter(asked).collect();
        if classes.is_empty() {
            bail!("no building is of that type and zone");
        }
        Ok(classes)
    }
}

/// Buildings in processes of their own. Waiting for them ends with an interrupt.
fn rollouts(
    catalog: &Catalog,
    ids: &[BuildingId],
    periods: &[RunPeriod],
    tasks: &[Task],
) -> b2b_control::Result<Rollouts> {
    let launcher = Launcher::this_program()
        .map_err(|source| b2b_control::Error::Io { path: "this program".into(), source })?;
    let options = PoolOptions::new(launcher, catalog.library().path());
    let options = PoolOptions { interrupted: interrupt::requested, ..options };
    Rollouts::new(options, catalog, ids, periods, tasks, &mut Download::new(true))
}

/// Writes what was found, an entry a paragraph; the files are there whole or not at all.
fn write(folder: &Path, found: &[Tuned]) -> Result<()> {
    let staged = OutputFolder::stage(folder)?;
    list(&staged, TUNED, found)?;
    list(&staged, ENERGY, &found.iter().map(Energy::of).collect::<Vec<_>>())?;
    staged.keep()
}

fn list(folder: &OutputFolder, name: &str, entries: &[impl serde::Serialize]) -> Result<()> {
    folder.write(name, |file| {
        serde_json::to_writer_pretty(&mut *file, entries)?;
        Ok(writeln!(file)?)
    })
}
