//! `b2b tune`: the search for parameters.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use b2b_building::{Class, RunPeriod};
use b2b_control::tune::{self, Outcome, Plan};
use b2b_control::{ReactiveParameters, Tuned};
use b2b_dataset::Catalog;
use b2b_env::Task;
use indicatif::ProgressBar;

use super::rollouts::{WEEKS, rollouts};
use crate::arguments::buildings::Classes;
use crate::output_folder::OutputFolder;
use crate::progress::{Download, counter};
use crate::table::Table;
use crate::{interrupt, stdout};

/// Arguments of the search.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    classes: Classes,
    /// Number of training buildings per type and climate zone
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    buildings: u32,
    /// Number of parameter sets to evaluate, including the defaults
    #[arg(long, default_value_t = 16, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    evaluations: u32,
    /// Random seed of the choice of buildings and of the search
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Run period; repeat the option for several
    #[arg(long = "period", value_name = "PERIOD", default_values = WEEKS)]
    periods: Vec<RunPeriod>,
    /// Folder for the evaluations and tuned.json
    #[arg(long, default_value = "b2b-tuning", value_name = "FOLDER")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The task of the tuning.
const TASK: &str = "occupancy";
/// The files of results.
const TUNED: &str = "tuned.json";
const ENERGY: &str = "energy_scale.json";

/// The energy scale of a class: its energy use under its tuned controllers.
#[derive(serde::Serialize)]
struct Energy<'a> {
    class: Class,
    /// HVAC energy per step, Wh/m².
    energy_scale: f64,
    command: &'a str,
}

impl<'a> Energy<'a> {
    fn of(tuned: &'a Tuned) -> Self {
        Self { class: tuned.class, energy_scale: tuned.measured.energy, command: &tuned.command }
    }
}

/// Tunes every selected class.
pub fn search(arguments: &Arguments) -> Result<()> {
    let classes = arguments.classes.list()?;
    let folder = arguments.out.join("evaluations");
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot write the folder {}", folder.display()))?;
    let mut download = Download::new(arguments.json);
    let catalog = Catalog::open(&mut download)?;
    let bar = counter(classes.len() * arguments.evaluations as usize, "evaluations", arguments.json);
    let mut found = Vec::new();
    for class in classes {
        found.push(arguments.tune_one(&catalog, class, &folder, &bar)?);
        write(&arguments.out, &found)?;
    }
    bar.finish_and_clear();
    stdout::print_result(arguments.json, &found, || arguments.text(&found))
}

impl Arguments {
    fn tune_one(&self, catalog: &Catalog, class: Class, folder: &Path, bar: &ProgressBar) -> Result<Tuned> {
        let task: Task = TASK.parse()?;
        let ids = tune::training_buildings(class, self.buildings as usize, self.seed)?;
        let plan = Plan::new(class, &ids, &self.periods, &task, self.seed);
        let file = folder.join(format!("{}.jsonl", class.to_string().replace(" in zone ", "-")));
        let before = bar.position();
        // Created on first use: a finished plan needs no engine.
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
        tuned.with_context(|| format!("cannot tune {class}"))
    }

    /// Returns the command that reproduces the tuning of one class.
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
            "score (default -1)",
            "default penalty (K²)",
            "tuned penalty (K²)",
            "default travel (strokes/day)",
            "tuned travel (strokes/day)",
            "tuned energy (Wh/m² per step)",
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

/// Writes the results. The files appear complete or not at all.
fn write(folder: &Path, found: &[Tuned]) -> Result<()> {
    let staged = OutputFolder::stage(folder)?;
    write_list(&staged, TUNED, found)?;
    write_list(&staged, ENERGY, &found.iter().map(Energy::of).collect::<Vec<_>>())?;
    staged.keep()
}

fn write_list(folder: &OutputFolder, name: &str, entries: &[impl serde::Serialize]) -> Result<()> {
    folder.write(name, |file| {
        serde_json::to_writer_pretty(&mut *file, entries)?;
        Ok(writeln!(file)?)
    })
}
