//! A planner that tries actions on copies of the true simulation, with perfect foresight of weather, occupants and
//! physics.
//!
//! It varies the actions of the reactive controller. At regular intervals it draws variations for the next few steps,
//! tries each on a copy of the simulation at its current point, followed by the unvaried reactive controller, and
//! narrows the draw to the best: the cross-entropy method (Rubinstein 1999) within a rollout (Bertsekas 1999). The best
//! variation is carried out up to the next plan. The zero variation is always tried, so a plan is no worse than the
//! reactive controller within its horizon.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use b2b_building::{Parameter, PreparedBuilding};
use b2b_env::{ActionSpace, Environment, Result, Task};
use b2b_workers::{Episode, step_all};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::kind::{self, AnyController, Case};
use crate::{Controller, Error, Reactive, Replay, reactive};

/// Parameters of a [`Planner`].
#[derive(Clone, Debug, PartialEq)]
pub struct PlannerParameters {
    /// Steps that a plan looks ahead.
    pub horizon: usize,
    /// Steps of a plan that are executed before the next plan.
    pub carried_out: usize,
    /// Number of stretches varied at the beginning of a plan, each by one value per actuator.
    pub stretches: usize,
    /// Steps of a stretch.
    pub stretch: usize,
    /// Variations tried per round.
    pub candidates: usize,
    /// Number of best variations from which the next round is drawn.
    pub elites: usize,
    /// Rounds per plan.
    pub rounds: usize,
    /// Initial standard deviation of the variations, as a share of an actuator's range.
    pub spread: f64,
}

impl Default for PlannerParameters {
    fn default() -> Self {
        Self {
            horizon: 24,
            carried_out: 4,
            stretches: 2,
            stretch: 3,
            candidates: 20,
            elites: 5,
            rounds: 2,
            spread: 0.04,
        }
    }
}

/// Plans the actions of an episode on copies of the simulation.
#[derive(Clone, Debug)]
pub struct Planner {
    parameters: PlannerParameters,
    reactive: Reactive,
    random: ChaCha8Rng,
}

/// A variation, as shares of the ranges, one row per stretch, and its return.
#[derive(Clone, Debug)]
struct Tried {
    variation: Vec<f64>,
    total: f64,
}

