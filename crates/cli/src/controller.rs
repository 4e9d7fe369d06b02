//! The controllers that a run can have.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Result, bail};
use b2b_control::{Constant, Controller, Random, Reactive, ReactiveParameters};
use b2b_env::Env;

use crate::prepare::Prepared;

/// Who acts.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub enum Kind {
    /// Proportional and staged control of every system, as a building would come with
    Reactive,
    /// A fresh uniform action at every step
    Random,
    /// The middle of every bound, always
    Constant,
    /// Tries actions on copies of the true simulation: what perfect foresight could reach; minutes a day
    #[cfg(target_os = "linux")]
    Planner,
}

impl Kind {
    /// Name, as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reactive => "reactive",
            Self::Random => "random",
            Self::Constant => "constant",
            #[cfg(target_os = "linux")]
            Self::Planner => "planner",
        }
    }

    /// A controller of this kind for an environment of a prepared building. A planner plans the episode here.
    pub fn build(
        self,
        prepared: &Prepared,
        env: &Env,
        parameters: &Parameters,
        seed: u64,
        quiet: bool,
    ) -> Result<Box<dyn Controller>> {
        Ok(match self {
            Self::Reactive => Box::new(reactive(env, parameters)?),
            Self::Random => Box::new(Random::new(env.action_space(), seed)),
            Self::Constant => Box::new(Constant::middle(env.action_space())),
            #[cfg(target_os = "linux")]
            Self::Planner => Box::new(plan(prepared, env, parameters, seed, quiet)?),
        })
    }
}

/// Which parameters the reactive controllers have.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameters {
    /// The same for every building.
    Default,
    /// What tuning found for the building's type and climate zone; the defaults where there is none, and for a
    /// prototype.
    Tuned,
    /// Those of a JSON file.
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
            _ => bail!("give default, tuned or a JSON file"),
        }
    }
}

impl Parameters {
    /// The parameters for the building of an environment.
    pub fn of(&self, env: &Env) -> Result<ReactiveParameters> {
        Ok(match self {
            Self::Default => ReactiveParameters::default(),
            Self::Tuned => ReactiveParameters::tuned_for(env.building()),
            Self::File(path) => ReactiveParameters::read(path)?,
        })
    }
}

/// The reactive controllers of a building.
pub fn reactive(env: &Env, parameters: &Parameters) -> Result<Reactive> {
    let (space, steps_per_hour) = (env.observation_space(), env.episode().steps_per_hour);
    Ok(Reactive::new(env.building(), space, steps_per_hour, &parameters.of(env)?))
}

/// Plans an episode on copies of it, to be carried out in the environment itself.
#[cfg(target_os = "linux")]
fn plan(
    prepared: &Prepared,
    env: &Env,
    parameters: &Parameters,
    seed: u64,
    quiet: bool,
) -> Result<b2b_control::Replay> {
    use b2b_control::{Planner, PlannerParameters, Replay};
    use b2b_env::vector::{Pool, Start};

    let steps = env.episode_steps();
    let bar = crate::progress::counter(steps, "steps planned", quiet);
    let mut pool = Pool::new(prepared.pool_options()?)?;
    let setting = prepared.setting(env.episode().clone());
    let template = pool.prepare(&setting)?;
    let mut live = pool.begin(template, Start::default())?;
    pool.wait(std::slice::from_mut(&mut live), 1)?;
    let mut planner = Planner::new(PlannerParameters::default(), reactive(env, parameters)?, seed);
    let actions = planner.run(&mut pool, &mut live, steps, || bar.inc(1))?;
    bar.finish_and_clear();
    Ok(Replay::new(actions, env.action_space().len()))
}
