//! Collection in lockstep: the owner computes the actions of all environments, and each makes one step.
//!
//! 1. The owner samples an action for every environment.
//! 2. Every worker makes a step with its action.
//! 3. The owner waits for all of them, and begins the next episode wherever one is over.
//!
//! This is the usual loop of learning libraries. In [`fragments`](crate::fragments) no environment waits for another.
//! Both give the same bits.

use std::sync::Arc;
use std::time::{Duration, Instant};

use b2b_agent::network::{Actor, Scratch};
use b2b_agent::{Interface, Pilot};
use b2b_workers::VecEnv;

use crate::collector::{Collector, count_lost};
use crate::credit::Credit;
use crate::error::Result;
use crate::fragments::{RewardScale, spaces_of, stream};
use crate::random::{Noise, RandomStream};
use crate::rollout::{End, Rollout, Scene, Widths};

/// Collects rollouts step by step in a [`VecEnv`] with [`Autoreset::Disabled`](b2b_workers::Autoreset::Disabled). A
/// reward has one part.
///
/// The rollouts equal a [`FragmentCollector`](crate::fragments::FragmentCollector)'s with the same seed and actors, bit
/// for bit, as long as no episode is lost.
pub struct LockstepCollector {
    environments: VecEnv,
    interface: Interface,
    widths: Widths,
    scale: RewardScale,
    seed: u64,
    correlation: f32,
    /// Episodes in a building that the memory of a recurrent actor spans.
    memory_episodes: u64,
    /// Rollouts collected so far.
    rollouts: u64,
    progress: Vec<EnvProgress>,
    /// Environments that are no longer busy.
    ready: Vec<usize>,
    lost: u64,
    /// Time that the last rollout spent on actions, and its total time.
    times: [Duration; 2],
}

/// The state of one environment during collection.
struct EnvProgress {
    pilot: Pilot,
    /// Buffers of the actor in the building of the episode in progress, and the state of a recurrent one.
    scratch: Option<Scratch>,
    /// That state when the rollout began.
    first_state: Vec<f32>,
    /// Steps of the rollout before which a recurrent actor forgets.
    starts: Vec<usize>,
    /// Episodes drawn, and whether the last one has no step yet.
    episodes: u64,
    is_new: bool,
    noise: Noise,
    /// Factor of the rewards of the episode in progress.
    scale: f32,
    /// Steps of the rollout so far.
    done: usize,
    /// This environment's fragments in the rollout: one more than the episodes that ended.
    fragments: u64,
    ends: Vec<End>,
    /// Buildings in the rollout, each with the step from which it applies, for a graph network.
    scenes: Vec<Scene>,
    lost_in_a_row: u32,
    /// The action in physical units, padded to the width of the batch.
    command: Vec<f64>,
}

impl EnvProgress {
    fn new(pilot: Pilot, noise: Noise, scale: f32, command: Vec<f64>) -> Self {
        Self {
            pilot,
            scratch: None,
            first_state: Vec::new(),
            starts: Vec::new(),
            episodes: 1,
            is_new: true,
            noise,
            scale,
            done: 0,
            fragments: 0,
            ends: Vec::new(),
            scenes: Vec::new(),
            lost_in_a_row: 0,
            command,
        }
    }
}

impl LockstepCollector {
    /// Begins the first episodes. `correlation` is the correlation of the exploration noise between consecutive steps.
    ///
    /// # Errors
    /// [`Error::Env`](crate::Error::Env) when an environment cannot begin.
    pub fn new(
        mut environments: VecEnv,
        interface: Interface,
        correlation: f32,
        scale: RewardScale,
        seed: u64,
    ) -> Result<Self> {
        environments.reset(seed)?;
        let mut widths = Widths { observation: 0, action: 0, parts: 1, nodes: 1 };
        let mut progress = Vec::with_capacity(environments.len());
        for index in 0..environments.len() {
            let spaces = spaces_of(&environments, index)?;
            let pilot = Pilot::new(interface, spaces)?;
            let own = Widths::of(&pilot, 1);
            if index == 0 || interface.nodes.is_some() {
                widths = widths.covering(own);
            }
            let noise = Noise::new(own.action, correlation, RandomStream::new(seed, 0));
            let command = vec![0.0; environments.widths().0];
            progress.push(EnvProgress::new(pilot, noise, scale(spaces)? as f32, command));
        }
        let mut collector = Self {
            environments,
            interface,
            widths,
            scale,
            seed,
            correlation,
            memory_episodes: 1,
            rollouts: 0,
            progress,
            ready: Vec::new(),
            lost: 0,
            times: [Duration::ZERO; 2],
        };
        (0..collector.progress.len()).try_for_each(|index| collector.check_and_observe(index))?;
        Ok(collector)
    }

