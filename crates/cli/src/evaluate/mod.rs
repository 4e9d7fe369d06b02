//! `b2b evaluate`: evaluation of a policy on many buildings.

mod compare;
mod table;

use std::path::PathBuf;

use anyhow::{Context, Result};
use b2b_env::Task;
use b2b_evaluate::{Baselines, EpisodePlan, Folder, Policy, Results, Summary};

use crate::arguments::episodes::Episodes;
use crate::arguments::jobs::Jobs;
use crate::arguments::policy::PolicyArguments;
use crate::arguments::task;
use crate::program;
use crate::scoring::evaluation::{Bars, evaluation, fetch_weather};
use crate::terminal::exit_code::ExitCode;
use crate::terminal::progress::Download;
use crate::terminal::stdout;

/// Evaluate a policy on many buildings and score it against the baseline
///
/// Runs every combination of building, task, run period and seed, each episode in its own process, and writes
/// episodes.parquet (one row per episode), summary.json (what --json prints) and report.html (opens in any browser,
/// no network needed). The score is the return divided by the reactive controllers' return in the same episode; in
/// tasks of operation, the cost divided by guideline36's, plus a penalty for more discomfort. Lower is better; the
/// baseline scores 1. Finished episodes are kept: the same command resumes an interrupted evaluation. Exits with code
/// 1 if an episode fails.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = EXAMPLES
)]
pub struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    // Not an `Option`: clap would never fill it, because it flattens other arguments.
    #[command(flatten)]
    run: Run,
}

#[derive(clap::Subcommand)]
enum Command {
    Compare(compare::Arguments),
}

/// The evaluation of a policy.
#[derive(clap::Args)]
struct Run {
    #[command(flatten)]
    policy: PolicyArguments,
    #[command(flatten)]
    episodes: Episodes,
    /// Tasks (see `b2b run --help`) [default: operate; with an agent, the task that it was trained for]
    #[arg(long = "task", value_name = "TASK", num_args = 1.., value_parser = Task::from_text)]
    tasks: Vec<Task>,
    #[command(flatten)]
    jobs: Jobs,
    /// Output folder
    #[arg(long, value_name = "FOLDER", required = true)]
    out: Option<PathBuf>,
    /// Print one JSON object instead of the text report
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  b2b evaluate --policy own --out b2b-out/own              one winter in each of the 48 buildings of test_small
  b2b evaluate --policy ppo.onnx --type OfficeSmall --task constant occupancy --period winter summer --out ppo
  b2b evaluate --policy random --seed 0 1 2 --split test --out random
  b2b evaluate compare own ppo                             several evaluations on one page
  b2b evaluate --policy planner OfficeSmall-0042 --period 01-01..01-01 --out planner

An ONNX policy maps a float32 array [1, observation], unscaled and ordered as `b2b show BUILDING --observations`
lists it, to an array [1, action]. Actions range from -1 to 1 between the bounds of each actuator; use
--actions physical for policies that output physical units.";

/// Runs the command.
pub fn evaluate(arguments: &Arguments) -> Result<ExitCode> {
    match &arguments.command {
        Some(Command::Compare(arguments)) => compare::compare(arguments),
        None => run(&arguments.run),
    }
}

impl Run {
    /// Returns the given tasks; by default the policy's training task, else `operate`.
    fn tasks(&self, policy: &dyn Policy) -> Vec<Task> {
        match &self.tasks[..] {
            [] => vec![policy.trained_task().cloned().unwrap_or_else(task::usual)],
            given => given.to_vec(),
        }
    }
}

fn run(arguments: &Run) -> Result<ExitCode> {
    let policy = arguments.policy.load()?;
    let episodes = arguments.episodes.list(&arguments.tasks(policy.as_ref()))?;
    let out = arguments.out.as_deref().context("--out is required")?;
    Folder::open(out, policy.as_ref(), &episodes)?
        .carry_out(|folder| evaluate_into(folder, arguments, policy.as_ref(), &episodes))
}

fn evaluate_into(
    folder: &Folder,
    arguments: &Run,
    policy: &dyn Policy,
    episodes: &[EpisodePlan],
) -> Result<ExitCode> {
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    fetch_weather(episodes, arguments.json)?;
    let evaluation = evaluation(&catalog, arguments.jobs.count()?);
    let baselines = Baselines::open()?;
    let bars = Bars::new(arguments.json);
    let results = Results::of(&evaluation, folder, episodes, policy, &baselines, &bars)?;
    drop(bars);
    let summary = results.summary(policy);
    let files = results.write(folder, &summary)?;
    stdout::print_result(arguments.json, &summary, || text(&summary, &files))?;
    Ok(ExitCode::of(summary.lost.is_empty()))
}

/// Returns the text report.
fn text(summary: &Summary, files: &[PathBuf]) -> String {
    let mut text: String =
        summary.windows.iter().map(|window| table::window_text(&summary.policy, window)).collect();
    for lost in &summary.lost {
        text += &format!("failed: {lost}\n");
    }
    if !summary.lost.is_empty() {
        text += "  run the same command again to retry the failed episodes\n\n";
    }
    let files: Vec<_> = files.iter().map(|file| format!("  {}", file.display())).collect();
    text + &files.join("\n")
}
