//! The arguments of `b2b` for an action.

use crate::folder::{CONFIG, ENTRY, EVALUATION, EVALUATION_LAST};
use crate::job::{Action, Entry, Episodes, Job, LAST_AGENT};

/// Returns the arguments that run an action of a job, in the folder of the job.
pub(super) fn of(action: &Action, job: &Job) -> Vec<String> {
    match action {
        Action::Train { agent, .. } => {
            words(&["train", "--config", CONFIG, "--out", agent, "--jobs", "1", "--json"])
        }
        Action::Evaluate(episodes) => evaluate(episodes, job.policy(), EVALUATION),
        Action::EvaluateLast(episodes) => evaluate(episodes, LAST_AGENT, EVALUATION_LAST),
        Action::Enter(entry) => enter(entry, job.agent()),
        Action::Measure(arguments) => arguments.iter().cloned().chain(words(&["--json"])).collect(),
    }
}

/// Returns the arguments that evaluate a policy, with the result in a folder.
pub(super) fn evaluate(episodes: &Episodes, policy: &str, folder: &str) -> Vec<String> {
    let Episodes { buildings, tasks, periods } = episodes;
    let mut arguments = words(&["evaluate", "--policy", policy, "--out", folder]);
    arguments.extend(words(&["--jobs", "1", "--json", "--task"]));
    arguments.extend(tasks.iter().cloned());
    arguments.push("--period".into());
    arguments.extend(periods.iter().cloned());
    arguments.push("--".into());
    arguments.extend(buildings.iter().cloned());
    arguments
}

/// Returns the arguments that make an entry.
fn enter(entry: &Entry, name: &str) -> Vec<String> {
    let Entry { problem, policy, steps, seeds, test, .. } = entry;
    let mut arguments = words(&["benchmark", "run", problem, "--policy", policy, "--entry", name]);
    arguments.extend(words(&["--out", ENTRY, "--jobs", "1", "--json"]));
    arguments.extend(steps.iter().flat_map(|steps| ["--trained-steps".into(), steps.to_string()]));
    for (option, values) in [("--seed", seeds.iter().map(u64::to_string).collect()), ("--test", test.clone())]
    {
        if !values.is_empty() {
            arguments.push(option.into());
            arguments.extend(values);
        }
    }
    arguments
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}
