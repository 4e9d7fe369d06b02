//! `b2b benchmark run`: evaluation of a policy on a problem.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use b2b_benchmark::entry::{Entry, EntryPolicy, RunOutcome};
use b2b_benchmark::problem::{Problem, Stage};
use b2b_evaluate::{ActionScale, Baselines, EpisodeResult};

use super::selection::Selection;
use super::text::text;
use crate::arguments::jobs::Jobs;
use crate::arguments::policy::PolicyArguments;
use crate::program;
use crate::scoring::evaluation::{Bars, evaluation, fetch_weather};
use crate::terminal::exit_code::ExitCode;
use crate::terminal::progress::Download;
use crate::terminal::stdout;

/// Run a policy on a benchmark problem
///
/// Runs the policy in the test environments of a problem and in a sample of its training environments, and writes a
/// result folder: result.json, episodes.parquet, and the files of the policy. Finished episodes are kept: the same
/// command resumes an interrupted run and produces the same bytes. In problems whose policies keep their memory
/// (`adapt-…`), one controller runs all episodes of a building, task and seed in order. Exits with code 1 if an episode
/// fails.
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    policy: PolicyArguments,
    /// Policy for the training environments, if their spaces have other sizes
    #[arg(long, value_name = "POLICY")]
    train_policy: Option<String>,
    /// Policy after STEPS of training in each test environment
    #[arg(long, value_name = "STEPS=POLICY", num_args = 1.., value_parser = adapted)]
    adapted: Vec<(u64, String)>,
    /// Specialists, each trained in one test environment: an upper bound that is reported but not ranked
    #[arg(long, value_name = "POLICY")]
    upper_bound: Option<String>,
    /// Number of training steps of the policy
    #[arg(long, value_name = "N")]
    trained_steps: Option<u64>,
    /// Name on the leaderboard [default: name of the policy]
    #[arg(long, value_name = "NAME")]
    entry: Option<String>,
    /// One-line description of how the policy was trained
    #[arg(long, value_name = "TEXT")]
    description: Option<String>,
    #[command(flatten)]
    jobs: Jobs,
    /// Result folder
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Print result.json instead of the text report
    #[arg(long)]
    json: bool,
    // Last, because its heading applies to all arguments after it.
    #[command(flatten)]
    selection: Selection,
}

const EXAMPLES: &str = "\
Examples:
  b2b benchmark run dynamics-house --policy reactive --out entries/reactive
  b2b benchmark run dynamics-house --policy ppo-{seed}.onnx --trained-steps 4000000 --out entries/ppo
  b2b benchmark run dynamics-house --policy ppo.onnx --adapted 2016=week/{building}.onnx --out entries/tuned
  b2b benchmark run dynamics-house --policy ppo-{seed}.onnx --upper-bound own/{building}.onnx --out entries/bound
  b2b benchmark run cross-domain --train-type Warehouse RetailStandalone --test-type OfficeSmall --policy my.onnx --out x
  b2b benchmark run dynamics-house --period 01-10..01-11 --policy random --out try        a modified problem

In the path of an ONNX policy, {seed}, {building} and {task} stand for the episode's.";

fn adapted(text: &str) -> std::result::Result<(u64, String), String> {
    let pair =
        text.split_once('=').and_then(|(steps, policy)| Some((steps.parse().ok()?, policy.to_owned())));
    pair.ok_or_else(|| format!("`{text}`: expected STEPS=POLICY, such as 2016=week/{{building}}.onnx"))
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let entry = arguments.entry()?;
    entry.check()?;
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    let episodes: Vec<_> = entry.stages().into_iter().flat_map(|stage| entry.episodes(stage)).collect();
    fetch_weather(&episodes, arguments.json)?;
    let evaluation = evaluation(&catalog, arguments.jobs.count()?);
    let bars = Bars::new(arguments.json);
    let ended = entry.run(&arguments.out, &evaluation, &Baselines::open()?, &bars)?;
    drop(bars);
    match ended {
        RunOutcome::Complete(result, _) if arguments.json => stdout::print_json(&result)?,
        RunOutcome::Complete(result, stages) => {
            stdout::print(&format!("{}\n\n  {}", text(&result, &stages), arguments.out.display()))?;
        }
        RunOutcome::Incomplete(rows) => {
            eprintln!("{}", lost(&rows));
            return Ok(ExitCode::Failure);
        }
    }
    Ok(ExitCode::Success)
}

impl Arguments {
    fn entry(&self) -> Result<Entry> {
        let problem = self.selection.problem()?;
        let policy = self.entry_policy(&problem, self.policy.text(), Stage::Test)?;
        let train_policy = self.train_policy.as_ref();
        let train_policy =
            train_policy.map(|text| self.entry_policy(&problem, text, Stage::Train)).transpose()?;
        let mut adapted = BTreeMap::new();
        for (steps, text) in &self.adapted {
            let policy = self.entry_policy(&problem, text, Stage::Adapted(*steps))?;
            if adapted.insert(*steps, policy).is_some() {
                bail!("--adapted is given twice for {steps} steps");
            }
        }
        let upper_bound = self.upper_bound.as_ref();
        let upper_bound =
            upper_bound.map(|text| self.entry_policy(&problem, text, Stage::UpperBound)).transpose()?;
        Ok(Entry {
            name: self.entry.clone().unwrap_or_else(|| policy.name()),
            description: self.description.clone(),
            training_steps: self.trained_steps,
            problem,
            policy,
            train_policy,
            adapted,
            upper_bound,
        })
    }

    /// Returns the scale of the actions of all policies.
    fn scale(&self) -> Result<ActionScale> {
        let others = [&self.train_policy, &self.upper_bound].into_iter().flatten();
        let all = others.chain(self.adapted.iter().map(|(_, policy)| policy)).map(String::as_str);
        self.policy.scale(all.chain([self.policy.text()]))
    }

    fn entry_policy(&self, problem: &Problem, text: &str, stage: Stage) -> Result<EntryPolicy> {
        let seeds = &problem.protocol.seeds;
        let episodes = problem.episodes(stage, &seeds[..1]);
        let policy = EntryPolicy::read(text, self.scale()?, seeds, &episodes);
        policy.with_context(|| format!("no policy for stage {stage}"))
    }
}

fn lost(rows: &[EpisodeResult]) -> String {
    let line = |row: &EpisodeResult| {
        let why = row.outcome.as_ref().map_or_else(ToString::to_string, |_| "undefined score".to_owned());
        format!("failed: {}: {why}", row.info)
    };
    let lines: Vec<_> = rows.iter().map(line).collect();
    format!(
        "{}\na result needs all episodes; run the same command again to retry those that failed",
        lines.join("\n")
    )
}
