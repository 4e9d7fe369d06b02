//! The owner's side: rollouts of environments in worker processes.

use std::sync::Arc;

use b2b_agent::network::Actor;
use b2b_agent::{Interface, Pilot, attributes};
use b2b_env::Spaces;
use b2b_env::vector::{SharedMemory, VecEnv};

use super::blocks::Block;
use super::building::GraphBuilding;
use super::order::{Order, Use, stream};
use crate::collector::{Collector, Widths, count_lost};
use crate::error::{Error, Result};
use crate::rollout::{End, Rollout, Scene};
use crate::state::State;

/// Steps of an environment that are carried out again at a time.
const REPLAYED: usize = 1024;

/// The factor by which the rewards of a building are multiplied.
pub type RewardScale = Box<dyn Fn(&Spaces) -> Result<f64> + Send>;

/// Collects rollouts in the worker processes of a [`VecEnv`] with [`Autoreset::Disabled`](b2b_env::vector::Autoreset::Disabled).
///
/// The same seed and actors give the same bits, however fast each environment is.
pub struct FragmentCollector {
    environments: VecEnv,
    interface: Interface,
    widths: Widths,
    scale: RewardScale,
    seed: u64,
    correlation: f32,
    travel_cost: f32,
    memory: SharedMemory,
    /// Place of the parameters and how many there is room for.
    parameters: (usize, usize),
    /// Place of the blocks and the steps that each has room for.
    blocks: (usize, usize),
    /// Rollouts collected so far.
    rollouts: u64,
    seats: Vec<Seat>,
    /// Episodes that ended.
    ended: u64,
    lost: u64,
}

/// One environment in the course of a collection.
#[derive(Clone, Debug)]
struct Seat {
    phase: Phase,
    /// Steps of the rollout.
    done: usize,
    /// Fragments that the rollout has of this environment.
    fragments: u64,
    /// Factor of the rewards of the episode in progress.
    scale: f32,
    /// Attributes that the agent observes of its building.
    attributes: Vec<f64>,
    /// Factors of the rewards of the rollout, each from a step on.
    scales: Vec<(usize, f32)>,
    ends: Vec<End>,
    /// Building of the episode in progress, for a graph network.
    building: Option<GraphBuilding>,
    /// Buildings of the rollout, each from a step on.
    scenes: Vec<Scene>,
    /// Episodes begun since the first reset.
    episodes: u64,
    /// Actions of the episode in progress.
    actions: Vec<f32>,
    lost_in_a_row: u32,
    /// Time spent on actions and on all steps of the rollout, s.
    times: [f32; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Ready for a fragment.
    Ready,
    /// In a fragment.
    Running,
    /// Between two episodes.
    Starting,
}

impl Seat {
    fn new(scale: f32, building: Option<GraphBuilding>, attributes: Vec<f64>) -> Self {
        Self {
            building,
            scenes: Vec::new(),
            phase: Phase::Ready,
            done: 0,
            fragments: 0,
            scale,
            attributes,
            scales: Vec::new(),
            ends: Vec::new(),
            episodes: 1,
            actions: Vec::new(),
            lost_in_a_row: 0,
            times: [0.0; 2],
        }
    }

    fn begin_rollout(&mut self, environment: usize) {
        (self.done, self.fragments, self.times) = (0, 0, [0.0; 2]);
        self.ends.clear();
        self.scales.clear();
        self.scenes.clear();
        self.begin_scene(environment);
    }

