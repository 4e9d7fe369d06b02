//! Lists of episodes: every combination of building, run period, task and seed.

use anyhow::Result;
use b2b_building::Period;
use b2b_env::Task;
use b2b_evaluate::{EpisodePlan, Subject};

use super::buildings::Buildings;
use super::location::Location;

/// The episodes of a command, except for their tasks.
#[derive(clap::Args)]
pub struct Episodes {
    #[command(flatten)]
    buildings: Buildings,
    #[command(flatten)]
    location: Location,
    /// Run periods: winter, summer, full_year or MM-DD..MM-DD; peak-heating, typical-heating, peak-cooling,
    /// typical-cooling or mixed: two weeks chosen from the weather of each building
    #[arg(long = "period", value_name = "PERIOD", num_args = 1.., default_values_t = [Period::WINTER])]
    periods: Vec<Period>,
    /// Random seeds of the policy, one episode each
    #[arg(long = "seed", value_name = "N", num_args = 1.., default_values_t = [0])]
    seeds: Vec<u64>,
    /// Zone time steps per hour
    #[arg(long, default_value_t = 12, value_name = "N")]
    steps_per_hour: u32,
}

impl Episodes {
    /// Returns the episodes, grouped by building so that each building is prepared only once. Errors if there is no
    /// building.
    pub fn list(&self, tasks: &[Task]) -> Result<Vec<EpisodePlan>> {
        let subject = |name| Subject { name, placement: self.location.placement() };
        let subjects: Vec<Subject> = self.buildings.names()?.into_iter().map(subject).collect();
        Ok(EpisodePlan::combinations(&subjects, &self.periods, tasks, &self.seeds, self.steps_per_hour))
    }
}
