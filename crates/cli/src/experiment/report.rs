//! `b2b experiment report`.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Result;
use b2b_experiment::{Folder, Results, duration_text};
use serde_json::json;

use crate::output_folder::OutputFolder;
use crate::terminal::stdout;

/// Write the report of an experiment from the results in its folder
///
/// Writes results.json (every episode; identical whether the jobs ran on one machine or in shards) and report.html
/// (opens in any browser, no network needed). Can be run at any time; unfinished jobs are left out.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Folder of `b2b experiment run`
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Print one JSON object instead of the text report
    #[arg(long)]
    json: bool,
}

const RESULTS: &str = "results.json";
const PAGE: &str = "report.html";

/// Runs the command.
pub fn report(arguments: &Arguments) -> Result<()> {
    write(&arguments.folder, arguments.json)
}

/// Writes the report of the results in a folder.
pub fn write(path: &Path, json: bool) -> Result<()> {
    let (folder, experiment, budget) = Folder::open(path)?;
    let results = Results::read(&folder, &experiment, &budget)?;
    folder.keep(&results.done)?;
    let staged = OutputFolder::stage(path)?;
    staged.write(RESULTS, |file| {
        serde_json::to_writer_pretty(&mut *file, &results.json())?;
        Ok(file.write_all(b"\n")?)
    })?;
    staged.write(PAGE, |file| Ok(b2b_experiment::report::write(file, &experiment, &results)?))?;
    let files = staged.destinations(&[RESULTS, PAGE]);
    staged.keep()?;
    let (done, failed, missing) = (results.done.len(), results.failed.len(), results.missing.len());
    let summary = json!({
        "experiment": experiment.name, "budget": budget.name, "done": done, "failed": failed, "missing": missing,
        "training_steps": results.steps(), "hours": results.time().as_secs_f64() / 3600.0, "files": files,
    });
    stdout::print_result(json, &summary, || {
        let mut text = format!(
            "{done} jobs done, {failed} failed, {missing} not run; {} of jobs\n\n",
            duration_text(results.time())
        );
        for (job, error) in &results.failed {
            text += &format!("failed: {job}: {error}\n");
        }
        text + &files.iter().map(|file| format!("  {}", file.display())).collect::<Vec<_>>().join("\n")
    })
}
