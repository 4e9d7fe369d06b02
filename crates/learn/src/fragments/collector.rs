//! The owner's side: rollouts of environments in worker processes.

use std::collections::BTreeSet;
use std::sync::Arc;

use b2b_agent::network::Actor;
use b2b_agent::{Interface, Pilot, attributes};
use b2b_building::morphology::NodeType;
use b2b_env::Spaces;
use b2b_workers::{SharedMemory, VecEnv};

use super::blocks::Block;
use super::building::GraphBuilding;
use super::order::{FragmentOrder, Purpose, stream};
use super::progress::{EnvironmentProgress, FragmentPhase};
use super::runner::LEARNER;
use crate::collector::{Collector, count_lost};
use crate::comfort_weights::ComfortWeights;
use crate::error::Result;
use crate::rollout::{End, Rollout, Widths};

/// The scale of a building's rewards.
pub type RewardScale = Box<dyn Fn(&Spaces) -> Result<f64> + Send>;

/// Collects rollouts in the worker processes of a [`VecEnv`] with
/// [`Autoreset::Disabled`](b2b_workers::Autoreset::Disabled).
///
/// The same seed and actors give the same bits, however fast each environment is.
pub struct FragmentCollector {
    pub(super) environments: VecEnv,
    pub(super) interface: Interface,
    /// Whether a reward has parts by zone.
    pub(super) by_zone: bool,
    pub(super) widths: Widths,
    pub(super) scale: RewardScale,
    pub(super) seed: u64,
    correlation: f32,
    /// Whether the second environment of every pair gets the first one's noise, negated.
    mirrored: bool,
    travel_cost: f32,
    /// Steps for which a decision is held, and the discount of their rewards.
    hold: usize,
    discount: f32,
    /// Episodes in a building that the memory of an actor spans, and the width of its state in the largest building.
    pub(super) memory_episodes: u64,
    pub(super) state: usize,
    /// Factors of the penalty of discomfort.
    pub comfort_weights: ComfortWeights,
    pub(super) memory: SharedMemory,
    /// Place of the parameters, and their maximum number.
    parameters: (usize, usize),
    /// Place of the blocks, and the maximum number of steps in each.
    blocks: (usize, usize),
    /// Rollouts collected so far.
    pub(super) rollouts: u64,
    pub(super) progress: Vec<EnvironmentProgress>,
    /// Episodes that ended.
    pub(super) ended: u64,
    pub(super) lost: u64,
}

impl FragmentCollector {
    /// Begins the first episodes. With `by_zone`, a reward has a part for each controlled zone and one for energy: flat
    /// networks need the same zones in all buildings, and graph networks give each part to its node. `correlation` is
    /// the correlation of exploration noise between consecutive steps; `travel_cost` is the cost of a full stroke,
    /// averaged over the actuators, in the unit of the scaled rewards.
    ///
    /// # Errors
    /// [`Error::Env`](crate::Error::Env) when an environment cannot begin.
    pub fn new(
        mut environments: VecEnv,
        interface: Interface,
        by_zone: bool,
        correlation: f32,
        travel_cost: f32,
        scale: RewardScale,
        seed: u64,
    ) -> Result<Self> {
        environments.reset(seed)?;
        let mut progress = Vec::with_capacity(environments.len());
        let mut widths = Widths { observation: 0, action: 0, parts: 1, nodes: 1 };
        let mut hold = 1;
        for index in 0..environments.len() {
            let spaces = spaces_of(&environments, index)?;
            hold = interface.acting.hold(spaces.episode.steps_per_hour);
            let building = GraphBuilding::of(interface, by_zone, spaces)?;
            let parts = 1 + if by_zone { spaces.controlled_zones().count() } else { 0 };
            widths = widths.covering(match &building {
                Some(building) => building.widths(),
                None => Widths::of(&Pilot::new(interface, spaces)?, parts),
            });
            let attributes = attributes(interface.observation, spaces)?;
            progress.push(EnvironmentProgress::new(scale(spaces)? as f32, building, attributes));
        }
        Ok(Self {
            memory: environments.workers().memory(),
            environments,
            interface,
            by_zone,
            widths,
            scale,
            seed,
            correlation,
            mirrored: false,
            travel_cost,
            hold,
            discount: 1.0,
            memory_episodes: 1,
            state: 0,
            comfort_weights: ComfortWeights::default(),
            parameters: (0, 0),
            blocks: (0, 0),
            rollouts: 0,
            progress,
            ended: 0,
            lost: 0,
        })
    }

