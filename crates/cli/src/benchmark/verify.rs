//! `b2b benchmark verify`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use b2b_benchmark::entry::{self, Check, Sample};
use b2b_dataset::Catalog;
use serde_json::json;

use crate::evaluate::{Bars, evaluation};
use crate::progress::Download;
use crate::stdout;

/// Check whether a result is what it says
///
/// Recomputes the list of episodes, the scores and the measures, and runs a sample of the episodes and of their baselines
/// once more, to compare them to the bit. Needs the same version of b2b. Exit code 1 when anything differs.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b benchmark verify results/ppo
  b2b benchmark verify results/ppo --episodes 20 --sample-seed 7")]
pub struct Arguments {
    /// Folder of a result
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Episodes to run once more
    #[arg(long, value_name = "N", default_value_t = 3)]
    episodes: usize,
    /// Decides which
    #[arg(long, value_name = "N", default_value_t = 0)]
    sample_seed: u64,
    /// Episodes at a time [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    jobs: Option<u32>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn verify(arguments: &Arguments) -> Result<ExitCode> {
    let catalog = Catalog::open(&mut Download::new(arguments.json))?;
    let evaluation = evaluation(&catalog, arguments.jobs)?;
    let sample = Sample { episodes: arguments.episodes, seed: arguments.sample_seed };
    let bars = Bars::new(arguments.json);
    let checks = entry::verify(&arguments.folder, &evaluation, sample, &bars)?;
    drop(bars);
    let good = checks.iter().all(|check| check.outcome.is_ok());
    if arguments.json {
        let check = |check: &Check| {
            let (Ok(said) | Err(said)) = &check.outcome;
            json!({"what": check.name, "good": check.outcome.is_ok(), "found": said})
        };
        stdout::print_json(&json!({"good": good, "checks": checks.iter().map(check).collect::<Vec<_>>()}))?;
    } else {
        let line = |check: &Check| match &check.outcome {
            Ok(said) => format!("  good   {:<20}{said}", check.name),
            Err(said) => format!("  WRONG  {:<20}{said}", check.name),
        };
        stdout::print(&checks.iter().map(line).collect::<Vec<_>>().join("\n"))?;
    }
    Ok(if good { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