    /// Notes scale and building from this step on.
    fn begin_scene(&mut self, environment: usize) {
        self.scales.push((self.done, self.scale));
        if let Some(GraphBuilding { graph, .. }) = &self.building {
            self.scenes.retain(|scene| scene.step < self.done);
            self.scenes.push(Scene { environment, step: self.done, graph: Arc::clone(graph) });
        }
    }
}

impl FragmentCollector {
    /// Begins the first episodes. With `by_zone` a reward has a part for each controlled zone and one for energy, so that all
    /// buildings must have the same zones. `correlation` is that of the exploration noise between consecutive steps, `travel_cost`
    /// what a full stroke costs, averaged over the actuators, in the unit of the scaled rewards.
    ///
    /// # Errors
    /// [`Error::Env`] when an environment cannot begin.
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
        let mut seats = Vec::with_capacity(environments.len());
        let parts = if by_zone { spaces_of(&environments, 0)?.controlled_zones().count() + 1 } else { 1 };
        let mut widths = Widths { observation: 0, action: 0, parts };
        for index in 0..environments.len() {
            let spaces = spaces_of(&environments, index)?;
            let building = GraphBuilding::of(interface, spaces)?;
            let (observation, action) = match &building {
                Some(building) => building.widths(),
                None => Pilot::new(interface, spaces)?.widths(),
            };
            widths = widths.covering(Widths { observation, action, parts });
            let attributes = attributes(interface.observation, spaces)?;
            seats.push(Seat::new(scale(spaces)? as f32, building, attributes));
        }
        Ok(Self {
            memory: environments.workers().memory(),
            environments,
            interface,
            widths,
            scale,
            seed,
            correlation,
            travel_cost,
            parameters: (0, 0),
            blocks: (0, 0),
            rollouts: 0,
            seats,
            ended: 0,
            lost: 0,
        })
    }

    /// Makes room for buildings of these widths, for a graph network whose later episodes may be in larger ones than the first.
    /// Called before the first rollout.
    pub fn make_room(&mut self, widths: Widths) {
        self.widths = self.widths.covering(widths);
    }

    /// Returns the state, from which [`FragmentCollector::restore`] continues: of every environment the number of its episode,
    /// and the actions in it.
    pub fn state(&self) -> State {
        let mut state = State::default();
        // Of a seat between two episodes, the state is that of the next one.
        let is_between = |seat: &Seat| seat.phase == Phase::Starting;
        let episodes: Vec<u64> =
            self.seats.iter().map(|seat| seat.episodes + u64::from(is_between(seat))).collect();
        state.put_u64("episodes", &episodes);
        state.put_u64("counts", &[self.rollouts, self.ended, self.lost]);
        for (index, seat) in self.seats.iter().enumerate() {
            state.put_f32(&actions_of(index), if is_between(seat) { &[] } else { &seat.actions });
        }
        state
    }

    /// Continues from a state: every environment begins the episode that it was in, and carries out its actions again.
    ///
    /// # Errors
    /// When the state is of another number of environments, and when an environment cannot begin its episode.
    pub fn restore(&mut self, state: &State, actor: &Actor) -> Result<()> {
        [self.rollouts, self.ended, self.lost] = state.read_u64("counts")?;
        let episodes = state.values_u64("episodes", self.seats.len())?;
        let skipped: Vec<u64> = episodes.iter().map(|episodes| episodes.saturating_sub(1)).collect();
        self.environments.reset_after(self.seed, &skipped)?;
        for (index, episodes) in episodes.into_iter().enumerate() {
            let spaces = spaces_of(&self.environments, index)?;
            let building = GraphBuilding::of(self.interface, spaces)?;
            let scale = (self.scale)(spaces)? as f32;
            let attributes = attributes(self.interface.observation, spaces)?;
            let actions = state.values_f32(&actions_of(index))?;
            self.seats[index] = Seat { episodes, actions, ..Seat::new(scale, building, attributes) };
        }
        self.replay(actor)
    }

    /// Carries out the actions of all episodes in progress, some at a time.
    fn replay(&mut self, actor: &Actor) -> Result<()> {
        let width = self.widths.action;
        let rows: Vec<usize> = self.seats.iter().map(|seat| seat.actions.len() / width).collect();
        self.share(actor, REPLAYED)?;
        for first in (0..rows.iter().copied().max().unwrap_or(0)).step_by(REPLAYED) {
            self.begin_rollout();
            let steps: Vec<usize> =
                rows.iter().map(|rows| rows.saturating_sub(first).min(REPLAYED)).collect();
            for (index, steps) in steps.iter().enumerate().filter(|(_, steps)| **steps > 0) {
                let actions = &self.seats[index].actions[first * width..][..steps * width];
                self.memory.write(self.block(index).action(0), actions);
            }
            self.run(actor, Use::Replay, &steps)?;
        }
        Ok(())
    }

