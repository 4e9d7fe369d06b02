//! An episode to run.

use std::fmt;

use b2b_building::Period;
use b2b_env::Task;

use crate::subject::Subject;

/// An episode to run.
#[derive(Clone, Debug, PartialEq)]
pub struct EpisodePlan {
    /// The building.
    pub subject: Subject,
    /// The task.
    pub task: Task,
    /// The run period.
    pub period: Period,
    /// Seed of the policy.
    pub seed: u64,
    /// Zone time steps per hour; each is one step of the environment.
    pub steps_per_hour: u32,
}

impl EpisodePlan {
    /// Returns every combination, grouped by building so that each building is prepared only once.
    pub fn combinations(
        subjects: &[Subject],
        periods: &[Period],
        tasks: &[Task],
        seeds: &[u64],
        steps_per_hour: u32,
    ) -> Vec<Self> {
        let mut all = Vec::new();
        for subject in subjects {
            for period in periods {
                for task in tasks {
                    let of_seed = |seed: &u64| Self {
                        subject: subject.clone(),
                        task: task.clone(),
                        period: *period,
                        seed: *seed,
                        steps_per_hour,
                    };
                    all.extend(seeds.iter().map(of_seed));
                }
            }
        }
        all
    }

    /// Returns the number of simulated days.
    pub fn days(&self) -> u64 {
        u64::from(self.period.days())
    }

    /// Returns the number of steps.
    pub fn steps(&self) -> u64 {
        self.days() * 24 * u64::from(self.steps_per_hour)
    }
}

impl fmt::Display for EpisodePlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}, {}, seed {}", self.subject.label(), self.task, self.period, self.seed)
    }
}
