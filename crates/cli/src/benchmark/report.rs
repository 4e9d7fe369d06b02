//! `b2b benchmark report`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use b2b_benchmark::entry::{RunResult, read_result};
use b2b_benchmark::report::leaderboard;

use crate::output_folder::OutputFolder;
use crate::stdout;

/// Make a leaderboard of results
///
/// Writes one page that needs no network: for every problem a table of its entries with intervals, performance profiles,
/// scores by type, deviations from target, and what adaptation brings. Results of changed problems stand apart.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b benchmark report results/* --out leaderboard.html")]
pub struct Arguments {
    /// Folders of results
    #[arg(value_name = "FOLDER", required = true)]
    folders: Vec<PathBuf>,
    /// The page
    #[arg(long, value_name = "FILE", default_value = "leaderboard.html")]
    out: PathBuf,
}

/// Runs the command.
pub fn report(arguments: &Arguments) -> Result<()> {
    let mut results: Vec<(RunResult, _)> = Vec::new();
    for folder in &arguments.folders {
        let (result, stages) = read_result(folder)?;
        let twin = results
            .iter()
            .any(|(other, _)| other.name == result.name && other.problem_hash == result.problem_hash);
        if twin {
            bail!(
                "two results on {} are called {}: run one with another --entry",
                result.problem.name,
                result.name
            );
        }
        results.push((result, stages));
    }
    let folder = arguments.out.parent().filter(|parent| !parent.as_os_str().is_empty());
    let Some(name) = arguments.out.file_name().and_then(|name| name.to_str()) else {
        bail!("{} is no file: give --out a name", arguments.out.display());
    };
    let folder = OutputFolder::stage(folder.unwrap_or(Path::new(".")))?;
    folder.write(name, |file| Ok(leaderboard::write(file, &results)?))?;
    folder.keep()?;
    stdout::print(&arguments.out.display().to_string())
}
