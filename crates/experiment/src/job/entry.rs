//! The jobs that enter agents on benchmark problems.

use b2b_benchmark::Problem;
use toml::Value;

use super::action::{AGENT, Action, Entry, Episodes, Job, texts, train};
use crate::definition::{Agent, Budget};

/// Returns the job that enters a built-in policy on a problem.
pub(super) fn built_in(policy: &str, problem: &str, budget: &Budget) -> Job {
    let entry = on_problem(problem, budget);
    let action = Action::Enter(Entry { policy: policy.to_owned(), ..entry });
    Job { key: format!("{policy}/{problem}"), actions: vec![action] }
}

/// Returns the job that trains an agent for each seed of a problem and enters them.
pub(super) fn job(agent: &Agent, problem: &str, budget: &Budget) -> Job {
    let entry = on_problem(problem, budget);
    let mut config = agent.options.clone();
    config.insert("problem".to_owned(), Value::String(problem.to_owned()));
    let seeds = match entry.seeds.is_empty() {
        true => named(problem).protocol.seeds,
        false => entry.seeds.clone(),
    };
    let folder = |seed: &dyn std::fmt::Display| format!("{AGENT}-{seed}");
    let mut actions: Vec<Action> =
        seeds.iter().map(|seed| train(&folder(seed), config.clone(), budget.steps, *seed)).collect();
    actions.push(Action::Enter(Entry { policy: folder(&"{seed}"), steps: Some(budget.steps), ..entry }));
    Job { key: format!("{}/{problem}", agent.name), actions }
}

/// Returns an entry on a problem with the seeds and the test buildings of a budget, without a policy.
fn on_problem(name: &str, budget: &Budget) -> Entry {
    let problem = named(name);
    let protocol = &problem.protocol;
    let seeds = protocol.seeds.iter().copied().take(budget.seeds as usize).collect::<Vec<_>>();
    let (all, types) = (problem.test.buildings.ids(), problem.test.buildings.types().len());
    let buildings = budget.buildings.of_all().expect("the definition was checked");
    let tested = problem.test.buildings.sample(buildings * types);
    Entry {
        problem: name.to_owned(),
        policy: String::new(),
        steps: None,
        seeds: if seeds == protocol.seeds { Vec::new() } else { seeds },
        test: if tested.len() == all.len() { Vec::new() } else { texts(&tested) },
        episodes: Episodes {
            buildings: texts(&tested),
            tasks: problem.test.tasks.iter().map(ToString::to_string).collect(),
            periods: protocol.windows.iter().map(ToString::to_string).collect(),
        },
    }
}

fn named(problem: &str) -> Problem {
    Problem::named(problem).expect("the definition was checked")
}
