//! `b2b tune`: parameters of the reactive controllers, optimized on training buildings.

mod check;
mod compare;
mod rollouts;
mod search;

use anyhow::Result;

/// Tune the reactive controllers on training buildings
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true, long_about = LONG_ABOUT, after_help = EXAMPLES)]
pub struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    search: search::Arguments,
}

const LONG_ABOUT: &str = "\
Tune the reactive controllers on training buildings

For each building type and climate zone, optimizes eight controller parameters by Bayesian optimization. Each
candidate is simulated on training buildings for a winter and a summer week, with setpoints that follow occupancy
and no energy term in the reward. Its score is the 25th percentile, over the buildings, of the return divided by
the loss under the default parameters: -1 is as good as the defaults, 0 is perfect. The best candidate is chosen
among those whose actuator travel is at most five full strokes per day in every building, or no more than under the
defaults; it is never worse than the defaults. Every evaluation is kept in a file: the same command resumes an
interrupted tuning. The parameters that ship with b2b are FOLDER/tuned.json of a run with the default options.";

const EXAMPLES: &str = "\
Examples:
  b2b tune                                       all types and zones: one to two hours
  b2b tune --type OfficeSmall --zone 5
  b2b tune --type SingleFamilyHouse --buildings 8 --evaluations 50 --seed 1 --out mine
  b2b tune check --type SingleFamilyHouse        reproduce the shipped results
  b2b tune compare --type OfficeSmall            default against tuned, on test buildings
  b2b run OfficeSmall --parameters mine.json     run with your own parameters";

#[derive(clap::Subcommand)]
enum Command {
    Check(check::Arguments),
    Compare(compare::Arguments),
}

/// Runs the command.
pub fn tune(arguments: &Arguments) -> Result<()> {
    match &arguments.command {
        Some(Command::Check(arguments)) => check::check(arguments),
        Some(Command::Compare(arguments)) => compare::compare(arguments),
        None => search::search(&arguments.search),
    }
}
