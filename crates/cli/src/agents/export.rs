//! `b2b export`: an agent as an ONNX file.

use std::path::PathBuf;

use anyhow::{Context, Result};
use b2b_agent::Agent;
use b2b_base::aside::write_whole;
use b2b_building::RunPeriod;
use b2b_dataset::BuildingName;

use crate::arguments::location::Location;
use crate::program::prepare::Prepared;
use crate::terminal::stdout;

/// Write an agent as an ONNX file
///
/// Only agents trained with `--direct` and the observation raw or roles can be exported. The network takes the unscaled
/// observation of the environment (the values that `b2b show BUILDING --observations` lists, or the observation by
/// roles) and returns actions from -1 to 1. The file of a graph network is for one building, whose nodes and edges it
/// contains.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Folder of the agent
    #[arg(value_name = "FOLDER")]
    agent: PathBuf,
    /// A building that the agent controls [default: the one it was trained on]
    #[arg(long, value_name = "BUILDING")]
    building: Option<BuildingName>,
    #[command(flatten)]
    location: Location,
    /// Output file
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

/// Runs the command.
pub fn export(arguments: &Arguments) -> Result<()> {
    let agent = Agent::read(&arguments.agent)?;
    let training = &agent.info().training;
    let building = match &arguments.building {
        Some(building) => building.clone(),
        None => training.buildings.parse().with_context(|| {
            format!("the agent was trained on {}; name one building with --building", training.buildings)
        })?,
    };
    let prepared = Prepared::new(&building, &arguments.location, false)?;
    let task = agent.info().task.clone();
    let spaces = prepared.spaces(RunPeriod::WINTER, training.steps_per_hour, task)?;
    let written = write_whole(&arguments.out, &agent.to_onnx(&spaces.into())?);
    written.with_context(|| format!("cannot write {}", arguments.out.display()))?;
    stdout::print(&arguments.out.display().to_string())
}
