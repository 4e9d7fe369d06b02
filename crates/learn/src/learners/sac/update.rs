//! An update of SAC.

use super::learner::Sac;
use super::loss::{SacLosses, temperature_gradient};
use super::worker::{SacMinibatch, SacWorker};
use crate::error::{Error, Result};
use crate::nn::{chunk, chunk_count, clip_norm, for_each, threads_for};
use crate::rollout::Rollout;

/// Number of consecutive updates with skipped steps after which learning fails.
const FAILURES: u64 = 3;

/// Results of an update. Losses, entropy, value and norms are means over its minibatches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SacUpdate {
    /// Half the squared error of the values, summed over both critics.
    pub critic_loss: f64,
    /// Temperature × log density - smaller value.
    pub actor_loss: f64,
    /// Temperature after the update.
    pub temperature: f64,
    /// Entropy of the policy in nats.
    pub entropy: f64,
    /// Value of the steps by the first critic.
    pub value: f64,
    /// Norm of the gradient of the critics before its clip.
    pub critic_gradient_norm: f64,
    /// Norm of the gradient of the actor before its clip.
    pub actor_gradient_norm: f64,
    /// Learning rate.
    pub learning_rate: f64,
    /// Minibatches.
    pub steps: usize,
    /// Minibatches given up at a non-finite loss or gradient, and rollouts with non-finite values, which do not enter
    /// the replay buffer.
    pub skipped: usize,
}

/// The network that a stage of a minibatch trains; also the index of its optimizer and gradients.
#[derive(Clone, Copy)]
enum Stage {
    Actor = 0,
    Critics = 1,
}

/// Index of the optimizer of the temperature.
const TEMPERATURE: usize = 2;

impl Sac {
    /// Adds the steps of a rollout to the replay buffer and learns from it.
    ///
    /// # Errors
    /// When an array of the rollout has a wrong length, or losses or gradients were not finite in three updates in a
    /// row.
    pub fn update(&mut self, rollout: &Rollout) -> Result<SacUpdate> {
        self.check(rollout)?;
        let learning_rate = self.config.learning_rate * self.config.schedule.factor(self.done);
        let mut update = SacUpdate { learning_rate, ..SacUpdate::default() };
        self.remember(rollout, &mut update);
        if self.can_learn() {
            self.owed += self.config.updates_per_step * rollout.rows() as f64;
        }
        while self.owed >= 1.0 {
            self.owed -= 1.0;
            match self.learn(&mut update) {
                Some(losses) => update.add(&losses),
                None => update.skipped += 1,
            }
        }
        update.set_means();
        update.temperature = f64::from(self.parameters.log_temperature.exp());
        self.updates += 1;
        self.failures = if update.skipped > 0 { self.failures + 1 } else { 0 };
        match self.failures >= FAILURES {
            true => Err(Error::NotFinite { updates: self.failures }),
            false => Ok(update),
        }
    }

    /// Returns whether the replay buffer has enough steps to begin learning.
    fn can_learn(&self) -> bool {
        !self.replay.is_empty() && (self.replay.len() >= self.config.learning_starts || self.replay.is_full())
    }

    fn check(&self, rollout: &Rollout) -> Result<()> {
        rollout.check(self.widths)?;
        let (length, expected) = (rollout.environments, self.replay.environments());
        if length != expected {
            return Err(Error::Rollout { name: "environments", length, expected });
        }
        Ok(())
    }

    fn remember(&mut self, rollout: &Rollout, update: &mut SacUpdate) {
        let arrays = [&rollout.observations, &rollout.actions, &rollout.rewards, &rollout.next];
        let ends = rollout.ends.iter().map(|end| &end.observation);
        if arrays.into_iter().chain(ends).flatten().all(|value| value.is_finite()) {
            self.replay.add(rollout);
        } else {
            self.replay.cut();
            update.skipped += 1;
        }
    }

