//! `b2b experiment claims`.

use std::path::PathBuf;

use anyhow::Result;
use b2b_experiment::claims;

use crate::terminal::stdout;

/// Judge the claims of the paper by results, as a table in Markdown
///
/// Prints one row per claim: holds here, does not hold, cannot be told, or no results yet. Training runs with fewer
/// steps than the paper's do not count. With several folders of one experiment, a claim is judged by one that
/// decides it; if another decides otherwise, it cannot be told.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Folders of `b2b experiment run`
    #[arg(value_name = "FOLDER")]
    folders: Vec<PathBuf>,
}

/// Runs the command.
pub fn print(arguments: &Arguments) -> Result<()> {
    let read = |path: &PathBuf| super::read(path).map(|(_, experiment, results)| (experiment, results));
    let all = arguments.folders.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    stdout::print(claims::markdown(&all).trim_end())
}
