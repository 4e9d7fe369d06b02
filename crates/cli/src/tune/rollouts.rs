//! Tuning episodes in worker processes.

use b2b_building::RunPeriod;
use b2b_control::tune::{CellOutcome, Cells, PlanBuilding, Rollouts, TrainingBuildings, TuningPlan};
use b2b_control::{ReactiveParameters, Result};
use b2b_dataset::{BuildingId, Catalog};
use b2b_env::Task;

use crate::program::worker_options;
use crate::terminal::progress::Download;

/// Default run periods of tuning: Sunday to Tuesday in winter and in summer, to include the end of a weekend.
pub const DAYS: [&str; 2] = ["01-08..01-10", "07-09..07-11"];

/// The episodes of a class on its training buildings, which are prepared on first use because a finished plan needs
/// none.
pub struct TrainingRollouts<'a> {
    catalog: &'a Catalog,
    buildings: &'a TrainingBuildings,
    periods: &'a [RunPeriod],
    constant_targets: bool,
    search: Option<Rollouts>,
    validation: Option<Rollouts>,
}

impl<'a> TrainingRollouts<'a> {
    /// Creates the episodes of a plan for these buildings and periods, which are not prepared yet.
    pub fn new(
        catalog: &'a Catalog,
        buildings: &'a TrainingBuildings,
        periods: &'a [RunPeriod],
        plan: &TuningPlan,
    ) -> Self {
        let constant_targets = plan.constant_targets;
        Self { catalog, buildings, periods, constant_targets, search: None, validation: None }
    }

    /// Returns the outcomes of a building: one for the search, one under constant setpoints, or one per setpoint mode
    /// for the validation.
    pub fn simulate(
        &mut self,
        parameters: &ReactiveParameters,
        building: PlanBuilding,
    ) -> Result<Vec<CellOutcome>> {
        let tasks = TuningPlan::tasks()?;
        // The search uses setpoints by occupancy, preceded by constant ones if the plan requires them.
        let searched = if self.constant_targets { &tasks[..] } else { &tasks[tasks.len() - 1..] };
        let TrainingBuildings { search, validation } = self.buildings;
        let (kept, ids, tasks, index, range) = match building {
            PlanBuilding::Search(index) => {
                (&mut self.search, search, searched, index, searched.len() - 1..searched.len())
            }
            PlanBuilding::Constant(index) => (&mut self.search, search, searched, index, 0..1),
            PlanBuilding::Validation(index) => {
                (&mut self.validation, validation, &tasks[..], index, 0..tasks.len())
            }
        };
        let ready = match kept {
            Some(ready) => ready,
            none => none.insert(rollouts(self.catalog, ids, self.periods, tasks)?),
        };
        let episodes = ready.run(parameters, index, range)?;
        Ok(episodes.chunks(self.periods.len()).map(CellOutcome::of).collect())
    }

    /// Returns the outcomes of all buildings.
    pub fn cells(&mut self, parameters: &ReactiveParameters) -> Result<Cells> {
        let (search, validation) = (self.buildings.search.len(), self.buildings.validation.len());
        let constant = if self.constant_targets { search } else { 0 };
        let mut all = |count: usize, building: fn(usize) -> PlanBuilding| -> Result<Vec<Vec<CellOutcome>>> {
            (0..count).map(|index| self.simulate(parameters, building(index))).collect()
        };
        Ok(Cells {
            search: all(search, PlanBuilding::Search)?.concat(),
            constant: all(constant, PlanBuilding::Constant)?.concat(),
            validation: all(validation, PlanBuilding::Validation)?,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pages_name_the_days_of_the_tuning() {
        let [winter, summer] = DAYS.map(|days| {
            let (first, last) = days.split_once("..").unwrap();
            [first, last].map(|date| date[3..].trim_start_matches('0')).join(" to ")
        });
        for page in [include_str!("../../../../docs/tasks.md"), include_str!("../../../../docs/tuning.md")] {
            let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(page.contains(&format!("{winter} January and {summer} July")), "{winter}, {summer}");
        }
    }
}
