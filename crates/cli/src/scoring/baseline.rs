//! `b2b baseline`: the returns of the baselines, as a table.

use std::collections::HashSet;
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Result, bail};
use b2b_building::{Period, RunPeriod};
use b2b_dataset::Catalog;
use b2b_env::Resource;
use b2b_env::Task;
use b2b_evaluate::{Baselines, EpisodePlan, Key, ReturnTerms, SiteInfo, Subject, baseline_table};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::arguments::buildings::Buildings;
use crate::arguments::jobs::Jobs;
use crate::output_folder::OutputFolder;
use crate::program;
use crate::scoring::evaluation::{Bars, evaluation};
use crate::scoring::shipped;
use crate::terminal::exit_code::ExitCode;
use crate::terminal::progress::Download;
use crate::terminal::{interrupt, stdout};

/// Compute the baseline returns that scores are normalized by
///
/// A task is scored against the reactive controllers with the parameters tuned for its objective: comfort, or comfort
/// and energy if it has an energy term. Within an objective, one episode gives the baseline for every energy weight.
/// A task of operation is scored against the guideline controller.
/// Finished episodes are cached: the same command resumes an interrupted run; --fresh ignores the cache. With --check,
/// compares the results with the shipped baselines and exits with code 1 if any differs by more than 1e-6 (relative).
///
/// The default selection has 864 episodes (48 buildings, three setpoint modes, two objectives, three run periods) and
/// takes about an hour on two cores. --check --fresh --sample 20 takes about two minutes.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b baseline --out crates/evaluate/data/baselines.csv     the shipped table
  b2b baseline --task operate operate+tou --period peak-heating typical-heating mixed typical-cooling peak-cooling \
      --out crates/evaluate/data/baselines_operation.csv     the same of operation: 480 episodes, half an hour
  b2b baseline --check --fresh --sample 20 --seed 1          recompute 20 of the shipped rows
  b2b baseline --check --fresh SingleFamilyHouse-0018 --task constant --period winter"
)]
pub struct Arguments {
    #[command(flatten)]
    buildings: Buildings,
    /// Tasks; the energy term selects the objective, and any weight above 0 gives the same baseline
    #[arg(long = "task", value_name = "TASK", num_args = 1.., value_parser = Task::from_text,
          default_values = Task::NAMED)]
    tasks: Vec<Task>,
    /// Run periods: winter, summer, full_year or MM-DD..MM-DD
    #[arg(long = "period", value_name = "PERIOD", num_args = 1..,
          default_values_t = [Period::WINTER, Period::Days(RunPeriod::SUMMER), Period::Days(RunPeriod::FULL_YEAR)])]
    periods: Vec<Period>,
    /// Zone time steps per hour
    #[arg(long, default_value_t = 12, value_name = "N")]
    steps_per_hour: u32,
    #[command(flatten)]
    jobs: Jobs,
    /// Ignore cached baselines
    #[arg(long)]
    fresh: bool,
    /// Compute only N of the selected episodes, drawn at random
    #[arg(long, value_name = "N", requires = "check", value_parser = clap::value_parser!(u32).range(1..))]
    sample: Option<u32>,
    /// Random seed of the sample
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// CSV file to write
    #[arg(long, value_name = "FILE.csv", required_unless_present = "check")]
    out: Option<PathBuf>,
    /// Compare with the shipped baselines instead of writing a file
    #[arg(long, conflicts_with = "out")]
    check: bool,
}

