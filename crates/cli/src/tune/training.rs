//! Episodes of the commands that tune supervisors of Guideline 36, and the training buildings they run in.

use anyhow::Result;
use b2b_base::spread::spread;
use b2b_building::{BuildingType, Period};
use b2b_climate::TwoWeeks;
use b2b_dataset::{BuildingId, BuildingName, Catalog, Placement, Split};
use b2b_env::{EpisodeConfig, Task};
use b2b_workers::{Episode, EpisodeSetting, Source, Workers};

use crate::arguments::task;
use crate::program::worker_options;
use crate::terminal::interrupt;
use crate::terminal::progress::Download;

/// Zone time steps per hour.
const STEPS_PER_HOUR: u32 = 12;

/// Training buildings, run periods and a task of operation.
#[derive(clap::Args)]
pub struct TrainingBuildings {
    /// Building types, each with its own result
    #[arg(long = "type", value_name = "TYPE", num_args = 1.., required = true)]
    pub types: Vec<BuildingType>,
    /// Number of training buildings of a type, evenly spread over the training split
    #[arg(long, default_value_t = 24, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    buildings: u32,
    /// Run periods [default: the five two-week periods]
    #[arg(long = "period", value_name = "PERIOD", num_args = 1..)]
    periods: Vec<Period>,
    /// Task of operation [default: operate]
    #[arg(long, value_name = "TASK", value_parser = Task::from_text)]
    task: Option<Task>,
}

impl TrainingBuildings {
    /// Returns the buildings of a type.
    pub fn ids(&self, building_type: BuildingType) -> Vec<BuildingId> {
        let rows = b2b_dataset::rows(building_type).iter().filter(|row| row.split == Split::Train);
        spread(&rows.map(|row| row.id).collect::<Vec<_>>(), self.buildings as usize)
    }

    /// Returns the run periods.
    pub fn periods(&self) -> Vec<Period> {
        match self.periods.is_empty() {
            true => TwoWeeks::ALL.map(Period::TwoWeeks).to_vec(),
            false => self.periods.clone(),
        }
    }

    /// Returns the task.
    pub fn task(&self) -> Task {
        self.task.clone().unwrap_or_else(task::usual)
    }

    /// Returns the episode of a building in a run period.
    pub fn episode(&self, catalog: &Catalog, id: BuildingId, period: Period) -> Result<Episode> {
        interrupt::check()?;
        episode(catalog, (&BuildingName::Id(id), &Placement::default()), period, STEPS_PER_HOUR, self.task())
    }
}

/// Returns the episode of a building at a place in a run period.
pub fn episode(
    catalog: &Catalog,
    (building, placement): (&BuildingName, &Placement),
    period: Period,
    steps_per_hour: u32,
    task: Task,
) -> Result<Episode> {
    let found = catalog.find(building, placement, &mut Download::new(true))?;
    let weather = found.weather.clone();
    let period = period.in_weather(&weather)?;
    let config = EpisodeConfig { weather, period, steps_per_hour, task };
    let workers = Workers::new(worker_options(catalog.library().path()))?;
    Ok(workers.episode(&EpisodeSetting::new(Source::from(found), config))?)
}
