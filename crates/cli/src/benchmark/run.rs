//! `b2b benchmark run`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use b2b_benchmark::entry::{Entry, EntryPolicy, RunOutcome, RunResult};
use b2b_benchmark::problem::{Problem, Stage};
use b2b_benchmark::statistics::Aggregate;
use b2b_benchmark::{Baselines, Row};
use b2b_dataset::Catalog;

use super::selection::Selection;
use crate::evaluate::{Actions, Bars, evaluation, fetch_weather};
use crate::progress::Download;
use crate::stdout;
use crate::table::Table;

/// Run a policy on a problem
///
/// Runs the test environments of a problem, and a sample of its training environments, and leaves the result in a
/// folder: result.json, episodes.parquet, and the networks that were run. Every episode is kept as it ends: the same
/// command goes on where it was interrupted, and leaves the same bytes. Exit code 1 when an episode is lost.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    selection: Selection,
    /// Who acts: reactive, random, constant, planner, or an ONNX file; {seed}, {building} and {task} in its name stand
    /// for those of the episode
    #[arg(long, value_name = "POLICY")]
    policy: String,
    /// Who acts on training buildings, where these have other shapes
    #[arg(long, value_name = "POLICY")]
    train_policy: Option<String>,
    /// Who acts after so many steps of training on each test environment
    #[arg(long, value_name = "STEPS=POLICY", num_args = 1.., value_parser = adapted)]
    adapted: Vec<(u64, String)>,
    /// What the numbers of an ONNX policy mean
    #[arg(long, value_enum, default_value_t = Actions::Rescaled)]
    actions: Actions,
    /// Steps that it was trained for
    #[arg(long, value_name = "N")]
    trained_steps: Option<u64>,
    /// Name on the leaderboard [default: that of the policy]
    #[arg(long, value_name = "NAME")]
    entry: Option<String>,
    /// How it came about, in a line
    #[arg(long, value_name = "TEXT")]
    description: Option<String>,
    /// Episodes at a time [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    jobs: Option<u32>,
    /// Folder of the result
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Print result.json instead of a summary for people
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  b2b benchmark run dynamics-house --policy reactive --out results/reactive
  b2b benchmark run dynamics-house --policy ppo-{seed}.onnx --trained-steps 4000000 --out results/ppo
  b2b benchmark run dynamics-house --policy ppo.onnx --adapted 2016=week/{building}.onnx --out results/tuned
  b2b benchmark run cross-domain --train-type Warehouse RetailStandalone --test-type OfficeSmall --policy my.onnx --out x
  b2b benchmark run dynamics-house --period 01-10..01-11 --policy random --out try        (says what is changed)";

fn adapted(text: &str) -> std::result::Result<(u64, String), String> {
    let pair =
        text.split_once('=').and_then(|(steps, policy)| Some((steps.parse().ok()?, policy.to_owned())));
    pair.ok_or_else(|| format!("`{text}`: give STEPS=POLICY, such as 2016=week/{{building}}.onnx"))
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let entry = arguments.entry()?;
    entry.check()?;
    let catalog = Catalog::open(&mut Download::new(arguments.json))?;
    let episodes: Vec<_> = entry.stages().into_iter().flat_map(|stage| entry.episodes(stage)).collect();
    fetch_weather(&episodes, arguments.json)?;
    let evaluation = evaluation(&catalog, arguments.jobs)?;
    let bars = Bars::new(arguments.json);
    let ended = entry.run(&arguments.out, &evaluation, &Baselines::open()?, &bars)?;
    drop(bars);
    match ended {
        RunOutcome::Complete(result, _) if arguments.json => stdout::print_json(&result)?,
        RunOutcome::Complete(result, _) => stdout::print(&text(&result, arguments))?,
        RunOutcome::Incomplete(rows) => {
            eprintln!("{}", lost(&rows));
            return Ok(ExitCode::FAILURE);
        }
    }
    Ok(ExitCode::SUCCESS)
}

