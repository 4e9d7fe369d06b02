//! `b2b bench train`: the speed of training.

use std::sync::Arc;

use anyhow::{Context, Result, bail};
use b2b_building::BuildingType;
use b2b_dataset::{BuildingId, BuildingName, Catalog, Split};
use b2b_learn::train::{
    Design, GraphPolicy, PolicyConfig, RecurrentPolicy, TrainConfig, TrainingLoop, UpdateTimes,
};
use cpu_time::ProcessTime;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::process::{cpu_seconds, private_mb, resident_mb};
use super::sb3::{Python, Speed};
use crate::program;
use crate::program::worker_options;
use crate::terminal::progress::{Download, spinner};
use crate::terminal::table::Table;
use crate::terminal::{interrupt, stdout};

/// Measure the speed of training in both loop designs, and the shares of environment, inference and learner
///
/// Trains PPO with the preset paper on the task constant in winter; for a building type, on its first training
/// building. After a first rollout that is excluded, the two designs alternate in random order, one rollout and update
/// each, so that other load affects both alike. Stable-Baselines3 follows, with the same settings and buildings on
/// make_sb3_vec.
#[derive(clap::Args)]
#[command(after_help = "\
Designs:
  fragments        workers compute actions, for a whole rollout at a time, as in `b2b train`
  lockstep         this process computes all actions, for one step at a time

Columns:
  steps/s          steps of all environments per wall-clock second
  steps/CPU s      the same per CPU time of this process and the environments' processes
  environment, inference, learner: shares of the wall-clock time. With fragments, inference is its share of the workers' time
  SB3              steps/s and steps/CPU s of Stable-Baselines3
  ratio            steps/s divided by SB3's
  private (MB)     memory that an environment's process shares with no other, with its actor, at the end
  owner (MB)       memory of this process, with the learners of both designs, at the end

Examples:
  b2b bench train
  b2b bench train --type OfficeSmall --steps 20000 --python none
  b2b bench train --recurrent 64
  b2b bench train --graph --recurrent 64
  b2b bench train --type SingleFamilyHouse-0042 --python venv/bin/python --json")]
pub struct Arguments {
    /// Building types, or buildings of the dataset such as OfficeSmall-0042
    #[arg(long = "type", visible_alias = "types", value_name = "BUILDING", num_args = 1..,
        default_values = ["SingleFamilyHouse", "OfficeMedium"])]
    buildings: Vec<BuildingName>,
    /// Steps of all environments to measure, rounded up to whole rollouts
    #[arg(long, default_value_t = 56_448, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    steps: u64,
    /// Number of environments
    #[arg(long, default_value_t = 14, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    environments: u32,
    /// Train graph networks instead of flat ones; without Stable-Baselines3, which has none
    #[arg(long)]
    graph: bool,
    /// Give actor and critic a gated recurrent unit of this width before their last layer, in a graph network for each
    /// node; without Stable-Baselines3, which has none
    #[arg(long, value_name = "WIDTH", value_parser = clap::value_parser!(u16).range(1..))]
    recurrent: Option<u16>,
    /// Python interpreter with building2building and stable-baselines3, or none to skip Stable-Baselines3
    #[arg(long, default_value = "python3", value_name = "PATH")]
    python: String,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Measurements of one design on one building.
#[derive(Serialize)]
struct MeasuredDesign {
    #[serde(rename = "type")]
    building_type: BuildingType,
    building: String,
    design: &'static str,
    environments: u32,
    steps: u64,
    steps_per_s: f64,
    /// `None` if an episode ended in every rollout.
    steps_per_cpu_s: Option<f64>,
    environment_share: f64,
    inference_share: f64,
    learner_share: f64,
    sb3_steps_per_s: Option<f64>,
    sb3_steps_per_cpu_s: Option<f64>,
    private_mb_per_env: f64,
    owner_mb: f64,
}

/// Runs the command.
pub fn bench(arguments: &Arguments) -> Result<()> {
    let buildings = arguments.buildings.iter().map(training_building).collect::<Result<Vec<_>>>()?;
    let has_none = arguments.python == "none" || arguments.graph || arguments.recurrent.is_some();
    let python = if has_none { None } else { Python::find(&arguments.python)? };
    let catalog = Arc::new(program::catalog(&mut Download::new(arguments.json))?);
    let mut measured = Vec::new();
    for building in buildings {
        let spinner = spinner(format!("training on {building}"), arguments.json);
        let costs = costs(building, arguments, &catalog)?;
        let sb3 = python
            .as_ref()
            .map(|python| python.measure(&building.to_string(), arguments.environments, arguments.steps));
        let sb3 = sb3.transpose()?;
        measured.extend(costs.iter().map(|(design, cost)| cost.measured(building, *design, arguments, sb3)));
        spinner.finish_and_clear();
    }
    if arguments.json { stdout::print_json(&measured) } else { stdout::print(&text(&measured)) }
}

/// Returns the building of a name, or the first training building of a type.
fn training_building(name: &BuildingName) -> Result<BuildingId> {
    match name {
        BuildingName::Id(id) => Ok(*id),
        BuildingName::Type(building_type) => {
            let mut rows = b2b_dataset::rows(*building_type).iter();
            let first = rows.find(|row| row.split == Split::Train);
            Ok(first.with_context(|| format!("{name} has no training building"))?.id)
        }
        BuildingName::Model(_) => {
            bail!(
                "`{name}` is not in the dataset; expected a building type or an id such as OfficeSmall-0042"
            )
        }
    }
}