    /// Learns from a minibatch, and returns its losses if they and their gradients are finite.
    fn learn(&mut self, update: &mut SacUpdate) -> Option<SacLosses> {
        let Self { replay, random, batch, config, .. } = self;
        replay.sample(config.batch_size, config.return_steps, config.gamma, random, batch);
        let critics = self.differentiate(Stage::Critics);
        let critic_norm = self.step(Stage::Critics, critics.critics, update.learning_rate)?;
        // The targets follow every step of the critics, also if the one of the actor is given up.
        self.parameters.follow(self.config.tau);
        let losses = self.differentiate(Stage::Actor);
        let actor_norm = self.step(Stage::Actor, losses.actor, update.learning_rate)?;
        if self.config.learn_temperature {
            self.step_temperature(losses.log_density, update.learning_rate);
        }
        update.critic_gradient_norm += critic_norm;
        update.actor_gradient_norm += actor_norm;
        Some(losses)
    }

    /// Computes the gradients of the actor or of the critics, and returns the losses so far.
    fn differentiate(&mut self, stage: Stage) -> SacLosses {
        let Self { workers, networks, parameters, batch, gradients, threads, .. } = self;
        let used = chunk_count(batch.rows, 1);
        while workers.len() < used {
            workers.push(SacWorker::new(networks));
        }
        let workers = &mut workers[..used];
        let threads = threads_for(batch.rows, parameters.actor.len() + parameters.critics.len(), *threads);
        let minibatch = SacMinibatch { networks, parameters, batch };
        for_each(workers, threads, |index, worker| match stage {
            Stage::Actor => worker.learn_actor(&minibatch, chunk(batch.rows, 1, index)),
            Stage::Critics => worker.learn_critics(&minibatch, chunk(batch.rows, 1, index)),
        });
        let sums = &mut gradients[stage as usize];
        sums.fill(0.0);
        let mut losses = SacLosses::default();
        for worker in workers {
            let own = match stage {
                Stage::Actor => &worker.actor_gradients,
                Stage::Critics => &worker.critic_gradients,
            };
            sums.iter_mut().zip(own).for_each(|(sum, gradient)| *sum += gradient);
            losses.add(&worker.losses);
        }
        losses
    }

    /// Makes a step of the optimizer, and returns the norm of the gradient if it and the loss are finite.
    fn step(&mut self, stage: Stage, loss: f64, learning_rate: f64) -> Option<f64> {
        let gradients = &mut self.gradients[stage as usize];
        let norm = clip_norm(&mut [gradients], self.config.max_grad_norm.unwrap_or(f32::MAX));
        if !(norm.is_finite() && loss.is_finite()) {
            return None;
        }
        let parameters = match stage {
            Stage::Actor => &mut self.parameters.actor,
            Stage::Critics => &mut self.parameters.critics,
        };
        self.adams[stage as usize].step(parameters, gradients, learning_rate);
        Some(f64::from(norm))
    }

    fn step_temperature(&mut self, log_density: f64, learning_rate: f64) {
        let target = -f64::from(self.config.target_entropy_factor) * self.widths.action as f64;
        let gradient = temperature_gradient(log_density, target) as f32;
        let temperature = std::slice::from_mut(&mut self.parameters.log_temperature);
        self.adams[TEMPERATURE].step(temperature, &[gradient], learning_rate);
    }
}

impl SacUpdate {
    /// Returns the numbers to report in a run's progress, by name.
    pub(super) fn named(&self) -> [(&'static str, f64); 10] {
        [
            ("critic_loss", self.critic_loss),
            ("actor_loss", self.actor_loss),
            ("temperature", self.temperature),
            ("entropy", self.entropy),
            ("value", self.value),
            ("critic_gradient_norm", self.critic_gradient_norm),
            ("actor_gradient_norm", self.actor_gradient_norm),
            ("learning_rate", self.learning_rate),
            ("minibatches", self.steps as f64),
            ("skipped", self.skipped as f64),
        ]
    }

    fn add(&mut self, losses: &SacLosses) {
        self.steps += 1;
        self.critic_loss += losses.critics;
        self.actor_loss += losses.actor;
        self.entropy -= losses.log_density;
        self.value += losses.value;
    }

    fn set_means(&mut self) {
        let share = 1.0 / self.steps.max(1) as f64;
        let sums = [
            &mut self.critic_loss,
            &mut self.actor_loss,
            &mut self.entropy,
            &mut self.value,
            &mut self.critic_gradient_norm,
            &mut self.actor_gradient_norm,
        ];
        sums.into_iter().for_each(|sum| *sum *= share);
    }
}