impl Planner {
    /// Creates a planner that varies the actions of a reactive controller.
    pub fn new(parameters: PlannerParameters, reactive: Reactive, seed: u64) -> Self {
        Self { parameters, reactive, random: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// Resets an episode and plans it step by step. Returns the actions, one row per step, up to `steps` steps. `step`
    /// is called after each step.
    ///
    /// # Errors
    /// The errors of [`Episode`] when a copy cannot be made or an episode is lost.
    pub fn plan_episode(
        &mut self,
        episode: &mut Episode,
        steps: usize,
        mut step: impl FnMut(),
    ) -> Result<Vec<f64>> {
        let spaces = Arc::clone(episode.spaces());
        let space = &spaces.action;
        let mut actions = Vec::new();
        self.reactive.reset();
        episode.reset()?;
        for done in (0..steps).step_by(self.parameters.carried_out) {
            let left = steps - done;
            let variation = self.plan(episode, space, self.parameters.horizon.min(left))?;
            for ahead in 0..self.parameters.carried_out.min(left) {
                let observation = episode.observation();
                let action = self.varied(&mut self.reactive.clone(), observation, &variation, ahead, space);
                self.reactive.act(observation, &mut vec![0.0; space.len()]);
                episode.step(&action)?;
                actions.extend(action);
                step();
            }
        }
        Ok(actions)
    }

    /// The best variation found from the current point of an episode.
    fn plan(&mut self, episode: &Episode, space: &ActionSpace, horizon: usize) -> Result<Vec<f64>> {
        let mut mean = vec![0.0; self.parameters.stretches * space.len()];
        let mut spread = vec![self.parameters.spread; mean.len()];
        let none = mean.clone();
        let mut best = Tried { variation: none.clone(), total: f64::NEG_INFINITY };
        for _ in 0..self.parameters.rounds {
            let mut variations = vec![none.clone()];
            variations.extend((0..self.parameters.candidates).map(|_| self.draw(&mean, &spread)));
            let mut tried = self.try_all(episode, space, variations, horizon)?;
            tried.sort_by(|a, b| b.total.total_cmp(&a.total));
            tried.truncate(self.parameters.elites);
            fit(&tried, &mut mean, &mut spread);
            if tried[0].total > best.total {
                best = tried.swap_remove(0);
            }
        }
        Ok(best.variation)
    }

    /// The action of a reactive controller `ahead` steps after the plan, varied and within bounds.
    fn varied(
        &self,
        reactive: &mut Reactive,
        observation: &[f64],
        variation: &[f64],
        ahead: usize,
        space: &ActionSpace,
    ) -> Vec<f64> {
        let mut action = vec![0.0; space.len()];
        reactive.act(observation, &mut action);
        let row = variation.chunks_exact(space.len()).nth(ahead / self.parameters.stretch);
        for (index, share) in row.into_iter().flatten().enumerate() {
            let (low, high) = (space.low()[index], space.high()[index]);
            action[index] = (action[index] + share * (high - low)).clamp(low, high);
        }
        action
    }

    /// Normal numbers around a mean, by the polar method (Marsaglia 1964).
    fn draw(&mut self, mean: &[f64], spread: &[f64]) -> Vec<f64> {
        let mut normal = || loop {
            let [u, v] = [0; 2].map(|_| self.random.random_range(-1.0..1.0f64));
            let s = u * u + v * v;
            if s > 0.0 && s < 1.0 {
                return u * (-2.0 * s.ln() / s).sqrt();
            }
        };
        mean.iter().zip(spread).map(|(mean, spread)| mean + spread * normal()).collect()
    }

    /// The returns of variations, each on a copy.
    fn try_all(
        &self,
        episode: &Episode,
        space: &ActionSpace,
        variations: Vec<Vec<f64>>,
        horizon: usize,
    ) -> Result<Vec<Tried>> {
        let mut tried: Vec<Tried> =
            variations.into_iter().map(|variation| Tried { variation, total: 0.0 }).collect();
        let mut controllers = vec![self.reactive.clone(); tried.len()];
        let mut copies = episode.branch(tried.len())?;
        let mut actions = Vec::with_capacity(tried.len() * space.len());
        for ahead in 0..horizon {
            actions.clear();
            for ((copy, controller), tried) in copies.iter().zip(&mut controllers).zip(&tried) {
                let observation = copy.observation();
                actions.extend(self.varied(controller, observation, &tried.variation, ahead, space));
            }
            step_all(&mut copies, &actions)?;
            for (tried, copy) in tried.iter_mut().zip(&copies) {
                tried.total += copy.reward().total();
            }
        }
        Ok(tried)
    }
}

/// Mean and spread of the best.
fn fit(elites: &[Tried], mean: &mut [f64], spread: &mut [f64]) {
    let count = elites.len() as f64;
    for (index, (mean, spread)) in mean.iter_mut().zip(spread).enumerate() {
        let values = || elites.iter().map(|tried| tried.variation[index]);
        *mean = values().sum::<f64>() / count;
        *spread = (values().map(|value| (value - *mean).powi(2)).sum::<f64>() / count).sqrt();
    }
}

/// The kind `planner`, with the parameters of the reactive controllers that it varies.
pub(crate) struct Kind;

impl kind::Kind for Kind {
    fn name(&self) -> &'static str {
        "planner"
    }

    fn help(&self) -> &'static str {
        "cross-entropy planning on copies of the simulation with perfect foresight; minutes per simulated day"
    }

    fn is_stochastic(&self) -> bool {
        true
    }

    fn controls_whole_building(&self) -> bool {
        true
    }

    fn plans(&self) -> bool {
        true
    }

    fn parameters(&self) -> Vec<Parameter> {
        reactive::Kind.parameters()
    }

    fn defaults(&self) -> Value {
        reactive::Kind.defaults()
    }

    fn tuned(&self, building: &PreparedBuilding, task: &Task) -> Value {
        reactive::Kind.tuned(building, task)
    }

    fn changed(&self, values: Value, changes: &BTreeMap<String, f64>) -> crate::Result<Value> {
        reactive::Kind.changed(values, changes)
    }

    fn read(&self, path: &Path) -> crate::Result<Value> {
        reactive::Kind.read(path)
    }

    fn make(&self, _: &Case<'_>) -> crate::Result<Box<dyn AnyController>> {
        Err(Error::NeedsEpisode { name: self.name() })
    }

    fn plan(
        &self,
        case: &Case<'_>,
        episode: &mut Episode,
        step: &mut dyn FnMut(),
    ) -> crate::Result<Option<Box<dyn AnyController>>> {
        let spaces = case.spaces;
        let mut planner = Planner::new(PlannerParameters::default(), Reactive::of_case(case)?, case.seed);
        let actions = planner.plan_episode(episode, spaces.episode_steps(), step)?;
        Ok(Some(Box::new(Replay::new(actions, spaces.action.len()))))
    }
}
