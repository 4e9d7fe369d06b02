//! `b2b benchmark`: the four problems, and results that strangers can compare.

mod list;
mod report;
mod run;
mod selection;
mod verify;

use std::process::ExitCode;

use anyhow::Result;

/// Run a policy on the benchmark problems, check results and compare them
///
/// A problem says what a policy may be trained on, what it is tested on, and by which rules. A result is a folder with
/// result.json, episodes.parquet and the networks that were run; two runs leave the same bytes.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

const EXAMPLES: &str = "\
Examples:
  b2b benchmark list
  b2b benchmark show dynamics-house
  b2b benchmark run dynamics-house --policy reactive --out results/reactive
  b2b benchmark run dynamics-house --policy ppo-{seed}.onnx --out results/ppo
  b2b benchmark verify results/ppo
  b2b benchmark report results/* --out leaderboard.html";

#[derive(clap::Subcommand)]
enum What {
    List(list::ListArguments),
    Show(Box<list::ShowArguments>),
    Run(Box<run::Arguments>),
    Verify(verify::Arguments),
    Report(report::Arguments),
}

/// Runs the command.
pub fn benchmark(arguments: &Arguments) -> Result<ExitCode> {
    match &arguments.what {
        What::List(arguments) => list::list(arguments)?,
        What::Show(arguments) => list::show(arguments)?,
        What::Run(arguments) => return run::run(arguments),
        What::Verify(arguments) => return verify::verify(arguments),
        What::Report(arguments) => report::report(arguments)?,
    }
    Ok(ExitCode::SUCCESS)
}
