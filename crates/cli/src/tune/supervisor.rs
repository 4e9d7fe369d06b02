//! `b2b tune supervisor`: the rules of the controller `linear-supervisor`.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use b2b_base::parallel;
use b2b_building::BuildingType;
use b2b_control::linear_supervisor::{Rule, TunedWeights, WeightSearchOptions, run, tune};
use b2b_dataset::Catalog;
use serde_json::json;

use super::training::TrainingBuildings;
use crate::arguments::jobs::Jobs;
use crate::output_folder::{self, OutputFolder};
use crate::program;
use crate::terminal::progress::{Download, counter};
use crate::terminal::table::Table;
use crate::terminal::{interrupt, stdout};

/// Search the rules of the controller linear-supervisor
///
/// Runs two weeks in many buildings of the training split under Guideline 36 with shifts that are linear in the weather
/// and in what zones need, and finds the weights with the lowest cost at the guideline's discomfort. Finished rounds
/// are kept: the same command resumes an interrupted search. linear_supervisor.json has the rule of every type,
/// TYPE.json one rule, which `b2b run --controller linear-supervisor --parameters TYPE.json` carries out.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    #[command(flatten)]
    training: TrainingBuildings,
    /// Rounds of a search
    #[arg(long, default_value_t = WeightSearchOptions::default().rounds, value_name = "N")]
    rounds: usize,
    /// Episodes of a round, each in another building or period
    #[arg(long, default_value_t = WeightSearchOptions::default().episodes, value_name = "N")]
    episodes: usize,
    /// Mirrored pairs of an episode
    #[arg(long, default_value_t = WeightSearchOptions::default().pairs, value_name = "N")]
    pairs: usize,
    /// Random seed of the search
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    jobs: Jobs,
    /// Folder for the rounds, a file for each rule, and linear_supervisor.json with all of them
    #[arg(long, default_value = "b2b-supervisor", value_name = "FOLDER")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Name of the file with all rules.
const ALL: &str = "linear_supervisor.json";

/// Runs the command.
pub fn supervisor(arguments: &Arguments) -> Result<()> {
    let _lock = output_folder::lock(&arguments.out)?;
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    let mut all: BTreeMap<String, TunedWeights> = BTreeMap::new();
    for building_type in &arguments.training.types {
        let tuned = arguments.search(&catalog, *building_type)?;
        if let Some(last) = tuned.rounds.last() {
            write(&arguments.out.join(format!("{building_type}.json")), &last.rule)?;
        }
        all.insert(building_type.to_string(), tuned);
    }
    let rules: BTreeMap<&String, Option<&Rule>> =
        all.iter().map(|(name, tuned)| (name, tuned.rounds.last().map(|round| &round.rule))).collect();
    write(&arguments.out.join(ALL), &rules)?;
    stdout::print_result(arguments.json, &all, || arguments.text(&all))
}

impl Arguments {
    /// Searches the rule of a type.
    fn search(&self, catalog: &Catalog, building_type: BuildingType) -> Result<TunedWeights> {
        let training = &self.training;
        let (ids, periods, task) = (training.ids(building_type), training.periods(), training.task());
        let options = WeightSearchOptions {
            rounds: self.rounds,
            episodes: self.episodes,
            pairs: self.pairs,
            seed: self.seed,
        };
        let days = periods.iter().map(|period| period.days()).max().unwrap_or(0) as usize;
        let head = json!({
            "buildings": ids.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "periods": periods,
            "task_sha256": task.hash(),
            "guideline36": b2b_control::guideline36::REVISION,
        });
        let path = self.out.join(format!("{building_type}.jsonl"));
        let bar = counter(options.rounds * options.episodes, "episodes", self.json);
        let jobs = self.jobs.count()?;
        let mut tries = |round: usize, all: &[Vec<Vec<Rule>>]| {
            let first = round * all.len();
            let site = |(number, tried): &(usize, &Vec<Vec<Rule>>)| {
                let number = first + number;
                let id = ids[number % ids.len()];
                let period = periods[(number + number / ids.len()) % periods.len()];
                let mut episode = training.episode(catalog, id, period)?;
                let site = run(&mut episode, tried).with_context(|| format!("{id}, {period}"))?;
                bar.inc(1);
                anyhow::Ok(site)
            };
            parallel::map(jobs, &all.iter().enumerate().collect::<Vec<_>>(), site)
        };
        let tuned = tune(options, days, Some((&path, &head)), &mut tries);
        bar.finish_and_clear();
        interrupt::check()?;
        tuned.with_context(|| format!("cannot find a rule for {building_type}"))
    }

    fn text(&self, all: &BTreeMap<String, TunedWeights>) -> String {
        let mut rounds = Table::new(["type", "round", "cost (%)", "discomfort (K·h per zone and day)"]);
        let mut weights = Table::new(["type", "shift", "constant", "cold", "heating", "cooling"]);
        for (name, tuned) in all {
            for (number, round) in tuned.rounds.iter().enumerate() {
                let cost = format!("{:+.2}", 100.0 * round.cost);
                rounds.row([
                    name.clone(),
                    (number + 1).to_string(),
                    cost,
                    format!("{:+.3}", round.discomfort),
                ]);
            }
            for (shift, own) in tuned.rounds.last().iter().flat_map(|round| &round.rule.0) {
                let [constant, cold, heating, cooling] =
                    [own.constant, own.cold, own.heating, own.cooling].map(|own| format!("{own:.3}"));
                weights.row([name.clone(), shift.clone(), constant, cold, heating, cooling]);
            }
        }
        let file = self.out.join(ALL);
        format!(
            "change from guideline36 according to the response surfaces:\n\n{}\n\n{}\n\n  {}",
            rounds.text(),
            weights.text(),
            file.display()
        )
    }
}

fn write(path: &Path, value: &impl serde::Serialize) -> Result<()> {
    OutputFolder::write_file(path, |file| {
        serde_json::to_writer_pretty(&mut *file, value)?;
        writeln!(file)?;
        Ok(())
    })
}