    /// Lets a recurrent actor remember this many consecutive episodes of an environment, by default one.
    #[must_use]
    pub fn with_memory_episodes(mut self, episodes: u32) -> Self {
        self.memory_episodes = u64::from(episodes.max(1));
        self
    }

    /// Returns how many episodes were lost.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Returns the environments.
    pub fn environments(&self) -> &VecEnv {
        &self.environments
    }

    /// Returns the time that the last rollout spent on actions, and its total time, s.
    pub fn times(&self) -> [f64; 2] {
        self.times.map(|time| time.as_secs_f64())
    }

    /// Observes the first state of an episode. Its building must have the widths of the first building or, for a graph
    /// network, no larger ones than there is room for.
    fn check_and_observe(&mut self, environment: usize) -> Result<()> {
        let pilot = &self.progress[environment].pilot;
        let name = &spaces_of(&self.environments, environment)?.building.name;
        self.widths.check(name, Widths::of(pilot, 1), pilot.graph().is_some())?;
        self.observe(environment)
    }

    /// Passes the environment's observation to the pilot.
    fn observe(&mut self, environment: usize) -> Result<()> {
        let slots = spaces_of(&self.environments, environment)?.observation.len();
        let first = environment * self.environments.widths().1;
        self.progress[environment].pilot.observe(&self.environments.observations()[first..][..slots]);
        Ok(())
    }

    /// Makes room in the rollout and begins it in every environment.
    fn begin_rollout(&mut self, actor: &Actor, steps: usize, rollout: &mut Rollout) {
        rollout.resize(self.progress.len(), steps, self.widths);
        self.rollouts += 1;
        self.times = [Duration::ZERO; 2];
        for index in 0..self.progress.len() {
            let env = &mut self.progress[index];
            (env.done, env.fragments) = (0, 0);
            env.ends.clear();
            env.scenes.clear();
            env.begin_scene(index);
            env.starts.clear();
            env.first_state = env.scratch(actor).state().to_vec();
            env.first_state.resize(actor.shape.state() * self.widths.nodes, 0.0);
            self.begin_fragment(index);
        }
    }

    /// Begins the exploration noise of a fragment.
    fn begin_fragment(&mut self, environment: usize) {
        let env = &mut self.progress[environment];
        let random = RandomStream::new(self.seed, stream(self.rollouts, environment, env.fragments));
        env.noise = Noise::new(env.pilot.widths().1, self.correlation, random);
        env.fragments += 1;
    }

    /// Makes one step of every environment whose rollout is not complete.
    fn step(&mut self, actor: &Actor, rollout: &mut Rollout) -> Result<()> {
        let (before, steps) = (Instant::now(), rollout.steps);
        for (index, env) in self.progress.iter_mut().enumerate().filter(|(_, env)| env.done < steps) {
            env.begin_memory(actor, self.memory_episodes);
            env.act(actor, self.widths, index * steps + env.done, rollout);
        }
        self.times[0] += before.elapsed();
        for (index, env) in self.progress.iter().enumerate().filter(|(_, env)| env.done < steps) {
            self.environments.send(index, &env.command)?;
        }
        self.receive(|collector, environment| collector.take_step(environment, rollout))?;
        while self.receive(Self::begin_episode)? > 0 {}
        Ok(())
    }

    /// Waits for all busy environments and handles each result. Returns how many there were.
    fn receive(&mut self, mut take: impl FnMut(&mut Self, usize) -> Result<()>) -> Result<usize> {
        let mut ready = std::mem::take(&mut self.ready);
        self.environments.recv(self.progress.len(), &mut ready)?;
        for environment in &ready {
            match self.environments.lost(*environment).map(str::to_owned) {
                Some(why) => self.lose(*environment, why)?,
                None => take(self, *environment)?,
            }
        }
        self.ready = ready;
        Ok(self.ready.len())
    }

    /// Records the outcome of a step.
    fn take_step(&mut self, environment: usize, rollout: &mut Rollout) -> Result<()> {
        let reward = self.environments.rewards()[environment].total();
        self.progress[environment].pilot.reward(reward);
        self.observe(environment)?;
        let env = &mut self.progress[environment];
        rollout.rewards[environment * rollout.steps + env.done] = reward as f32 * env.scale;
        env.done += 1;
        env.lost_in_a_row = 0;
        if env.done == rollout.steps {
            let width = self.widths.observation;
            let observed = env.pilot.observed();
            rollout.next[environment * width..][..observed.len()].copy_from_slice(observed);
        }
        if self.environments.truncated()[environment] {
            env.end(environment, self.widths);
            env.episodes += 1;
            self.environments.reset_one(environment)?;
        }
        Ok(())
    }

