//! Thousands of EnergyPlus buildings as reinforcement-learning environments.
//!
//! [`make`] names a building and returns an [`EnvBuilder`], which takes the task, the days and the weather and builds
//! an [`Env`] or a batch of environments. A [`Controller`] acts in it, and [`rollout`] runs a whole episode:
//!
//! ```no_run
//! use building2building::{Reactive, make, rollout};
//!
//! # fn main() -> building2building::Result<()> {
//! let mut env = make("OfficeSmall")?.task("occupancy").period("winter").build()?;
//! let mut controller = Reactive::for_env(&env);
//! let metrics = rollout(&mut env, &mut controller, &mut ())?;
//! println!("return {:.1}", metrics.episode_return);
//! # Ok(())
//! # }
//! ```
//!
//! EnergyPlus and weather files are downloaded into the cache when they are first used. The folder `examples` of this
//! crate shows one episode, a batch, a custom reward, a custom controller, snapshots and the training of an agent.
//!
//! The top level has the items that most programs need; the modules have the rest:
//!
//! | module | contents |
//! |---|---|
//! | [`mod@env`] | environments, spaces, tasks, rewards, metrics |
//! | [`control`] | controllers that do not learn (reactive, Guideline 36, MPC, planner) and their tuning |
//! | [`agent`] | trained agents: what they observe, how they act, their folders |
//! | [`learn`] | training of agents: PPO and SAC |
//! | [`workers`] | environments in worker processes, and batches of them |
//! | [`evaluation`] | evaluation of policies, baselines, scores and reports |
//! | [`benchmark`] | benchmark problems, entries, verification, leaderboard |
//! | [`dataset`] | building types, generators, the 6,000 buildings of the dataset |
//! | [`building`] | models, HVAC, sizing, preparation, import, description, morphology |
//! | [`climate`] | places, weather files, sites |
//! | [`energyplus`] | the engine |

mod builder;
mod error;
mod training;

pub use b2b_agent as agent;
pub use b2b_benchmark as benchmark;
pub use b2b_building as building;
pub use b2b_climate as climate;
pub use b2b_control as control;
pub use b2b_dataset as dataset;
pub use b2b_energyplus as energyplus;
pub use b2b_env as env;
pub use b2b_evaluate as evaluation;
pub use b2b_learn as learn;
pub use b2b_workers as workers;

pub use b2b_building::{BuildingType, RunPeriod};
pub use b2b_control::{Constant, Random, Reactive};
pub use b2b_dataset::{BuildingId, BuildingName};
pub use b2b_env::{
    Controller, Env, Environment, Metrics, Observer, Reward, RewardFunction, Spaces, Step, StepView, Task,
    Term, Trajectory, rollout,
};
pub use b2b_learn::fragments::run_if_worker;
pub use b2b_workers::{Episode, Snapshot, VecEnv};
pub use builder::{EnvBuilder, make};
pub use error::{Error, Result};
pub use training::train;

/// The examples for contributors, which are compiled as tests.
#[cfg(doctest)]
#[doc = include_str!("../../../CONTRIBUTING.md")]
struct Contributing;

/// The example in the documentation, which runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/rust.md")]
struct Documentation;