/// Runs the command.
pub fn baseline(arguments: &Arguments) -> Result<ExitCode> {
    let catalog = program::catalog(&mut Download::new(false))?;
    let mut episodes = arguments.episodes(&catalog)?;
    if let Some(count) = arguments.sample {
        draw(&mut episodes, count as usize, arguments.seed);
    }
    let fresh = b2b_base::scratch::temporary_folder("b2b-")?;
    let cache = Baselines::folder_in(&b2b_energyplus::install::cache_dir()?);
    let baselines = Baselines::without_shipped(if arguments.fresh { fresh.path() } else { cache.as_path() });
    let missing = baselines.missing(episodes.clone());
    let bars = Bars::new(false);
    let lost = baselines.compute(&evaluation(&catalog, arguments.jobs.count()?), &missing, &bars)?;
    drop(bars);
    if let Some((key, why)) = lost.iter().min_by_key(|(key, _)| *key) {
        bail!("{} episodes failed; first: {}: {why}", lost.len(), describe(key));
    }
    let rows: Vec<_> = episodes
        .into_iter()
        .filter_map(|(key, _)| Some((key.clone(), baselines.get(&key, Resource::ENERGY)?)))
        .collect();
    let Some(path) = &arguments.out else { return check(&rows) };
    let table = baseline_table::text(&rows);
    OutputFolder::write_file(path, |file| Ok(file.write_all(table.as_bytes())?))?;
    Ok(ExitCode::Success)
}

impl Arguments {
    /// Returns the episodes with their keys, each once.
    fn episodes(&self, catalog: &Catalog) -> Result<Vec<(Key, EpisodePlan)>> {
        let (mut episodes, mut known) = (Vec::new(), HashSet::new());
        for name in self.buildings.names()? {
            interrupt::check()?;
            let subject = Subject::at_home(name);
            let site: SiteInfo = subject.locate(catalog, &mut Download::new(false))?;
            for period in &self.periods {
                for task in &self.tasks {
                    let episode = EpisodePlan {
                        subject: subject.clone(),
                        task: task.clone(),
                        period: *period,
                        seed: 0,
                        steps_per_hour: self.steps_per_hour,
                    };
                    // Tasks that differ in their weight, say, share a baseline.
                    let key = Key::of(&episode, &site)?;
                    if known.insert(key.clone()) {
                        episodes.push((key, episode));
                    }
                }
            }
        }
        Ok(episodes)
    }
}

/// Keeps `count` randomly drawn episodes, in their order.
fn draw<T>(episodes: &mut Vec<T>, count: usize, seed: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    while episodes.len() > count {
        episodes.remove(random.random_range(0..episodes.len()));
    }
}

fn describe(key: &Key) -> String {
    format!("{}, {}, {}, {}", key.building, key.task, key.objective, key.period)
}

/// Compares baselines with the shipped ones.
fn check(rows: &[(Key, ReturnTerms)]) -> Result<ExitCode> {
    let known = Baselines::open()?;
    let mut wrong = Vec::new();
    for (key, terms) in rows {
        let Some((_, shipped)) = known.shipped().find(|(other, _)| *other == key) else {
            wrong.push(format!("{}: no shipped baseline", describe(key)));
            continue;
        };
        // The shipped values may be from before a resource was added.
        let known: Vec<_> = shipped.values().collect();
        let ours = terms.values().filter(|(name, _)| known.iter().any(|(known, _)| known == name));
        let difference = shipped::difference(ours.map(|(_, sum)| sum), known.iter().map(|(_, sum)| *sum));
        if difference > shipped::TOLERANCE {
            wrong.push(format!("{}: differs by {difference:.1e}", describe(key)));
        }
    }
    stdout::print(&format!(
        "{} baselines checked, {} differ from the shipped values",
        rows.len(),
        wrong.len()
    ))?;
    wrong.iter().try_for_each(|line| stdout::print(&format!("  {line}")))?;
    Ok(ExitCode::of(wrong.is_empty()))
}

#[cfg(test)]
mod tests {
    use super::draw;

    #[test]
    fn a_sample_keeps_the_order_and_is_determined_by_its_seed() {
        let sample = |seed| {
            let mut numbers: Vec<usize> = (0..100).collect();
            draw(&mut numbers, 7, seed);
            numbers
        };
        assert_eq!((sample(1), sample(1).len()), (sample(1), 7));
        assert!(sample(1).is_sorted() && sample(1) != sample(2));
        let mut few = vec![1, 2];
        draw(&mut few, 7, 0);
        assert_eq!(few, [1, 2]);
    }
}
