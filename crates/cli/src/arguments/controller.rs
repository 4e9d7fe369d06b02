//! The controller of an episode and its parameters.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use anyhow::{Result, bail};
use b2b_agent::{Acting, Agent, AgentController};
use b2b_building::Controls;
use b2b_control::{
    Case, Controller, Guideline36, Guideline36Parameters, KINDS, Kind, Reactive, ReactiveParameters,
};
use b2b_env::{Spaces, Task};
use serde_json::Value;

use super::task;
use crate::output_folder::path_in_name;
use crate::program::prepare::Prepared;
use crate::terminal::suggestion;

/// A controller on the command line.
#[derive(clap::Args)]
pub struct ControllerArguments {
    #[arg(long = "controller", value_name = "CONTROLLER", help = controller_help())]
    choice: Option<Choice>,
    /// Parameters of the controller: default, tuned (for the building type, the climate zone and the task's objective:
    /// comfort, or comfort and energy), or a JSON file
    #[arg(long, default_value = "tuned", value_name = "default|tuned|FILE.json")]
    parameters: Parameters,
    /// Random seed of the controllers that draw: random, mpc, foresight and planner
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

fn controller_help() -> String {
    let kinds: Vec<String> = KINDS.iter().map(|kind| format!("{} ({})", kind.name(), kind.help())).collect();
    format!(
        "Controller: {}, or the folder of an agent that `b2b train` wrote [default: the task's baseline, guideline36 with \
         comfort bands and reactive with targets]",
        kinds.join(", ")
    )
}

/// The controller of an episode.
pub struct Chosen<'a> {
    choice: Choice,
    parameters: &'a Parameters,
    seed: u64,
}

/// The choice of a controller.
#[derive(Clone)]
enum Choice {
    Kind(&'static dyn Kind),
    /// The agent in a folder.
    Agent(PathBuf),
}

impl FromStr for Choice {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        if let Some(kind) = b2b_control::kind(text) {
            return Ok(Self::Kind(kind));
        }
        if Path::new(text).is_dir() {
            return Ok(Self::Agent(text.into()));
        }
        let names = KINDS.map(Kind::name);
        let near = suggestion::near(text, names.into_iter());
        bail!("{near}expected {} or the folder of an agent", names.join(", "))
    }
}

impl ControllerArguments {
    /// Returns the task of an episode: the given one, else an agent's training task, else the default of all commands.
    ///
    /// # Errors
    /// The reason why the agent cannot be read.
    pub fn task(&self, given: Option<&Task>) -> Result<Task> {
        if let (None, Some(Choice::Agent(folder))) = (given, &self.choice) {
            return Ok(Agent::read(folder)?.info().task.clone());
        }
        Ok(given.cloned().unwrap_or_else(task::usual))
    }

    /// Returns the controller for a task: without a choice, the task's baseline.
    pub fn chosen(&self, task: &Task) -> Chosen<'_> {
        let choice = self.choice.clone().unwrap_or_else(|| Choice::Kind(b2b_control::baseline(task)));
        Chosen { choice, parameters: &self.parameters, seed: self.seed }
    }
}

impl Chosen<'_> {
    /// Returns the name of the controller.
    pub fn name(&self) -> String {
        match &self.choice {
            Choice::Kind(kind) => kind.name().to_owned(),
            Choice::Agent(folder) => folder.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }

    /// Returns the values of its parameters, unless they are those that it has without an argument.
    pub fn parameters(&self, spaces: &Spaces) -> Result<Option<Value>> {
        match &self.choice {
            Choice::Kind(kind) if *self.parameters != Parameters::Tuned => {
                self.parameters.of(*kind, spaces).map(Some)
            }
            Choice::Kind(_) | Choice::Agent(_) => Ok(None),
        }
    }

    /// Returns what tells its episodes from those of the controller without arguments, in names of folders.
    pub fn variant(&self) -> String {
        let parameters = match self.parameters {
            Parameters::Tuned => String::new(),
            Parameters::Default => "-default".to_owned(),
            Parameters::File(path) => format!("-{}", path_in_name(&path.with_extension(""))),
        };
        match self.seed {
            0 => parameters,
            seed => format!("{parameters}-seed{seed}"),
        }
    }

    /// Returns whether the controller is a trained agent, which is plotted beside the reactive controllers.
    pub fn is_agent(&self) -> bool {
        !matches!(self.choice, Choice::Kind(_))
    }

    /// Returns who controls the building, and through what.
    pub fn controls(&self) -> Controls {
        match &self.choice {
            Choice::Kind(kind) => kind.controls(),
            Choice::Agent(_) => Controls::Actuators,
        }
    }

    /// Returns the random seed.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Returns a controller for the environment of a prepared building. A planner plans the whole episode first.
    pub fn build(
        &self,
        prepared: &Prepared,
        spaces: &Arc<Spaces>,
        quiet: bool,
    ) -> Result<Box<dyn Controller>> {
        let kind = match &self.choice {
            Choice::Kind(kind) => *kind,
            Choice::Agent(folder) if *self.parameters != Parameters::Tuned => {
                bail!("--parameters is for controllers, and {} is an agent; remove it", folder.display());
            }
            Choice::Agent(folder) => return Ok(Box::new(agent(folder, spaces)?)),
        };
        let values = self.parameters.of(kind, spaces)?;
        let case = Case { spaces, action: &spaces.action, seed: self.seed, values: &values };
        if kind.plans()
            && let Some(plan) = plan(kind, prepared, &case, quiet)?
        {
            return Ok(plan);
        }
        Ok(kind.make(&case)?)
    }
}

