//! `b2b tune`: the search for parameters.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use anyhow::{Context, Result};
use b2b_base::parallel;
use b2b_building::{Class, RunPeriod};
use b2b_control::tune::{self, TrainingBuildings, TuningPlan};
use b2b_control::{Objective, Tuned};
use b2b_dataset::Catalog;
use indicatif::ProgressBar;
use serde::Deserialize;

use super::rollouts::{DAYS, TrainingRollouts};
use crate::arguments::buildings::Classes;
use crate::arguments::jobs::Jobs;
use crate::output_folder::{self, OutputFolder};
use crate::program;
use crate::terminal::progress::{Download, counter};
use crate::terminal::table::Table;
use crate::terminal::{interrupt, stdout};

/// Arguments of the search.
#[derive(clap::Args, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Arguments {
    #[command(flatten)]
    classes: Classes,
    /// Objectives: comfort (energy weight 0), energy (weight 0.5). The energy search needs the result of the comfort
    /// search, which runs first unless its result is in the folder
    #[arg(long = "objective", value_name = "OBJECTIVE", num_args = 1.., default_values_t = Objective::ALL)]
    objectives: Vec<Objective>,
    /// Number of training buildings per type and climate zone in the search
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    buildings: u32,
    /// Number of other training buildings on which the best parameter sets are validated
    #[arg(long, default_value_t = 5, value_name = "N")]
    validation: u32,
    /// Maximum number of parameter sets to evaluate for each objective, including the defaults; a search ends early
    /// when 20 sets in a row improve its score by less than 1 %
    #[arg(long, default_value_t = 100, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    evaluations: u32,
    /// Random seed of the choice of buildings and of the search
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Run period; repeat the option for several
    #[arg(long = "period", value_name = "PERIOD", default_values = DAYS)]
    periods: Vec<RunPeriod>,
    #[command(flatten)]
    jobs: Jobs,
    /// Folder for the evaluations, tuned.json and energy_scale.json
    #[arg(long, default_value = "b2b-tuning", value_name = "FOLDER")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Default for Arguments {
    /// Returns the defaults of the command line.
    fn default() -> Self {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            arguments: Arguments,
        }
        <Line as clap::Parser>::parse_from(["tune"]).arguments
    }
}

/// Names of the result files.
const TUNED: &str = "tuned.json";
const ENERGY: &str = "energy_scale.json";

/// The energy scale of a class: its energy use under its comfort set.
#[derive(serde::Serialize)]
struct Energy {
    class: Class,
    /// HVAC energy per step, Wh/m².
    energy_scale: f64,
    command: String,
}

/// The results of a class.
struct Found {
    /// Position of the class in the list.
    number: usize,
    comfort: Tuned,
    energy: Option<Tuned>,
}

/// Tunes every selected class, several in parallel.
pub fn search(arguments: &Arguments) -> Result<()> {
    let classes = arguments.classes.list()?;
    let _lock = output_folder::lock(&arguments.out)?;
    let folder = arguments.out.join("evaluations");
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot write the folder {}", folder.display()))?;
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    let each = arguments.evaluations as usize * arguments.searched().count();
    let bar = counter(classes.len() * each, "evaluations", arguments.json);
    let found = Mutex::new(Vec::new());
    let search = |(number, class): &(usize, Class)| -> Result<()> {
        let (comfort, energy) = arguments.tune_class(&catalog, *class, &folder, &bar)?;
        let mut found = found.lock().expect("no thread panics while it writes results");
        found.push(Found { number: *number, comfort, energy });
        found.sort_by_key(|found| found.number);
        arguments.write(&found)
    };
    let classes: Vec<(usize, Class)> = classes.into_iter().enumerate().collect();
    parallel::map(arguments.jobs.count()?, &classes, search)?;
    bar.finish_and_clear();
    let found = found.into_inner().expect("all threads have ended");
    let results = arguments.selected(&found);
    stdout::print_result(arguments.json, &results, || arguments.text(&results))
}

impl Arguments {
    /// Returns the objectives to search: the energy search builds on the comfort search.
    fn searched(&self) -> impl Iterator<Item = Objective> {
        let energy = self.objectives.contains(&Objective::Energy);
        Objective::ALL.into_iter().filter(move |objective| energy || *objective == Objective::Comfort)
    }

