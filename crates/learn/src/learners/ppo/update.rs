//! An update of PPO.

use std::sync::Arc;

use b2b_agent::network::graph::Batch;

use super::advantage::{RolloutValues, advantages, center_pairs};
use super::learner::Ppo;
use super::loss::Losses;
use super::samples::Samples;
use super::scale::Rows;
use super::worker::{ACTOR, CRITIC, Inputs, Minibatch, Worker};
use crate::error::{Error, Result};
use crate::nn::{Sequences, chunk, chunk_count, clip_norm, for_each, threads_for};
use crate::rollout::Rollout;

/// Rows of a pass through the networks before the epochs.
pub(super) const BLOCK: usize = 256;
/// Number of consecutive updates with skipped steps after which learning fails.
const FAILURES: u64 = 3;
/// Multiple of the target divergence at which an update stops, as in Stable-Baselines3.
const KL_FACTOR: f64 = 1.5;
/// Factor by which the learning rate adapts, and its limits as shares of the scheduled rate.
const RATE_FACTOR: f64 = 1.5;
const RATES: std::ops::RangeInclusive<f64> = 0.01..=3.0;

/// Results of an update. Losses, entropy, divergence and norm are means over its minibatches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Update {
    /// Clipped surrogate, negated.
    pub policy_loss: f64,
    /// Mean squared error of values, on the scale of the critic.
    pub value_loss: f64,
    /// Entropy of the policy in nats.
    pub entropy: f64,
    /// Divergence of the policy from the one that made the steps, in nats, averaged over the groups of actions.
    pub approx_kl: f64,
    /// Divergence at which the update stopped, if it did: see [`PpoConfig::target_kl`](super::PpoConfig::target_kl).
    pub stopped_kl: Option<f64>,
    /// Share of clipped ratios.
    pub clip_fraction: f64,
    /// 1 - variance of (return - value) / variance of returns, before the update; 0 if returns do not vary.
    pub explained_variance: f64,
    /// Norm of the gradient before its clip.
    pub gradient_norm: f64,
    /// Learning rate of the actor.
    pub learning_rate: f64,
    /// Complete epochs.
    pub epochs: usize,
    /// Steps of the optimizer.
    pub steps: usize,
    /// Minibatches with a non-finite loss or gradient, which were skipped.
    pub skipped: usize,
}

/// The outcome of a minibatch.
enum Outcome {
    Stepped,
    Skipped,
    Stopped,
}

impl Ppo {
    /// Learns from the steps of a rollout that the current actor has made.
    ///
    /// # Errors
    /// When an array of the rollout has a wrong length, or losses or gradients were not finite in three updates in a
    /// row.
    pub fn update(&mut self, rollout: &Rollout) -> Result<Update> {
        rollout.check(self.widths)?;
        self.check_sequences(rollout)?;
        let explained_variance = self.prepare(rollout);
        let learning_rate = self.learning_rate() * self.rate;
        let mut update = Update { explained_variance, learning_rate, ..Update::default() };
        self.run_epochs(&mut update);
        self.adapt_rate(&update);
        self.features.update(rollout, self.widths.observation);
        self.features.write(&self.networks, &mut self.parameters);
        self.average_parameters();
        self.updates += 1;
        self.failures = if update.skipped > 0 { self.failures + 1 } else { 0 };
        match self.failures >= FAILURES {
            true => Err(Error::NotFinite { updates: self.failures }),
            false => Ok(update),
        }
    }

    /// Adds the parameters, except feature statistics, to their running average. The first updates have equal weights.
    fn average_parameters(&mut self) {
        let rate = self.config.average_rate.max(1.0 / (self.updates + 1) as f32);
        for (average, newest) in self.average.iter_mut().zip(&self.parameters) {
            *average = rate * newest + (1.0 - rate) * *average;
        }
        self.features.write(&self.networks, &mut self.average);
    }

    /// Returns the learning rate of the critic, and of the actor before its adaptation.
    fn learning_rate(&self) -> f64 {
        self.config.learning_rate * self.config.schedule.factor(self.done)
    }

