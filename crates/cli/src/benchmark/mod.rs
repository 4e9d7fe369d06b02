//! `b2b benchmark`: generalization problems, and results that can be compared and verified.

mod list;
mod report;
mod run;
mod selection;
mod text;
mod verify;

use anyhow::Result;

use crate::terminal::exit_code::ExitCode;

/// Run policies on the benchmark problems, and verify and compare results
///
/// A problem defines what a policy may be trained on, what it is tested on, and the rules for both. A result is a
/// folder with result.json, episodes.parquet and the files of the policy; a second run reproduces the same bytes.
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_help = EXAMPLES)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  b2b benchmark list
  b2b benchmark show dynamics-house
  b2b benchmark run dynamics-house --policy reactive --out entries/reactive
  b2b benchmark run dynamics-house --policy ppo-{seed}.onnx --out entries/ppo
  b2b benchmark verify entries/ppo
  b2b benchmark report entries/* --out leaderboard.html";

#[derive(clap::Subcommand)]
enum Command {
    List(list::ListArguments),
    Show(Box<list::ShowArguments>),
    Run(Box<run::Arguments>),
    Verify(verify::Arguments),
    Report(report::Arguments),
}

/// Runs the command.
pub fn benchmark(arguments: &Arguments) -> Result<ExitCode> {
    match &arguments.command {
        Command::List(arguments) => list::list(arguments)?,
        Command::Show(arguments) => list::show(arguments)?,
        Command::Run(arguments) => return run::run(arguments),
        Command::Verify(arguments) => return verify::verify(arguments),
        Command::Report(arguments) => report::report(arguments)?,
    }
    Ok(ExitCode::Success)
}
