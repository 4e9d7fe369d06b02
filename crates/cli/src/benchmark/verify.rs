//! `b2b benchmark verify`: the check of a result.

use std::path::PathBuf;

use anyhow::Result;
use b2b_benchmark::entry::{self, Check, Sample};
use b2b_dataset::Catalog;
use serde_json::json;

use crate::arguments::jobs::Jobs;
use crate::evaluation::{Bars, evaluation};
use crate::exit_code::ExitCode;
use crate::progress::Download;
use crate::stdout;

/// Verify a result
///
/// Recomputes the list of episodes, the scores and the aggregate measures, simulates a sample of the episodes and of
/// their baselines again, and compares them bit for bit. Requires the version of b2b that wrote the result. Exits with
/// code 1 if anything differs.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b benchmark verify results/ppo
  b2b benchmark verify results/ppo --episodes 20 --sample-seed 7"
)]
pub struct Arguments {
    /// Result folder
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Number of episodes to simulate again
    #[arg(long, value_name = "N", default_value_t = 3)]
    episodes: usize,
    /// Random seed of the choice of episodes
    #[arg(long, value_name = "N", default_value_t = 0)]
    sample_seed: u64,
    #[command(flatten)]
    jobs: Jobs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn verify(arguments: &Arguments) -> Result<ExitCode> {
    let catalog = Catalog::open(&mut Download::new(arguments.json))?;
    let evaluation = evaluation(&catalog, arguments.jobs.count()?);
    let sample = Sample { episodes: arguments.episodes, seed: arguments.sample_seed };
    let bars = Bars::new(arguments.json);
    let checks = entry::verify(&arguments.folder, &evaluation, sample, &bars)?;
    drop(bars);
    let passed = checks.iter().all(|check| check.outcome.is_ok());
    if arguments.json {
        let check = |check: &Check| {
            let (Ok(message) | Err(message)) = &check.outcome;
            json!({"check": check.name, "passed": check.outcome.is_ok(), "message": message})
        };
        stdout::print_json(
            &json!({"passed": passed, "checks": checks.iter().map(check).collect::<Vec<_>>()}),
        )?;
    } else {
        let line = |check: &Check| match &check.outcome {
            Ok(message) => format!("  passed  {:<20}{message}", check.name),
            Err(message) => format!("  FAILED  {:<20}{message}", check.name),
        };
        stdout::print(&checks.iter().map(line).collect::<Vec<_>>().join("\n"))?;
    }
    Ok(ExitCode::of(passed))
}
