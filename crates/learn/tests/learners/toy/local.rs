//! A collector of steps of toy environments in this process.

use std::sync::Arc;

use b2b_agent::network::{Actor, Graph, Scratch};
use b2b_learn::Result;
use b2b_learn::collector::Collector;
use b2b_learn::credit::Credit;
use b2b_learn::random::{Noise, RandomStream};
use b2b_learn::rollout::{End, Rollout, Scene, Widths};

use super::Toy;

/// Environments in this process.
pub struct Local<T> {
    environments: Vec<Running<T>>,
    /// Buildings for graph networks, assigned to the environments in turn.
    graphs: Vec<Arc<Graph>>,
}

/// An environment within an episode.
struct Running<T> {
    toy: T,
    step: usize,
    random: RandomStream,
    noise: Noise,
    /// State of an actor with a memory.
    state: Vec<f32>,
}

impl<T: Toy> Local<T> {
    /// Returns this number of environments. Their episodes begin together.
    pub fn new(environments: usize, seed: u64) -> Self {
        let start = |index: usize| {
            let mut random = RandomStream::new(seed, 1000 + index as u64);
            let noise = Noise::new(T::WIDTHS.action, 0.0, RandomStream::new(seed, 2000 + index as u64));
            Running { toy: T::reset(&mut random), step: 0, random, noise, state: Vec::new() }
        };
        Self { environments: (0..environments).map(start).collect(), graphs: Vec::new() }
    }

    /// Sets the buildings for graph networks, whose first node has the observation and the actions.
    #[must_use]
    pub fn with_graphs(mut self, graphs: Vec<Arc<Graph>>) -> Self {
        self.graphs = graphs;
        self
    }
}

impl<T: Toy> Collector for Local<T> {
    fn widths(&self) -> Widths {
        let nodes = self.graphs.iter().map(|graph| graph.nodes()).max().unwrap_or(1);
        Widths { nodes, ..T::WIDTHS }
    }

    fn environments(&self) -> usize {
        self.environments.len()
    }

    fn collect(&mut self, actor: &Actor, steps: usize, rollout: &mut Rollout) -> Result<()> {
        *rollout = Rollout { environments: self.environments.len(), steps, ..Rollout::default() };
        let width = actor.shape.state() * self.widths().nodes;
        for (environment, running) in self.environments.iter_mut().enumerate() {
            let graph = self.graphs.get(environment % self.graphs.len().max(1)).map(Arc::clone);
            let mut scratch = actor.scratch(graph.as_ref());
            let credit = Arc::new(Credit::joint(T::WIDTHS));
            rollout.scenes.extend(graph.map(|graph| Scene { environment, step: 0, graph, credit }));
            running.state.resize(scratch.state().len(), 0.0);
            rollout.states.extend_from_slice(&running.state);
            rollout.states.resize((environment + 1) * width, 0.0);
            scratch.state_mut().copy_from_slice(&running.state);
            for step in 0..steps {
                if running.step == 0 && !scratch.state().is_empty() {
                    scratch.state_mut().fill(0.0);
                    rollout.starts.push((environment, step));
                }
                running.step(actor, &mut scratch, rollout);
                if running.step == T::STEPS {
                    let observation = running.observation();
                    rollout.ends.push(End { environment, step, observation });
                    running.toy = T::reset(&mut running.random);
                    running.step = 0;
                }
            }
            running.state.copy_from_slice(scratch.state());
            rollout.next.extend(running.observation());
        }
        Ok(())
    }
}

impl<T: Toy> Running<T> {
    fn observation(&self) -> Vec<f32> {
        let mut observation = vec![0.0; T::WIDTHS.observation];
        self.toy.observe(&mut observation);
        observation
    }

    fn step(&mut self, actor: &Actor, scratch: &mut Scratch, rollout: &mut Rollout) {
        let observation = self.observation();
        let mut action = vec![0.0; T::WIDTHS.action];
        actor.sample(&observation, self.noise.draw(), scratch, &mut action);
        let mut rewards = vec![0.0; T::WIDTHS.parts];
        self.toy.step(&action, &mut self.random, &mut rewards);
        self.step += 1;
        rollout.observations.extend(observation);
        rollout.actions.extend(action);
        rollout.rewards.extend(rewards.iter().map(|reward| reward * T::REWARD_SCALE));
    }
}

/// Returns the mean return of episodes with a policy.
pub fn mean_return<T: Toy>(episodes: usize, mut policy: impl FnMut(&[f32], &mut [f32])) -> f64 {
    let mut random = RandomStream::new(77, 77);
    let mut observation = vec![0.0; T::WIDTHS.observation];
    let (mut action, mut rewards) = (vec![0.0; T::WIDTHS.action], vec![0.0; T::WIDTHS.parts]);
    let mut sum = 0.0;
    for _ in 0..episodes {
        let mut toy = T::reset(&mut random);
        for _ in 0..T::STEPS {
            toy.observe(&mut observation);
            policy(&observation, &mut action);
            toy.step(&action, &mut random, &mut rewards);
            sum += rewards.iter().map(|reward| f64::from(*reward)).sum::<f64>();
        }
    }
    sum / episodes as f64
}
