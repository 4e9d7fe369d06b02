//! The search for the multipliers of a model, over simulated years.

use std::path::Path;

use b2b_base::parallel;
use b2b_energyplus::Library;

use super::report::{Calibrated, Report};
use super::{DEFAULT_PARAMETERS, MULTIPLIERS, Metered, Options, fit};
use crate::edit::{self, Change, Edits};
use crate::import::Notes;
use crate::{Error, Model, MonthlyEnergy, Result};

/// A calibration of a model.
#[derive(Clone, Copy, Debug)]
pub struct Calibration<'a> {
    /// Name of the model.
    pub name: &'a str,
    /// The model.
    pub model: &'a Model,
    /// The file of the model, if it is a user's.
    pub source: Option<&'a Path>,
    /// Notes on how it was read, which begin the warnings of the report.
    pub notes: &'a Notes,
    /// Name of the place, or of the weather file.
    pub place: &'a str,
    /// The weather file.
    pub weather: &'a Path,
    /// Metered energy.
    pub metered: &'a Metered,
    /// Parameters to calibrate; [`DEFAULT_PARAMETERS`] if there are none.
    pub parameters: &'a [Change],
    /// Maximum number of iterations.
    pub max_iterations: usize,
    /// Number of simulations at a time. More than one needs a library with a [`Host`](b2b_energyplus::Host).
    pub jobs: usize,
}

/// Receives the progress of a calibration's simulations.
pub trait Progress: Sync {
    /// Announces that a number of further simulations begin.
    fn begin(&self, simulations: usize);

    /// Announces that a simulation is done.
    fn done(&self);
}

impl Progress for () {
    fn begin(&self, _: usize) {}

    fn done(&self) {}
}

impl Calibration<'_> {
    /// Finds the multipliers, and writes the calibrated model to `out` (epJSON).
    ///
    /// # Errors
    /// [`Error::OutputName`]; [`Error::OutputIsModel`]; [`Error::FewMeteredValues`] for more parameters than metered
    /// values; [`Error::Edit`] and [`Error::NothingToChange`] for a parameter that the model does not have; errors from
    /// [`MonthlyEnergy::of`].
    pub fn run(&self, library: &Library, out: &Path, progress: &dyn Progress) -> Result<Report> {
        self.check_output(out)?;
        let parameters = self.distinct_parameters()?;
        let bounds = parameters.iter().map(|change| bounds(self.model, *change)).collect::<Result<_>>()?;
        let options = Options { bounds, max_iterations: self.max_iterations };
        let mut simulations =
            Simulations { of: self, parameters: &parameters, library, progress, done: Vec::new() };
        let fit = fit(&options, |batch| simulations.residuals(batch))?;
        let mut calibrated = self.model.clone();
        let edited = edit::apply(&mut calibrated, &edits(&parameters, &fit.point))?;
        calibrated.name_house(self.name);
        edit::write_aside(&calibrated, out)?;
        let before = simulations.energy_at(&vec![0.0; parameters.len()])?;
        let after = simulations.energy_at(&fit.point)?;
        let (metered, parameters) = (self.metered, &parameters[..]);
        let parts = Calibrated { metered, parameters, fit: &fit, before, after };
        let mut report = Report::new(self.name, self.place, parts);
        report.simulations = simulations.done.len();
        let read = self.notes.lines().chain(edited.warnings);
        let elsewhere = edit::names_files_elsewhere(&calibrated, out);
        report.warnings = read.chain(elsewhere).chain(report.warnings).collect();
        Ok(report)
    }

    /// Checks that the calibrated model is an epJSON and not the model itself.
    fn check_output(&self, out: &Path) -> Result<()> {
        edit::check_output(out)?;
        self.source.map_or(Ok(()), |source| edit::check_other_file(source, out))
    }

    /// Returns the parameters, each once.
    fn distinct_parameters(&self) -> Result<Vec<Change>> {
        let mut parameters = Vec::new();
        let named = if self.parameters.is_empty() { &DEFAULT_PARAMETERS[..] } else { self.parameters };
        for change in named {
            if !parameters.contains(change) {
                parameters.push(*change);
            }
        }
        let values = self.metered.len();
        match parameters.len() {
            count if count > values => Err(Error::FewMeteredValues { parameters: count, values }),
            _ => Ok(parameters),
        }
    }
}

