//! `b2b calibrate`: calibration of a model against monthly metered energy.

mod report;
mod simulations;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use b2b_building::calibration::{DEFAULT_PARAMETERS, Fit, Metered, Options, PARAMETERS, fit};
use b2b_building::edit::{self, Change, Edits};
use b2b_building::{Model, MonthlyEnergy, calibration};
use b2b_dataset::{BuildingName, Catalog};

use crate::arguments::jobs::Jobs;
use crate::arguments::location::Location;
use crate::progress::{Download, spinner};
use crate::stdout;
use report::{Calibrated, Report};
use simulations::Simulations;

/// Calibrate a model to monthly metered energy
///
/// Finds multipliers of the infiltration, the internal gains and the U-factors of a model for which a simulated year
/// agrees best with metered electricity and gas of the whole building, by least squares (Levenberg and Marquardt). The
/// model is simulated with its own controls and sizing; what agents do is not simulated. Writes the calibrated model,
/// and prints the statistics of ASHRAE Guideline 14 before and after.
///
/// The table of metered energy has the columns month (1 to 12), electricity_kwh and gas_kwh; one of the last two may be
/// missing. The weather file should be that of the metered year. A run period of a whole year in the model is kept, with
/// its weekdays and holidays; otherwise the year begins on a Sunday.
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
    /// Model file (.idf or .epJSON, EnergyPlus 25.2 or 25.1), or a building of the dataset
    #[arg(value_name = "MODEL")]
    model: BuildingName,
    #[command(flatten)]
    location: Location,
    /// CSV file of metered energy
    #[arg(long, value_name = "METERED.csv", required_unless_present = "simulate")]
    energy: Option<PathBuf>,
    /// Parameter to calibrate, may be repeated: infiltration, lights, equipment, people, wall_u, roof_u or window_u
    /// [default: infiltration, lights, equipment and wall_u]
    #[arg(long = "parameter", value_name = "NAME", value_parser = parameter)]
    parameters: Vec<Change>,
    /// File to write
    #[arg(long, value_name = "FILE.epJSON", required_unless_present = "simulate")]
    out: Option<PathBuf>,
    /// Maximum number of iterations; each takes a simulation per parameter and at least two more
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=100))]
    iterations: u32,
    #[command(flatten)]
    jobs: Jobs,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Simulate a year of the model in this process, and print its monthly energy as JSON
    #[arg(long, hide = true)]
    simulate: bool,
}

fn parameter(name: &str) -> Result<Change> {
    let known = || PARAMETERS.map(Change::name).join(", ");
    let found = name.parse::<Change>().ok().filter(|change| PARAMETERS.contains(change));
    found.with_context(|| format!("`{name}` cannot be calibrated; expected one of {}", known()))
}

/// Runs the command.
pub fn calibrate(arguments: &Arguments) -> Result<()> {
    if arguments.simulate {
        return arguments.simulate_here();
    }
    let (Some(energy), Some(out)) = (&arguments.energy, &arguments.out) else {
        bail!("--energy METERED.csv and --out FILE.epJSON are required");
    };
    let report = arguments.calibrated(energy, out)?;
    if !arguments.json {
        report.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    }
    stdout::print_result(arguments.json, &report, || report.text(out))
}

impl Arguments {
    /// Simulates a model file that the calling process has checked.
    fn simulate_here(&self) -> Result<()> {
        let found = find(&self.model, &self.location, true)?;
        let energy = MonthlyEnergy::of(&found.model, &found.weather, found.catalog.library())?;
        stdout::print_json(&energy)
    }

    fn calibrated(&self, energy: &Path, out: &Path) -> Result<Report> {
        edit::check_output(out)?;
        let metered = Metered::read(energy)?;
        let parameters = self.distinct_parameters(&metered)?;
        let found = find(&self.model, &self.location, self.json)?;
        let bounds = parameters.iter().map(|change| bounds(&found.model, *change)).collect::<Result<_>>()?;
        let options = Options { bounds, max_iterations: self.iterations as usize };
        let simulations = Simulations::new(&found, &metered, &parameters, &self.jobs, self.json)?;
        let fitted = fit(&options, |batch| simulations.residuals(batch));
        simulations.finish();
        let fitted = fitted.with_context(|| format!("cannot calibrate {}", self.model))?;
        let calibrated = self.write(&found.model, &parameters, &fitted, out)?;
        let before = simulations.energy_at(&vec![0.0; parameters.len()])?;
        let after = simulations.energy_at(&fitted.point)?;
        let mut report = Report::new(
            &self.model,
            &found.place,
            Calibrated { metered: &metered, parameters: &parameters, fit: &fitted, before, after },
        );
        report.simulations = simulations.count();
        report.warnings.extend(calibrated.warnings);
        Ok(report)
    }

    /// Returns the parameters, each once. Errors if there are more than metered values.
    fn distinct_parameters(&self, metered: &Metered) -> Result<Vec<Change>> {
        let mut parameters = Vec::new();
        let named = if self.parameters.is_empty() { &DEFAULT_PARAMETERS[..] } else { &self.parameters };
        for change in named {
            if !parameters.contains(change) {
                parameters.push(*change);
            }
        }
        if parameters.len() > metered.len() {
            bail!(
                "{} parameters cannot be found from {} metered values; give more months, or name fewer with --parameter",
                parameters.len(),
                metered.len()
            );
        }
        Ok(parameters)
    }

    /// Applies the multipliers to the model and writes it.
    fn write(&self, model: &Model, parameters: &[Change], fit: &Fit, out: &Path) -> Result<edit::Report> {
        let mut calibrated = model.clone();
        let report = edit::apply(&mut calibrated, &edits(parameters, &fit.point))?;
        edit::write_aside(&calibrated, out)?;
        Ok(report)
    }
}

/// A model with its weather.
struct FoundModel {
    catalog: Catalog,
    model: Model,
    place: String,
    weather: PathBuf,
}

fn find(name: &BuildingName, location: &Location, quiet: bool) -> Result<FoundModel> {
    let mut download = Download::new(quiet);
    let catalog = Catalog::open(&mut download)?;
    let spinner = spinner(format!("reading {name}"), quiet);
    let found = catalog.find(name, &location.placement(), &mut download);
    spinner.finish_and_clear();
    let found = found.with_context(|| format!("cannot read {name}"))?;
    Ok(FoundModel { catalog, model: found.model, place: found.place, weather: found.weather })
}

/// Returns the edits of multipliers that are given as logarithms.
fn edits(parameters: &[Change], point: &[f64]) -> Edits {
    let mut edits = Edits::default();
    for (change, logarithm) in parameters.iter().zip(point) {
        edits.multiply(*change, logarithm.exp());
    }
    edits
}

/// Returns the bounds of the logarithm of a multiplier: as wide as the model allows. A wall cannot have a higher U-factor
/// than its layers without insulation.
fn bounds(model: &Model, change: Change) -> Result<[f64; 2]> {
    let applies = |logarithm: f64| edit::apply(&mut model.clone(), &edits(&[change], &[logarithm]));
    applies(0.0)?;
    let widest = |bound: f64| {
        let mut bound = bound.ln();
        while applies(bound).is_err() && bound.abs() > 1e-2 {
            bound *= 0.8;
        }
        bound
    };
    Ok(calibration::MULTIPLIERS.map(widest))
}
