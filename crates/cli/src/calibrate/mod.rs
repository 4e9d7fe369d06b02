//! `b2b calibrate`: calibration of a model against monthly metered energy.

mod text;

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use b2b_building::calibration::{Calibration, Metered, PARAMETERS, Progress, Report};
use b2b_building::edit::{self, Change};
use b2b_dataset::BuildingName;
use indicatif::ProgressBar;

use crate::arguments::jobs::Jobs;
use crate::arguments::location::Location;
use crate::program;
use crate::terminal::progress::{Download, counter, spinner};
use crate::terminal::{interrupt, stdout};

/// Calibrate a model to monthly metered energy
///
/// Finds multipliers of the infiltration, the internal gains and the U-factors of a model for which a simulated year
/// agrees best with metered electricity and gas of the whole building, by least squares (Levenberg and Marquardt). The
/// model is simulated with its own controls and sizing; what agents do is not simulated. Writes the calibrated model,
/// and prints the statistics of ASHRAE Guideline 14 before and after.
///
/// The table of metered energy has the columns month (1 to 12), electricity_kwh and gas_kwh; one of the last two may be
/// missing. Electricity is all that the building uses, including what it produces. The weather file should be of the
/// metered year. A run period of a whole year in the model is kept if it has a year or a first weekday; otherwise the
/// year is the model's or the weather file's.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b calibrate office.idf --weather boston-2023.epw --energy metered.csv --out calibrated.epJSON
  b2b calibrate office.idf --place Denver --energy metered.csv --parameter infiltration --parameter lights --out c.epJSON
  b2b calibrate OfficeSmall-0042 --energy metered.csv --out calibrated.epJSON"
)]
pub struct Arguments {
    /// Model file (.idf or .epJSON, EnergyPlus 8.8 to 25.2), or a building of the dataset
    #[arg(value_name = "MODEL")]
    model: BuildingName,
    #[command(flatten)]
    location: Location,
    /// CSV file of metered energy
    #[arg(long, value_name = "FILE.csv")]
    energy: PathBuf,
    /// Parameter to calibrate, may be repeated: infiltration, lights, equipment, people, wall_u, roof_u or window_u
    /// [default: infiltration, lights, equipment and wall_u]
    #[arg(long = "parameter", value_name = "NAME", value_parser = parameter)]
    parameters: Vec<Change>,
    /// File to write
    #[arg(long, value_name = "FILE.epJSON")]
    out: PathBuf,
    /// Maximum number of iterations; each takes a simulation per parameter and at least two more
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=100))]
    iterations: u32,
    #[command(flatten)]
    jobs: Jobs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

fn parameter(name: &str) -> Result<Change> {
    let known = || PARAMETERS.map(Change::name).join(", ");
    let found = name.parse::<Change>().ok().filter(|change| PARAMETERS.contains(change));
    found.with_context(|| format!("`{name}` cannot be calibrated; expected one of {}", known()))
}

/// Runs the command.
pub fn calibrate(arguments: &Arguments) -> Result<()> {
    let report = arguments.calibrated()?;
    if !arguments.json {
        report.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    }
    stdout::print_result(arguments.json, &report, || text::text(&report, &arguments.out))
}

impl Arguments {
    fn calibrated(&self) -> Result<Report> {
        if self.location.control.is_some() {
            bail!(
                "--control is not for calibration: the model is simulated with its own controls; leave it out"
            );
        }
        edit::check_output(&self.out)?;
        let metered = Metered::read(&self.energy)?;
        let (name, mut download) = (self.model.to_string(), Download::new(self.json));
        let catalog = program::catalog(&mut download)?;
        let spinner = spinner(format!("reading {name}"), self.json);
        let found = catalog.find(&self.model, &self.location.placement(), &mut download);
        spinner.finish_and_clear();
        interrupt::check()?;
        let found = found.with_context(|| format!("cannot read {name}"))?;
        let calibration = Calibration {
            name: &name,
            model: &found.model,
            source: self.model.file(),
            notes: &found.notes,
            place: &found.place,
            weather: &found.weather,
            metered: &metered,
            parameters: &self.parameters,
            max_iterations: self.iterations as usize,
            jobs: if catalog.library().is_hosted() { self.jobs.count()? } else { 1 },
        };
        let bar = Bar(counter(0, "simulations", self.json));
        let report = calibration.run(catalog.library(), &self.out, &bar);
        interrupt::check()?;
        report.with_context(|| format!("cannot calibrate {name}"))
    }
}

/// A progress bar of simulations.
struct Bar(ProgressBar);

impl Progress for Bar {
    fn begin(&self, simulations: usize) {
        self.0.inc_length(simulations as u64);
    }

    fn done(&self) {
        self.0.inc(1);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
