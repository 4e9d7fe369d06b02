//! A robustness campaign against `b2b`: damaged inputs, implausible models and weather, and faults at random times.
//!
//! It tests the guarantees of docs/trust.md: no panic, no crash, no endless run, no success with invalid results, and
//! no processes or files left behind. Every violation is a finding: it is saved with the files that reproduce it, and
//! the exit code is 1.

mod faults;
mod inputs;
mod ledger;
mod material;
mod mutation;
mod program;
mod runs;
mod tricks;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use clap::{Parser, ValueEnum};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use ledger::Ledger;
use material::Material;
use program::Program;

/// Attack b2b with damaged inputs, implausible models and faults
///
/// Runs for the given time and prints how many inputs of each kind were accepted and rejected. Every violated guarantee
/// is a finding: it is saved in the folder of findings with the files that reproduce it, and the exit code is 1.
#[derive(Parser)]
struct Arguments {
    /// Parts to run; each has an equal share of the time [default: all]
    #[arg(long = "part", value_enum, value_name = "PART")]
    parts: Vec<Part>,
    /// Duration, in minutes
    #[arg(long, default_value_t = 5.0, value_name = "MINUTES")]
    minutes: f64,
    /// Random seed
    #[arg(long, default_value_t = 0, value_name = "N")]
    seed: u64,
    /// The b2b program [default: b2b beside this program]
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// Folder for the findings
    #[arg(long, default_value = "b2b-findings", value_name = "FOLDER")]
    findings: PathBuf,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Part {
    /// Damaged files, given to every file reader
    Inputs,
    /// Damaged models, weather files, trajectories and arguments, given to the commands
    Runs,
    /// Signals and resource limits, at random times while commands run
    Faults,
    /// Folders and files that somebody else put there, and commands started at the same time
    Tricks,
}

/// Program, material and limits for a part of the campaign.
struct Campaign<'a> {
    program: &'a Program,
    material: &'a Material,
    deadline: Instant,
    random: ChaCha8Rng,
    ledger: &'a mut Ledger,
}

fn main() -> ExitCode {
    attack(Arguments::parse()).unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::FAILURE
    })
}

fn attack(arguments: Arguments) -> Result<ExitCode> {
    if let Some(order) = inputs::Order::of_this_process() {
        return inputs::attack_here(&order);
    }
    let beside = || Ok(std::env::current_exe()?.with_file_name("b2b"));
    let program = Program::new(arguments.program.map_or_else(beside, Result::<_>::Ok)?)?;
    let parts = if arguments.parts.is_empty() { Part::value_variants().to_vec() } else { arguments.parts };
    let share = Duration::from_secs_f64(60.0 * arguments.minutes / parts.len() as f64);

    let work = tempfile::tempdir().context("cannot create a folder to work in")?;
    let material = Material::make(&program, work.path())?;
    let mut ledger = Ledger::new(arguments.findings);
    for part in parts {
        let deadline = Instant::now() + share;
        let mut random = ChaCha8Rng::seed_from_u64(arguments.seed);
        random.set_stream(part as u64);
        let attack = match part {
            Part::Inputs => inputs::attack,
            Part::Runs => runs::attack,
            Part::Faults => faults::attack,
            Part::Tricks => tricks::attack,
        };
        attack(Campaign { program: &program, material: &material, deadline, random, ledger: &mut ledger })?;
    }
    println!("{ledger}");
    Ok(ledger.exit_code())
}
