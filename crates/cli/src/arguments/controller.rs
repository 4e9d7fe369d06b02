//! The controller of an episode and its parameters.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Result, bail};
use b2b_control::{Constant, Controller, Random, Reactive, ReactiveParameters};
use b2b_env::Env;

use crate::prepare::Prepared;

/// A controller on the command line.
#[derive(clap::Args)]
pub struct ControllerArguments {
    /// Controller
    #[arg(long = "controller", value_enum, default_value_t = Kind::Reactive)]
    kind: Kind,
    /// Parameters of the reactive controller: default, tuned (for the building type and climate zone), or a JSON file
    #[arg(long, default_value = "tuned", value_name = "default|tuned|FILE.json")]
    parameters: Parameters,
    /// Random seed of the random controller and of the planner
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

/// The controllers that need no policy file.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Kind {
    /// Rule-based baseline: PI loops and trim-and-respond after ASHRAE Guideline 36
    Reactive,
    /// Uniformly random action at every step
    Random,
    /// Constant action: the midpoint of every actuator's range
    Constant,
    /// Cross-entropy planning on copies of the simulation (perfect foresight); minutes per simulated day
    #[cfg(target_os = "linux")]
    Planner,
}

impl ControllerArguments {
    /// Returns the name of the controller.
    pub fn name(&self) -> &'static str {
        match self.kind {
            Kind::Reactive => "reactive",
            Kind::Random => "random",
            Kind::Constant => "constant",
            #[cfg(target_os = "linux")]
            Kind::Planner => "planner",
        }
    }

    /// Returns the random seed.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Returns a controller for the environment of a prepared building. The planner plans its episode here.
    pub fn build(&self, prepared: &Prepared, env: &Env, quiet: bool) -> Result<Box<dyn Controller>> {
        Ok(match self.kind {
            Kind::Reactive => Box::new(reactive(env, &self.parameters)?),
            Kind::Random => Box::new(Random::new(env.action_space(), self.seed)),
            Kind::Constant => Box::new(Constant::middle(env.action_space())),
            #[cfg(target_os = "linux")]
            Kind::Planner => Box::new(self.plan(prepared, env, quiet)?),
        })
    }

    /// Plans an episode on copies of the simulation, to be replayed in the environment itself.
    #[cfg(target_os = "linux")]
    fn plan(&self, prepared: &Prepared, env: &Env, quiet: bool) -> Result<b2b_control::Replay> {
        use b2b_control::{Planner, PlannerParameters, Replay};
        use b2b_env::vector::{Pool, Start};

        let steps = env.episode_steps();
        let bar = crate::progress::counter(steps, "steps planned", quiet);
        let mut pool = Pool::new(prepared.pool_options()?)?;
        let setting = prepared.setting(env.episode().clone());
        let template = pool.prepare(&setting)?;
        let mut live = pool.begin(template, Start::default())?;
        pool.wait(std::slice::from_mut(&mut live), 1)?;
        let reactive = reactive(env, &self.parameters)?;
        let mut planner = Planner::new(PlannerParameters::default(), reactive, self.seed);
        let actions = planner.run(&mut pool, &mut live, steps, || bar.inc(1))?;
        bar.finish_and_clear();
        Ok(Replay::new(actions, env.action_space().len()))
    }
}

/// Parameters of the reactive controllers.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameters {
    /// Default parameters, equal for all buildings.
    Default,
    /// Parameters tuned for the building's type and climate zone. The defaults where no tuning is available, and for prototypes.
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
    /// Returns the parameters for the building of an environment.
    fn of(&self, env: &Env) -> Result<ReactiveParameters> {
        Ok(match self {
            Self::Default => ReactiveParameters::default(),
            Self::Tuned => ReactiveParameters::tuned_for(env.building()),
            Self::File(path) => ReactiveParameters::read(path)?,
        })
    }
}

/// Returns the reactive controllers of a building.
pub fn reactive(env: &Env, parameters: &Parameters) -> Result<Reactive> {
    let (space, steps_per_hour) = (env.observation_space(), env.episode().steps_per_hour);
    Ok(Reactive::new(env.building(), space, steps_per_hour, &parameters.of(env)?))
}