    fn adapt_rate(&mut self, update: &Update) {
        let Some(desired) = self.config.desired_kl.map(f64::from) else { return };
        // Divergence grows with the square of the rate.
        let desired = desired * self.config.schedule.factor(self.done).powi(2);
        // If the update stopped early, the divergence at the stop says more than the mean over the minibatches before
        // it.
        let kl = update.stopped_kl.unwrap_or(update.approx_kl);
        if kl > 2.0 * desired {
            self.rate /= RATE_FACTOR;
        } else if kl < 0.5 * desired {
            self.rate *= RATE_FACTOR;
        }
        self.rate = self.rate.clamp(*RATES.start(), *RATES.end());
    }

    /// Computes log densities, advantages and returns of the steps. Returns the explained variance.
    pub(super) fn prepare(&mut self, rollout: &Rollout) -> f64 {
        if !rollout.scenes.is_empty() {
            self.graphs = rollout.scenes.iter().map(|scene| Arc::clone(&scene.graph)).collect();
            self.credits = rollout.scenes.iter().map(|scene| Arc::clone(&scene.credit)).collect();
        }
        let remembers = self.networks.actor.state() > 0;
        self.samples.read(rollout, remembers);
        self.features.normalize(&mut self.samples.observations);
        if !remembers {
            self.evaluate_actions();
        }
        let values = self.evaluate(rollout);
        let mut of_parts = vec![0.0; values.steps.len()];
        advantages(rollout, &values, self.config.gamma, self.config.gae_lambda, &mut of_parts);
        let returns = &mut self.samples.returns;
        returns.clear();
        returns.extend(of_parts.iter().zip(&values.steps).map(|(advantage, value)| advantage + value));
        center_pairs(rollout, self.widths.parts, &mut of_parts);
        self.assign_credit(&of_parts);
        if self.config.balance_buildings {
            self.samples.balance_advantages(self.groups, &self.credits);
        }
        let returns = &mut self.samples.returns;
        let explained = explained_variance(&values.steps, returns, self.widths.parts);
        if self.config.normalize_values {
            let critic = &mut self.parameters[self.networks.critics()];
            let (scenes, parts) = (&self.samples.scenes, self.widths.parts);
            let rows = Rows { credits: &self.credits, scenes, parts };
            self.scale.update(rows, returns, |kind| self.networks.value_outputs(kind), critic);
            self.scale.normalize(rows, returns);
        }
        explained
    }

    /// Computes the advantages of action groups from the advantages of reward parts, rows × parts.
    fn assign_credit(&mut self, of_parts: &[f32]) {
        let (parts, Samples { advantages, scenes, .. }) = (self.widths.parts, &mut self.samples);
        advantages.clear();
        advantages.resize(scenes.len() * self.groups, 0.0);
        let rows = of_parts.chunks_exact(parts).zip(advantages.chunks_exact_mut(self.groups));
        for ((of_parts, of_groups), scene) in rows.zip(scenes.iter()) {
            self.credits[*scene].assign(of_parts, of_groups);
        }
    }

    fn evaluate_actions(&mut self) {
        let Self { samples, workers, networks, credits, groups, parameters, widths, graphs, .. } = self;
        samples.old.clear();
        let observations = samples.observations.chunks(BLOCK * widths.observation);
        let actions = samples.actions.chunks(BLOCK * widths.action);
        for ((observations, actions), of_rows) in observations.zip(actions).zip(samples.scenes.chunks(BLOCK))
        {
            let batch = Batch { graphs, of_rows, observations, width: widths.observation };
            let (credits, inputs) = ((&credits[..], *groups), Inputs { batch, sequences: Sequences::none() });
            workers[0].log_densities(networks, credits, parameters, (inputs, actions), &mut samples.old);
        }
    }

    /// Returns the values of the observations of a rollout; for networks with a memory, also computes the log densities
    /// of its actions.
    pub(super) fn evaluate(&mut self, rollout: &Rollout) -> RolloutValues {
        let after = scenes_after(rollout);
        let mut values = match self.networks.critic.state() {
            0 => self.outputs_of_critic(rollout, &after),
            _ => self.evaluate_sequences(rollout, &after),
        };
        self.denormalize(&after, &mut values);
        values
    }

