//! `b2b bench soak`: many episodes of all types, to find leaks and crashes.

mod chaos;

use anyhow::{Context, Result};
use b2b_base::digest::hex;
use b2b_building::{BuildingType, RunPeriod};
use b2b_control::{Controller, Random};
use b2b_dataset::BuildingName;
use b2b_env::Task;
use b2b_workers::{AnyOf, VecEnv, VecEnvOptions, Windows};
use serde_json::json;
use sha2::{Digest, Sha256};

use self::chaos::{Chaos, Hits};
use super::process::{open_files, resident_mb};
use crate::arguments::location::Location;
use crate::program::prepare::Prepared;
use crate::terminal::progress::counter;
use crate::terminal::{interrupt, stdout};

/// Run episodes of all types at once, with random actions and random resets, and report losses and leaks
///
/// Every episode has a random type, begins on one of a few days and lasts a random number of days. The printed hash
/// covers every observation and reward: two runs with the same arguments give the same hash. Exits with code 1 if an
/// episode is lost; with --chaos, only if its worker was not hit.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b bench soak --steps 20000
  b2b bench soak --environments 14 --steps 1000000 --seed 1
  b2b bench soak --steps 200000 --chaos 1      kill and stop processes at random, in every phase")]
pub struct Arguments {
    /// Number of environments
    #[arg(long, default_value_t = 14, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    environments: u32,
    /// Total number of steps of all environments
    #[arg(long, default_value_t = 100_000, value_name = "N")]
    steps: u64,
    /// Minimum and maximum days of an episode
    #[arg(long, num_args = 2, default_values_t = [1, 3], value_names = ["MIN", "MAX"])]
    days: Vec<u32>,
    /// Number of possible first days of an episode
    #[arg(long, default_value_t = 3, value_name = "N")]
    starts: u32,
    /// Building types, or buildings of the dataset [default: every type]
    #[arg(long = "type", value_name = "BUILDING", num_args = 1..)]
    buildings: Vec<BuildingName>,
    /// Seed of episodes and actions
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Kill and stop templates and workers at random times drawn with this seed
    #[arg(long, value_name = "SEED")]
    chaos: Option<u64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The results of a soak test.
#[derive(Default)]
struct Tally {
    episodes: u64,
    /// Reasons for lost episodes.
    lost: Vec<String>,
    hash: Sha256,
    /// Resident memory of this process after the first tenth and at the end, MB.
    memory: Vec<f64>,
}

/// Runs the command.
pub fn bench(arguments: &Arguments) -> Result<()> {
    let mut batch = arguments.batch()?;
    batch.reset(arguments.seed)?;
    let files = open_files()?;
    let chaos = arguments.chaos.map(|seed| Chaos::start(seed, batch.workers().clone()));
    let tally = arguments.run(&mut batch);
    let hits = chaos.map(Chaos::end);
    arguments.report(tally?, hits.as_ref(), open_files()? as i64 - files as i64)
}

impl Arguments {
    /// Returns the number of steps of each environment.
    fn turns(&self) -> u64 {
        self.steps.div_ceil(u64::from(self.environments))
    }