    /// Gives the environments 0 and 1, 2 and 3, and so on, opposite exploration noise. Both of a pair must have the
    /// same episodes. Called before the first rollout.
    #[must_use]
    pub fn with_mirrored_noise(mut self) -> Self {
        self.mirrored = true;
        self
    }

    /// Discounts the rewards of the steps of a held decision, by default not at all.
    #[must_use]
    pub fn with_discount(mut self, discount: f32) -> Self {
        self.discount = discount;
        self
    }

    /// Lets a recurrent actor remember this many consecutive episodes of an environment, by default one. They must be
    /// in the same building. Called before the first rollout.
    #[must_use]
    pub fn with_memory_episodes(mut self, episodes: u32) -> Self {
        self.memory_episodes = u64::from(episodes.max(1));
        self
    }

    /// Returns the cost of a full stroke of all actuators, in units of the scaled reward.
    pub fn travel_cost(&self) -> f32 {
        self.travel_cost
    }

    /// Sets the cost of a full stroke of all actuators of the next rollouts.
    pub fn set_travel_cost(&mut self, travel_cost: f32) {
        self.travel_cost = travel_cost;
    }

    /// Makes room for buildings of these widths, because a graph network's later episodes may be in larger buildings
    /// than the first. Called before the first rollout.
    pub fn make_room(&mut self, widths: Widths) {
        self.widths = self.widths.covering(widths);
    }

    pub(super) fn begin_rollout(&mut self) {
        self.progress
            .iter_mut()
            .enumerate()
            .for_each(|(environment, progress)| progress.begin_rollout(environment));
    }

    /// Returns the names of the node types of the buildings of the episodes in progress, for graph networks.
    pub fn node_types(&self) -> Vec<String> {
        let graphs = self.progress.iter().filter_map(|progress| progress.building.as_ref());
        let types: BTreeSet<usize> = graphs.flat_map(|building| building.graph.types.clone()).collect();
        types.into_iter().map(|index| NodeType::ALL[index].name().to_owned()).collect()
    }

    /// Returns how many episodes ended.
    pub fn ended(&self) -> u64 {
        self.ended
    }

    /// Returns how many episodes were lost.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Returns the environments.
    pub fn environments(&self) -> &VecEnv {
        &self.environments
    }

    /// Returns the times that the workers spent on actions and on all steps of the last rollout, s, summed over
    /// workers.
    pub fn worker_times(&self) -> [f64; 2] {
        [0, 1].map(|index| self.progress.iter().map(|progress| f64::from(progress.times[index])).sum())
    }

    /// Makes room for an actor and for blocks of a number of steps, and writes the actor.
    pub(super) fn share(&mut self, actor: &Actor, steps: usize) -> Result<()> {
        let numbers = FragmentOrder::numbers(actor);
        if self.parameters.1 < numbers.len() {
            self.parameters = (self.environments.workers().reserve_memory(numbers.len())?, numbers.len());
        }
        let state = self.state_of(actor);
        if self.blocks.1 < steps || self.state < state {
            (self.blocks, self.state) = ((0, self.blocks.1.max(steps)), state);
            let count = self.environments.len() * self.block(0).numbers();
            self.blocks.0 = self.environments.workers().reserve_memory(count)?;
        }
        self.progress.iter_mut().for_each(|progress| progress.state.resize(state, 0.0));
        self.memory.write(self.parameters.0, &numbers);
        Ok(())
    }

    /// Returns the width of an actor's state in the largest building.
    pub(super) fn state_of(&self, actor: &Actor) -> usize {
        actor.shape.state() * self.widths.nodes
    }