/// Measures both designs on a building.
fn costs(
    building: BuildingId,
    arguments: &Arguments,
    catalog: &Arc<Catalog>,
) -> Result<Vec<(Design, UpdateCost)>> {
    let mut config = TrainConfig::preset("paper")?;
    config.training_set.buildings = vec![building.to_string()];
    config.budget.environments = arguments.environments as usize;
    config.agent.policy = match (arguments.graph, arguments.recurrent.map_or(0, usize::from)) {
        (true, memory) => PolicyConfig::Graph(GraphPolicy { memory, ..GraphPolicy::default() }),
        (false, 0) => PolicyConfig::Flat,
        (false, width) => PolicyConfig::Recurrent(RecurrentPolicy { width, ..RecurrentPolicy::default() }),
    };
    let mut turns = Vec::new();
    for design in Design::ALL {
        let workers = worker_options(catalog.library().path());
        let mut training = TrainingLoop::new(&config, design, catalog, workers)?;
        training.update()?;
        turns.push((design, training, UpdateCost::default()));
    }
    let mut random = ChaCha8Rng::seed_from_u64(0);
    while turns.iter().any(|(_, _, cost)| cost.times.steps < arguments.steps) {
        turns.shuffle(&mut random);
        for (_, training, cost) in &mut turns {
            interrupt::check()?;
            cost.add_update(training)?;
        }
    }
    for (_, training, cost) in &mut turns {
        cost.private_mb = Processes::of(training)?.private_mb()?;
        cost.owner_mb = resident_mb(std::process::id())?;
    }
    turns.sort_by_key(|(design, ..)| *design as u8);
    Ok(turns.into_iter().map(|(design, _, cost)| (design, cost)).collect())
}

/// The accumulated cost of updates.
#[derive(Default)]
struct UpdateCost {
    times: UpdateTimes,
    /// CPU time, s, and the number of steps that it covers.
    cpu: (f64, u64),
    /// Memory at the end, of an environment and of this process, MB.
    private_mb: f64,
    owner_mb: f64,
}

impl UpdateCost {
    /// Runs an update and adds its cost.
    fn add_update(&mut self, training: &mut TrainingLoop) -> Result<()> {
        let (before, owner) = (Processes::of(training)?, ProcessTime::now());
        let UpdateTimes { steps, environment, inference, learner } = training.update()?;
        let owner = owner.elapsed().as_secs_f64();
        let after = Processes::of(training)?;
        // The CPU time of a process that has ended with its episode is no longer readable.
        if before.ids == after.ids {
            self.cpu.0 += after.cpu_seconds - before.cpu_seconds + owner;
            self.cpu.1 += steps;
        }
        self.times.steps += steps;
        self.times.environment += environment;
        self.times.inference += inference;
        self.times.learner += learner;
        Ok(())
    }

    fn measured(
        &self,
        building: BuildingId,
        design: Design,
        arguments: &Arguments,
        sb3: Option<Speed>,
    ) -> MeasuredDesign {
        let (times, seconds) = (self.times, self.times.seconds());
        let (cpu_seconds, cpu_steps) = self.cpu;
        MeasuredDesign {
            building_type: building.building_type(),
            building: building.to_string(),
            design: design.name(),
            environments: arguments.environments,
            steps: times.steps,
            steps_per_s: times.steps as f64 / seconds,
            steps_per_cpu_s: (cpu_steps > 0).then(|| cpu_steps as f64 / cpu_seconds),
            environment_share: times.environment / seconds,
            inference_share: times.inference / seconds,
            learner_share: times.learner / seconds,
            sb3_steps_per_s: sb3.map(|sb3| sb3.steps_per_s),
            sb3_steps_per_cpu_s: sb3.and_then(|sb3| sb3.steps_per_cpu_s),
            private_mb_per_env: self.private_mb,
            owner_mb: self.owner_mb,
        }
    }
}

/// The processes of the environments, and the CPU time that they have used.
struct Processes {
    ids: Vec<Option<u32>>,
    cpu_seconds: f64,
}

impl Processes {
    fn of(training: &TrainingLoop) -> Result<Self> {
        let environments = training.environments();
        let ids: Vec<_> = (0..environments.len()).map(|index| environments.process(index)).collect();
        let cpu_seconds = ids.iter().flatten().map(|process| cpu_seconds(*process)).sum::<Result<f64>>()?;
        Ok(Self { ids, cpu_seconds })
    }

    /// Returns the mean private memory of a process, MB.
    fn private_mb(&self) -> Result<f64> {
        let all = self.ids.iter().flatten().map(|process| private_mb(*process)).sum::<Result<f64>>()?;
        Ok(all / self.ids.iter().flatten().count().max(1) as f64)
    }
}

fn text(measured: &[MeasuredDesign]) -> String {
    let mut table = Table::new([
        "building",
        "design",
        "N",
        "steps",
        "steps/s",
        "steps/CPU s",
        "environment (%)",
        "inference (%)",
        "learner (%)",
        "SB3 steps/s",
        "SB3 steps/CPU s",
        "ratio",
        "private (MB)",
        "owner (MB)",
    ]);
    let number = |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{value:.0}"));
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    for each in measured {
        let ratio = each.sb3_steps_per_s.map(|sb3| format!("{:.2}", each.steps_per_s / sb3));
        table.row([
            each.building.clone(),
            each.design.to_owned(),
            each.environments.to_string(),
            each.steps.to_string(),
            format!("{:.0}", each.steps_per_s),
            number(each.steps_per_cpu_s),
            percent(each.environment_share),
            percent(each.inference_share),
            percent(each.learner_share),
            number(each.sb3_steps_per_s),
            number(each.sb3_steps_per_cpu_s),
            ratio.unwrap_or("–".to_owned()),
            format!("{:.0}", each.private_mb_per_env),
            format!("{:.0}", each.owner_mb),
        ]);
    }
    table.text()
}
