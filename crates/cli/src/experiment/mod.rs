//! `b2b experiment`: the paper's experiments and your own, as lists of resumable jobs.

mod check;
mod claims;
mod rates;
mod report;
mod run;
mod show;

use std::path::Path;

use anyhow::{Result, bail};
use b2b_experiment::{Experiment, Folder, Results};

use crate::terminal::exit_code::ExitCode;

/// Run the paper's experiments and your own
///
/// An experiment trains and evaluates agents and writes one page that shows the results beside the paper's. Its jobs
/// are independent: they run in parallel, resume after an interruption, and can be divided between machines with
/// --shard.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b experiment list
  b2b experiment show ppo
  b2b experiment run speed
  b2b experiment run dynamics --budget quick --out experiments/dynamics
  b2b experiment run ppo --budget full --shard 0/16 --out experiments/ppo   one of 16 parts, into a shared folder
  b2b experiment run ppo --budget paper-part --out experiments/ppo-paper    one of the experiment's other budgets
  b2b experiment run ppo --reuse results/residual --out experiments/ppo     agents that are there already
  b2b experiment run mine.toml --budget quick
  b2b experiment report experiments/dynamics
  b2b experiment check results/residual                                     evaluate agents again
  b2b experiment claims results/*/                                          the claims of the paper, judged"
)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    List(show::ListArguments),
    Show(show::ShowArguments),
    Run(run::Arguments),
    Report(report::Arguments),
    Check(check::Arguments),
    Claims(claims::Arguments),
    Rates(rates::Arguments),
}

/// Reads the results in a folder, with a note on standard error if they are of other versions.
fn read(path: &Path) -> b2b_experiment::Result<(Folder, Experiment, Results)> {
    let (folder, experiment, budget) = Folder::open(path)?;
    let results = Results::read(&folder, &experiment, &budget)?;
    if let Some(outdated) = results.outdated() {
        eprintln!("{}: {outdated}", path.display());
    }
    Ok((folder, experiment, results))
}

/// Runs an experiment like `b2b experiment run`. Errors if a job fails.
pub(crate) fn carry_out(arguments: &run::Arguments) -> Result<String> {
    crate::terminal::interrupt::be_patient();
    match &run::failures(arguments)?[..] {
        [] => Ok(String::new()),
        failures => bail!("{}", failures.join("\n")),
    }
}

/// Runs the command.
pub fn experiment(arguments: &Arguments) -> Result<ExitCode> {
    // Training runs write checkpoints first.
    crate::terminal::interrupt::be_patient();
    match &arguments.command {
        Command::List(arguments) => show::list(arguments)?,
        Command::Show(arguments) => show::show(arguments)?,
        Command::Run(arguments) => return run::run(arguments),
        Command::Report(arguments) => report::report(arguments)?,
        Command::Check(arguments) => return check::check(arguments),
        Command::Claims(arguments) => claims::print(arguments)?,
        Command::Rates(arguments) => rates::print(arguments)?,
    }
    Ok(ExitCode::Success)
}
