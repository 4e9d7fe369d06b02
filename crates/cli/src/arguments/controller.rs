//! The controller of an episode and its parameters.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use anyhow::{Result, bail};
#[cfg(target_os = "linux")]
use b2b_agent::{Agent, AgentController};
use b2b_control::{Constant, Controller, Random, Reactive, ReactiveParameters};
use b2b_env::Spaces;

use crate::prepare::Prepared;

/// A controller on the command line.
#[derive(clap::Args)]
pub struct ControllerArguments {
    /// Controller: reactive (rule-based baseline, after ASHRAE Guideline 36), random (uniform at every step), constant
    /// (middle of every actuator's range), planner (cross-entropy planning on copies of the simulation with perfect
    /// foresight; minutes per simulated day), or the folder of an agent that `b2b train` wrote
    #[arg(long = "controller", value_name = "CONTROLLER", default_value = "reactive")]
    kind: Kind,
    /// Parameters of the reactive controller: default, tuned (for the building type, the climate zone and the
    /// task's objective: comfort, or comfort and energy), or a JSON file
    #[arg(long, default_value = "tuned", value_name = "default|tuned|FILE.json")]
    parameters: Parameters,
    /// Random seed of the random controller and of the planner
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

/// The kind of controller.
#[derive(Clone, PartialEq)]
enum Kind {
    Reactive,
    Random,
    Constant,
    #[cfg(target_os = "linux")]
    Planner,
    /// The agent in a folder.
    #[cfg(target_os = "linux")]
    Agent(PathBuf),
}

impl FromStr for Kind {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        Ok(match text {
            "reactive" => Self::Reactive,
            "random" => Self::Random,
            "constant" => Self::Constant,
            #[cfg(target_os = "linux")]
            "planner" => Self::Planner,
            #[cfg(target_os = "linux")]
            folder if Path::new(folder).is_dir() => Self::Agent(folder.into()),
            _ => bail!("expected reactive, random, constant, planner or the folder of an agent"),
        })
    }
}

impl ControllerArguments {
    /// Returns the name of the controller.
    pub fn name(&self) -> String {
        let name = match &self.kind {
            Kind::Reactive => "reactive",
            Kind::Random => "random",
            Kind::Constant => "constant",
            #[cfg(target_os = "linux")]
            Kind::Planner => "planner",
            #[cfg(target_os = "linux")]
            Kind::Agent(folder) => {
                return folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
            }
        };
        name.to_owned()
    }

    /// Returns whether the controller is a trained agent, which is plotted beside the reactive controllers.
    pub fn is_agent(&self) -> bool {
        #[cfg(target_os = "linux")]
        return matches!(self.kind, Kind::Agent(_));
        #[cfg(not(target_os = "linux"))]
        false
    }

    /// Returns the random seed.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Returns a controller for the environment of a prepared building. The planner plans the whole episode first.
    #[cfg_attr(
        not(target_os = "linux"),
        expect(unused_variables, reason = "agents and the planner need Linux")
    )]
    pub fn build(
        &self,
        prepared: &Prepared,
        spaces: &Arc<Spaces>,
        quiet: bool,
    ) -> Result<Box<dyn Controller>> {
        Ok(match &self.kind {
            Kind::Reactive => Box::new(reactive(spaces, &self.parameters)?),
            Kind::Random => Box::new(Random::new(&spaces.action, self.seed)),
            Kind::Constant => Box::new(Constant::middle(&spaces.action)),
            #[cfg(target_os = "linux")]
            Kind::Planner => Box::new(self.plan(prepared, spaces, quiet)?),
            #[cfg(target_os = "linux")]
            Kind::Agent(folder) => Box::new(agent(folder, spaces)?),
        })
    }

    /// Plans an episode on copies of the simulation. The actions are then replayed in the environment itself.
    #[cfg(target_os = "linux")]
    fn plan(&self, prepared: &Prepared, spaces: &Spaces, quiet: bool) -> Result<b2b_control::Replay> {
        use b2b_control::{Planner, PlannerParameters, Replay};
        use b2b_workers::Workers;

        let steps = spaces.episode_steps();
        let bar = crate::progress::counter(steps, "steps planned", quiet);
        let workers = Workers::new(prepared.worker_options())?;
        let mut episode = workers.episode(&prepared.setting(spaces.episode.clone()))?;
        let reactive = reactive(spaces, &self.parameters)?;
        let mut planner = Planner::new(PlannerParameters::default(), reactive, self.seed);
        let actions = planner.plan_episode(&mut episode, steps, || bar.inc(1))?;
        bar.finish_and_clear();
        Ok(Replay::new(actions, spaces.action.len()))
    }
}

/// Parameters of the reactive controllers.
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
            _ => bail!("expected default, tuned or a JSON file"),
        }
    }
}

impl Parameters {
    /// Returns the parameters for the building and the task of an environment.
    fn of(&self, spaces: &Spaces) -> Result<ReactiveParameters> {
        Ok(match self {
            Self::Default => ReactiveParameters::default(),
            Self::Tuned => ReactiveParameters::tuned_for(&spaces.building, &spaces.episode.task),
            Self::File(path) => ReactiveParameters::read(path)?,
        })
    }
}

/// Returns the controller of the agent in a folder.
#[cfg(target_os = "linux")]
fn agent(folder: &Path, spaces: &Arc<Spaces>) -> Result<AgentController> {
    let controller = Agent::read(folder)?.controller(spaces)?;
    let (corrected, actuators) = (controller.actuators(), spaces.action.len());
    if corrected < actuators {
        eprintln!(
            "the agent {} corrects {corrected} of the {actuators} actuators of {}; the reactive controllers control the others, whose \
             node types it was not trained with",
            folder.display(),
            spaces.building.name
        );
    }
    Ok(controller)
}

/// Returns the reactive controllers of a building.
pub fn reactive(spaces: &Spaces, parameters: &Parameters) -> Result<Reactive> {
    let (space, steps_per_hour) = (&spaces.observation, spaces.episode.steps_per_hour);
    Ok(Reactive::new(&spaces.building, space, steps_per_hour, &parameters.of(spaces)?))
}
