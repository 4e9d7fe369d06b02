//! Selection of a problem: by name, from a file, or by building types, with modifications.

use std::path::Path;

use anyhow::{Result, bail};
use b2b_benchmark::Problem;
use b2b_evaluate::HouseForm;

use b2b_benchmark::problem::{Attributes, Changes, Fallback, Memory};
use b2b_building::{BuildingType, Period};
use b2b_dataset::BuildingId;
use b2b_env::Task;

/// Arguments that select a problem.
#[derive(clap::Args)]
pub struct Selection {
    /// Problem: a name from `b2b benchmark list`, a JSON file, or cross-domain with --train-type and --test-type
    #[arg(value_name = "PROBLEM")]
    name: String,
    /// Building types to train on (cross-domain)
    #[arg(long = "train-type", value_name = "TYPE", num_args = 1.., requires = "test_types")]
    train_types: Vec<BuildingType>,
    /// Building types to test on (cross-domain)
    #[arg(long = "test-type", value_name = "TYPE", num_args = 1.., requires = "train_types")]
    test_types: Vec<BuildingType>,
    #[command(flatten)]
    changes: ChangeArguments,
}

/// Modifications of the problem. The result records them and is not compared with results of the original problem.
#[derive(clap::Args)]
#[command(next_help_heading = "Modifications (recorded in the result, which is then ranked separately)")]
struct ChangeArguments {
    /// Buildings to train and test on, for problems that use the same buildings for both
    #[arg(long = "building", value_name = "ID", num_args = 1.., conflicts_with_all = ["train", "test"])]
    buildings: Vec<BuildingId>,
    /// Buildings to train on
    #[arg(long, value_name = "ID", num_args = 1..)]
    train: Vec<BuildingId>,
    /// Buildings to test on
    #[arg(long, value_name = "ID", num_args = 1..)]
    test: Vec<BuildingId>,
    /// Tasks to train on
    #[arg(long = "train-task", value_name = "TASK", num_args = 1.., value_parser = Task::from_text)]
    train_tasks: Vec<Task>,
    /// Tasks to test on
    #[arg(long = "test-task", value_name = "TASK", num_args = 1.., value_parser = Task::from_text)]
    test_tasks: Vec<Task>,
    /// Task to test on; training uses the other five of the six tasks
    #[arg(long, value_name = "TASK", conflicts_with_all = ["train_tasks", "test_tasks"])]
    left_out: Option<String>,
    /// Run periods of the test episodes: winter, summer, full_year or MM-DD..MM-DD
    #[arg(long = "period", value_name = "PERIOD", num_args = 1..)]
    windows: Vec<Period>,
    /// How long a policy with memory keeps it: for an episode, or for all test episodes of a building
    #[arg(long, value_name = "episode|building")]
    memory: Option<Memory>,
    /// Random seeds
    #[arg(long = "seed", value_name = "N", num_args = 1..)]
    seeds: Vec<u64>,
    /// Zone time steps per hour
    #[arg(long, value_name = "N")]
    steps_per_hour: Option<u32>,
    /// Whether the observation includes the attributes of the building, scaled to [-1, 1]
    #[arg(long, value_name = "given|withheld")]
    attributes: Option<Attributes>,
    /// Form of the observations of houses: a slot for every zone role, or zones in model order padded with zeros
    #[arg(long, value_name = "roles|raw")]
    observation: Option<HouseForm>,
    /// Control of the actuators that are withheld from the policy: the reactive controllers, or a constant
    #[arg(long, value_name = "reactive|pin")]
    fallback: Option<Fallback>,
    /// Constant value of the withheld actuators, in their unit
    #[arg(long, value_name = "VALUE")]
    pin: Option<f64>,
}

impl Selection {
    /// Returns the problem with its modifications.
    pub fn problem(&self) -> Result<Problem> {
        let problem = match (self.name.as_str(), self.train_types.is_empty()) {
            ("cross-domain", false) => Problem::cross_domain(&self.train_types, &self.test_types)?,
            ("cross-domain", true) => bail!("cross-domain requires --train-type and --test-type"),
            (_, false) => {
                bail!("--train-type and --test-type apply only to cross-domain, not to {}", self.name)
            }
            (name, true) if name.to_ascii_lowercase().ends_with(".json") => Problem::read(Path::new(name))?,
            (name, true) => Problem::named(name)?,
        };
        Ok(problem.with(&self.changes.changes())?)
    }
}

impl ChangeArguments {
    fn changes(&self) -> Changes {
        let Self { memory, attributes, observation, fallback, pin, steps_per_hour, .. } = *self;
        Changes {
            buildings: self.buildings.clone(),
            train: self.train.clone(),
            test: self.test.clone(),
            train_tasks: self.train_tasks.clone(),
            test_tasks: self.test_tasks.clone(),
            left_out: self.left_out.clone(),
            windows: self.windows.clone(),
            seeds: self.seeds.clone(),
            memory,
            steps_per_hour,
            attributes,
            observation,
            fallback,
            pin,
            ..Changes::default()
        }
    }
}
