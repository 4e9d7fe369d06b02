//! `b2b bench graph`: the cost of graph networks, compared with flat ones.

use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use b2b_agent::network::{Actor, Graph};
use b2b_agent::{Interface, Pilot};
use b2b_building::{BuildingType, RunPeriod};
use b2b_dataset::BuildingName;
use b2b_env::{Spaces, Task};
use b2b_learn::credit::Credit;
use b2b_learn::learner::Learner as _;
use b2b_learn::ppo::{Ppo, PpoConfig};
use b2b_learn::random::RandomStream;
use b2b_learn::rollout::{Rollout, Scene, Widths};
use b2b_learn::train::TrainConfig;
use cpu_time::ProcessTime;
use serde::Serialize;

use super::statistics::median;
use crate::arguments::location::Location;
use crate::program::prepare::Prepared;
use crate::terminal::table::Table;
use crate::terminal::{interrupt, stdout};

/// Measure the CPU time of forward passes and updates of graph networks, compared with flat networks and the
/// environment
///
/// Uses the networks of the presets graph and residual (flat), on one thread.
#[derive(clap::Args)]
#[command(after_help = "\
Columns:
  nodes, features, actions   of the building, for the graph network
  step                       CPU time of a step of the environment, µs
  forward                    CPU time of an action of the graph network, µs, and of the flat one
  update                     CPU time of an update per environment step, µs, and of the flat one; same number of epochs

Examples:
  b2b bench graph
  b2b bench graph --type OfficeMedium --edges bias --json")]
pub struct Arguments {
    /// Building types, or buildings of the dataset such as OfficeSmall-0042 [default: every type]
    #[arg(long = "type", visible_alias = "types", value_name = "BUILDING", num_args = 1..)]
    buildings: Vec<BuildingName>,
    /// How attention uses the edges of the graph: none, bias, mask or mixed
    #[arg(long, default_value = "none", value_name = "EDGES")]
    edges: String,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

const STEPS_PER_HOUR: u32 = 12;
/// Number of steps of an update: one minibatch of the preset.
const STEPS: usize = 504;
/// Number of updates, the first of which is excluded.
const UPDATES: usize = 4;
/// Number of blocks of forward passes.
const BLOCKS: usize = 9;
/// Number of forward passes in a block.
const PASSES: usize = 100;

/// The measurements in a building. Times are CPU time, µs.
#[derive(Serialize)]
struct TypeCost {
    building: String,
    nodes: usize,
    features: usize,
    actions: usize,
    step_us: f64,
    forward_us: f64,
    flat_forward_us: f64,
    update_us: f64,
    flat_update_us: f64,
}

/// Runs the command.
pub fn bench(arguments: &Arguments) -> Result<()> {
    let types = BuildingType::ALL.map(BuildingName::Type);
    let buildings = if arguments.buildings.is_empty() { &types[..] } else { &arguments.buildings };
    let edges = format!("[policy]\nedges = \"{}\"", arguments.edges);
    let changed = TrainConfig::preset("graph")?.with_changes(&edges);
    let config = changed.map_err(|why| anyhow::anyhow!("--edges: {why}"))?;
    let costs = buildings.iter().map(|name| cost(name, &config, arguments)).collect::<Result<Vec<_>>>()?;
    if arguments.json { stdout::print_json(&costs) } else { stdout::print(&text(&costs)) }
}

fn cost(name: &BuildingName, config: &TrainConfig, arguments: &Arguments) -> Result<TypeCost> {
    let prepared = Prepared::new(name, &Location::default(), arguments.json)?;
    let spaces = Arc::new(prepared.spaces(RunPeriod::WINTER, STEPS_PER_HOUR, Task::default())?);
    let flat = TrainConfig::preset("residual")?;
    let epochs = ppo_of(config)?.epochs;
    let of_graph = MeasuredLearner::new(config, ppo_of(config)?, &spaces)?;
    let of_flat =
        MeasuredLearner::new(&flat, PpoConfig { epochs, batch_size: STEPS, ..ppo_of(&flat)? }, &spaces)?;
    let Some(graph) = of_graph.graph.clone() else { bail!("the preset graph has no graph network") };
    Ok(TypeCost {
        building: name.to_string(),
        nodes: graph.nodes(),
        features: graph.width(),
        actions: graph.actions.len(),
        step_us: step(&prepared)?,
        forward_us: of_graph.forward(),
        flat_forward_us: of_flat.forward(),
        update_us: of_graph.update()?,
        flat_update_us: of_flat.update()?,
    })
}

/// Returns the median CPU time of a step of the environment over the second day of an episode, µs.
fn step(prepared: &Prepared) -> Result<f64> {
    let mut env = prepared.env("01-10..01-11".parse()?, STEPS_PER_HOUR, Task::default())?;
    env.reset()?;
    let action = env.action_space().middle();
    let mut times = Vec::new();
    for _ in 0..2 * 24 * STEPS_PER_HOUR {
        interrupt::check()?;
        let before = ProcessTime::now();
        env.step(&action)?;
        times.push(before.elapsed().as_secs_f64() * 1e6);
    }
    Ok(median(times.split_off(times.len() / 2)))
}

/// Returns the options of PPO of a configuration.
fn ppo_of(config: &TrainConfig) -> Result<PpoConfig> {
    let ppo: Option<&PpoConfig> = config.learner.options();
    Ok(ppo.context("the preset does not learn by PPO")?.clone())
}

/// A learner for a building, with random observations.
struct MeasuredLearner {
    ppo: Ppo,
    actor: Actor,
    graph: Option<Arc<Graph>>,
    widths: Widths,
}

impl MeasuredLearner {
    fn new(config: &TrainConfig, ppo: PpoConfig, spaces: &Arc<Spaces>) -> Result<Self> {
        let interface: Interface = config.agent.interface();
        let pilot = Pilot::new(interface, spaces)?;
        let widths = Widths::of(&pilot, 1);
        let ppo = Ppo::of_policy(&config.agent.policy, interface, widths, ppo, 0)?;
        Ok(Self { actor: ppo.actor(), ppo, graph: pilot.graph().cloned(), widths })
    }