/// Simulated years of a model with different multipliers.
struct Simulations<'a> {
    of: &'a Calibration<'a>,
    parameters: &'a [Change],
    library: &'a Library,
    progress: &'a dyn Progress,
    /// Every simulation so far, by the logarithms of its multipliers.
    done: Vec<(Vec<f64>, MonthlyEnergy)>,
}

impl Simulations<'_> {
    /// Returns the residuals of each point of a batch: simulated minus metered energy, over the mean metered energy of
    /// the fuel.
    fn residuals(&mut self, batch: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        self.run(batch)?;
        batch.iter().map(|point| Ok(self.residuals_of(&self.energy_at_known(point)))).collect()
    }

    fn residuals_of(&self, energy: &MonthlyEnergy) -> Vec<f64> {
        let metered = self.of.metered;
        let mut residuals = Vec::new();
        for (fuel, values) in &metered.fuels {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let simulated = metered.months.iter().map(|month| energy.fuel(*fuel)[month - 1]);
            residuals.extend(
                values.iter().zip(simulated).map(|(metered, simulated)| (simulated - metered) / mean),
            );
        }
        residuals
    }

    /// Returns the energy of a point, which is simulated unless it was before.
    fn energy_at(&mut self, point: &[f64]) -> Result<MonthlyEnergy> {
        self.run(&[point.to_vec()])?;
        Ok(self.energy_at_known(point))
    }

    fn energy_at_known(&self, point: &[f64]) -> MonthlyEnergy {
        let known = self.done.iter().find(|(other, _)| other == point);
        known.map(|(_, energy)| *energy).expect("it was simulated")
    }

    /// Simulates the points of a batch that were not simulated before, several at a time.
    fn run(&mut self, batch: &[Vec<f64>]) -> Result<()> {
        let mut new: Vec<&Vec<f64>> = Vec::new();
        for point in batch {
            if !self.done.iter().any(|(done, _)| done == point) && !new.contains(&point) {
                new.push(point);
            }
        }
        self.progress.begin(new.len());
        let energies = parallel::map(self.of.jobs, &new, |point| self.simulate(point))?;
        self.done.extend(new.into_iter().cloned().zip(energies));
        Ok(())
    }

    fn simulate(&self, point: &[f64]) -> Result<MonthlyEnergy> {
        let mut edited = self.of.model.clone();
        edit::apply(&mut edited, &edits(self.parameters, point))?;
        let energy = MonthlyEnergy::of(&edited, self.of.weather, self.library);
        let energy =
            energy.map_err(|error| error.while_doing(format!("simulating a year of {}", self.of.name)))?;
        self.progress.done();
        Ok(energy)
    }
}

/// Returns the edits for multipliers given as logarithms.
fn edits(parameters: &[Change], point: &[f64]) -> Edits {
    let mut edits = Edits::default();
    for (change, logarithm) in parameters.iter().zip(point) {
        edits.multiply(*change, logarithm.exp());
    }
    edits
}

/// Returns the widest bounds of the logarithm of a multiplier that the model allows. A wall cannot have a higher
/// U-factor than its layers without insulation.
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
    Ok(MULTIPLIERS.map(widest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_model_itself_is_not_a_name_for_the_calibrated_one() {
        let source = tempfile::Builder::new().suffix(".epJSON").tempfile().unwrap();
        let (model, notes) = (Model::default(), Notes::default());
        let metered = Metered { months: Vec::new(), fuels: Vec::new() };
        let of = |source| Calibration {
            name: "office",
            model: &model,
            source,
            notes: &notes,
            place: "Denver",
            weather: Path::new("denver.epw"),
            metered: &metered,
            parameters: &[],
            max_iterations: 1,
            jobs: 1,
        };
        let error = of(Some(source.path())).check_output(source.path()).unwrap_err();
        assert!(matches!(error, Error::OutputIsModel { .. }), "{error}");
        of(Some(source.path())).check_output(Path::new("other.epJSON")).unwrap();
        of(None).check_output(source.path()).unwrap();
    }
}
