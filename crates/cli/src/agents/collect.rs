//! `b2b collect`: recorded episodes as a Minari dataset.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use b2b_base::shard::Shard;
use b2b_env::Task;
use b2b_evaluate::{ActionScale, Policy};
use b2b_learn::offline::{
    Collected, Collection, CorpusPart, Dataset, Definition, collect as collect_episodes, collect_corpus,
    train_agents,
};
use serde_json::json;

use crate::arguments::episodes::Episodes;
use crate::arguments::jobs::Jobs;
use crate::program::{self, weather};
use crate::scoring::evaluation::{Bars, evaluation, fetch_weather};
use crate::terminal::progress::Download;
use crate::terminal::table::Table;
use crate::terminal::{interrupt, stdout};
use crate::train::train_in;

/// Record episodes as a Minari dataset, for offline learning
///
/// Runs every combination of policy, building, run period and seed, and writes a dataset in Minari's Parquet format:
/// `minari.load_dataset(NAME)` reads it in Python, and `b2b clone` learns from it. Actions are in physical units for a
/// single building, and scaled to [-1, 1] between the bounds of each actuator for several buildings.
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_help = EXAMPLES)]
pub struct Arguments {
    /// Name of the dataset, with a version, such as b2b/office-small-v0
    #[arg(value_name = "NAME")]
    name: String,
    #[command(flatten)]
    episodes: Episodes,
    /// Policies: guideline36, reactive, random or another name of `b2b evaluate`, folders of agents or ONNX files;
    /// several make a mixed dataset
    #[arg(long = "policy", value_name = "POLICY", num_args = 1.., default_values = ["reactive"])]
    policies: Vec<String>,
    /// Task (see `b2b run --help`); constant by default, as in training
    #[arg(long, value_name = "TASK", default_value = "constant", value_parser = Task::from_text)]
    task: Task,
    #[command(flatten)]
    jobs: Jobs,
    /// Collect a corpus instead: many policies in buildings of all six types. `quick` has 2 million steps in 144
    /// buildings; `full` has 100 million in 1,008, some by agents at stages of their training, which it trains first; a
    /// TOML file defines another. The same command resumes it
    #[arg(long, value_name = "CORPUS", conflicts_with_all = ["names", "split", "types", "zones", "place", "weather", "control", "periods", "seeds", "steps_per_hour", "policies", "task", "allow_external", "keep_design_days", "transition"])]
    corpus: Option<String>,
    /// Collect only part I of N of a corpus, with I from 0 to N - 1; the parts share the output folder
    #[arg(long, value_name = "I/N", requires = "corpus")]
    shard: Option<Shard>,
    /// Folder of all datasets [default: $MINARI_DATASETS_PATH, or ~/.minari/datasets]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print one JSON object instead of the text report
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  b2b collect b2b/office-small-v0 OfficeSmall-0042                         one winter of the reactive controllers
  b2b collect b2b/office-small-mixed-v0 OfficeSmall-0042 --policy reactive runs/x random
  b2b collect b2b/warehouse-v0 --type Warehouse --split test_small --task occupancy --period winter summer
  b2b collect --corpus quick b2b/corpus-quick-v0          2 million steps, with noise and labels: half an hour on two cores
  b2b collect --corpus full b2b/corpus-v0 --shard 0/16    one of 16 parts of 100 million steps, into a shared folder";

/// Runs the command.
pub fn collect(arguments: &Arguments) -> Result<()> {
    check_name(&arguments.name)?;
    if let Some(name) = &arguments.corpus {
        return corpus(arguments, name);
    }
    let load = |text: &String| <dyn Policy>::named(text, ActionScale::Rescaled);
    let policies = arguments.policies.iter().map(load).collect::<b2b_evaluate::Result<Vec<_>>>()?;
    let episodes = arguments.episodes.list(std::slice::from_ref(&arguments.task))?;
    let destination = arguments.root()?.join(&arguments.name);
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    fetch_weather(&episodes, arguments.json)?;
    let evaluation = evaluation(&catalog, arguments.jobs.count()?);
    let bars = Bars::new(arguments.json);
    let collection = Collection { id: &arguments.name, episodes: &episodes, policies: &policies };
    let dataset = collect_episodes(&collection, &destination, &evaluation, &bars)?;
    drop(bars);
    let summary = json!({
        "name": arguments.name,
        "out": destination,
        "episodes": dataset.episodes.len(),
        "steps": dataset.episodes.iter().map(|episode| episode.total_steps).sum::<usize>(),
        "contents": dataset.contents,
    });
    stdout::print_result(arguments.json, &summary, || text(&dataset, &destination.display().to_string()))
}

/// Collects a corpus, or its part.
fn corpus(arguments: &Arguments, name: &str) -> Result<()> {
    let destination = arguments.root()?.join(&arguments.name);
    let buildings = Definition::named(name)?.ids();
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    weather::fetch(buildings.into_iter().map(|id| &b2b_dataset::row(id).building), arguments.json)?;
    let (catalog, jobs) = (Arc::new(catalog), arguments.jobs.count()?);
    train_agents(name, &destination, interrupt::requested, &mut |config, out| {
        train_in(out, config, Arc::clone(&catalog), jobs, arguments.json).map(drop)
    })?;
    let evaluation = evaluation(&catalog, jobs);
    let bars = Bars::new(arguments.json);
    let part = CorpusPart { id: &arguments.name, name, shard: arguments.shard.unwrap_or(Shard::WHOLE) };
    let collected = collect_corpus(&part, &destination, &evaluation, &bars)?;
    drop(bars);
    let Collected { episodes, of, transitions } = collected;
    let summary = json!({
        "name": arguments.name,
        "out": destination,
        "episodes": episodes,
        "of": of,
        "steps": transitions,
        "complete": collected.is_complete(),
    });
    stdout::print_result(arguments.json, &summary, || {
        let state = if collected.is_complete() { "complete" } else { "the other parts are left" };
        format!("{episodes} of {of} episodes, {transitions} steps: {state}\n\n  {}", destination.display())
    })
}

/// Errors unless Minari accepts the name: `NAMESPACE/NAME-vN` with an optional namespace.
fn check_name(name: &str) -> Result<()> {
    let is_part = |part: &str| {
        let mut letters = part.chars();
        !part.is_empty()
            && !part.starts_with('.')
            && letters.all(|letter| letter.is_ascii_alphanumeric() || "-_.".contains(letter))
    };
    let version = name.rsplit_once("-v").map(|(_, version)| version);
    let has_version =
        version.is_some_and(|text| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit()));
    if name.split('/').all(is_part) && has_version {
        return Ok(());
    }
    bail!(
        "`{name}` is not the name of a dataset; expected letters, digits, `-`, `_` and a version, such as b2b/{name}-v0"
    )
}

impl Arguments {
    fn root(&self) -> Result<PathBuf> {
        let set = self.out.clone().or_else(|| std::env::var_os("MINARI_DATASETS_PATH").map(PathBuf::from));
        let home = || std::env::home_dir().map(|home| home.join(".minari/datasets"));
        set.or_else(home).context("the home folder is unknown; set --out")
    }
}

fn text(dataset: &Dataset, path: &str) -> String {
    let mut table = Table::new(["building", "policy", "seed", "steps", "return"]);
    for episode in &dataset.episodes {
        table.row([
            episode.building.clone(),
            episode.policy.clone(),
            episode.seed.to_string(),
            episode.total_steps.to_string(),
            format!("{:.1}", episode.episode_return),
        ]);
    }
    format!("{}\n\n  {path}", table.text())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_follow_minari() {
        for name in ["b2b/office-small-v0", "office-v12", "a/b/c_d-v1"] {
            check_name(name).unwrap();
        }
        for name in
            ["office", "office-v", "office-vx", "../office-v0", "b2b//office-v0", "b2b/of fice-v0", ""]
        {
            assert!(check_name(name).is_err(), "{name}");
        }
    }
}
