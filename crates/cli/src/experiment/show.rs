//! `b2b experiment list` and `b2b experiment show`.

use anyhow::Result;
use b2b_experiment::{Budget, Experiment, Job, duration_text, estimate};
use serde_json::{Value, json};

use crate::terminal::stdout;
use crate::terminal::table::Table;

/// List the experiments
#[derive(clap::Args)]
pub struct ListArguments {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Describe an experiment: question, agents, number of jobs and estimated duration
#[derive(clap::Args)]
pub struct ShowArguments {
    /// Name of an experiment, or a TOML file
    #[arg(value_name = "EXPERIMENT")]
    experiment: String,
    /// Print the jobs of all budgets as JSON
    #[arg(long)]
    json: bool,
}

/// Runs `list`.
pub fn list(arguments: &ListArguments) -> Result<()> {
    if arguments.json {
        let entry =
            |each: Experiment| json!({"name": each.name, "title": each.title, "question": each.question});
        return stdout::print_json(&Experiment::all().map(entry).collect::<Vec<_>>());
    }
    let mut table = Table::new(["experiment", "title", "budgets", "jobs"]);
    for experiment in Experiment::all() {
        let names: Vec<&str> = experiment.budgets().map(|budget| &budget.name[..]).collect();
        let jobs: Vec<String> =
            experiment.budgets().map(|budget| experiment.jobs(budget).len().to_string()).collect();
        let (names, jobs) = (names.join(", "), jobs.join(", "));
        table.row([experiment.name, experiment.title, names, jobs]);
    }
    stdout::print(&format!("{}\n\n  `b2b experiment show NAME` describes an experiment", table.text()))
}

/// Runs `show`.
pub fn show(arguments: &ShowArguments) -> Result<()> {
    let experiment = Experiment::named(&arguments.experiment)?;
    if arguments.json {
        let keys =
            |budget: &Budget| experiment.jobs(budget).into_iter().map(|job| job.key).collect::<Vec<_>>();
        let mut shown = json!({
            "name": experiment.name, "title": experiment.title, "question": experiment.question, "paper": experiment.paper,
        });
        for budget in experiment.budgets() {
            shown[&budget.name] = Value::from(keys(budget));
        }
        return stdout::print_json(&shown);
    }
    let agents: Vec<String> = experiment.agents.iter().map(|agent| agent.name.clone()).collect();
    let mut table = Table::new(["budget", "jobs", "training steps", "time on 2 cores", "on 64 cores"]);
    for budget in experiment.budgets() {
        let jobs = experiment.jobs(budget);
        let steps: u64 = jobs.iter().map(Job::steps).sum();
        let [two, many] = [2, 64].map(|cores| duration_text(estimate(None, &jobs, cores)));
        table.row([budget.name.clone(), jobs.len().to_string(), steps.to_string(), two, many]);
    }
    stdout::print(&format!(
        "{}\n\n  {}\n  in the paper   {}\n  agents         {}\n\n{}",
        experiment.title,
        experiment.question,
        experiment.paper,
        if agents.is_empty() { "none".to_owned() } else { agents.join(", ") },
        table.text(),
    ))
}
