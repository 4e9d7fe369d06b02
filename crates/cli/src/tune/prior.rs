//! `b2b tune prior`: what the controller `mpc` expects of a building type.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, Result};
use b2b_base::parallel;
use b2b_building::BuildingType;
use b2b_control::mpc::{Observed, Prior, Priors, observe};

use super::training::TrainingBuildings;
use crate::arguments::jobs::Jobs;
use crate::output_folder::OutputFolder;
use crate::program;
use crate::terminal::progress::{Download, counter};
use crate::terminal::stdout;

/// Learn what the controller mpc expects of a building type
///
/// Runs the identification of mpc in many buildings of the training split, and estimates how the effects of supply air
/// temperatures, minimum flows and the economizer limit on cost and discomfort are distributed over them. In a building
/// of the type, mpc begins from there. crates/control/data/mpc_prior.json is the result for all types.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    #[command(flatten)]
    training: TrainingBuildings,
    /// Random seed of the movements
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    jobs: Jobs,
    /// File of the result
    #[arg(long, default_value = "mpc_prior.json", value_name = "FILE.json")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn prior(arguments: &Arguments) -> Result<()> {
    let Arguments { training, seed, jobs, out, json } = arguments;
    let catalog = program::catalog(&mut Download::new(*json))?;
    let jobs = jobs.count()?;
    let mut all: BTreeMap<BuildingType, Prior> = BTreeMap::new();
    for building_type in &training.types {
        let periods = training.periods();
        let cases: Vec<_> = training
            .ids(*building_type)
            .into_iter()
            .flat_map(|id| periods.iter().map(move |period| (id, *period)))
            .collect();
        let bar = counter(cases.len(), "identifications", *json);
        let observed: Vec<Observed> = parallel::map(jobs, &cases, |&(id, period)| {
            let episode = training.episode(&catalog, id, period)?;
            let (_, observed) =
                observe(&episode, *seed, &mut || ()).with_context(|| format!("{id}, {period}"))?;
            bar.inc(1);
            anyhow::Ok(observed)
        })?;
        bar.finish_and_clear();
        all.insert(*building_type, Prior::learn(&observed));
    }
    let all = Priors::new(&training.task(), all);
    OutputFolder::write_file(out, |file| serde_json::to_writer(file, &all).map_err(Into::into))?;
    stdout::print_result(*json, &all, || format!("  {}", out.display()))
}
