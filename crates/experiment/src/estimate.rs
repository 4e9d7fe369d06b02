//! Estimates of the duration of jobs.

use std::time::Duration;

use b2b_building::{BuildingType, Period};

use crate::folder::Folder;
use crate::job::Job;
use crate::rates;

/// Time to prepare a building, s: generation, sizing, warm-up, and starting a process.
const PREPARATION: f64 = 2.5;
/// Number of preparations in a training run: environments, evaluations, and their templates.
const OF_TRAINING: f64 = 8.0;
/// Episodes that a planner simulates for one: the search of `foresight` (unless its schedule is shipped), and the two weeks
/// before an episode for `mpc`.
const OF_PLANNERS: [(&str, f64); 2] = [("foresight", 120.0), ("mpc", 2.0)];
/// Zone time steps of a day.
const STEPS_PER_DAY: f64 = 288.0;

/// Returns the estimated duration of the unfinished jobs with `parallel` jobs at a time, each on its own core; never
/// less than the longest job. Speeds come from `data/rates.csv` and are corrected by the times of finished jobs.
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
    let parsed = |name: &str| name.parse::<BuildingType>().ok();
    let types: Vec<BuildingType> = job.building_types().filter_map(parsed).collect();
    let step_time =
        types.iter().map(|each| 1.0 / rates::of_environment(*each)).sum::<f64>() / types.len().max(1) as f64;
    let periods = episodes.periods.iter().filter_map(|period| period.parse::<Period>().ok());
    let days: u32 = periods.map(|each| each.days()).sum();
    let days_per_episode = f64::from(days) / episodes.periods.len().max(1) as f64;
    let steps = days_per_episode * STEPS_PER_DAY * job.episode_count() as f64;
    let trainings = job.trainings();
    let training = match job.steps() {
        0 => 0.0,
        steps => steps as f64 / rates::of_training(job) + trainings as f64 * OF_TRAINING * PREPARATION,
    };
    // The agent of every seed is evaluated, and mostly the reactive controllers, too, for the baseline.
    let planner = OF_PLANNERS.iter().find(|(name, _)| *name == job.policy());
    let policies = trainings.max(1) as f64 * planner.map_or(1.0, |(_, episodes)| *episodes) + 1.0;
    training + policies * steps * step_time + PREPARATION * episodes.buildings.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Experiment;

    fn jobs(experiment: &str, budget: &str) -> Vec<Job> {
        let experiment = Experiment::named(experiment).unwrap();
        experiment.jobs(experiment.budget(budget).unwrap())
    }

    #[test]
    fn more_steps_take_longer_and_more_cores_less() {
        let (quick, full) = (jobs("ppo", "quick"), jobs("ppo", "full"));
        assert!(estimate(None, &full, 2) > 20 * estimate(None, &quick, 2));
        let halves = (estimate(None, &quick, 4) * 2).abs_diff(estimate(None, &quick, 2));
        assert!(halves < Duration::from_micros(1), "{halves:?}");
        assert_eq!(estimate(None, &full, 10_000), estimate(None, &full, 20_000), "the longest job");
        assert_eq!(estimate(None, &[], 2), Duration::ZERO);
    }

    #[test]
    fn a_training_takes_its_steps_at_the_measured_speed() {
        let jobs = jobs("ppo", "paper-part");
        let of = |key: &str| jobs.iter().find(|job| job.key.starts_with(key)).map(seconds).unwrap();
        // On one core, 5,000,000 steps take 10 minutes in a house and 32 in a medium office.
        let (house, office) = (of("paper/SingleFamilyHouse"), of("paper/OfficeMedium"));
        assert!((580.0..660.0).contains(&house) && (1930.0..2050.0).contains(&office), "{house} {office}");
    }

    #[test]
    fn a_search_takes_its_episodes() {
        let jobs = jobs("supervision", "controllers");
        let of = |key: &str| jobs.iter().find(|job| job.key == key).map(seconds).unwrap();
        let (rule, search) = (of("linear-supervisor/Warehouse"), of("foresight/Warehouse"));
        // 40 episodes of two weeks at 7,398 steps/s.
        let episodes = 40.0 * 14.0 * STEPS_PER_DAY / 7398.0;
        assert!((search - rule - 119.0 * episodes).abs() < 1.0, "{rule} {search}");
    }

    #[test]
    fn an_agent_for_each_seed_of_a_problem_is_trained_prepared_and_tested() {
        let job = jobs("board", "full").into_iter().find(|job| job.key == "residual/dynamics-house").unwrap();
        let [training, .., entry] = &job.actions[..] else { unreachable!() };
        let one = Job { actions: vec![training.clone(), entry.clone()], ..job.clone() };
        let of_each = (seconds(&job) - seconds(&one)) / 8.0;
        // 166 s of training, 20 s of preparation, and 81 s in 100 buildings.
        assert!((260.0..275.0).contains(&of_each), "{of_each}");
    }
}