    pub(super) fn block(&self, environment: usize) -> Block {
        let (place, steps) = self.blocks;
        let block = |place| Block::new(place, steps, self.widths, self.state);
        block(place + environment * block(0).numbers())
    }

    /// Runs fragments until every environment has made its steps. One that loses its episode in a replay makes no more.
    pub(super) fn run(&mut self, actor: &Actor, purpose: Purpose, steps: &mut [usize]) -> Result<()> {
        for (environment, steps) in steps.iter().enumerate() {
            self.send(environment, actor, purpose, *steps)?;
        }
        let mut ready = Vec::with_capacity(self.progress.len());
        while self.progress.iter().zip(&*steps).any(|(progress, steps)| progress.done < *steps) {
            self.environments.recv(1, &mut ready)?;
            for environment in ready.drain(..) {
                let lost = self.lost;
                self.settle(environment, purpose)?;
                if purpose == Purpose::Replay && self.lost > lost {
                    steps[environment] = 0;
                }
                self.send(environment, actor, purpose, steps[environment])?;
            }
        }
        Ok(())
    }

    /// Requests the remaining steps of an environment, if it is ready.
    fn send(&mut self, environment: usize, actor: &Actor, purpose: Purpose, steps: usize) -> Result<()> {
        let block = self.block(environment);
        // The environment whose noise this one shares.
        let source = if self.mirrored { environment / 2 * 2 } else { environment };
        let spaces = spaces_of(&self.environments, environment)?;
        let progress = &mut self.progress[environment];
        if progress.phase != FragmentPhase::Ready || progress.done >= steps {
            return Ok(());
        }
        if purpose == Purpose::Explore && self.state > 0 {
            progress.begin_memory(self.memory_episodes);
        }
        self.memory.write(block.state(), &progress.state);
        let comfort_weight = progress.comfort_weight(&self.comfort_weights, spaces)?;
        let order = FragmentOrder {
            interface: self.interface,
            plan: progress.building.as_ref().map(|building| building.plan.clone()),
            attributes: progress.attributes.clone(),
            shape: actor.shape.clone(),
            distribution: actor.distribution.clone(),
            parameters: self.parameters.0,
            version: self.rollouts,
            purpose,
            steps: steps - progress.done,
            block,
            done: progress.done,
            random: (self.seed, stream(self.rollouts, source, progress.fragments)),
            correlation: self.correlation,
            mirrored: source != environment,
            discount: self.discount,
            comfort_weight,
            // Rewards are scaled afterwards.
            travel_cost: self.travel_cost / progress.scale,
        };
        self.environments.send_fragment(environment, LEARNER, &order, order.steps * self.hold)?;
        progress.phase = FragmentPhase::Running;
        progress.fragments += 1;
        Ok(())
    }

    /// Handles the outcome of an environment that is no longer busy.
    fn settle(&mut self, environment: usize, purpose: Purpose) -> Result<()> {
        if let Some(why) = self.environments.lost(environment).map(str::to_owned) {
            return self.lose(environment, why);
        }
        if self.progress[environment].phase == FragmentPhase::Starting {
            return self.begin_episode(environment);
        }
        self.take_steps(environment, purpose);
        if self.environments.truncated()[environment] {
            self.end_episode(environment)?;
        } else {
            self.progress[environment].phase = FragmentPhase::Ready;
        }
        Ok(())
    }

    /// Counts the decisions of a fragment, and keeps their actions.
    fn take_steps(&mut self, environment: usize, purpose: Purpose) {
        let block = self.block(environment);
        let steps = self.environments.fragment_steps(environment).div_ceil(self.hold);
        let progress = &mut self.progress[environment];
        progress.lost_in_a_row = 0;
        if purpose == Purpose::Explore {
            let mut actions = vec![0.0; steps * self.widths.action];
            self.memory.read(block.action(progress.done), &mut actions);
            progress.actions.extend(actions);
            self.memory.read(block.state(), &mut progress.state);
            let mut times = [0.0; 2];
            self.memory.read(block.times(), &mut times);
            progress.times = [progress.times[0] + times[0], progress.times[1] + times[1]];
        }
        progress.done += steps;
    }

