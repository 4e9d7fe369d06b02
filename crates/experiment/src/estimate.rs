//! Estimates of the duration of jobs.

use std::time::Duration;

use b2b_building::{BuildingType, RunPeriod};

use crate::folder::Folder;
use crate::job::Job;

/// Seconds of preparation of a building: generation, sizing, warm-up, and starting a process.
const PREPARATION: f64 = 6.0;
/// Zone time steps of a day.
const STEPS_PER_DAY: f64 = 288.0;

/// Milliseconds of CPU time of a step of training, environment, inference and learner, and of evaluation. Measured with
/// `b2b bench train` and `b2b bench speed` on two cores of a server; other machines differ, and the jobs that are done correct it.
fn milliseconds(building_type: BuildingType) -> [f64; 2] {
    match building_type {
        BuildingType::SingleFamilyHouse => [0.35, 0.15],
        BuildingType::RestaurantFastFood => [0.4, 0.2],
        BuildingType::Warehouse => [0.5, 0.3],
        BuildingType::RetailStandalone => [0.5, 0.3],
        BuildingType::OfficeSmall => [0.6, 0.35],
        BuildingType::OfficeMedium => [1.2, 0.9],
    }
}

/// Returns the estimated duration of the unfinished jobs with `parallel` jobs at a time, each on a core of its own: no less than
/// that of the longest job. The times of finished jobs correct it.
pub fn estimate(folder: Option<&Folder>, jobs: &[Job], parallel: usize) -> Duration {
    let (mut left, mut longest, mut expected, mut taken) = (0.0, 0.0_f64, 0.0, 0.0);
    for job in jobs {
        let done = folder.and_then(|folder| folder.state(job)).filter(|state| state.error.is_none());
        match done {
            Some(state) => {
                expected += seconds(job);
                taken += state.seconds;
            }
            None => {
                let own = seconds(job);
                left += own;
                longest = longest.max(own);
            }
        }
    }
    let correction = if expected > 0.0 { taken / expected } else { 1.0 };
    Duration::from_secs_f64(correction * longest.max(left / parallel.max(1) as f64))
}

/// Returns a duration as text in its largest unit, such as `48 s`, `13 min` or `2.4 h`.
pub fn duration_text(duration: Duration) -> String {
    match duration.as_secs_f64() {
        seconds @ ..60.0 => format!("{seconds:.0} s"),
        seconds @ ..3570.0 => format!("{:.0} min", seconds / 60.0),
        seconds @ ..36_000.0 => format!("{:.1} h", seconds / 3600.0),
        seconds => format!("{:.0} h", seconds / 3600.0),
    }
}

/// Returns the time of a job on one core, s.
fn seconds(job: &Job) -> f64 {
    let Some(episodes) = job.episodes() else { return 300.0 };
    let type_of = |building: &String| building.split('-').next().and_then(|name| name.parse().ok());
    let types: Vec<BuildingType> = episodes.buildings.iter().filter_map(type_of).collect();
    let mean = |of: usize| {
        types.iter().map(|each| milliseconds(*each)[of] / 1000.0).sum::<f64>() / types.len().max(1) as f64
    };
    let days: u32 = episodes
        .periods
        .iter()
        .filter_map(|period| period.parse::<RunPeriod>().ok())
        .map(|each| each.days())
        .sum();
    let steps = f64::from(days) * STEPS_PER_DAY * (episodes.tasks.len() * episodes.buildings.len()) as f64;
    let training = if job.steps() > 0 { job.steps() as f64 * mean(0) + 8.0 * PREPARATION } else { 0.0 };
    // Most evaluations run the reactive controllers, too, for the baseline.
    training + 2.0 * steps * mean(1) + PREPARATION * episodes.buildings.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Experiment;

    #[test]
    fn more_steps_take_longer_and_more_cores_less() {
        let experiment = Experiment::named("ppo").unwrap();
        let jobs = |budget| experiment.jobs(experiment.budget(budget).unwrap());
        let (quick, full) = (jobs("quick"), jobs("full"));
        assert!(estimate(None, &full, 2) > 50 * estimate(None, &quick, 2));
        assert_eq!(estimate(None, &quick, 4) * 2, estimate(None, &quick, 2));
        assert_eq!(estimate(None, &full, 10_000), estimate(None, &full, 20_000), "the longest job");
        assert_eq!(estimate(None, &[], 2), Duration::ZERO);
    }
}