    fn begin_rollout(&mut self) {
        self.seats.iter_mut().enumerate().for_each(|(environment, seat)| seat.begin_rollout(environment));
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

    /// Returns the times that the workers spent on actions and on all steps of the last rollout, s, summed over workers.
    pub fn worker_times(&self) -> [f64; 2] {
        [0, 1].map(|index| self.seats.iter().map(|seat| f64::from(seat.times[index])).sum())
    }

    /// Makes room for an actor and for blocks of a number of steps, and writes the actor.
    fn share(&mut self, actor: &Actor, steps: usize) -> Result<()> {
        let numbers = Order::numbers(actor);
        if self.parameters.1 < numbers.len() {
            self.parameters = (self.environments.workers().reserve_memory(numbers.len())?, numbers.len());
        }
        if self.blocks.1 < steps {
            let count = self.environments.len() * Block::numbers(steps, self.widths);
            self.blocks = (self.environments.workers().reserve_memory(count)?, steps);
        }
        self.memory.write(self.parameters.0, &numbers);
        Ok(())
    }

    fn block(&self, environment: usize) -> Block {
        let (place, steps) = self.blocks;
        Block::new(place + environment * Block::numbers(steps, self.widths), steps, self.widths)
    }

    /// Runs fragments until every environment has made its steps.
    fn run(&mut self, actor: &Actor, purpose: Use, steps: &[usize]) -> Result<()> {
        for (environment, steps) in steps.iter().enumerate() {
            self.send(environment, actor, purpose, *steps)?;
        }
        let mut ready = Vec::with_capacity(self.seats.len());
        while self.seats.iter().zip(steps).any(|(seat, steps)| seat.done < *steps) {
            self.environments.recv(1, &mut ready)?;
            for environment in ready.drain(..) {
                self.settle(environment, purpose)?;
                self.send(environment, actor, purpose, steps[environment])?;
            }
        }
        Ok(())
    }

    /// Orders what is left of an environment's steps, if it is ready.
    fn send(&mut self, environment: usize, actor: &Actor, purpose: Use, steps: usize) -> Result<()> {
        let block = self.block(environment);
        let seat = &mut self.seats[environment];
        if seat.phase != Phase::Ready || seat.done >= steps {
            return Ok(());
        }
        let order = Order {
            interface: self.interface,
            plan: seat.building.as_ref().map(|building| building.plan.clone()),
            attributes: seat.attributes.clone(),
            shape: actor.shape.clone(),
            distribution: actor.distribution.clone(),
            parameters: self.parameters.0,
            version: self.rollouts,
            purpose,
            steps: steps - seat.done,
            block,
            done: seat.done,
            random: (self.seed, stream(self.rollouts, environment, seat.fragments)),
            correlation: self.correlation,
            // The scale comes after.
            travel_cost: self.travel_cost / seat.scale,
        };
        let text = serde_json::to_vec(&order).map_err(|error| Error::Collect(error.into()))?;
        self.environments.send_fragment(environment, &text, order.steps)?;
        seat.phase = Phase::Running;
        seat.fragments += 1;
        Ok(())
    }

    /// Takes what became of an environment that is no longer busy.
    fn settle(&mut self, environment: usize, purpose: Use) -> Result<()> {
        if let Some(why) = self.environments.lost(environment).map(str::to_owned) {
            return self.lose(environment, why);
        }
        if self.seats[environment].phase == Phase::Starting {
            return self.begin_episode(environment);
        }
        self.take_steps(environment, purpose);
        if self.environments.truncated()[environment] {
            self.end_episode(environment)?;
        } else {
            self.seats[environment].phase = Phase::Ready;
        }
        Ok(())
    }

    /// Counts the steps of a fragment, and keeps their actions.
    fn take_steps(&mut self, environment: usize, purpose: Use) {
        let block = self.block(environment);
        let steps = self.environments.fragment_steps(environment);
        let seat = &mut self.seats[environment];
        seat.lost_in_a_row = 0;
        if purpose == Use::Explore {
            let mut actions = vec![0.0; steps * self.widths.action];
            self.memory.read(block.action(seat.done), &mut actions);
            seat.actions.extend(actions);
            let mut times = [0.0; 2];
            self.memory.read(block.times(), &mut times);
            seat.times = [seat.times[0] + times[0], seat.times[1] + times[1]];
        }
        seat.done += steps;
    }

    /// Keeps the end of an episode, and has the next begin.
    fn end_episode(&mut self, environment: usize) -> Result<()> {
        let mut observation = vec![0.0; self.widths.observation];
        self.memory.read(self.block(environment).next(), &mut observation);
        let seat = &mut self.seats[environment];
        seat.ends.push(End { environment, step: seat.done - 1, observation });
        self.ended += 1;
        self.restart(environment)
    }

    fn restart(&mut self, environment: usize) -> Result<()> {
        self.environments.reset_one(environment)?;
        self.seats[environment].phase = Phase::Starting;
        Ok(())
    }

    fn begin_episode(&mut self, environment: usize) -> Result<()> {
        let spaces = spaces_of(&self.environments, environment)?;
        let seat = &mut self.seats[environment];
        seat.scale = (self.scale)(spaces)? as f32;
        seat.attributes = attributes(self.interface.observation, spaces)?;
        seat.building = GraphBuilding::of(self.interface, spaces)?;
        if let Some(building) = &seat.building {
            self.widths.check(&spaces.building.name, building.widths(), true)?;
        }
        seat.phase = Phase::Ready;
        seat.episodes += 1;
        seat.actions.clear();
        seat.begin_scene(environment);
        Ok(())
    }

    /// Drops the fragment that was lost and begins another episode. What the rollout has of the lost one ends before its last
    /// step, whose observation is known.
    fn lose(&mut self, environment: usize, why: String) -> Result<()> {
        self.lost += 1;
        let block = self.block(environment);
        let seat = &mut self.seats[environment];
        count_lost(&mut seat.lost_in_a_row, why)?;
        let ended = seat.ends.last().map_or(0, |end| end.step + 1);
        if seat.done > ended {
            let mut observation = vec![0.0; self.widths.observation];
            self.memory.read(block.observation(seat.done - 1), &mut observation);
            seat.ends.push(End { environment, step: seat.done - 1, observation });
        }
        self.restart(environment)
    }

    /// Copies the blocks to a rollout.
    fn write(&self, steps: usize, rollout: &mut Rollout) {
        let Widths { observation, action, parts } = self.widths;
        rollout.resize(self.seats.len(), steps, self.widths);
        for (index, seat) in self.seats.iter().enumerate() {
            let block = self.block(index);
            let row = |width: usize| index * steps * width..(index + 1) * steps * width;
            self.memory.read(block.observation(0), &mut rollout.observations[row(observation)]);
            self.memory.read(block.action(0), &mut rollout.actions[row(action)]);
            self.memory.read(block.next(), &mut rollout.next[index * observation..][..observation]);
            let rewards = &mut rollout.rewards[row(parts)];
            self.memory.read(block.reward(0), rewards);
            seat.scale_rewards(rewards, parts);
            rollout.ends.extend_from_slice(&seat.ends);
            rollout.scenes.extend(seat.scenes.iter().filter(|scene| scene.step < steps).cloned());
        }
        rollout.clear_padding(self.widths);
    }
}

impl Seat {
    fn scale_rewards(&self, rewards: &mut [f32], parts: usize) {
        for (index, (from, scale)) in self.scales.iter().enumerate() {
            let to = self.scales.get(index + 1).map_or(rewards.len(), |(step, _)| step * parts);
            rewards[from * parts..to].iter_mut().for_each(|reward| *reward *= scale);
        }
    }
}

impl Collector for FragmentCollector {
    fn widths(&self) -> Widths {
        self.widths
    }

    fn environments(&self) -> usize {
        self.seats.len()
    }

    fn collect(&mut self, actor: &Actor, steps: usize, rollout: &mut Rollout) -> Result<()> {
        self.rollouts += 1;
        self.share(actor, steps)?;
        self.begin_rollout();
        self.run(actor, Use::Explore, &vec![steps; self.seats.len()])?;
        self.write(steps, rollout);
        Ok(())
    }
}

/// Returns the name of an environment's actions in a state.
fn actions_of(environment: usize) -> String {
    format!("actions.{environment}")
}

/// Returns the spaces of an environment's current episode.
pub(crate) fn spaces_of(environments: &VecEnv, index: usize) -> Result<&Arc<Spaces>> {
    Ok(environments.shared_spaces(index).ok_or(b2b_env::Error::NotReset)?)
}
