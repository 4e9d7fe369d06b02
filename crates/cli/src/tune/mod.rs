//! `b2b tune`: parameters of the reactive controllers, optimized on training buildings; schedules, rules and models of
//! other controllers.

mod ablations;
mod check;
mod compare;
mod foresight;
mod mpc;
mod operation;
mod prior;
mod rollouts;
mod search;
mod supervisor;
mod training;
mod two_weeks;

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

For each building type and climate zone, optimizes the controller parameters for two objectives: comfort (energy
weight 0) and energy (weight 0.5, relative to the energy use under the comfort set). Each candidate is simulated on
training buildings from a Sunday to a Tuesday in winter and in summer, with setpoints that follow occupancy. Its loss
is divided by the default parameters' loss: 1 is as good as the defaults, 0 is perfect. Clearly inferior candidates
are dropped after the first buildings. The best ones are validated on other training buildings, also with constant
setpoints, and the one with the lowest median loss is chosen, provided that actuators travel at most five full
strokes per day on every building, or no more than under the defaults, and that it is not clearly worse than the
defaults on any building. Every evaluation is written to a file: the same command resumes an interrupted tuning. The
parameters that ship with b2b are FOLDER/tuned.json of a run with the default options.";

const EXAMPLES: &str = "\
Examples:
  b2b tune                                       all types and zones: one to two hours on two cores
  b2b tune --type OfficeSmall --zone 5
  b2b tune --type SingleFamilyHouse --buildings 8 --evaluations 50 --seed 1 --out mine
  b2b tune check --type SingleFamilyHouse        reproduce the shipped results
  b2b tune compare --type OfficeSmall            default against tuned, on test buildings
  b2b tune foresight OfficeSmall-0509            schedules of supervisory points with perfect foresight
  b2b tune supervisor --type OfficeMedium        one rule of shifts for all buildings of a type
  b2b tune mpc OfficeMedium-0626                 the model of the model predictive controller
  b2b tune prior --type OfficeMedium             what that controller expects of buildings of a type
  b2b tune operation                             the scale and the weight of rewards of operation
  b2b tune ablations OfficeMedium-0626           what the sequences of Guideline 36 save
  b2b run OfficeSmall --parameters mine.json     run with your own parameters";

#[derive(clap::Subcommand)]
enum Command {
    Ablations(ablations::Arguments),
    Check(check::Arguments),
    Compare(compare::Arguments),
    Foresight(Box<foresight::Arguments>),
    Mpc(Box<mpc::Arguments>),
    Operation(operation::Arguments),
    Prior(Box<prior::Arguments>),
    Supervisor(Box<supervisor::Arguments>),
}

/// Searches parameters like the command without a subcommand.
pub(crate) fn carry_out(arguments: &search::Arguments) -> Result<String> {
    search::search(arguments).map(|()| String::new())
}

/// Runs the command.
pub fn tune(arguments: &Arguments) -> Result<()> {
    match &arguments.command {
        Some(Command::Ablations(arguments)) => ablations::ablations(arguments),
        Some(Command::Check(arguments)) => check::check(arguments),
        Some(Command::Compare(arguments)) => compare::compare(arguments),
        Some(Command::Foresight(arguments)) => foresight::foresight(arguments),
        Some(Command::Mpc(arguments)) => mpc::mpc(arguments),
        Some(Command::Operation(arguments)) => operation::operation(arguments),
        Some(Command::Prior(arguments)) => prior::prior(arguments),
        Some(Command::Supervisor(arguments)) => supervisor::supervisor(arguments),
        None => search::search(&arguments.search),
    }
}