    fn outputs_of_critic(
        &mut self,
        rollout: &Rollout,
        [of_ends, of_next]: &[Vec<usize>; 2],
    ) -> RolloutValues {
        let [ends, next] = self.observations_after(rollout);
        let Self { workers, networks, parameters, widths, graphs, samples, .. } = self;
        let mut of = |observations: &[f32], scenes: &[usize]| {
            let mut values = Vec::new();
            for (observations, of_rows) in
                observations.chunks(BLOCK * widths.observation).zip(scenes.chunks(BLOCK))
            {
                let batch = Batch { graphs, of_rows, observations, width: widths.observation };
                let inputs = Inputs { batch, sequences: Sequences::none() };
                workers[0].values(networks, parameters, inputs, &mut values);
            }
            values
        };
        RolloutValues {
            steps: of(&samples.observations, &samples.scenes),
            next: of(&next, of_next),
            ends: of(&ends, of_ends),
        }
    }

    /// Returns the final observations of episodes, and the observations after the last steps.
    pub(super) fn observations_after(&self, rollout: &Rollout) -> [Vec<f32>; 2] {
        let ends = rollout.ends.iter().flat_map(|end| &end.observation).copied().collect();
        let mut after = [ends, rollout.next.clone()];
        after.iter_mut().for_each(|observations| self.features.normalize(observations));
        after
    }

    /// Converts outputs of the critic to the scale of returns.
    fn denormalize(&self, [of_ends, of_next]: &[Vec<usize>; 2], values: &mut RolloutValues) {
        if self.config.normalize_values {
            let RolloutValues { steps, next, ends } = values;
            for (scenes, values) in [(&self.samples.scenes, steps), (of_next, next), (of_ends, ends)] {
                let rows = Rows { credits: &self.credits, scenes, parts: self.widths.parts };
                self.scale.denormalize(rows, values);
            }
        }
    }

    fn run_epochs(&mut self, update: &mut Update) {
        let mut order = std::mem::take(&mut self.order);
        order.clear();
        let length = self.networks.sequence;
        order.extend(0..self.samples.scenes.len() / length);
        let mut sums = Losses::default();
        let size = (self.config.batch_size / length).max(1);
        'epochs: for _ in 0..self.config.epochs {
            self.random.shuffle(&mut order);
            for sequences in order.chunks(size) {
                match self.learn(sequences, &mut sums, update) {
                    Outcome::Stepped => update.steps += 1,
                    Outcome::Skipped => update.skipped += 1,
                    Outcome::Stopped => break 'epochs,
                }
            }
            update.epochs += 1;
        }
        for _ in 0..self.config.critic_epochs {
            self.random.shuffle(&mut order);
            order.chunks(size).for_each(|sequences| self.learn_values(sequences, update));
        }
        self.order = order;
        update.set_means(&sums);
    }

    /// Learns from a minibatch of these sequences, which are single steps unless networks have a memory, and adds its
    /// losses to the sums.
    fn learn(&mut self, sequences: &[usize], sums: &mut Losses, update: &mut Update) -> Outcome {
        let rows = self.gather(sequences);
        if self.config.normalize_advantage {
            self.minibatch.normalize_advantages(self.groups, &self.credits);
        }
        let losses = self.differentiate(rows, false);
        if self.config.target_kl.is_some_and(|target| losses.kl > KL_FACTOR * f64::from(target)) {
            update.stopped_kl = Some(losses.kl);
            return Outcome::Stopped;
        }
        let norm = clip_norm(&mut [&mut self.gradients], self.config.max_grad_norm);
        if !(norm.is_finite() && (losses.policy + losses.value + losses.entropy).is_finite()) {
            return Outcome::Skipped;
        }
        let actor = 0..self.networks.critics().start;
        let gradients = &self.gradients[actor.clone()];
        self.adams[ACTOR].step(&mut self.parameters[actor], gradients, update.learning_rate);
        self.step_critic();
        self.networks.project(&mut self.parameters);
        sums.add(&losses);
        update.gradient_norm += f64::from(norm);
        Outcome::Stepped
    }

    /// Like [`Ppo::learn`], for the critic only, and without adding to the means of the update.
    fn learn_values(&mut self, sequences: &[usize], update: &mut Update) {
        let rows = self.gather(sequences);
        let losses = self.differentiate(rows, true);
        let norm = clip_norm(&mut [&mut self.gradients], self.config.max_grad_norm);
        match norm.is_finite() && losses.value.is_finite() {
            true => self.step_critic(),
            false => update.skipped += 1,
        }
    }

    /// Moves the parameters of the critic by one step.
    fn step_critic(&mut self) {
        let (critic, rate) = (self.networks.critics(), self.learning_rate());
        let gradients = &self.gradients[critic.clone()];
        self.adams[CRITIC].step(&mut self.parameters[critic], gradients, rate);
    }

    /// Copies these sequences of the samples to the minibatch. Returns the number of rows.
    fn gather(&mut self, sequences: &[usize]) -> usize {
        let length = self.networks.sequence;
        let rows: Vec<usize> =
            sequences.iter().flat_map(|sequence| sequence * length..(sequence + 1) * length).collect();
        self.minibatch.gather(&self.samples, &rows, self.widths, self.groups);
        self.minibatch.gather_states(&self.samples, sequences, self.networks.states());
        rows.len()
    }

    /// Computes the gradients of the minibatch, of all parameters or of the critic's only, and returns its losses.
    fn differentiate(&mut self, rows: usize, critic_only: bool) -> Losses {
        let Self {
            workers,
            networks,
            config,
            credits,
            groups,
            parameters,
            minibatch,
            graphs,
            gradients,
            threads,
            ..
        } = self;
        let (length, used) = (networks.sequence, chunk_count(rows, networks.sequence));
        while workers.len() < used {
            workers.push(Worker::new(networks));
        }
        let workers = &mut workers[..used];
        let (samples, groups) = (&*minibatch, *groups);
        let batch =
            Minibatch { config, networks, credits, groups, parameters, samples, graphs, rows, critic_only };
        let threads = threads_for(rows, batch.parameters.len(), *threads);
        for_each(workers, threads, |index, worker| worker.learn(&batch, chunk(rows, length, index)));
        gradients.fill(0.0);
        let mut losses = Losses::default();
        for worker in workers {
            gradients.iter_mut().zip(&worker.gradients).for_each(|(sum, gradient)| *sum += gradient);
            losses.add(&worker.losses);
        }
        losses
    }
}