    /// Returns the CPU time of an action, µs.
    fn forward(&self) -> f64 {
        let mut scratch = self.actor.scratch(self.graph.as_ref());
        let mut observation = vec![0.0; self.widths.observation];
        RandomStream::new(0, 0).normals(&mut observation);
        let mut action = vec![0.0; self.widths.action];
        let mut block = |_| {
            let before = ProcessTime::now();
            (0..PASSES).for_each(|_| self.actor.mean(&observation, &mut scratch, &mut action));
            before.elapsed().as_secs_f64() * 1e6 / PASSES as f64
        };
        median((0..BLOCKS).map(&mut block).collect())
    }

    /// Returns the CPU time of an update per step, µs.
    fn update(mut self) -> Result<f64> {
        let rollout = self.rollout();
        let mut times = Vec::new();
        for _ in 0..UPDATES {
            interrupt::check()?;
            let before = ProcessTime::now();
            self.ppo.update(&rollout)?;
            times.push(before.elapsed().as_secs_f64() * 1e6 / STEPS as f64);
        }
        Ok(median(times.split_off(1)))
    }

    fn rollout(&self) -> Rollout {
        let mut random = RandomStream::new(1, 0);
        let mut draw = |count: usize| {
            let mut values = vec![0.0; count];
            random.normals(&mut values);
            values
        };
        let credit = Arc::new(Credit::joint(self.widths));
        let scene = |graph: &Arc<Graph>| {
            let (graph, credit) = (Arc::clone(graph), Arc::clone(&credit));
            Scene { environment: 0, step: 0, graph, credit }
        };
        Rollout {
            environments: 1,
            steps: STEPS,
            observations: draw(STEPS * self.widths.observation),
            actions: draw(STEPS * self.widths.action),
            rewards: draw(STEPS),
            next: draw(self.widths.observation),
            scenes: self.graph.iter().map(scene).collect(),
            ..Rollout::default()
        }
    }
}

fn text(costs: &[TypeCost]) -> String {
    let mut table = Table::new([
        "building",
        "nodes",
        "features",
        "actions",
        "step (µs)",
        "forward (µs)",
        "flat (µs)",
        "update (µs/step)",
        "flat (µs/step)",
    ]);
    for cost in costs {
        table.row([
            cost.building.clone(),
            cost.nodes.to_string(),
            cost.features.to_string(),
            cost.actions.to_string(),
            format!("{:.0}", cost.step_us),
            format!("{:.0}", cost.forward_us),
            format!("{:.1}", cost.flat_forward_us),
            format!("{:.0}", cost.update_us),
            format!("{:.0}", cost.flat_update_us),
        ]);
    }
    table.text()
}