/// Plans an episode on copies of the simulation. The actions are then replayed in the environment itself.
fn plan(
    kind: &dyn Kind,
    prepared: &Prepared,
    case: &Case<'_>,
    quiet: bool,
) -> Result<Option<Box<dyn Controller>>> {
    let bar = crate::terminal::progress::counter(case.spaces.episode_steps(), "steps planned", quiet);
    let workers = b2b_workers::Workers::new(prepared.worker_options())?;
    let mut episode = workers.episode(&prepared.setting(case.spaces.episode.clone()))?;
    let plan = kind.plan(case, &mut episode, &mut || bar.inc(1))?;
    bar.finish_and_clear();
    Ok(plan.map(|plan| plan as Box<dyn Controller>))
}

/// Parameters of a controller.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameters {
    /// Default parameters, equal for all buildings.
    Default,
    /// Parameters tuned for the building's type and climate zone and the objective of the task; the defaults for
    /// prototypes and where there is no tuned set.
    Tuned,
    /// Read from a JSON file.
    File(PathBuf),
}

impl FromStr for Parameters {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        match text {
            "default" => Ok(Self::Default),
            "tuned" => Ok(Self::Tuned),
            file if Path::new(file).extension().is_some_and(|extension| extension == "json") => {
                Ok(Self::File(file.into()))
            }
            _ => {
                let near = suggestion::near(text, ["default", "tuned"].into_iter());
                bail!("{near}expected default, tuned or a JSON file")
            }
        }
    }
}

impl Parameters {
    /// Returns the values of a kind's parameters for the building and the task of an environment. For a kind without
    /// parameters, only a file is an error.
    fn of(&self, kind: &dyn Kind, spaces: &Spaces) -> Result<Value> {
        Ok(match self {
            Self::Default => kind.defaults(),
            Self::Tuned => kind.tuned(&spaces.building, &spaces.episode.task),
            Self::File(path) => kind.read(path)?,
        })
    }
}

/// Returns the controller of the agent in a folder. Prints a note if it leaves a part of the building to others.
fn agent(folder: &Path, spaces: &Arc<Spaces>) -> Result<AgentController> {
    let agent = Agent::read(folder)?;
    let controller = agent.controller(spaces)?;
    let (moved, info) = (controller.actions(), agent.info());
    let (all, what, others) = match info.interface.acting {
        acting @ Acting::Supervisory { .. } => {
            let guideline = Guideline36::new(spaces, &Guideline36Parameters::default());
            let points = guideline.supervisory_points().iter().filter(|point| acting.sets(point.shift));
            let others = match acting.starts_from_rule() {
                true => "linear-supervisor chooses",
                false => "guideline36 chooses",
            };
            (points.count(), "supervisory points", others)
        }
        _ => (spaces.action.len(), "actuators", "the reactive controllers control"),
    };
    // A flat network is trained with all actions of its buildings; an action may be shared by several points.
    if !info.node_types.is_empty() && moved < all {
        eprintln!(
            "the agent {} acts on {moved} of the {all} {what} of {}; {others} the others, whose node types it was not trained with",
            folder.display(),
            spaces.building.name
        );
    }
    Ok(controller)
}

/// Returns the reactive controllers of a building.
pub fn reactive(spaces: &Spaces, parameters: &Parameters) -> Result<Reactive> {
    let parameters = match parameters {
        Parameters::Default => ReactiveParameters::default(),
        Parameters::Tuned => ReactiveParameters::tuned_for(&spaces.building, &spaces.episode.task),
        Parameters::File(path) => ReactiveParameters::read(path)?,
    };
    Ok(Reactive::new(&spaces.building, &spaces.observation, spaces.episode.steps_per_hour, &parameters))
}
