//! A whole episode under a controller.

pub(crate) mod controller;
pub(crate) mod decisions;
pub(crate) mod trajectory;

use self::decisions::Decisions;
use self::trajectory::Trajectory;
use crate::environment::Step;
use crate::metrics::Metrics;
use crate::{Controller, Environment, Error, Result};

/// Watches a [`rollout`]: records it, reports progress, or stops it with an error.
///
/// `()` ignores everything, a [`Trajectory`] records the steps, a closure is called with every step, and both observers
/// of a pair are called in order.
pub trait Observer {
    /// Called with the first observation, before the first step.
    ///
    /// # Errors
    /// An error ends the rollout.
    fn begin(&mut self, _observation: &[f64]) -> Result<()> {
        Ok(())
    }

    /// Called with the decisions behind every action of a controller that keeps any, before the step.
    fn decided(&mut self, _decisions: &Decisions) {}

    /// Called after every step.
    ///
    /// # Errors
    /// An error ends the rollout.
    fn step(&mut self, step: &Step<'_>) -> Result<()>;
}

/// Runs an episode from reset to truncation and returns its metrics. The loop allocates one buffer for the action.
///
/// # Errors
/// The errors of the environment and of the observer.
pub fn rollout(
    environment: &mut dyn Environment,
    controller: &mut dyn Controller,
    observer: &mut dyn Observer,
) -> Result<Metrics> {
    controller.reset();
    run(environment, controller, observer)
}

/// Runs another episode in the same building: like [`rollout`], but with [`Controller::next_episode`] instead of
/// [`Controller::reset`].
///
/// # Errors
/// The errors of the environment and of the observer.
pub fn rollout_next(
    environment: &mut dyn Environment,
    controller: &mut dyn Controller,
    observer: &mut dyn Observer,
) -> Result<Metrics> {
    controller.next_episode();
    run(environment, controller, observer)
}

fn run(
    environment: &mut dyn Environment,
    controller: &mut dyn Controller,
    observer: &mut dyn Observer,
) -> Result<Metrics> {
    let mut action = vec![0.0; environment.spaces().action.len()];
    let mut observation = environment.reset()?;
    observer.begin(observation)?;
    loop {
        controller.act(observation, &mut action);
        if let Some(decisions) = controller.record() {
            observer.decided(decisions);
        }
        let step = environment.step(&action)?;
        controller.reward(step.reward.total());
        observer.step(&step)?;
        if step.truncated {
            break;
        }
        observation = step.observation;
    }
    environment.metrics().cloned().ok_or(Error::NotReset)
}

impl Observer for () {
    fn step(&mut self, _: &Step<'_>) -> Result<()> {
        Ok(())
    }
}

impl Observer for Trajectory {
    fn step(&mut self, step: &Step<'_>) -> Result<()> {
        self.push(step);
        Ok(())
    }
}

impl<F: FnMut(&Step<'_>) -> Result<()>> Observer for F {
    fn step(&mut self, step: &Step<'_>) -> Result<()> {
        self(step)
    }
}

impl<A: Observer + ?Sized, B: Observer + ?Sized> Observer for (&mut A, &mut B) {
    fn begin(&mut self, observation: &[f64]) -> Result<()> {
        self.0.begin(observation)?;
        self.1.begin(observation)
    }

    fn decided(&mut self, decisions: &Decisions) {
        self.0.decided(decisions);
        self.1.decided(decisions);
    }

    fn step(&mut self, step: &Step<'_>) -> Result<()> {
        self.0.step(step)?;
        self.1.step(step)
    }
}
