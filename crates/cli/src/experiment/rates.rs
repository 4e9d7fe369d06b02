//! `b2b experiment rates`.

use std::path::PathBuf;

use anyhow::Result;
use b2b_experiment::{Folder, Rate, rates, rates_text};
use serde_json::json;

use crate::terminal::stdout;

/// Print the speed of training runs in folders of results, by building type and preset
///
/// Prints the table behind the estimates of `show` and `run` (crates/experiment/data/rates.csv): the 75th percentile of
/// the steps per second of training runs, without evaluations, where their job folders are available, otherwise of
/// whole jobs; and the speed of environments, from results of the experiment `speed`.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Folders of `b2b experiment run`
    #[arg(value_name = "FOLDER", required = true)]
    folders: Vec<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn print(arguments: &Arguments) -> Result<()> {
    let folders = arguments.folders.iter().map(|path| Folder::open(path)).collect::<Result<Vec<_>, _>>()?;
    let rates = rates(&folders)?;
    if arguments.json {
        let entry = |rate: &Rate| {
            let Rate { building_type, preset, steps_per_s, count, timed } = rate;
            json!({"type": building_type, "preset": preset, "steps_per_s": steps_per_s, "count": count, "timed": timed})
        };
        return stdout::print_json(&rates.iter().map(entry).collect::<Vec<_>>());
    }
    stdout::print(rates_text(&rates).trim_end())
}
