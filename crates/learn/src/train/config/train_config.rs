//! The parts of a configuration, and checks across them.

use b2b_agent::{Acting, ObservationForm};
use b2b_env::Task;
use serde::Serialize;

use super::agent::AgentConfig;
use super::budget::Budget;
use super::checkpoints::CheckpointConfig;
use super::evaluation::EvaluationConfig;
use super::noise::NoiseConfig;
use super::rewards::RewardConfig;
use super::training_set::TrainingSet;
use crate::error::{Error, Result};
use crate::learner::Abilities;
use crate::learners::{LearnerChoice, LearnerKind, kinds};
use crate::limits::require;
use crate::ppo::PpoConfig;
use crate::train::problem::training_side;

/// The configuration of a training run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TrainConfig {
    /// Buildings, tasks and period.
    #[serde(flatten)]
    pub training_set: TrainingSet,
    /// Network, observation and actions.
    #[serde(flatten)]
    pub agent: AgentConfig,
    /// Steps, environments and random seed.
    #[serde(flatten)]
    pub budget: Budget,
    /// Training rewards.
    #[serde(flatten)]
    pub rewards: RewardConfig,
    /// Exploration noise.
    #[serde(flatten)]
    pub noise: NoiseConfig,
    /// Checkpoints, and the agent that is kept.
    #[serde(flatten)]
    pub checkpoints: CheckpointConfig,
    /// Evaluations during training.
    pub evaluation: EvaluationConfig,
    /// The learner. In a file, `algorithm` is its name, and the table of this name has its options.
    #[serde(skip)]
    pub learner: LearnerChoice,
}

impl TrainConfig {
    /// Returns the configuration with the learner of this name, and with options of rewards and noise that it does not
    /// support turned off. A different learner than before has its default options.
    ///
    /// # Errors
    /// [`Error::Invalid`](crate::Error::Invalid) for an unknown name.
    pub fn with_algorithm(mut self, name: &str) -> Result<Self> {
        let kind = LearnerKind::find(name)?;
        if self.learner.name() != kind.name {
            self.learner = kind.into();
        }
        let Abilities { credit, mirrored_noise, new_weights, noise, .. } = self.learner.abilities();
        self.rewards.credit_by_zone &= credit;
        self.noise.mirrored_noise &= mirrored_noise;
        if !new_weights {
            let RewardConfig { comfort_rate, comfort_weight, travel_cost_growth, .. } =
                RewardConfig::default();
            self.rewards = RewardConfig { comfort_rate, comfort_weight, travel_cost_growth, ..self.rewards };
        }
        if noise.is_err() {
            (self.noise.noise_cost, self.noise.final_noise) = (0.0, 1.0);
        }
        Ok(self)
    }

    /// Returns the configuration for the training side of a benchmark problem, by name or JSON file: its buildings,
    /// tasks, run period, steps per hour, training budget, attributes and, for houses, roles instead of raw slots.
    ///
    /// # Errors
    /// [`Error::Evaluation`](crate::Error::Evaluation) for an unknown problem;
    /// [`Error::Invalid`](crate::Error::Invalid) for a problem that no agent can be trained for, because its buildings
    /// differ in what they observe or control.
    pub fn with_problem(mut self, name: &str) -> Result<Self> {
        training_side(name)?.apply(&mut self.training_set, &mut self.agent, &mut self.budget)?;
        self.training_set.problem = name.to_owned();
        Ok(self)
    }

    /// Checks every part, and that the parts go together.
    ///
    /// # Errors
    /// [`Error::Invalid`](crate::Error::Invalid) or [`Error::Config`](crate::Error::Config) for the first value that is
    /// not allowed.
    pub fn check(&self) -> Result<()> {
        let Self { training_set, agent, budget, rewards, noise, evaluation, learner, .. } = self;
        learner.check()?;
        budget.check()?;
        training_set.check()?;
        if !training_set.problem.is_empty() {
            training_side(&training_set.problem)?.check(training_set, agent, budget)?;
        }
        rewards.check()?;
        noise.check()?;
        evaluation.check()?;
        agent.check()?;
        self.check_abilities()?;
        self.check_supervision()?;
        self.check_variety()
    }

    /// Checks that the learner supports the options of the other parts.
    fn check_abilities(&self) -> Result<()> {
        let name = self.learner.name();
        let Abilities { graphs, recurrent, credit, mirrored_noise, new_weights, noise } =
            self.learner.abilities();
        require(graphs || !self.agent.policy.is_graph(), || {
            let able = able(|abilities| abilities.graphs);
            format!("`algorithm` with graph networks: it must be {able}")
        })?;
        require(recurrent || self.agent.policy.recurrent().is_none(), || {
            let able = able(|abilities| abilities.recurrent);
            format!("`algorithm` with recurrent networks: it must be {able}")
        })?;
        if let Some(policy) = self.agent.policy.recurrent() {
            policy.check_steps(&format!("{name}.n_steps"), self.learner.steps_per_rollout())?;
        }
        require(credit || !self.rewards.credit_by_zone, || {
            let able = able(|abilities| abilities.credit);
            format!("`credit_by_zone` is for {able}; with {name} it must be false")
        })?;
        require(mirrored_noise || !self.noise.mirrored_noise, || {
            let able = able(|abilities| abilities.mirrored_noise);
            format!("`mirrored_noise` is for {able}; with {name} it must be false")
        })?;
        let RewardConfig { comfort_rate, travel_cost_growth, .. } = self.rewards;
        for (option, value, fixed) in
            [("comfort_rate", comfort_rate, 0.0), ("travel_cost_growth", travel_cost_growth.into(), 1.0)]
        {
            require(new_weights || value == fixed, || {
                let able = able(|abilities| abilities.new_weights);
                format!(
                    "`{option}` is for {able}: {name} learns from rewards of earlier weights; expected {fixed}"
                )
            })?;
        }
        if let Some(ppo) = self.learner.options::<PpoConfig>() {
            self.check_ppo(ppo)?;
        }
        let Err(why) = noise else { return Ok(()) };
        let NoiseConfig { noise_cost, final_noise, .. } = self.noise;
        require(noise_cost == 0.0, || format!("`noise_cost` is {noise_cost}; {why}; expected 0"))?;
        require(final_noise == 1.0, || format!("`final_noise` is {final_noise}; {why}; expected 1"))
    }

