//! Tuning episodes in worker processes.

use b2b_building::RunPeriod;
use b2b_control::tune::{Building, Cells, Outcome, Plan, Rollouts, TrainingBuildings};
use b2b_control::{ReactiveParameters, Result};
use b2b_dataset::{BuildingId, Catalog};
use b2b_env::Task;

use crate::progress::Download;
use crate::workers::worker_options;

/// Default run periods of tuning: Sunday to Tuesday in winter and in summer, to include the end of a weekend.
pub const DAYS: [&str; 2] = ["01-08..01-10", "07-09..07-11"];

/// The episodes of a class on its training buildings, which are prepared on first use: a finished plan needs none.
pub struct TrainingRollouts<'a> {
    catalog: &'a Catalog,
    buildings: &'a TrainingBuildings,
    periods: &'a [RunPeriod],
    search: Option<Rollouts>,
    constant: Option<Rollouts>,
    validation: Option<Rollouts>,
}

impl<'a> TrainingRollouts<'a> {
    /// Creates the episodes of these buildings, which are not prepared yet.
    pub fn new(catalog: &'a Catalog, buildings: &'a TrainingBuildings, periods: &'a [RunPeriod]) -> Self {
        Self { catalog, buildings, periods, search: None, constant: None, validation: None }
    }

    /// Returns the outcomes of a building: one for the search, one per setpoint mode for the
    /// validation.
    pub fn simulate(&mut self, parameters: &ReactiveParameters, building: Building) -> Result<Vec<Outcome>> {
        let tasks = Plan::tasks()?;
        let (kept, ids, tasks, index) = match building {
            Building::Search(index) => {
                (&mut self.search, &self.buildings.search, &tasks[tasks.len() - 1..], index)
            }
            Building::Constant(index) => (&mut self.constant, &self.buildings.search, &tasks[..1], index),
            Building::Validation(index) => {
                (&mut self.validation, &self.buildings.validation, &tasks[..], index)
            }
        };
        let ready = match kept {
            Some(ready) => ready,
            none => none.insert(rollouts(self.catalog, ids, self.periods, tasks)?),
        };
        let episodes = ready.run(parameters, index)?;
        Ok(episodes.chunks(self.periods.len()).map(Outcome::of).collect())
    }

    /// Returns the outcomes of all buildings of a plan.
    pub fn cells(&mut self, plan: &Plan, parameters: &ReactiveParameters) -> Result<Cells> {
        let mut all = |count: usize, building: fn(usize) -> Building| -> Result<Vec<Vec<Outcome>>> {
            (0..count).map(|index| self.simulate(parameters, building(index))).collect()
        };
        let (search, validation) = (plan.buildings.len(), plan.validation.len());
        let constant = if plan.constant_targets { search } else { 0 };
        Ok(Cells {
            search: all(search, Building::Search)?.concat(),
            constant: all(constant, Building::Constant)?.concat(),
            validation: all(validation, Building::Validation)?,
        })
    }
}

/// Returns the episodes of these buildings, ready to run. An interrupt ends any wait for them.
pub fn rollouts(
    catalog: &Catalog,
    ids: &[BuildingId],
    periods: &[RunPeriod],
    tasks: &[Task],
) -> Result<Rollouts> {
    let options = worker_options(catalog.library().path());
    Rollouts::new(options, catalog, ids, periods, tasks, &mut Download::new(true))
}
