//! The worker's side: an actor in its episode.

use std::time::{Duration, Instant};

use b2b_agent::network::{Actor, Distribution, Scratch};
use b2b_agent::{ControllerDescription, Pilot};
use b2b_env::{Env, Reward};
use b2b_workers::{ControllerRunner, ROLLOUT, RolloutOrder, Runner, RunnerError, Runners, SharedMemory};

use super::order::{FragmentOrder, Purpose};
use crate::credit::part_places;
use crate::random::{Noise, RandomStream};
use crate::travel::TravelCost;
use crate::widths::mismatch;

/// The runners of a worker: see [`b2b_workers::run_if_worker_with`].
pub const RUNNERS: Runners = Runners(&[(ROLLOUT, make_rollout_runner), (LEARNER, make_runner)]);

/// The kind of the runner that collects steps for a learner.
pub(super) const LEARNER: &str = "learner";

/// Makes the runner of a rollout from the description of its controller.
fn make_rollout_runner(env: &Env, order: &[u8]) -> Result<Box<dyn Runner>, RunnerError> {
    let RolloutOrder::<ControllerDescription> { controller, .. } = serde_json::from_slice(order)?;
    Ok(Box::new(ControllerRunner::new(controller.controller(env.spaces())?, env)))
}

/// Makes the runner of an actor in its episode.
fn make_runner(env: &Env, order: &[u8]) -> Result<Box<dyn Runner>, RunnerError> {
    let order: FragmentOrder = serde_json::from_slice(order)?;
    let FragmentOrder { interface, plan, attributes, shape, distribution, block, .. } = order;
    let mut pilot = Pilot::without_model(interface, env.spaces(), plan.as_ref(), &attributes)?;
    pilot.observe(env.observation());
    let actor = Actor { parameters: vec![0.0; shape.parameters()], shape, distribution };
    let scratch = actor.scratch(pilot.graph());
    let parts = block.parts();
    let places = part_places(env.spaces(), plan.as_ref(), parts);
    if (scratch.observations(), scratch.actions()) != pilot.widths() {
        return Err(mismatch(&env.building().name).into());
    }
    Ok(Box::new(FragmentRunner {
        action: vec![0.0; scratch.actions()],
        scratch,
        rewards: vec![0.0; parts],
        step_rewards: vec![0.0; parts],
        travel: TravelCost::new(env.spaces(), &places, parts),
        places,
        actor,
        pilot,
        version: None,
    }))
}

struct FragmentRunner {
    pilot: Pilot,
    actor: Actor,
    /// Version of the actor's parameters.
    version: Option<u64>,
    scratch: Scratch,
    action: Vec<f32>,
    /// Parts of the reward of a decision, and of a step.
    rewards: Vec<f32>,
    step_rewards: Vec<f32>,
    /// Indices of the controlled zones and of energy among the parts.
    places: Vec<usize>,
    travel: TravelCost,
}

impl Runner for FragmentRunner {
    fn run(&mut self, env: &mut Env, order: &[u8], memory: &SharedMemory) -> Result<usize, RunnerError> {
        let order: FragmentOrder = serde_json::from_slice(order)?;
        self.read_parameters(&order, memory);
        memory.read(order.block.state(), self.scratch.state_mut());
        let (seed, stream) = order.random;
        let mut noise = Noise::new(self.action.len(), order.correlation, RandomStream::new(seed, stream));
        if order.mirrored {
            noise = noise.mirrored();
        }
        let (began, mut acting) = (Instant::now(), Duration::ZERO);
        let (mut done, mut steps) = (0, 0);
        while done < order.steps && !env.is_truncated() {
            let before = Instant::now();
            self.choose(&order, order.done + done, &mut noise, memory);
            acting += before.elapsed();
            steps += self.carry_out(&order, env)?;
            if order.purpose == Purpose::Explore {
                memory.write(order.block.reward(order.done + done), &self.rewards);
            }
            done += 1;
        }
        if order.purpose == Purpose::Explore {
            memory.write(order.block.next(), self.pilot.observed());
            memory.write(order.block.state(), self.scratch.state());
            let times = [acting, began.elapsed()].map(|time| time.as_secs_f32());
            memory.write(order.block.times(), &times);
        }
        Ok(steps)
    }
}

impl FragmentRunner {
    fn read_parameters(&mut self, order: &FragmentOrder, memory: &SharedMemory) {
        if self.version.replace(order.version) == Some(order.version) {
            return;
        }
        let count = self.actor.parameters.len();
        memory.read(order.parameters, &mut self.actor.parameters);
        if let Distribution::Gaussian { log_std } = &mut self.actor.distribution {
            memory.read(order.parameters + count, log_std);
        }
    }

    /// Chooses the action of a step and records it with the observation.
    fn choose(&mut self, order: &FragmentOrder, step: usize, noise: &mut Noise, memory: &SharedMemory) {
        let (observation, block) = (self.pilot.observed(), &order.block);
        match order.purpose {
            Purpose::Replay => memory.read(block.action(step), &mut self.action),
            Purpose::Explore => {
                self.actor.sample(observation, noise.draw(), &mut self.scratch, &mut self.action);
                memory.write(block.observation(step), observation);
                memory.write(block.action(step), &self.action);
            }
        }
    }

    /// Makes the steps for which the decision is held, and adds up their discounted rewards. Returns their number.
    fn carry_out(&mut self, order: &FragmentOrder, env: &mut Env) -> Result<usize, RunnerError> {
        self.rewards.fill(0.0);
        let (mut steps, mut discount) = (0, 1.0);
        loop {
            let action = self.pilot.act(&self.action);
            self.travel.before_step(env.metrics());
            let reward = env.step(action)?.reward;
            self.pilot.reward(reward.total());
            if order.purpose == Purpose::Explore {
                self.add_reward(order, reward, discount, env);
            }
            self.pilot.observe(env.observation());
            (steps, discount) = (steps + 1, discount * order.discount);
            if self.pilot.is_due() || env.is_truncated() {
                return Ok(steps);
            }
        }
    }

    /// Adds the reward of a step: as a whole, or with a part for each controlled zone and one for energy, minus the
    /// cost of travel.
    fn add_reward(&mut self, order: &FragmentOrder, reward: Reward, discount: f32, env: &Env) {
        let weight = f64::from(order.comfort_weight);
        match &mut self.step_rewards[..] {
            [whole] if order.comfort_weight == 1.0 => *whole = reward.total() as f32,
            [whole] => *whole = -(weight * reward.temperature_penalty + reward.energy_penalty) as f32,
            parts => {
                let (energy, zones) = self.places.split_last().expect("energy has a part");
                let count = zones.len() as f64;
                parts.fill(0.0);
                for (place, penalty) in zones.iter().zip(env.comfort_penalties()) {
                    parts[*place] = (-weight * penalty / count) as f32;
                }
                parts[*energy] = -reward.energy_penalty as f32;
            }
        }
        if order.travel_cost > 0.0 {
            self.travel.subtract(env.metrics(), order.travel_cost, &mut self.step_rewards);
        }
        let steps = self.step_rewards.iter();
        self.rewards.iter_mut().zip(steps).for_each(|(sum, step)| *sum += discount * step);
    }
}
