//! The `b2b` command: buildings as reinforcement-learning environments, from a terminal.
//!
//! A library, because the Python package provides the command as well.

mod actions;
mod agents;
mod arguments;
mod bench;
mod benchmark;
mod buildings;
mod calibrate;
mod compare;
mod dataset;
mod evaluate;
mod experiment;
mod generate;
mod import;
mod installation;
mod output_folder;
mod program;
mod rollout;
mod run;
mod scoring;
mod serve;
mod terminal;
mod time_series;
mod train;
mod tune;
mod view;

use std::ffi::OsString;

use anyhow::Result;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use agents::{clone, collect, export};
use buildings::{check, edit, list, show};
use installation::{doctor, setup};
pub use program::Program;
pub use rollout::Rollout;
pub use run::Author;
use scoring::{baseline, score};
pub use terminal::exit_code::ExitCode;
use terminal::{front_page, interrupt, stdout, suggestion, wrap};

/// Building simulations as reinforcement-learning environments, powered by EnergyPlus
#[derive(Parser)]
#[command(name = "b2b", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(Box<run::Arguments>),
    List(list::Arguments),
    Show(show::Arguments),
    View(view::Arguments),
    Compare(compare::Arguments),
    Serve(Box<serve::Arguments>),
    Setup(setup::Arguments),
    Doctor(doctor::Arguments),
    Bench(bench::Arguments),
    Evaluate(evaluate::Arguments),
    Score(score::Arguments),
    Baseline(baseline::Arguments),
    Benchmark(benchmark::Arguments),
    Generate(generate::Arguments),
    Dataset(dataset::Arguments),
    Check(check::Arguments),
    Import(import::Arguments),
    Edit(edit::Arguments),
    Calibrate(calibrate::Arguments),
    Train(Box<train::Arguments>),
    Export(export::Arguments),
    Collect(Box<collect::Arguments>),
    Clone(clone::Arguments),
    Experiment(experiment::Arguments),
    Tune(tune::Arguments),
}

/// Runs the command with these arguments, the first of which is the program's name, and returns its exit code.
///
/// `program` is also started for workers and for actions, such as the jobs of experiments, so it must call this
/// function. Must be called before any thread is started. Does not return if this process was started as a worker.
pub fn run(program: Program, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    program.set();
    b2b_workers::run_if_worker_with(b2b_learn::fragments::RUNNERS, actions::ACTIONS);
    let arguments: Vec<_> = arguments.into_iter().collect();
    let mut parser = wrap::help(front_page::add(Cli::command()));
    if arguments.len() <= 1 {
        // A failure to print cannot be reported.
        let _ = parser.print_help();
        return ExitCode::Success;
    }
    let parsed = parser.try_get_matches_from(&arguments).and_then(|matches| Cli::from_arg_matches(&matches));
    let command = match parsed {
        Ok(cli) => cli.command,
        Err(usage) => {
            let usage = suggestion::add(usage);
            print_usage(&usage);
            return if usage.use_stderr() { ExitCode::Usage } else { ExitCode::Success };
        }
    };
    match interrupt::listen().and_then(|()| execute(command)) {
        Ok(code) => code,
        Err(error) if interrupt::requested() => {
            eprintln!("{error}");
            ExitCode::Interrupted
        }
        Err(error) if stdout::is_closed(&error) => ExitCode::Success,
        Err(error) => {
            eprintln!("{}", wrap::message(&format!("error: {}", with_remedy(&error))));
            ExitCode::Failure
        }
    }
}

fn execute(command: Command) -> Result<ExitCode> {
    match command {
        Command::Run(arguments) => run::run(&arguments)?,
        Command::List(arguments) => list::list(&arguments)?,
        Command::Show(arguments) => show::show(&arguments)?,
        Command::View(arguments) => view::view(&arguments)?,
        Command::Compare(arguments) => compare::compare(&arguments)?,
        Command::Serve(arguments) => serve::serve(&arguments)?,
        Command::Setup(arguments) => setup::setup(&arguments)?,
        Command::Doctor(arguments) => return doctor::doctor(&arguments),
        Command::Bench(arguments) => bench::bench(&arguments)?,
        Command::Evaluate(arguments) => return evaluate::evaluate(&arguments),
        Command::Score(arguments) => score::score(&arguments)?,
        Command::Baseline(arguments) => return baseline::baseline(&arguments),
        Command::Benchmark(arguments) => return benchmark::benchmark(&arguments),
        Command::Generate(arguments) => generate::generate(&arguments)?,
        Command::Check(arguments) => return check::check(&arguments),
        Command::Import(arguments) => return import::import(&arguments),
        Command::Edit(arguments) => edit::edit(&arguments)?,
        Command::Calibrate(arguments) => calibrate::calibrate(&arguments)?,
        Command::Export(arguments) => export::export(&arguments)?,
        Command::Collect(arguments) => collect::collect(&arguments)?,
        Command::Clone(arguments) => clone::clone(&arguments)?,
        Command::Experiment(arguments) => return experiment::experiment(&arguments),
        Command::Train(arguments) => train::train(&arguments)?,
        Command::Tune(arguments) => tune::tune(&arguments)?,
        Command::Dataset(arguments) => dataset::dataset(&arguments)?,
    }
    Ok(ExitCode::Success)
}

/// Prints help, or an error in the arguments, within the width of the terminal.
fn print_usage(usage: &clap::Error) {
    let text = usage.to_string();
    let wrapped = wrap::message(&suggestion::in_words(&text));
    if usage.use_stderr() && wrapped != text.trim_end() {
        return eprintln!("{wrapped}");
    }
    // A failure to print cannot be reported.
    let _ = usage.print();
}

/// Returns the text of an error with its causes and, if there is one, a remedy.
pub(crate) fn with_remedy(error: &anyhow::Error) -> String {
    let error = with_causes(error);
    let remedy = interrupt::remedy().filter(|_| !error.contains("`ulimit -f`"));
    error + &remedy.map(|remedy| format!("; {remedy}")).unwrap_or_default()
}

/// Returns the text of an error, followed by the causes that it does not mention.
pub(crate) fn with_causes(error: &anyhow::Error) -> String {
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
        let mut command = front_page::add(Cli::command());
        command.clone().debug_assert();
        // In a release build, clap does not check for duplicate arguments.
        command.build();
        assert_no_duplicate_argument(&command);
    }

    fn assert_no_duplicate_argument(command: &clap::Command) {
        let mut ids: Vec<_> = command.get_arguments().map(|argument| argument.get_id().to_string()).collect();
        ids.sort();
        let count = ids.len();
        ids.dedup();
        assert_eq!(ids.len(), count, "{}: {ids:?}", command.get_name());
        command.get_subcommands().for_each(assert_no_duplicate_argument);
    }

    #[test]
    fn the_front_page_lists_every_command_once() {
        let command = Cli::command();
        let listed: Vec<_> = front_page::listed().collect();
        for subcommand in command.get_subcommands() {
            let name = subcommand.get_name();
            assert_eq!(listed.iter().filter(|each| **each == name).count(), 1, "{name}");
        }
        assert_eq!(listed.len(), command.get_subcommands().count());
    }

    #[test]
    fn a_cause_that_is_already_mentioned_is_not_repeated() {
        let error = anyhow::anyhow!("disk full").context("a.txt: disk full").context("cannot write");
        assert_eq!(with_causes(&error), "cannot write\n  because: a.txt: disk full");
    }
}
