//! The constraints on a definition that its types do not enforce.

use b2b_benchmark::Problem;
use b2b_building::{BuildingType, Period};
use b2b_dataset::BuildingId;
use b2b_env::Task;
use b2b_evaluate::BuiltIn;
use b2b_learn::train::TrainConfig;

use super::agent::{Agent, Training};
use super::budget::{Budget, Buildings};
use super::experiment::{Experiment, ReportKind};

/// Returns the fault of a definition; `None` if it has none.
pub(super) fn fault(experiment: &Experiment) -> Option<String> {
    let checks = [tasks, budgets, controllers, agents, problems, subjects];
    checks.iter().find_map(|check| check(experiment).err())
}

fn tasks(experiment: &Experiment) -> Result<(), String> {
    for tasks in experiment.budgets().map(|budget| experiment.with_tasks_of(budget).tasks) {
        for task in &tasks {
            task.parse::<Task>().map_err(|error| error.to_string())?;
        }
        if let Some(task) = repeated(&tasks) {
            return Err(format!("task `{task}` is listed twice"));
        }
    }
    for period in &experiment.periods {
        period.parse::<Period>().map_err(|error| error.to_string())?;
    }
    Ok(())
}

fn budgets(experiment: &Experiment) -> Result<(), String> {
    for name in experiment.budgets.keys() {
        check_name("budget", name)?;
        if ["quick", "full"].contains(&&name[..]) {
            return Err(format!("two budgets are named `{name}`"));
        }
    }
    for budget in experiment.budgets() {
        let name = &budget.name;
        let is_known = |agent: &&String| experiment.agents.iter().any(|each| each.name == **agent);
        if let Some(unknown) = budget.agents.iter().flatten().find(|agent| !is_known(agent)) {
            return Err(format!("budget `{name}`: the experiment has no agent `{unknown}`"));
        }
        subset(experiment, budget).map_err(|error| format!("budget `{name}`: {error}"))?;
    }
    Ok(())
}

/// Checks the tasks and the buildings of a budget and of its agents.
fn subset(experiment: &Experiment, budget: &Budget) -> Result<(), String> {
    let of_agents = experiment.agents.iter().map(|agent| agent.budget(budget).buildings);
    let all: Vec<Buildings> = of_agents.chain([budget.buildings.clone()]).collect();
    let (are_numbers, has_tasks) = (all.iter().all(|each| each.of_all().is_some()), budget.tasks.is_some());
    if experiment.report == ReportKind::Board && (!are_numbers || budget.with_best || has_tasks) {
        return Err("`buildings` other than a number, `tasks` and `with_best` are for experiments without \
                    `problems`"
            .into());
    }
    if experiment.measure.is_some() && (!are_numbers || has_tasks) {
        return Err("`buildings` and `tasks` have no effect with `measure`; remove them".into());
    }
    if budget.tasks.as_ref().is_some_and(Vec::is_empty) {
        return Err("`tasks` is empty".into());
    }
    all.iter().try_for_each(|each| listed(experiment, each))
}

/// Checks that listed buildings are test buildings of the types, some of each.
fn listed(experiment: &Experiment, buildings: &Buildings) -> Result<(), String> {
    let ids = buildings.ids();
    if ids.is_empty() {
        return Ok(());
    }
    let all: Vec<BuildingId> =
        experiment.types.iter().flat_map(|each| experiment.buildings(*each, usize::MAX)).collect();
    if let Some(id) = ids.iter().find(|id| !all.contains(id)) {
        return Err(format!("`buildings` lists {id}, which is not a test building of the experiment"));
    }
    if let Some(id) = repeated(ids) {
        return Err(format!("`buildings` lists {id} twice"));
    }
    let is_missing = |each: &&BuildingType| experiment.tests(**each, buildings).is_empty();
    experiment
        .types
        .iter()
        .find(is_missing)
        .map_or(Ok(()), |each| Err(format!("`buildings` lists no {each}")))
}

/// Returns the first item that equals an earlier one.
fn repeated<T: PartialEq>(items: &[T]) -> Option<&T> {
    items.iter().enumerate().find(|(number, item)| items[..*number].contains(item)).map(|(_, item)| item)
}

fn controllers(experiment: &Experiment) -> Result<(), String> {
    let all: Vec<&str> = experiment.kept_controllers().collect();
    for name in &all {
        name.parse::<BuiltIn>().map_err(|error| error.to_string())?;
    }
    repeated(&all).map_or(Ok(()), |name| Err(format!("controller `{name}` is listed twice")))
}

