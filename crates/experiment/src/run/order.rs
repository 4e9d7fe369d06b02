//! The order of a job's process: one action.

use serde::{Deserialize, Serialize};

use crate::folder::{CONFIG, ENTRY, EVALUATION, EVALUATION_LAST};
use crate::job::{Action, Entry, Episodes, Job, LAST_AGENT, Measurement};

/// An action, carried out in the folder of its job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Order {
    /// Trains an agent with the options of a file.
    Train { config: String, out: String },
    /// Evaluates a policy.
    Evaluate { policy: String, episodes: Episodes, out: String },
    /// Enters a policy on a benchmark problem.
    Enter { entry: Entry, name: String, out: String },
    /// Runs a benchmark of the program.
    Measure(Measurement),
}

impl Order {
    /// Returns the order of an action of a job.
    pub(super) fn of(action: &Action, job: &Job) -> Self {
        match action {
            Action::Train { agent, .. } => Self::Train { config: CONFIG.into(), out: agent.clone() },
            Action::Evaluate(episodes) => Self::evaluate(job.policy(), episodes, EVALUATION),
            Action::EvaluateLast(episodes) => Self::evaluate(LAST_AGENT, episodes, EVALUATION_LAST),
            Action::Enter(entry) => {
                Self::Enter { entry: entry.clone(), name: job.agent().to_owned(), out: ENTRY.into() }
            }
            Action::Measure(measurement) => Self::Measure(measurement.clone()),
        }
    }

    /// Returns the order to evaluate a policy in a folder.
    pub(super) fn evaluate(policy: &str, episodes: &Episodes, out: &str) -> Self {
        Self::Evaluate { policy: policy.to_owned(), episodes: episodes.clone(), out: out.to_owned() }
    }

    /// Returns the command that does the same, for the log.
    pub(super) fn command(&self) -> String {
        let words = |values: &[String]| values.join(" ");
        match self {
            Self::Train { config, out } => format!("b2b train --config {config} --out {out} --jobs 1 --json"),
            Self::Evaluate { policy, episodes: Episodes { buildings, tasks, periods }, out } => format!(
                "b2b evaluate --policy {policy} --out {out} --jobs 1 --json --task {} --period {} -- {}",
                words(tasks),
                words(periods),
                words(buildings)
            ),
            Self::Enter { entry: Entry { problem, policy, steps, seeds, test, .. }, name, out } => {
                let seeds: Vec<String> = seeds.iter().map(u64::to_string).collect();
                let steps: Vec<String> = steps.iter().map(u64::to_string).collect();
                let options = [("--trained-steps", &steps), ("--seed", &seeds), ("--test", test)];
                let given = options.into_iter().filter(|(_, values)| !values.is_empty());
                let given: String =
                    given.map(|(name, values)| format!(" {name} {}", words(values))).collect();
                format!(
                    "b2b benchmark run {problem} --policy {policy} --entry {name} --out {out} --jobs 1 --json{given}"
                )
            }
            Self::Measure(measurement) => format!("b2b {} --json", words(&measurement.words())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::definition::Experiment;

    #[test]
    fn every_action_of_the_shipped_experiments_is_an_order_that_reads_back() {
        let mut commands = Vec::new();
        for experiment in Experiment::all() {
            for job in experiment.jobs(experiment.budget("quick").unwrap()) {
                for action in &job.actions {
                    let order = Order::of(action, &job);
                    let text = serde_json::to_string(&order).unwrap();
                    assert_eq!(serde_json::from_str::<Order>(&text).unwrap(), order);
                    commands.push(order.command());
                }
            }
        }
        let has = |command: &str| assert!(commands.iter().any(|each| each == command), "{command}");
        has("b2b train --config config.toml --out agent --jobs 1 --json");
        has(
            "b2b bench speed --type OfficeSmall --type OfficeMedium --type RetailStandalone --type RestaurantFastFood --type \
             Warehouse --type SingleFamilyHouse --json",
        );
        let is_entry = |each: &String| {
            each.starts_with("b2b benchmark run ")
                && each.contains(" --entry residual --out entry --jobs 1 --json --trained-steps ")
        };
        assert!(commands.iter().any(is_entry));
    }

    #[test]
    fn the_shipped_measurement_still_belongs_to_its_job() {
        let experiment = Experiment::named("speed").unwrap();
        let jobs = experiment.jobs(experiment.budget("quick").unwrap());
        let text =
            std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../results/speed/jobs.json"));
        assert!(text.unwrap().contains(&jobs[0].actions_sha256()));
    }
}