impl Arguments {
    fn entry(&self) -> Result<Entry> {
        let problem = self.selection.problem()?;
        let policy = self.entry_policy(&problem, &self.policy, Stage::Test)?;
        let train_policy = self.train_policy.as_ref();
        let train_policy =
            train_policy.map(|text| self.entry_policy(&problem, text, Stage::Train)).transpose()?;
        let mut adapted = BTreeMap::new();
        for (steps, text) in &self.adapted {
            let policy = self.entry_policy(&problem, text, Stage::Adapted(*steps))?;
            if adapted.insert(*steps, policy).is_some() {
                bail!("two policies are given after {steps} steps");
            }
        }
        Ok(Entry {
            name: self.entry.clone().unwrap_or_else(|| policy.name()),
            description: self.description.clone(),
            training_steps: self.trained_steps,
            problem,
            policy,
            train_policy,
            adapted,
        })
    }

    fn entry_policy(&self, problem: &Problem, text: &str, stage: Stage) -> Result<EntryPolicy> {
        let seeds = &problem.protocol.seeds;
        let episodes = problem.episodes(stage, &seeds[..1]);
        let policy = EntryPolicy::read(text, self.actions.scale(), seeds, &episodes);
        policy.with_context(|| format!("no policy for stage {stage}"))
    }
}

fn lost(rows: &[Row]) -> String {
    let line = |row: &Row| {
        let why = row.outcome.as_ref().map_or_else(ToString::to_string, |_| "it has no score".to_owned());
        format!("lost: {}: {why}", row.info)
    };
    let lines: Vec<_> = rows.iter().map(line).collect();
    format!("{}\nthere is no result without them; the same command runs them once more", lines.join("\n"))
}

fn text(result: &RunResult, arguments: &Arguments) -> String {
    let measures = &result.measures;
    let changed = match result.problem_changes.as_deref() {
        Some([]) => String::new(),
        Some(changes) => format!(", changed: {}", changes.join(", ")),
        None => ", a problem of your own".to_owned(),
    };
    let mut text = format!(
        "{} on {}{changed}\nnormalised scores: lower is better, 1 is the reactive controllers\n\n",
        result.name, result.problem.name
    );
    let mut scores = Table::new(["building", "task", "days", "score"]);
    for each in &measures.scores {
        scores.row([
            each.building.clone(),
            each.task.clone(),
            each.period.clone(),
            format!("{:.3}", each.score),
        ]);
    }
    text += &scores.text();
    text += "\n\n";
    let mut table = Table::new(["", "scores", "interquartile mean", "median", "mean", "beat 1"]);
    for stratum in &measures.strata {
        let name = format!("{}, {}, {}", stratum.building_type, stratum.task, stratum.period);
        row(&mut table, name, &stratum.scores);
    }
    row(&mut table, "test".into(), &measures.test);
    if let Some(train) = &measures.train {
        row(&mut table, "train".into(), train);
    }
    if let Some(adaptation) = &measures.adaptation {
        for point in adaptation.curve.iter().skip(1) {
            row(&mut table, format!("test, after {} steps", point.steps), &point.scores);
        }
    }
    text += &table.text();
    if let Some(gap) = measures.generalization_gap {
        text += &format!("\n\n  generalization gap {gap}");
    }
    if let Some(adaptation) = &measures.adaptation {
        let steps = match adaptation.median_steps_to_baseline {
            Some(steps) => format!("{steps:.0} steps"),
            None => "never".to_owned(),
        };
        text += &format!(
            "\n  jump-start {}; half of the buildings at the level of the baseline: {steps}",
            adaptation.jump_start
        );
    }
    text += "\n  in brackets: 95 % intervals of a bootstrap over buildings, stratified by type and task\n\n";
    text + &format!("  {}", arguments.out.display())
}

fn row(table: &mut Table, name: String, scores: &Aggregate) {
    table.row([
        name,
        scores.episodes.to_string(),
        scores.interquartile_mean.to_string(),
        scores.median.to_string(),
        scores.mean.to_string(),
        format!("{:.0} %", scores.beats_baseline_percent()),
    ]);
}
