//! `b2b tune mpc`: the model of the controller `mpc`.

use std::path::PathBuf;

use anyhow::{Context, Result};
use b2b_building::Period;
use b2b_control::mpc::{Effect, IDENTIFICATION_HOURS, Model, Response, identify};
use b2b_dataset::BuildingName;
use b2b_env::Task;

use super::training::episode;
use crate::arguments::location::Location;
use crate::arguments::task;
use crate::output_folder::OutputFolder;
use crate::program;
use crate::terminal::progress::{Download, counter};
use crate::terminal::stdout;
use crate::terminal::table::Table;

/// Identify the model of the controller mpc
///
/// Runs the two weeks before an episode under Guideline 36 while supply air temperatures, minimum flows and the
/// economizer limit move at random, and fits their effects on cost and discomfort.
/// `b2b run --controller mpc --parameters FILE.json` uses the model; without a file, mpc identifies its own.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Building type, dataset building such as OfficeSmall-0042, or model file
    building: BuildingName,
    #[command(flatten)]
    location: Location,
    /// Run period of the episode
    #[arg(long, default_value = "peak-heating", value_name = "PERIOD")]
    period: Period,
    /// Task of operation [default: operate]
    #[arg(long, value_name = "TASK", value_parser = Task::from_text)]
    task: Option<Task>,
    /// Zone time steps per hour
    #[arg(long, default_value_t = 12, value_name = "N")]
    steps_per_hour: u32,
    /// Random seed of the movements
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// File of the model
    #[arg(long, default_value = "model.json", value_name = "FILE.json")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn mpc(arguments: &Arguments) -> Result<()> {
    let Arguments { building, out, json, .. } = arguments;
    let catalog = program::catalog(&mut Download::new(*json))?;
    let task = arguments.task.clone().unwrap_or_else(task::usual);
    let at = (building, &arguments.location.placement());
    let episode = episode(&catalog, at, arguments.period, arguments.steps_per_hour, task)?;
    let bar = counter(IDENTIFICATION_HOURS, "hours", *json);
    let model = identify(&episode, arguments.seed, &mut || bar.inc(1))
        .with_context(|| format!("cannot identify a model of {building}"))?;
    bar.finish_and_clear();
    OutputFolder::write_file(out, |file| serde_json::to_writer_pretty(file, &model).map_err(Into::into))?;
    stdout::print_result(*json, &model, || text(&model, arguments))
}

fn text(model: &Model, arguments: &Arguments) -> String {
    let mut table = Table::new(["point", "shift", "effect on cost (%)", "effect on discomfort (%)"]);
    for Effect { shift, value, cost, discomfort } in &model.effects {
        table.row([shift.clone(), format!("{value:+}"), percent(cost), percent(discomfort)]);
    }
    format!(
        "{} in {}: effects in cold, mild and warm hours, or in the hours in which the point acts\n\n{}\n\n  {}",
        model.building,
        model.identified,
        table.text(),
        arguments.out.display()
    )
}

/// Returns the terms of an effect with their standard deviations.
fn percent(effect: &Response) -> String {
    let term = |(number, mean): (usize, &f64)| {
        let deviation = effect.covariance[number][number].sqrt();
        format!("{:+.1} ± {:.1}", 100.0 * mean, 100.0 * deviation)
    };
    effect.mean.iter().enumerate().map(term).collect::<Vec<_>>().join(", ")
}