impl Update {
    /// Returns the numbers to report in a run's progress, by name.
    pub(super) fn named(&self) -> [(&'static str, f64); 10] {
        [
            ("policy_loss", self.policy_loss),
            ("value_loss", self.value_loss),
            ("entropy", self.entropy),
            ("approx_kl", self.approx_kl),
            ("clip_fraction", self.clip_fraction),
            ("explained_variance", self.explained_variance),
            ("gradient_norm", self.gradient_norm),
            ("learning_rate", self.learning_rate),
            ("epochs", self.epochs as f64),
            ("skipped", self.skipped as f64),
        ]
    }

    fn set_means(&mut self, sums: &Losses) {
        let share = 1.0 / self.steps.max(1) as f64;
        let means = sums.scaled(share);
        self.policy_loss = means.policy;
        self.value_loss = means.value;
        self.entropy = means.entropy;
        self.approx_kl = means.kl;
        self.clip_fraction = means.clipped;
        self.gradient_norm *= share;
    }
}

/// Returns the scenes of the final observations of episodes, and of the observations after the last steps.
fn scenes_after(rollout: &Rollout) -> [Vec<usize>; 2] {
    let last = rollout.steps.saturating_sub(1);
    [
        rollout.ends.iter().map(|end| rollout.scene_of(end.environment, end.step)).collect(),
        (0..rollout.environments).map(|environment| rollout.scene_of(environment, last)).collect(),
    ]
}

/// Returns the explained variance of returns by values, each summed over parts.
fn explained_variance(values: &[f32], returns: &[f32], parts: usize) -> f64 {
    let sums = |values: &[f32]| -> Vec<f64> {
        values.chunks_exact(parts).map(|row| row.iter().map(|value| f64::from(*value)).sum()).collect()
    };
    let (values, returns) = (sums(values), sums(returns));
    let errors: Vec<f64> = returns.iter().zip(&values).map(|(target, value)| target - value).collect();
    let total = variance(&returns);
    if total > 0.0 { 1.0 - variance(&errors) / total } else { 0.0 }
}

fn variance(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count
}
