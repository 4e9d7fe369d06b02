//! The `b2b` command: buildings as reinforcement-learning environments, from a terminal.

#[cfg(target_os = "linux")]
mod baseline;
mod bench;
#[cfg(target_os = "linux")]
mod benchmark;
mod check;
mod child;
mod controller;
mod dataset;
mod doctor;
#[cfg(target_os = "linux")]
mod evaluate;
mod facts;
mod generate;
mod import;
mod interrupt;
mod list;
mod manifest_file;
mod model_folder;
mod output_folder;
mod picture;
mod prepare;
mod progress;
mod ranges;
mod run;
#[cfg(target_os = "linux")]
mod score;
mod setup;
#[cfg(target_os = "linux")]
mod shipped;
mod show;
mod stdout;
mod summary;
mod table;
mod trajectory_file;
#[cfg(target_os = "linux")]
mod tune;
mod view;
#[cfg(target_os = "linux")]
mod workers;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

/// EnergyPlus buildings as reinforcement-learning environments.
#[derive(Parser)]
#[command(name = "b2b", version, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  b2b run OfficeSmall                      a winter in Denver under a reactive controller
  b2b run Warehouse --place Miami --period 07-01..07-14 --controller random
  b2b run OfficeSmall-0042                 a building of the dataset, at its own place
  b2b run OfficeSmall --task occupancy+energy0.5
  b2b list                                 the building types
  b2b show RetailStandalone                what one of them is, what can be seen and driven in it
  b2b view RetailStandalone                the same in 3D, as a page for the browser
  b2b generate Warehouse --count 100 --out warehouses
  b2b import my.idf --weather my.epw       what can be driven in a building of yours
  b2b evaluate --policy my.onnx --type OfficeSmall --out results
  b2b benchmark list                       the benchmark's problems
  b2b doctor                               what is installed and whether it is whole

EnergyPlus and weather files are fetched by themselves when first needed, with the Python
package client of this machine, into a cache folder.

Environment:
  B2B_ENERGYPLUS   an installed EnergyPlus (its folder or its library) to use instead
  B2B_CACHE        the cache folder
  B2B_OFFLINE=1    refuse downloads

Exit codes: 0 done, 1 failed, 130 interrupted.";

#[derive(Subcommand)]
enum Command {
    Run(Box<run::Arguments>),
    List(list::Arguments),
    Show(show::Arguments),
    View(view::Arguments),
    Setup(setup::Arguments),
    Doctor(doctor::Arguments),
    Bench(bench::Arguments),
    #[cfg(target_os = "linux")]
    Evaluate(evaluate::Arguments),
    #[cfg(target_os = "linux")]
    Score(score::Arguments),
    #[cfg(target_os = "linux")]
    Baseline(baseline::Arguments),
    #[cfg(target_os = "linux")]
    Benchmark(benchmark::Arguments),
    Generate(generate::Arguments),
    Dataset(dataset::Arguments),
    Check(check::Arguments),
    Import(import::Arguments),
    #[cfg(target_os = "linux")]
    Tune(tune::Arguments),
}

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    b2b_env::vector::run_if_worker();
    let command = match Cli::try_parse() {
        Ok(cli) => cli.command,
        Err(usage) => {
            // Nothing is left to do when the terminal is gone.
            let _ = usage.print();
            return if usage.use_stderr() { ExitCode::FAILURE } else { ExitCode::SUCCESS };
        }
    };
    match interrupt::listen().and_then(|()| execute(command)) {
        Ok(code) => code,
        Err(error) if interrupt::requested() => {
            eprintln!("{error}");
            ExitCode::from(interrupt::EXIT_CODE)
        }
        Err(error) if stdout::is_closed(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", with_causes(&error));
            ExitCode::FAILURE
        }
    }
}

fn execute(command: Command) -> Result<ExitCode> {
    match command {
        Command::Run(arguments) => run::run(&arguments)?,
        Command::List(arguments) => list::list(&arguments)?,
        Command::Show(arguments) => show::show(&arguments)?,
        Command::View(arguments) => view::view(&arguments)?,
        Command::Setup(arguments) => setup::setup(&arguments)?,
        Command::Doctor(arguments) => return doctor::doctor(&arguments),
        Command::Bench(arguments) => bench::bench(&arguments)?,
        #[cfg(target_os = "linux")]
        Command::Evaluate(arguments) => return evaluate::evaluate(&arguments),
        #[cfg(target_os = "linux")]
        Command::Score(arguments) => score::score(&arguments)?,
        #[cfg(target_os = "linux")]
        Command::Baseline(arguments) => return baseline::baseline(&arguments),
        #[cfg(target_os = "linux")]
        Command::Benchmark(arguments) => return benchmark::benchmark(&arguments),
        Command::Generate(arguments) => generate::generate(&arguments)?,
        Command::Check(arguments) => return check::check(&arguments),
        Command::Import(arguments) => return import::import(&arguments),
        #[cfg(target_os = "linux")]
        Command::Tune(arguments) => tune::tune(&arguments)?,
        Command::Dataset(arguments) => dataset::dataset(&arguments)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// An error with the causes that it does not name itself.
fn with_causes(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text += &format!("\n  because: {cause}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arguments_are_well_formed() {
        use clap::CommandFactory;
        let mut command = Cli::command();
        command.clone().debug_assert();
        // What clap checks for itself, it does not check in a release build.
        command.build();
        assert_no_argument_is_there_twice(&command);
    }

    fn assert_no_argument_is_there_twice(command: &clap::Command) {
        let mut ids: Vec<_> = command.get_arguments().map(|argument| argument.get_id().to_string()).collect();
        ids.sort();
        let count = ids.len();
        ids.dedup();
        assert_eq!(ids.len(), count, "{}: {ids:?}", command.get_name());
        command.get_subcommands().for_each(assert_no_argument_is_there_twice);
    }

    #[test]
    fn a_cause_that_is_named_already_is_not_named_twice() {
        let error = anyhow::anyhow!("disk full").context("a.txt: disk full").context("cannot write");
        assert_eq!(with_causes(&error), "cannot write\n  because: a.txt: disk full");
    }
}