    fn run(&self, batch: &mut VecEnv) -> Result<Tally> {
        let mut actors = Actors::new(batch, self.seed);
        let mut tally = Tally::default();
        let turns = self.turns();
        let bar = counter(turns as usize, "steps of each", self.json);
        for turn in 0..turns {
            interrupt::check()?;
            // Caches fill during the first tenth.
            if turn == turns / 10 || turn + 1 == turns {
                tally.memory.push(resident_mb(std::process::id())?);
            }
            batch.step(actors.act(batch))?;
            tally.add(batch);
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(tally)
    }

    fn report(&self, tally: Tally, hits: Option<&Hits>, files: i64) -> Result<()> {
        let Tally { episodes, lost, hash, memory } = tally;
        let hash = hex(&hash.finalize());
        let growth = memory.last().context("no step")? - memory.first().context("no step")?;
        let explained = |lost: &&String| hits.is_some_and(|hits| hits.explains(lost));
        let unexplained: Vec<&String> = lost.iter().filter(|lost| !explained(lost)).collect();
        let (steps, count) = (self.turns() * u64::from(self.environments), self.environments);
        if self.json {
            stdout::print_json(&json!({
                "steps": steps, "episodes": episodes, "lost": lost, "unexplained": unexplained, "hash": hash,
                "memory_mb": memory, "memory_growth_mb": growth, "open_files_growth": files, "chaos": hits,
            }))?;
        } else {
            let chaos =
                hits.map(|hits| format!("{}; {} losses are unexplained\n", hits.text(), unexplained.len()));
            stdout::print(&format!(
                "{steps} steps in {episodes} episodes of {count} environments, {} lost\n{}\
                 memory of this process grew by {growth:.1} MB after the first tenth, its open files by {files}\n\
                 hash {hash}",
                lost.len(),
                chaos.unwrap_or_default()
            ))?;
        }
        match unexplained.first() {
            None => Ok(()),
            Some(why) => anyhow::bail!("{} episodes were lost; the first: {why}", unexplained.len()),
        }
    }
}

impl Tally {
    /// Adds one step of every environment.
    fn add(&mut self, batch: &VecEnv) {
        for value in batch.observations() {
            self.hash.update(value.to_le_bytes());
        }
        for reward in batch.rewards() {
            self.hash.update(reward.total().to_le_bytes());
        }
        for index in (0..batch.len()).filter(|index| batch.truncated()[*index]) {
            self.episodes += 1;
            self.lost.extend(batch.lost(index).map(str::to_owned));
        }
    }
}

impl Arguments {
    fn batch(&self) -> Result<VecEnv> {
        let types = BuildingType::ALL.map(BuildingName::Type);
        let buildings = if self.buildings.is_empty() { &types[..] } else { &self.buildings };
        let mut prepared = Vec::new();
        for building in buildings {
            prepared.push(Prepared::new(building, &Location::default(), self.json)?);
        }
        let widths = |width: fn(&b2b_env::Env) -> usize| -> Result<usize> {
            let envs = prepared.iter().map(|each| each.env(RunPeriod::WINTER, 12, Task::default()));
            Ok(envs.map(|env| Ok(width(&env?))).collect::<Result<Vec<_>>>()?.into_iter().max().unwrap_or(0))
        };
        let widths = (widths(|env| env.action_space().len())?, widths(|env| env.observation_space().len())?);
        let settings: Vec<_> = prepared
            .iter()
            .map(|each| each.setting(each.episode(RunPeriod::WINTER, 12, Task::default())))
            .collect();
        let sampler =
            Windows { of: AnyOf(settings), days: (self.days[0], self.days[1]), starts: self.starts };
        let mut options = VecEnvOptions { widths: Some(widths), ..prepared[0].vec_env_options() };
        if self.chaos.is_some() {
            options.workers = chaos::with_short_time_limits(options.workers);
        }
        Ok(VecEnv::new(self.environments as usize, Box::new(sampler), options)?)
    }
}

/// A random controller for each environment, replaced in each episode.
struct Actors {
    seed: u64,
    actors: Vec<Random>,
    was_over: Vec<bool>,
    actions: Vec<f64>,
}

impl Actors {
    fn new(batch: &VecEnv, seed: u64) -> Self {
        let actions = vec![0.0; batch.widths().0 * batch.len()];
        let mut actors = Self { seed, actors: Vec::new(), was_over: vec![false; batch.len()], actions };
        actors.actors = (0..batch.len()).map(|index| actors.other(batch, index)).collect();
        actors
    }

    /// Returns a controller with the next seed of a sequence.
    fn other(&mut self, batch: &VecEnv, index: usize) -> Random {
        self.seed = self.seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let space = &batch.spaces(index).expect("every environment was reset").action;
        Random::new(space, self.seed)
    }

    fn act(&mut self, batch: &VecEnv) -> &[f64] {
        let (width, observed) = batch.widths();
        for index in 0..batch.len() {
            let spaces = batch.spaces(index).expect("every environment was reset");
            self.actions[index * width..][..width].fill(0.0);
            let observation = &batch.observations()[index * observed..][..spaces.observation.len()];
            let over = batch.is_over(index);
            if !over {
                if self.was_over[index] {
                    self.actors[index] = self.other(batch, index);
                }
                let row = &mut self.actions[index * width..][..spaces.action.len()];
                self.actors[index].act(observation, row);
            }
            self.was_over[index] = over;
        }
        &self.actions
    }
}
