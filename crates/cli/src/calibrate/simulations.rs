//! Simulations of a calibration, each in its own process: the engine runs once at a time in a process.

use std::cell::RefCell;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use b2b_base::scratch::temporary_folder;
use b2b_building::calibration::Metered;
use b2b_building::edit::{self, Change};
use b2b_building::{Model, MonthlyEnergy};
use indicatif::ProgressBar;
use rayon::prelude::*;
use tempfile::TempDir;

use super::{FoundModel, edits};
use crate::arguments::jobs::Jobs;
use crate::progress::counter;
use crate::{child, interrupt};

/// Simulations of a model with different multipliers.
pub struct Simulations<'a> {
    model: &'a Model,
    weather: &'a Path,
    metered: &'a Metered,
    parameters: &'a [Change],
    threads: rayon::ThreadPool,
    folder: TempDir,
    bar: ProgressBar,
    /// Every simulation so far, by the logarithms of its multipliers.
    done: RefCell<Vec<(Vec<f64>, MonthlyEnergy)>>,
}

impl<'a> Simulations<'a> {
    /// Creates simulations, with a progress bar unless `quiet`.
    pub fn new(
        found: &'a FoundModel,
        metered: &'a Metered,
        parameters: &'a [Change],
        jobs: &Jobs,
        quiet: bool,
    ) -> Result<Self> {
        Ok(Self {
            model: &found.model,
            weather: &found.weather,
            metered,
            parameters,
            threads: jobs.thread_pool()?,
            folder: temporary_folder("b2b-calibration-")?,
            bar: counter(0, "simulations", quiet),
            done: RefCell::default(),
        })
    }

    /// Returns the residuals of each point of a batch: simulated minus metered energy, over the mean metered energy of
    /// the fuel.
    pub fn residuals(&self, batch: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        self.run(batch)?;
        batch.iter().map(|point| Ok(self.residuals_of(&self.energy_at(point)?))).collect()
    }

    fn residuals_of(&self, energy: &MonthlyEnergy) -> Vec<f64> {
        let mut residuals = Vec::new();
        for (fuel, metered) in &self.metered.fuels {
            let mean = metered.iter().sum::<f64>() / metered.len() as f64;
            let simulated = self.metered.months.iter().map(|month| energy.fuel(*fuel)[month - 1]);
            residuals.extend(
                metered.iter().zip(simulated).map(|(metered, simulated)| (simulated - metered) / mean),
            );
        }
        residuals
    }

    /// Returns the energy of a point, which is simulated unless it was before.
    pub fn energy_at(&self, point: &[f64]) -> Result<MonthlyEnergy> {
        let known = |simulations: &Self| {
            let done = simulations.done.borrow();
            done.iter().find(|(other, _)| other == point).map(|(_, energy)| *energy)
        };
        if known(self).is_none() {
            self.run(&[point.to_vec()])?;
        }
        known(self).context("a simulation has no result")
    }

    /// Returns the number of simulations so far.
    pub fn count(&self) -> usize {
        self.done.borrow().len()
    }

    /// Removes the progress bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Simulates the points of a batch that were not simulated before, in parallel.
    fn run(&self, batch: &[Vec<f64>]) -> Result<()> {
        let mut new: Vec<&Vec<f64>> = Vec::new();
        for point in batch {
            let is_done = self.done.borrow().iter().any(|(done, _)| done == point);
            if !is_done && !new.contains(&point) {
                new.push(point);
            }
        }
        self.bar.inc_length(new.len() as u64);
        let (model, weather, parameters, folder, bar) =
            (self.model, self.weather, self.parameters, self.folder.path(), &self.bar);
        let one = |(number, point): (usize, &&Vec<f64>)| {
            interrupt::check()?;
            let mut edited = model.clone();
            edit::apply(&mut edited, &edits(parameters, point))?;
            let energy = simulate(&edited, weather, &folder.join(format!("{number}.epJSON")))?;
            bar.inc(1);
            anyhow::Ok(energy)
        };
        let energies: Result<Vec<_>> = self.threads.install(|| new.par_iter().enumerate().map(one).collect());
        self.done.borrow_mut().extend(new.into_iter().cloned().zip(energies?));
        Ok(())
    }
}

/// Simulates a model in its own process.
fn simulate(model: &Model, weather: &Path, file: &PathBuf) -> Result<MonthlyEnergy> {
    std::fs::write(file, model.to_epjson()).with_context(|| format!("cannot write {}", file.display()))?;
    // The names of files in the model are absolute, and this process has checked them.
    let arguments: [OsString; 6] = [
        "calibrate".into(),
        file.into(),
        "--simulate".into(),
        "--allow-external".into(),
        "--weather".into(),
        weather.into(),
    ];
    let text = child::run(arguments)?.map_err(|error| anyhow!(error))?;
    Ok(serde_json::from_str(&text)?)
}