    /// Checks the options of PPO that depend on other parts.
    fn check_ppo(&self, ppo: &PpoConfig) -> Result<()> {
        require(!ppo.balance_buildings || self.agent.policy.is_graph(), || {
            "`ppo.balance_buildings` is for graph networks, which know the building of each step; expected false"
                .into()
        })?;
        require(ppo.credit.is_none(), || "`ppo.credit` follows from `credit_by_zone`; remove it".into())?;
        let rows = self.budget.environments * ppo.n_steps;
        let minibatches = ppo.epochs * rows.div_ceil(ppo.batch_size);
        require(minibatches > 1 || ppo.desired_kl.is_none() && ppo.target_kl.is_none(), || {
            "`ppo.desired_kl` and `ppo.target_kl` need two minibatches in an update, before the first of which the \
             divergence is 0; raise `ppo.epochs`, lower `ppo.batch_size`, or remove them"
                .into()
        })?;
        let NoiseConfig { noise_cost, final_noise, .. } = self.noise;
        let last = f64::from(ppo.initial_log_std) + final_noise.ln();
        let least = ppo.minimum_log_std;
        require(noise_cost > 0.0 || final_noise == 1.0 || last >= f64::from(least), || {
            format!(
                "`final_noise` is {final_noise}, whose logarithm of the standard deviation, {last:.2}, is below \
                 `ppo.minimum_log_std`, {least}; change one of them"
            )
        })
    }

    /// Checks how the agent acts, that a supervisor has operation tasks and a flat one a reward in one part, and
    /// that `comfort_rate` has such tasks and evaluations.
    fn check_supervision(&self) -> Result<()> {
        let Self { training_set, agent, rewards, evaluation, .. } = self;
        let operates = training_set.task.as_slice().iter().all(Task::is_operation);
        require(operates || rewards.comfort_rate == 0.0, || {
            "`comfort_rate` is for tasks of operation; choose `task` = operate, or 0".into()
        })?;
        require(evaluation.every > 0 || rewards.comfort_rate == 0.0, || {
            "`comfort_rate` requires evaluations, and `evaluation.every` is 0; change one of them".into()
        })?;
        agent.acting.check(training_set.steps_per_hour).map_err(Error::Invalid)?;
        match agent.acting {
            Acting::Direct | Acting::Residual { .. } => Ok(()),
            Acting::Targets { .. } => require(!agent.policy.is_graph(), || {
                "`acting` shifts targets, which graph networks cannot; choose residual, or `policy` = flat"
                    .into()
            }),
            Acting::Supervisory { .. } => {
                require(operates, || {
                    "`acting` supervises guideline36, the controller of operation; choose `task` = operate"
                        .into()
                })?;
                require(!rewards.credit_by_zone || agent.policy.is_graph(), || {
                    "`credit_by_zone` is not for flat agents that shift all zones; choose false".into()
                })
            }
        }
    }

    /// Checks that the agent and the number of environments suit the building types and tasks.
    fn check_variety(&self) -> Result<()> {
        let (types, turns) = (self.training_set.building_type.len(), self.training_set.turns()?.len());
        let is_one_task = self.training_set.task.as_slice().len() == 1;
        require(is_one_task || self.agent.observation.form == ObservationForm::Features, || {
            "tasks with different observations require the observation `features`".into()
        })?;
        let named = self.training_set.named_types()?;
        require(types.max(named) <= 1 || self.agent.policy.is_graph(), || {
            "several building types are for graph networks; choose the preset graph, or one type".into()
        })?;
        let environments = self.budget.environments;
        require(turns <= self.distinct_environments(), || {
            format!(
                "`environments` is {environments}; expected at least {} for {}{}",
                turns * environments.div_ceil(self.distinct_environments()),
                if turns == types {
                    format!("{types} building types")
                } else {
                    format!("{turns} turns of {types} building types")
                },
                if self.noise.mirrored_noise { " with mirrored noise" } else { "" }
            )
        })
    }

    /// Returns the steps for which the agent holds a decision.
    pub(crate) fn hold(&self) -> usize {
        self.agent.acting.hold(self.training_set.steps_per_hour)
    }

    /// Returns the number of environments with different episodes: with mirrored noise, pairs share theirs.
    pub(crate) fn distinct_environments(&self) -> usize {
        let environments = self.budget.environments;
        if self.noise.mirrored_noise { environments.div_ceil(2) } else { environments }
    }
}

/// Returns the names of the learners whose default options have an ability.
fn able(has: impl Fn(&Abilities) -> bool) -> String {
    let is_able = |kind: &LearnerKind| has(&LearnerChoice::from(*kind).abilities());
    let names: Vec<_> = kinds().into_iter().filter(is_able).map(|kind| kind.name).collect();
    names.join(" or ")
}
