//! The speed of training: updates alone, without a folder, evaluations or checkpoints.

use std::sync::Arc;
use std::time::Instant;

use b2b_dataset::Catalog;
use b2b_evaluate::{Baselines, Evaluation};
use b2b_workers::{VecEnv, WorkerOptions};

use super::config::TrainConfig;
use super::environments::{Environments, learner};
use crate::collector::Collector;
use crate::error::Result;
use crate::fragments::{FragmentCollector, spaces_of};
use crate::learner::Learner;
use crate::lockstep::LockstepCollector;
use crate::rollout::Rollout;

/// The design of a training loop: where actions are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Design {
    /// In the workers, for a fragment of an episode at a time: see [`crate::fragments`]. [`train`](super::train) uses
    /// this design.
    Fragments,
    /// In the owner, for one step of all environments at a time: see [`crate::lockstep`].
    Lockstep,
}

impl Design {
    /// All designs.
    pub const ALL: [Self; 2] = [Self::Fragments, Self::Lockstep];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fragments => "fragments",
            Self::Lockstep => "lockstep",
        }
    }
}

/// A training loop without a folder. With the same configuration, both designs learn the same weights.
pub struct TrainingLoop {
    collector: Box<dyn Timed>,
    learner: Box<dyn Learner>,
    /// Decisions of each environment in a rollout, and the steps of a decision.
    decisions: usize,
    hold: usize,
    rollout: Rollout,
}

/// The steps of an update and its wall-clock time, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpdateTimes {
    /// Steps of all environments.
    pub steps: u64,
    /// Time of the environments: all of the collection but inference.
    pub environment: f64,
    /// Time of the actor: the collection times the share of acting in the time of the workers or, in lockstep, of the
    /// owner.
    pub inference: f64,
    /// Time of the learner.
    pub learner: f64,
}

impl UpdateTimes {
    /// Returns the time of the update, s.
    pub fn seconds(&self) -> f64 {
        self.environment + self.inference + self.learner
    }
}

impl TrainingLoop {
    /// Begins the first episodes of a configuration.
    ///
    /// # Errors
    /// The errors of [`TrainConfig::check`]; [`Error::Invalid`](crate::Error::Invalid) for options that lockstep does
    /// not support; errors from environments and from the baselines that scale the rewards.
    pub fn new(
        config: &TrainConfig,
        design: Design,
        catalog: &Arc<Catalog>,
        workers: WorkerOptions,
    ) -> Result<Self> {
        config.check()?;
        let environments = Environments::new(config, Arc::clone(catalog));
        environments.check_memory()?;
        let (launcher, interrupted) = (workers.launcher.clone(), workers.interrupted);
        let evaluation = Evaluation { catalog, launcher, jobs: 1, interrupted };
        let scale = environments.scale(&evaluation, &Baselines::open()?)?;
        let collector: Box<dyn Timed> = match design {
            Design::Fragments => Box::new(environments.fragments(workers, scale)?),
            Design::Lockstep => Box::new(environments.lockstep(workers, scale)?),
        };
        let learner = learner(config, collector.widths(), spaces_of(collector.batch(), 0)?)?;
        let (decisions, hold) = (config.learner.steps_per_rollout(), config.hold());
        Ok(Self { collector, learner, decisions, hold, rollout: Rollout::default() })
    }

    /// Collects a rollout and learns from it.
    ///
    /// # Errors
    /// The errors of the collector and of the learner.
    pub fn update(&mut self) -> Result<UpdateTimes> {
        let began = Instant::now();
        self.collector.collect(&self.learner.actor(), self.decisions, &mut self.rollout)?;
        let collected = began.elapsed().as_secs_f64();
        self.learner.learn(&self.rollout)?;
        let seconds = began.elapsed().as_secs_f64();
        let [acting, all] = self.collector.times();
        let inference = collected * acting / all.max(f64::MIN_POSITIVE);
        Ok(UpdateTimes {
            steps: (self.rollout.rows() * self.hold) as u64,
            environment: collected - inference,
            inference,
            learner: seconds - collected,
        })
    }

    /// Returns the environments.
    pub fn environments(&self) -> &VecEnv {
        self.collector.batch()
    }
}

/// A collector whose steps are timed.
trait Timed: Collector {
    /// Returns the environments.
    fn batch(&self) -> &VecEnv;

    /// Returns the times spent on actions and on all steps of the last rollout, s.
    fn times(&self) -> [f64; 2];
}

impl Timed for FragmentCollector {
    fn batch(&self) -> &VecEnv {
        self.environments()
    }

    fn times(&self) -> [f64; 2] {
        self.worker_times()
    }
}

impl Timed for LockstepCollector {
    fn batch(&self) -> &VecEnv {
        self.environments()
    }

    fn times(&self) -> [f64; 2] {
        self.times()
    }
}
