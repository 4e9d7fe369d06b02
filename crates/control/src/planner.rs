//! A planner that tries actions on copies of the true simulation: what could be had, with perfect foresight of
//! weather, occupants and physics.
//!
//! It varies what the reactive controller does. Every so often it draws variations for the next few steps, tries each
//! on a copy of the simulation where it stands, with the reactive controller alone in the steps after, and narrows the
//! draw to the best: the cross-entropy method (Rubinstein 1999) within a rollout (Bertsekas 1999). The best variation
//! is carried out up to the next plan. None is among those tried, so that a plan is no worse than the reactive
//! controller as far as it looks.

use b2b_env::vector::{Live, Pool};
use b2b_env::{ActionSpace, Result};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{Controller, Reactive};

/// Parameters of a [`Planner`].
#[derive(Clone, Debug, PartialEq)]
pub struct PlannerParameters {
    /// Steps that a plan looks ahead.
    pub horizon: usize,
    /// Steps of it that are carried out.
    pub carried_out: usize,
    /// Stretches of its beginning that are varied, each by a number for each actuator.
    pub stretches: usize,
    /// Steps of a stretch.
    pub stretch: usize,
    /// Variations tried in a round.
    pub candidates: usize,
    /// Of those, the best that the next round is drawn from.
    pub elites: usize,
    /// Rounds.
    pub rounds: usize,
    /// First spread of the variations, as a share of an actuator's bounds.
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

/// Plans the actions of an episode on copies of it.
#[derive(Clone, Debug)]
pub struct Planner {
    parameters: PlannerParameters,
    reactive: Reactive,
    random: ChaCha8Rng,
}

/// A variation, as shares of the bounds, one row for each stretch; and the return it had.
#[derive(Clone, Debug)]
struct Tried {
    variation: Vec<f64>,
    total: f64,
}

impl Planner {
    /// A planner that starts from what a reactive controller does.
    pub fn new(parameters: PlannerParameters, reactive: Reactive, seed: u64) -> Self {
        Self { parameters, reactive, random: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// The actions of an episode that has just begun, one row a step, up to its end or so many steps. `step` is called
    /// for each.
    ///
    /// # Errors
    /// What [`Pool`] says when a copy cannot be had or an episode is lost.
    pub fn run(
        &mut self,
        pool: &mut Pool,
        live: &mut Live,
        steps: usize,
        mut step: impl FnMut(),
    ) -> Result<Vec<f64>> {
        let space = live.spaces().action.clone();
        let mut actions = Vec::new();
        let mut observation = vec![0.0; live.spaces().observation.len()];
        self.reactive.reset();
        for done in (0..steps).step_by(self.parameters.carried_out) {
            let left = steps - done;
            let variation = self.plan(pool, live, &space, self.parameters.horizon.min(left))?;
            for ahead in 0..self.parameters.carried_out.min(left) {
                pool.observation(live, &mut observation);
                let action = self.varied(&mut self.reactive.clone(), &observation, &variation, ahead, &space);
                self.reactive.act(&observation, &mut vec![0.0; space.len()]);
                act(pool, std::slice::from_mut(live), std::slice::from_ref(&action))?;
                actions.extend(action);
                step();
            }
        }
        Ok(actions)
    }

    /// The best variation found from where an episode stands.
    fn plan(
        &mut self,
        pool: &mut Pool,
        live: &Live,
        space: &ActionSpace,
        horizon: usize,
    ) -> Result<Vec<f64>> {
        let mut mean = vec![0.0; self.parameters.stretches * space.len()];
        let mut spread = vec![self.parameters.spread; mean.len()];
        let none = mean.clone();
        let mut best = Tried { variation: none.clone(), total: f64::NEG_INFINITY };
        for _ in 0..self.parameters.rounds {
            let mut variations = vec![none.clone()];
            variations.extend((0..self.parameters.candidates).map(|_| self.draw(&mean, &spread)));
            let mut tried = self.try_all(pool, live, space, variations, horizon)?;
            tried.sort_by(|a, b| b.total.total_cmp(&a.total));
            tried.truncate(self.parameters.elites);
            fit(&tried, &mut mean, &mut spread);
            if tried[0].total > best.total {
                best = tried.swap_remove(0);
            }
        }
        Ok(best.variation)
    }

    /// What a reactive controller does so many steps after the plan, varied and within bounds.
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
        pool: &mut Pool,
        live: &Live,
        space: &ActionSpace,
        variations: Vec<Vec<f64>>,
        horizon: usize,
    ) -> Result<Vec<Tried>> {
        let mut tried: Vec<Tried> =
            variations.into_iter().map(|variation| Tried { variation, total: 0.0 }).collect();
        let mut controllers = vec![self.reactive.clone(); tried.len()];
        let mut copies = pool.branch(live, tried.len())?;
        pool.wait(&mut copies, tried.len())?;
        let mut observation = vec![0.0; live.spaces().observation.len()];
        for ahead in 0..horizon {
            let mut actions = Vec::with_capacity(tried.len());
            for ((copy, controller), tried) in copies.iter().zip(&mut controllers).zip(&tried) {
                pool.observation(copy, &mut observation);
                actions.push(self.varied(controller, &observation, &tried.variation, ahead, space));
            }
            for (tried, reward) in tried.iter_mut().zip(act(pool, &mut copies, &actions)?) {
                tried.total += reward;
            }
        }
        copies.into_iter().for_each(|copy| pool.stop(copy));
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

/// One step of each, and its reward.
fn act(pool: &mut Pool, lives: &mut [Live], actions: &[Vec<f64>]) -> Result<Vec<f64>> {
    for (live, action) in lives.iter_mut().zip(actions) {
        pool.send(live, action)?;
    }
    pool.wait(lives, lives.len())?;
    match lives.iter().find_map(|live| live.lost()) {
        Some(why) => Err(b2b_env::Error::Gone { what: "a copy that was tried", why: why.to_owned() }),
        None => Ok(lives.iter().map(|live| pool.reward(live).total()).collect()),
    }
}