fn agents(experiment: &Experiment) -> Result<(), String> {
    for (number, agent) in experiment.agents.iter().enumerate() {
        check_name("agent", &agent.name)?;
        let is_taken = experiment.agents[..number].iter().any(|other| other.name == agent.name);
        if is_taken || agent.name.parse::<BuiltIn>().is_ok() {
            return Err(format!("two agents are named `{}`", agent.name));
        }
        options(agent).map_err(|error| format!("agent `{}`: {error}", agent.name))?;
        let has_tasks =
            |budget: &Budget| budget.has(&agent.name) && experiment.with_tasks_of(budget).tasks.len() > 1;
        let is_split = !agent.all_tasks && experiment.budgets().any(has_tasks)
            || !agent.all_periods && experiment.periods.len() > 1;
        if experiment.report == ReportKind::Operation && is_split {
            return Err(format!(
                "agent `{}`: `report = \"operation\"` adds up periods and compares tasks; set `all_tasks` and \
                 `all_periods` to true",
                agent.name
            ));
        }
        for name in agent.changed_budgets() {
            let budget = experiment
                .budgets
                .get(name)
                .ok_or_else(|| format!("agent `{}`: the experiment has no budget `{name}`", agent.name))?;
            if !budget.has(&agent.name) {
                return Err(format!("agent `{}`: budget `{name}` does not have it in `agents`", agent.name));
            }
        }
    }
    Ok(())
}

/// Options of training that an experiment sets itself.
const SET: [&str; 7] = ["steps", "seed", "task", "period", "buildings", "building_type", "problem"];

fn options(agent: &Agent) -> Result<(), String> {
    if let Some(option) = SET.into_iter().find(|option| agent.options.contains_key(*option)) {
        return Err(format!("`options.{option}` is set by the experiment; remove it"));
    }
    let text = toml::to_string(&agent.options).map_err(|error| error.to_string())?;
    TrainConfig::default().with_changes(&text).map(drop)
}

fn check_name(kind: &str, name: &str) -> Result<(), String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-';
    match !name.is_empty() && name.chars().all(is_plain) {
        true => Ok(()),
        false => Err(format!("invalid {kind} name `{name}`; expected letters, digits and hyphens")),
    }
}

/// Checks the problems, and that agents are entered on problems if and only if the report is a leaderboard.
fn problems(experiment: &Experiment) -> Result<(), String> {
    for name in &experiment.problems {
        Problem::named(name).map_err(|error| error.to_string())?;
    }
    for agent in &experiment.agents {
        let is_entered = agent.trains == Training::Problem;
        if is_entered != (experiment.report == ReportKind::Board) || is_entered == agent.problems.is_empty() {
            return Err(format!(
                "agent `{}`: an agent is entered on `problems` if it `trains = \"problem\"` for `report = \"board\"`, and \
                 only then",
                agent.name
            ));
        }
        if is_entered && (agent.all_tasks || agent.all_periods) {
            return Err(format!(
                "agent `{}`: `all_tasks` and `all_periods` have no effect with `trains = \"problem\"`; remove them",
                agent.name
            ));
        }
        if let Some(other) = agent.problems.iter().find(|name| !experiment.problems.contains(name)) {
            return Err(format!("agent `{}`: `{other}` is not in the experiment's `problems`", agent.name));
        }
    }
    Ok(())
}

/// Checks that there is something to run or measure.
fn subjects(experiment: &Experiment) -> Result<(), String> {
    let Experiment { types, problems, tasks, periods, climate_zones, measure, controllers, .. } = experiment;
    let is_board = experiment.report == ReportKind::Board;
    if is_board == problems.is_empty() {
        return Err("`problems` belongs to `report = \"board\"`, which needs it".into());
    }
    if is_board {
        return Ok(());
    }
    if types.is_empty() {
        return Err("`types` is empty".into());
    }
    if types.iter().any(|each| experiment.buildings(*each, 1).is_empty()) {
        return Err(format!("no test building is in the climate zones {}", climate_zones.join(", ")));
    }
    let runs = experiment.reactive || !controllers.is_empty() || !experiment.agents.is_empty();
    if runs && (tasks.is_empty() || periods.is_empty()) {
        return Err("it has agents or controllers, but `tasks` or `periods` is empty".into());
    }
    if runs == measure.is_some() {
        return Err(
            "it has either agents (or `controllers`, or `reactive = true`) or a benchmark under `measure`"
                .into(),
        );
    }
    Ok(())
}