    fn tune_class(
        &self,
        catalog: &Catalog,
        class: Class,
        folder: &Path,
        bar: &ProgressBar,
    ) -> Result<(Tuned, Option<Tuned>)> {
        let (search, validation) = (self.buildings as usize, self.validation as usize);
        let buildings = TrainingBuildings::draw(class, search, validation, self.seed)?;
        let plan = TuningPlan::comfort(class, &buildings, &self.periods, self.seed);
        let mut rollouts = TrainingRollouts::new(catalog, &buildings, &self.periods, &plan);
        let comfort = self.tune_one(&plan, &mut rollouts, folder, bar)?;
        if !self.objectives.contains(&Objective::Energy) {
            return Ok((comfort, None));
        }
        let plan = plan.energy(&comfort.parameters, comfort.measured.energy);
        let energy = self.tune_one(&plan, &mut rollouts, folder, bar)?;
        Ok((comfort, Some(energy)))
    }

    fn tune_one(
        &self,
        plan: &TuningPlan,
        rollouts: &mut TrainingRollouts,
        folder: &Path,
        bar: &ProgressBar,
    ) -> Result<Tuned> {
        let (class, objective) = (plan.class, plan.objective);
        let file = folder.join(format!("{}-{objective}.jsonl", class.to_string().replace(" in zone ", "-")));
        let tuned = tune::tune(
            plan,
            self.evaluations as usize,
            &file,
            &self.command(class, objective),
            |parameters, building| rollouts.simulate(parameters, building),
            |_| bar.inc(1),
        );
        interrupt::check()?;
        let tuned = tuned.with_context(|| format!("cannot tune {class} for {objective}"))?;
        bar.inc(u64::from(self.evaluations) - tuned.evaluations as u64);
        Ok(tuned)
    }

    /// Returns the command that reproduces the tuning of one class for one objective.
    fn command(&self, class: Class, objective: Objective) -> String {
        let zone = class.climate_zone.map(|zone| format!(" --zone {zone}")).unwrap_or_default();
        let mut command = format!(
            "b2b tune --type {}{zone} --objective {objective} --buildings {} --validation {} --evaluations {} --seed {}",
            class.building_type, self.buildings, self.validation, self.evaluations, self.seed
        );
        let periods: Vec<String> = self.periods.iter().map(RunPeriod::to_string).collect();
        if periods != DAYS {
            periods.iter().for_each(|period| command += &format!(" --period {period}"));
        }
        command
    }

    /// Returns the results for the selected objectives.
    fn selected<'a>(&self, found: &'a [Found]) -> Vec<&'a Tuned> {
        let all = found.iter().flat_map(|found| std::iter::once(&found.comfort).chain(&found.energy));
        all.filter(|tuned| self.objectives.contains(&tuned.objective)).collect()
    }

    /// Writes the results so far. Each file is replaced as a whole.
    fn write(&self, found: &[Found]) -> Result<()> {
        let staged = OutputFolder::stage(&self.out)?;
        write_list(&staged, TUNED, &self.selected(found))?;
        let scale = |found: &Found| Energy {
            class: found.comfort.class,
            energy_scale: found.comfort.measured.energy,
            command: found.comfort.command.clone(),
        };
        write_list(&staged, ENERGY, &found.iter().map(scale).collect::<Vec<_>>())?;
        staged.keep()
    }

    fn text(&self, found: &[&Tuned]) -> String {
        let mut table = Table::new([
            "type",
            "zone",
            "objective",
            "evaluations",
            "relative loss (default 1)",
            "worst relative loss",
            "default loss",
            "tuned loss",
            "default travel (strokes/day)",
            "tuned travel (strokes/day)",
            "tuned energy (Wh/m² per step)",
        ]);
        for tuned in found {
            table.row([
                tuned.class.building_type.to_string(),
                tuned.class.climate_zone.map_or_else(String::new, |zone| zone.to_string()),
                tuned.objective.to_string(),
                tuned.evaluations.to_string(),
                format!("{:.3}", tuned.measured.relative_loss),
                format!("{:.3}", tuned.measured.worst_relative_loss),
                format!("{:.4}", tuned.measured.default_loss),
                format!("{:.4}", tuned.measured.loss),
                format!("{:.2}", tuned.measured.default_daily_travel),
                format!("{:.2}", tuned.measured.daily_travel),
                format!("{:.3}", tuned.measured.energy),
            ]);
        }
        format!("{}\n\n  {}", table.text(), self.out.join(TUNED).display())
    }
}

fn write_list(folder: &OutputFolder, name: &str, entries: &[impl serde::Serialize]) -> Result<()> {
    folder.write(name, |file| {
        serde_json::to_writer_pretty(&mut *file, entries)?;
        Ok(writeln!(file)?)
    })
}