    fn begin_episode(&mut self, environment: usize) -> Result<()> {
        let spaces = spaces_of(&self.environments, environment)?;
        let env = &mut self.progress[environment];
        let interface = self.interface;
        let pilot = Pilot::new(interface, spaces)?;
        if pilot.graph() != env.pilot.graph() {
            env.scratch = None;
        }
        env.pilot = pilot;
        env.is_new = true;
        env.scale = (self.scale)(spaces)? as f32;
        env.begin_scene(environment);
        self.begin_fragment(environment);
        self.check_and_observe(environment)
    }

    /// Ends a lost episode at its last step, and begins another.
    fn lose(&mut self, environment: usize, why: String) -> Result<()> {
        self.lost += 1;
        let env = &mut self.progress[environment];
        count_lost(&mut env.lost_in_a_row, why)?;
        env.end(environment, self.widths);
        env.episodes += 1;
        Ok(self.environments.reset_one(environment)?)
    }
}

impl EnvProgress {
    /// Returns the buffers of the actor.
    fn scratch(&mut self, actor: &Actor) -> &mut Scratch {
        self.scratch.get_or_insert_with(|| actor.scratch(self.pilot.graph()))
    }

    /// Empties the memory of a recurrent actor before the first step of an episode, unless it spans episodes and this
    /// is not the first of them.
    fn begin_memory(&mut self, actor: &Actor, memory_episodes: u64) {
        let is_first =
            std::mem::take(&mut self.is_new) && (self.episodes - 1).is_multiple_of(memory_episodes);
        if is_first && !self.scratch(actor).state().is_empty() {
            self.scratch(actor).state_mut().fill(0.0);
            self.starts.push(self.done);
        }
    }

    /// Chooses the action of a step, and records it in a row of the rollout, with the observation before the step.
    fn act(&mut self, actor: &Actor, widths: Widths, row: usize, rollout: &mut Rollout) {
        let scratch = self.scratch.get_or_insert_with(|| actor.scratch(self.pilot.graph()));
        let observation = self.pilot.observed();
        let (slots, actuators) = self.pilot.widths();
        let action = &mut rollout.actions[row * widths.action..][..actuators];
        actor.sample(observation, self.noise.draw(), scratch, action);
        rollout.observations[row * widths.observation..][..slots].copy_from_slice(observation);
        let physical = self.pilot.act(action);
        self.command[..physical.len()].copy_from_slice(physical);
    }

    /// Records the building from this step on.
    fn begin_scene(&mut self, environment: usize) {
        if let Some(graph) = self.pilot.graph() {
            self.scenes.retain(|scene| scene.step < self.done);
            let credit = Arc::new(Credit::joint(Widths::of(&self.pilot, 1)));
            self.scenes.push(Scene { environment, step: self.done, graph: Arc::clone(graph), credit });
        }
    }

    /// Ends the episode at the last step, unless it has ended there already or the rollout has no step yet.
    fn end(&mut self, environment: usize, widths: Widths) {
        let ended = self.ends.last().map_or(0, |end| end.step + 1);
        if self.done > ended {
            let mut observation = self.pilot.observed().to_vec();
            observation.resize(widths.observation, 0.0);
            self.ends.push(End { environment, step: self.done - 1, observation });
        }
    }
}

impl Collector for LockstepCollector {
    fn widths(&self) -> Widths {
        self.widths
    }

    fn environments(&self) -> usize {
        self.progress.len()
    }

    fn collect(&mut self, actor: &Actor, steps: usize, rollout: &mut Rollout) -> Result<()> {
        let began = Instant::now();
        self.begin_rollout(actor, steps, rollout);
        while self.progress.iter().any(|env| env.done < steps) {
            self.step(actor, rollout)?;
        }
        rollout.ends.extend(self.progress.iter_mut().flat_map(|env| env.ends.drain(..)));
        for (index, env) in self.progress.iter().enumerate() {
            rollout.states.extend_from_slice(&env.first_state);
            rollout.starts.extend(env.starts.iter().map(|step| (index, *step)));
        }
        let scenes = self.progress.iter_mut().flat_map(|env| env.scenes.drain(..));
        rollout.scenes.extend(scenes.filter(|scene| scene.step < steps));
        rollout.clear_padding(self.widths);
        self.times[1] = began.elapsed();
        Ok(())
    }
}
