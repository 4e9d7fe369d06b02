//! Which problem: a name, a file, or any types against any others; and what is to be otherwise in it.

use std::path::Path;

use anyhow::{Result, bail};
use b2b_benchmark::Problem;
use b2b_benchmark::problem::{Attributes, Changes, Fallback};
use b2b_building::{BuildingType, RunPeriod};
use b2b_dataset::BuildingId;
use b2b_env::Task;

use crate::run;

/// The problem of a command.
#[derive(clap::Args)]
pub struct Selection {
    /// Problem: a name of `b2b benchmark list`, a file (.json), or cross-domain with --train-type and --test-type
    #[arg(value_name = "NAME")]
    name: String,
    /// Types to train on, for cross-domain
    #[arg(long = "train-type", value_name = "TYPE", num_args = 1.., requires = "test_types")]
    train_types: Vec<BuildingType>,
    /// Types to test on, for cross-domain
    #[arg(long = "test-type", value_name = "TYPE", num_args = 1.., requires = "train_types")]
    test_types: Vec<BuildingType>,
    #[command(flatten)]
    changes: ChangeArguments,
}

/// What is to be otherwise. The result says so, and is not compared with those of the problem as it is.
#[derive(clap::Args)]
#[command(next_help_heading = "Changes (another problem: the result says so)")]
struct ChangeArguments {
    /// Buildings of both sides, where these have the same
    #[arg(long = "building", value_name = "ID", num_args = 1.., conflicts_with_all = ["train", "test"])]
    buildings: Vec<BuildingId>,
    /// Buildings to train on
    #[arg(long, value_name = "ID", num_args = 1..)]
    train: Vec<BuildingId>,
    /// Buildings to test on
    #[arg(long, value_name = "ID", num_args = 1..)]
    test: Vec<BuildingId>,
    /// Tasks to train on
    #[arg(long = "train-task", value_name = "TASK", num_args = 1.., value_parser = run::task)]
    train_tasks: Vec<Task>,
    /// Tasks to test on
    #[arg(long = "test-task", value_name = "TASK", num_args = 1.., value_parser = run::task)]
    test_tasks: Vec<Task>,
    /// The one of the six tasks to test on; the five others are to train on
    #[arg(long, value_name = "TASK", conflicts_with_all = ["train_tasks", "test_tasks"])]
    left_out: Option<String>,
    /// Days of each test: winter, summer, full_year or MM-DD..MM-DD
    #[arg(long = "period", value_name = "DAYS", num_args = 1..)]
    windows: Vec<RunPeriod>,
    /// Seeds
    #[arg(long = "seed", value_name = "N", num_args = 1..)]
    seeds: Vec<u64>,
    /// Zone time steps an hour
    #[arg(long, value_name = "N")]
    steps_per_hour: Option<u32>,
    /// Whether the policy sees what building it is in
    #[arg(long, value_name = "given|withheld")]
    attributes: Option<Attributes>,
    /// Control of the removed actuators
    #[arg(long, value_name = "reactive|pin")]
    fallback: Option<Fallback>,
    /// Value of pinned actuators, in their unit
    #[arg(long, value_name = "VALUE")]
    pin: Option<f64>,
}

impl Selection {
    /// The problem.
    pub fn problem(&self) -> Result<Problem> {
        let problem = match (self.name.as_str(), self.train_types.is_empty()) {
            ("cross-domain", false) => Problem::cross_domain(&self.train_types, &self.test_types)?,
            ("cross-domain", true) => bail!("cross-domain needs --train-type and --test-type"),
            (_, false) => bail!("--train-type and --test-type are for cross-domain, not for {}", self.name),
            (name, true) if name.to_ascii_lowercase().ends_with(".json") => Problem::read(Path::new(name))?,
            (name, true) => Problem::named(name)?,
        };
        Ok(problem.with(&self.changes.changes())?)
    }
}

impl ChangeArguments {
    fn changes(&self) -> Changes {
        let Self { attributes, fallback, pin, steps_per_hour, .. } = *self;
        Changes {
            buildings: self.buildings.clone(),
            train: self.train.clone(),
            test: self.test.clone(),
            train_tasks: self.train_tasks.clone(),
            test_tasks: self.test_tasks.clone(),
            left_out: self.left_out.clone(),
            windows: self.windows.clone(),
            seeds: self.seeds.clone(),
            steps_per_hour,
            attributes,
            fallback,
            pin,
        }
    }
}
