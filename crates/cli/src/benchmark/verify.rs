//! `b2b benchmark verify`: verification of a result.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use anyhow::{Context, Result};
use b2b_benchmark::entry::{self, Check, Sample};
use serde_json::json;

use crate::arguments::jobs::Jobs;
use crate::program;
use crate::scoring::evaluation::{Bars, evaluation};
use crate::terminal::exit_code::ExitCode;
use crate::terminal::progress::Download;
use crate::terminal::stdout;

/// Verify a result
///
/// Recomputes the list of episodes, the scores and the aggregate measures, checks the SHA-256 of every policy,
/// simulates a random sample of the episodes and of their baselines again, and compares them bit for bit, or within
/// 1e-6 if the result is from a machine that rounds differently. Requires the version of b2b that wrote the result.
/// Exits with code 1 if anything differs, and if the episodes cannot be run again because the policy is the author's
/// own program: such a result is unverified.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b benchmark verify entries/ppo
  b2b benchmark verify entries/ppo --episodes 20 --sample-seed 7"
)]
pub struct Arguments {
    /// Result folder
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Number of episodes to simulate again, at least 1, or of sequences of episodes if the policy keeps its memory
    /// [default: enough to find a forged one with a probability of 95 % if a tenth of them are forged]
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    episodes: Option<NonZeroUsize>,
    /// Random seed of the choice of episodes, to repeat a verification [default: from the operating system]
    #[arg(long, value_name = "N")]
    sample_seed: Option<u64>,
    #[command(flatten)]
    jobs: Jobs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn verify(arguments: &Arguments) -> Result<ExitCode> {
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    let evaluation = evaluation(&catalog, arguments.jobs.count()?);
    let seed = match arguments.sample_seed {
        Some(seed) => seed,
        None => getrandom::u32()
            .context("cannot get a random seed from the operating system; pass --sample-seed")?
            .into(),
    };
    let sample = Sample { episodes: arguments.episodes, seed };
    let bars = Bars::new(arguments.json);
    let checks = entry::verify(&arguments.folder, &evaluation, sample, &bars)?;
    drop(bars);
    let passed = checks.iter().all(Check::passed);
    if arguments.json {
        let check = |check: &Check| {
            let (Ok(message) | Err(message)) = &check.outcome;
            json!({"check": check.name, "passed": check.passed(), "unverified": check.unverified, "message": message})
        };
        stdout::print_json(
            &json!({"passed": passed, "sample_seed": seed, "checks": checks.iter().map(check).collect::<Vec<_>>()}),
        )?;
    } else {
        let line = |check: &Check| match &check.outcome {
            Ok(message) if check.unverified => format!("  UNVERIFIED  {:<16}{message}", check.name),
            Ok(message) => format!("  passed  {:<20}{message}", check.name),
            Err(message) => format!("  FAILED  {:<20}{message}", check.name),
        };
        stdout::print(&checks.iter().map(line).collect::<Vec<_>>().join("\n"))?;
    }
    Ok(ExitCode::of(passed))
}

fn at_least_one(text: &str) -> Result<NonZeroUsize, String> {
    text.parse().map_err(|_| {
        "expected a whole number of at least 1: the other checks alone do not find a forged episode".into()
    })
}