    /// Records the end of an episode and begins the next.
    fn end_episode(&mut self, environment: usize) -> Result<()> {
        let mut observation = vec![0.0; self.widths.observation];
        self.memory.read(self.block(environment).next(), &mut observation);
        let progress = &mut self.progress[environment];
        progress.ends.push(End { environment, step: progress.done - 1, observation });
        self.ended += 1;
        self.restart(environment)
    }

    fn restart(&mut self, environment: usize) -> Result<()> {
        self.environments.reset_one(environment)?;
        self.progress[environment].phase = FragmentPhase::Starting;
        Ok(())
    }

    fn begin_episode(&mut self, environment: usize) -> Result<()> {
        let spaces = spaces_of(&self.environments, environment)?;
        let progress = &mut self.progress[environment];
        progress.scale = (self.scale)(spaces)? as f32;
        progress.attributes = attributes(self.interface.observation, spaces)?;
        progress.building = GraphBuilding::of(self.interface, self.by_zone, spaces)?;
        if let Some(building) = &progress.building {
            self.widths.check(&spaces.building.name, building.widths(), true)?;
        }
        progress.comfort = None;
        progress.phase = FragmentPhase::Ready;
        progress.episodes += 1;
        progress.actions.clear();
        progress.begin_scene(environment);
        Ok(())
    }

    /// Drops the lost fragment and begins another episode. Earlier fragments in the rollout end with their episodes,
    /// because a fragment makes all steps that the rollout still needs unless its episode ends first.
    fn lose(&mut self, environment: usize, why: String) -> Result<()> {
        self.lost += 1;
        let progress = &mut self.progress[environment];
        count_lost(&mut progress.lost_in_a_row, why)?;
        if progress.phase == FragmentPhase::Starting {
            // The episode was drawn, although it did not begin.
            progress.episodes += 1;
        }
        progress.actions.clear();
        self.restart(environment)
    }

    /// Copies the blocks to a rollout.
    fn write(&self, steps: usize, rollout: &mut Rollout) {
        let Widths { observation, action, parts, .. } = self.widths;
        rollout.resize(self.progress.len(), steps, self.widths);
        for (index, progress) in self.progress.iter().enumerate() {
            let block = self.block(index);
            let row = |width: usize| index * steps * width..(index + 1) * steps * width;
            self.memory.read(block.observation(0), &mut rollout.observations[row(observation)]);
            self.memory.read(block.action(0), &mut rollout.actions[row(action)]);
            self.memory.read(block.next(), &mut rollout.next[index * observation..][..observation]);
            let rewards = &mut rollout.rewards[row(parts)];
            self.memory.read(block.reward(0), rewards);
            progress.scale_rewards(rewards, parts);
            rollout.ends.extend_from_slice(&progress.ends);
            rollout.states.extend_from_slice(&progress.first_state);
            rollout.starts.extend(progress.starts.iter().map(|step| (index, *step)));
            rollout.scenes.extend(progress.scenes.iter().filter(|scene| scene.step < steps).cloned());
        }
        rollout.clear_padding(self.widths);
        if self.mirrored {
            let pairs = self.progress.chunks_exact(2);
            rollout.pairs.extend(pairs.map(|pair| pair[0].in_step_with(&pair[1], steps)));
        }
    }
}

impl Collector for FragmentCollector {
    fn widths(&self) -> Widths {
        self.widths
    }

    fn environments(&self) -> usize {
        self.progress.len()
    }

    fn collect(&mut self, actor: &Actor, steps: usize, rollout: &mut Rollout) -> Result<()> {
        self.rollouts += 1;
        self.share(actor, steps)?;
        self.begin_rollout();
        self.run(actor, Purpose::Explore, &mut vec![steps; self.progress.len()])?;
        self.write(steps, rollout);
        Ok(())
    }
}

/// Returns the spaces of an environment's current episode.
pub(crate) fn spaces_of(environments: &VecEnv, index: usize) -> Result<&Arc<Spaces>> {
    Ok(environments.shared_spaces(index).ok_or(b2b_env::Error::NotReset)?)
}
