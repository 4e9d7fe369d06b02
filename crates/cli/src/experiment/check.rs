//! `b2b experiment check`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use anyhow::Result;
use b2b_experiment::{Checked, Folder, Runner};
use serde_json::json;

use crate::arguments::jobs::Jobs;
use crate::program;
use crate::terminal::exit_code::ExitCode;
use crate::terminal::{interrupt, stdout};

/// Evaluate the agents and controllers in a folder of results again and compare with the results
///
/// Checks every agent whose folder (jobs/AGENT/.../agent, or agent-SEED of an entry) is available, and the controllers
/// that the experiment lists. On a machine that rounds like the one that produced the results, episodes must agree bit
/// for bit; on others, scores must agree within 0.1 %. Exits with code 1 if one does not agree.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Folder of `b2b experiment run`
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Evaluate at most N buildings of each agent, evenly spaced over its results (default: all)
    #[arg(long, value_name = "N")]
    buildings: Option<NonZeroUsize>,
    #[command(flatten)]
    jobs: Jobs,
    /// Print one JSON object instead of the text report
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn check(arguments: &Arguments) -> Result<ExitCode> {
    let (folder, experiment, budget) = Folder::open(&arguments.folder)?;
    let runner = Runner {
        launcher: program::launcher(),
        folder: &folder,
        parallel: arguments.jobs.count()?,
        interrupted: interrupt::requested,
    };
    let line = |checked: &Checked| match &checked.fault {
        None => format!("✓ {}", checked.job),
        Some(fault) => format!("✗ {}: {fault}", checked.job),
    };
    let done = |checked: &Checked| {
        if !arguments.json {
            eprintln!("{}", line(checked));
        }
    };
    let all = b2b_experiment::check(&runner, &experiment, &budget, arguments.buildings, &done)?;
    let faults: Vec<_> = all.iter().filter(|checked| checked.fault.is_some()).collect();
    let summary = json!({
        "checked": all.len(),
        "agree": all.len() - faults.len(),
        "faults": faults.iter().map(|checked| json!({"job": checked.job, "fault": checked.fault})).collect::<Vec<_>>(),
    });
    stdout::print_result(arguments.json, &summary, || {
        format!("{} of {} agents agree with the results", all.len() - faults.len(), all.len())
    })?;
    Ok(ExitCode::of(faults.is_empty()))
}
