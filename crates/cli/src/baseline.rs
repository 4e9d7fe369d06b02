//! `b2b baseline`: what the reactive controllers get, as a table.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Result, bail};
use b2b_benchmark::{Baselines, Episode, Key, ReturnTerms, Subject, Surroundings, baseline_table};
use b2b_building::{BuildingType, RunPeriod};
use b2b_dataset::{BuildingName, Catalog};
use b2b_env::Task;

use crate::evaluate::{Bars, evaluation, names};
use crate::generate::Part;
use crate::output_folder::OutputFolder;
use crate::progress::Download;
use crate::{interrupt, run, shipped, stdout};

/// Compute the returns that scores are relative to
///
/// One episode of the reactive controllers gives them for every weight of energy. They are kept in the cache as they
/// end, so that the same command goes on where it was interrupted; --fresh computes them again. --check compares with
/// those that are shipped, and ends with exit code 1 where they differ by more than 1e-6.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b baseline --out crates/benchmark/data/baselines.csv     as shipped
  b2b baseline --check --fresh SingleFamilyHouse-0014 --task constant --period winter")]
pub struct Arguments {
    /// Buildings [default: those of --split]
    #[arg(value_name = "BUILDING")]
    buildings: Vec<BuildingName>,
    /// Part of the dataset
    #[arg(long, value_enum, default_value = "test_small", conflicts_with = "buildings")]
    split: Part,
    /// Only buildings of these types
    #[arg(long = "type", value_name = "TYPE", num_args = 1.., conflicts_with = "buildings")]
    types: Vec<BuildingType>,
    /// What is asked; the weight of energy does not matter
    #[arg(long = "task", value_name = "TASK", num_args = 1.., value_parser = run::task,
          default_values = ["constant", "occupancy", "random"])]
    tasks: Vec<Task>,
    /// Days
    #[arg(long = "period", value_name = "DAYS", num_args = 1..,
          default_values_t = [RunPeriod::WINTER, RunPeriod::SUMMER, RunPeriod::FULL_YEAR])]
    periods: Vec<RunPeriod>,
    /// Zone time steps an hour
    #[arg(long, default_value_t = 12, value_name = "N")]
    steps_per_hour: u32,
    /// Episodes at a time [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    jobs: Option<u32>,
    /// Do not take what the cache holds
    #[arg(long)]
    fresh: bool,
    /// File to write
    #[arg(long, value_name = "FILE.csv", required_unless_present = "check")]
    out: Option<PathBuf>,
    /// Compare with those shipped
    #[arg(long, conflicts_with = "out")]
    check: bool,
}

/// Runs the command.
pub fn baseline(arguments: &Arguments) -> Result<ExitCode> {
    let catalog = Catalog::open(&mut Download::new(false))?;
    let wanted = arguments.wanted(&catalog)?;
    let fresh = tempfile::tempdir()?;
    let cache = b2b_energyplus::install::cache_dir()?.join("baselines");
    let baselines = Baselines::without_shipped(if arguments.fresh { fresh.path() } else { cache.as_path() });
    let missing = baselines.missing(wanted.clone());
    let bars = Bars::new(false);
    let lost = baselines.compute(&evaluation(&catalog, arguments.jobs)?, &missing, &bars)?;
    drop(bars);
    if let Some((key, why)) = lost.iter().min_by_key(|(key, _)| *key) {
        bail!("{} episodes were lost; {}, {}, {}: {why}", lost.len(), key.building, key.task, key.period);
    }
    let rows: Vec<_> =
        wanted.into_iter().filter_map(|(key, _)| Some((key.clone(), baselines.get(&key)?))).collect();
    match &arguments.out {
        Some(path) => write(path, &baseline_table::text(&rows)).map(|()| ExitCode::SUCCESS),
        None => check(&rows),
    }
}

impl Arguments {
    /// The episodes, with their keys.
    fn wanted(&self, catalog: &Catalog) -> Result<Vec<(Key, Episode)>> {
        let names =
            if self.buildings.is_empty() { names(self.split, &self.types) } else { self.buildings.clone() };
        let mut wanted = Vec::new();
        for name in names {
            interrupt::check()?;
            let subject = Subject::at_home(name);
            let surroundings: Surroundings = subject.locate(catalog, &mut Download::new(false))?;
            for period in &self.periods {
                for task in &self.tasks {
                    let episode = Episode {
                        subject: subject.clone(),
                        task: task.clone(),
                        period: *period,
                        seed: 0,
                        steps_per_hour: self.steps_per_hour,
                    };
                    wanted.push((Key::of(&episode, &surroundings)?, episode));
                }
            }
        }
        Ok(wanted)
    }
}

fn write(path: &std::path::Path, text: &str) -> Result<()> {
    let Some(name) = path.file_name().filter(|_| !path.is_dir()) else {
        bail!("{} is a folder: give --out a file", path.display());
    };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = OutputFolder::stage(folder.unwrap_or(std::path::Path::new(".")))?;
    folder.write(&name.to_string_lossy(), |file| Ok(std::io::Write::write_all(file, text.as_bytes())?))?;
    folder.keep()
}

/// Compares with what is shipped.
fn check(rows: &[(Key, ReturnTerms)]) -> Result<ExitCode> {
    let known = Baselines::open()?;
    let mut wrong = Vec::new();
    for (key, terms) in rows {
        let Some((_, theirs)) = known.shipped().find(|(other, _)| *other == key) else {
            wrong.push(format!("{}, {}, {}: none is shipped", key.building, key.task, key.period));
            continue;
        };
        let difference = shipped::difference(terms.values(), theirs.values());
        if difference > shipped::TOLERANCE {
            wrong
                .push(format!("{}, {}, {}: differs by {difference:.1e}", key.building, key.task, key.period));
        }
    }
    stdout::print(&format!("{} baselines, {} of them not as shipped", rows.len(), wrong.len()))?;
    wrong.iter().try_for_each(|line| stdout::print(&format!("  {line}")))?;
    Ok(if wrong.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
