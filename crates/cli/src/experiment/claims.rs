//! `b2b experiment claims`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use b2b_experiment::{Error, Experiment, Folder, Results, claims};

use crate::terminal::stdout;

/// Judge the claims of the paper by results, as a table in Markdown
///
/// Prints one row per claim: holds here, does not hold, cannot be told, or no results yet. Training runs with fewer
/// steps than the paper's do not count. With several folders of one experiment, each claim is judged by the first
/// folder that decides it; if another decides otherwise, it cannot be told.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Folders of `b2b experiment run`
    #[arg(value_name = "FOLDER")]
    folders: Vec<PathBuf>,
}

/// Runs the command.
pub fn print(arguments: &Arguments) -> Result<()> {
    let all = arguments.folders.iter().map(|path| read(path)).collect::<Result<Vec<_>, _>>()?;
    stdout::print(claims::markdown(&all).trim_end())
}

/// Notes on standard error that results are of other versions.
pub(super) fn note(path: &Path, results: &Results) {
    if let Some(outdated) = results.outdated() {
        eprintln!("{}: {outdated}", path.display());
    }
}

fn read(path: &Path) -> Result<(Experiment, Results), Error> {
    let (folder, experiment, budget) = Folder::open(path)?;
    let results = Results::read(&folder, &experiment, &budget)?;
    note(path, &results);
    Ok((experiment, results))
}
