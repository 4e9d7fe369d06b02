//! `b2b import`: a report on what an agent can control in a user's own model.

mod overview;
mod report;
mod text;
mod trial;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use b2b_building::{RunPeriod, import};
use b2b_dataset::BuildingName;

use crate::arguments::location::Location;
use crate::program::prepare::Prepared;
use crate::terminal::exit_code::ExitCode;
use crate::terminal::progress::counter;
use crate::terminal::{interrupt, stdout};
use crate::with_causes;
use overview::Imported;
use report::Report;
use trial::Trial;

/// Import your own model and report what an agent can control in it
///
/// Converts a model of an older EnergyPlus and sizes it for the design days of the weather file. Then makes every
/// supported system controllable: unitary and rooftop units of one or several zones, room units, central air loops,
/// and zone heaters (docs/import.md). Zones with other equipment are controlled through the setpoints of their
/// thermostats. The agent observes all zones; the reward counts the zones it controls; energy use covers all HVAC.
///
/// Nothing is written: `b2b run`, `b2b show` and `b2b doctor --authority` accept the model file itself and prepare it
/// in the same way. Given several models, prints one line for each and exits with code 1 if any cannot be imported or
/// produces severe messages.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b import office.idf --weather boston.epw
  b2b import office.idf --weather boston.epw --run 01-08..01-14     also simulate a week
  b2b import models/ --place Denver --run 01-08..01-14              one line per model of a folder
  b2b run office.idf --weather boston.epw                           then run an episode"
)]
pub struct Arguments {
    /// Model files (.idf or .epJSON, EnergyPlus 8.8 to 25.2), or folders of them
    #[arg(value_name = "MODEL", required = true)]
    models: Vec<PathBuf>,
    #[command(flatten)]
    location: Location,
    /// Simulate this run period under the reactive controller and report temperature deviations
    #[arg(long, value_name = "PERIOD")]
    run: Option<RunPeriod>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn import(arguments: &Arguments) -> Result<ExitCode> {
    match &arguments.models[..] {
        [model] if !model.is_dir() => import_one(arguments, model),
        _ => import_all(arguments),
    }
}

fn import_one(arguments: &Arguments, model: &Path) -> Result<ExitCode> {
    let report = arguments.report(model)?;
    stdout::print_result(arguments.json, &report, || text::text(&report, model, &arguments.location))?;
    Ok(ExitCode::Success)
}

fn import_all(arguments: &Arguments) -> Result<ExitCode> {
    let models = model_files(&arguments.models)?;
    let bar = counter(models.len(), "models", arguments.json);
    let mut imported = Vec::new();
    for model in models {
        interrupt::check()?;
        let report = arguments.report(&model).map_err(|error| with_causes(&error));
        imported.push(Imported { name: name(&model), report });
        bar.inc(1);
    }
    bar.finish_and_clear();
    interrupt::check()?;
    let values = imported.iter().map(Imported::json).collect::<Result<Vec<_>>>()?;
    stdout::print_result(arguments.json, &values, || overview::text(&imported))?;
    let all_passed = imported.iter().all(Imported::passed);
    Ok(ExitCode::of(all_passed))
}

/// Returns the models among files and folders, ordered by name within a folder.
fn model_files(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut models = Vec::new();
    for path in paths {
        if !path.is_dir() {
            models.push(path.clone());
            continue;
        }
        let cannot = || format!("cannot read {}", path.display());
        let entries = std::fs::read_dir(path).with_context(cannot)?;
        let mut files = entries.map(|e| Ok(e?.path())).collect::<Result<Vec<_>>>().with_context(cannot)?;
        files.retain(|file| import::is_model_file(file));
        if files.is_empty() {
            bail!("no model in {}; model files end in .idf or .epJSON", path.display());
        }
        files.sort();
        models.append(&mut files);
    }
    Ok(models)
}

fn name(model: &Path) -> String {
    BuildingName::Model(model.to_owned()).to_string()
}

impl Arguments {
    /// Imports a model.
    fn report(&self, model: &Path) -> Result<Report> {
        let name = BuildingName::Model(model.to_owned());
        let prepared = Prepared::new(&name, &self.location, self.json)?;
        let trial = match self.run {
            Some(period) => Some(Trial::run(&prepared, period, self.json)?),
            None => {
                prepared.check_start().with_context(|| format!("{name} was prepared, but does not run"))?;
                None
            }
        };
        Ok(Report::new(&name, &prepared, trial))
    }
}
