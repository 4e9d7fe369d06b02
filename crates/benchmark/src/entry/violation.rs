//! What a problem does not allow of a policy, as far as its files tell.

use b2b_agent::{AgentInfo, TrainingInfo};
use b2b_dataset::BuildingId;
use b2b_env::Task;

use super::entry_policy::EntryPolicy;
use crate::problem::{Attributes, Problem, Stage};

/// Steps by which a run may exceed its budget: it ends after a rollout, which has fewer steps in every preset.
const LAST_ROLLOUT: u64 = 50_000;

/// Returns what a problem does not allow of a policy in a stage, if anything: a file for every test building or task,
/// or an agent whose record contradicts the protocol or the declared training steps. ONNX files and programs have no
/// record.
pub(super) fn violation_of(
    policy: &EntryPolicy,
    problem: &Problem,
    stage: Stage,
    declared: Option<u64>,
) -> Option<String> {
    let unseen = Unseen::of(problem);
    if stage == Stage::Test
        && let Some(why) = unseen.specialists(policy.pattern())
    {
        return Some(why);
    }
    let is_ranked = matches!(stage, Stage::Test | Stage::Train);
    let steps = declared.unwrap_or(problem.protocol.training_steps);
    policy.agents().find_map(|(name, info)| {
        let AgentInfo { training, task, .. } = info;
        let trained = || unseen.seen_by(training, task).or_else(|| longer(training, steps));
        let why = observed(info, problem).or_else(|| if is_ranked { trained() } else { None })?;
        Some(format!("the agent `{name}` {why}"))
    })
}

/// Returns what an agent observes beyond the problem.
fn observed(info: &AgentInfo, problem: &Problem) -> Option<String> {
    let interface = &info.interface;
    let attributes = interface.nodes.map_or(interface.observation.attributes, |nodes| nodes.attributes);
    if attributes && problem.protocol.attributes == Attributes::Withheld {
        return Some(
            "observes attributes of buildings, which are withheld; change the problem to give them".into(),
        );
    }
    let hours = interface.observation.forecast;
    (hours > 0).then(|| format!("observes a forecast of {hours} h, which is not part of the problem"))
}

fn longer(training: &TrainingInfo, steps: u64) -> Option<String> {
    let trained = training.steps;
    (trained > steps + LAST_ROLLOUT).then(|| format!("was trained for {trained} steps, not {steps}"))
}

/// Buildings and tasks that are in the test but not on the training side.
struct Unseen {
    buildings: Vec<BuildingId>,
    tasks: Vec<Task>,
}

impl Unseen {
    fn of(problem: &Problem) -> Self {
        let (train, test) = (&problem.train, &problem.test);
        let known = train.buildings.ids();
        Self {
            buildings: test.buildings.ids().into_iter().filter(|id| !known.contains(id)).collect(),
            tasks: test.tasks.iter().filter(|task| !train.tasks.contains(task)).cloned().collect(),
        }
    }

    /// Describes file names that give each unseen building or task a policy of its own.
    fn specialists(&self, pattern: &str) -> Option<String> {
        let building = self.buildings.first().map(|id| ("{building}", id.to_string()));
        let task = self.tasks.first().map(|task| ("{task}", task.to_string()));
        let (placeholder, unseen) =
            building.into_iter().chain(task).find(|(placeholder, _)| pattern.contains(placeholder))?;
        Some(format!(
            "`{pattern}` has a policy for each {placeholder}, and {unseen} is only in the test; enter specialists as the \
             upper bound, which is not ranked, or as adapted policies"
        ))
    }

    /// Describes what an agent was trained on that it must not have seen before the test.
    fn seen_by(&self, training: &TrainingInfo, task: &Task) -> Option<String> {
        let words = |text: &str| text.split([',', ' ']).map(str::to_owned).collect::<Vec<_>>();
        let names = words(&training.buildings);
        let building = self.buildings.iter().map(ToString::to_string).find(|id| names.contains(id));
        let own = task.to_string();
        let names = words(if training.tasks.is_empty() { &own } else { &training.tasks });
        let task = || self.tasks.iter().map(ToString::to_string).find(|task| names.contains(task));
        let seen = building.or_else(task)?;
        Some(format!("was trained on {seen}, which is only in the test; enter it as the upper bound"))
    }
}

#[cfg(test)]
mod tests {
    use b2b_agent::TrainingInfo;

    use super::*;

    fn problem(name: &str) -> Problem {
        Problem::named(name).unwrap()
    }

    #[test]
    fn files_for_unseen_buildings_or_tasks_are_specialists() {
        let said = |name: &str, pattern| Unseen::of(&problem(name)).specialists(pattern);
        assert!(said("dynamics-house", "own/{building}").unwrap().contains("{building}"));
        assert!(said("goal-leave-one-out", "own-{task}").unwrap().contains("{task}"));
        assert_eq!(said("dynamics-house", "ppo-{task}-{seed}"), None);
        assert_eq!(said("goal-leave-one-out", "{building}"), None);
    }

    #[test]
    fn the_record_of_training_counts() {
        let unseen = Unseen::of(&problem("dynamics-house"));
        let test = unseen.buildings[0].to_string();
        let training = |buildings: &str, steps| TrainingInfo {
            buildings: buildings.to_owned(),
            steps,
            ..TrainingInfo::default()
        };
        let seen = |buildings: &str| unseen.seen_by(&training(buildings, 0), &Task::default());
        assert!(seen(&test).unwrap().contains(&test));
        assert!(seen(&format!("SingleFamilyHouse-0014, {test} in Miami")).unwrap().contains(&test));
        assert_eq!(seen("SingleFamilyHouse of the training split"), None);
        let weights = Unseen::of(&problem("goal-energy-weight"));
        let task = weights.tasks[0].to_string();
        let own = TrainingInfo { tasks: format!("constant, {task}"), ..training("", 0) };
        assert!(weights.seen_by(&own, &Task::default()).unwrap().contains(&task));
        assert_eq!(longer(&training("", 4_018_176), 4_000_000), None);
        assert!(longer(&training("", 76_032), 1).unwrap().contains("76032 steps, not 1"));
    }
}
