//! The interface between an environment and an agent's network.

use std::sync::Arc;

use b2b_control::Controller;
use b2b_env::{Decisions, Spaces};

use crate::acting::Driver;
use crate::error::{Error, Result};
use crate::interface::Interface;
use crate::network::Graph;
use crate::observation::{AgentObservation, Past, attributes};
use crate::plan::NodePlan;

/// An agent's observations and actions in an episode of a building, around its network. Allocates nothing in a step.
///
/// Call [`Pilot::observe`] for every observation of the environment and [`Pilot::act`] for every step, alternately, and
/// [`Pilot::reward`] for its reward. Where decisions are held, the network acts when [`Pilot::is_due`], and its action
/// is repeated in the other steps.
#[derive(Clone, Debug)]
pub struct Pilot {
    observation: AgentObservation,
    graph: Option<Arc<Graph>>,
    driver: Driver,
    /// Index of the driver's action for each action of the network.
    actions: Vec<usize>,
    /// The last action of the driver, in [-1, 1]; 0 without a network action.
    previous: Vec<f32>,
    row: Vec<f32>,
    /// Sum of the rewards since the last decision; 0 before the first one.
    reward: f64,
    /// Whether the network has not acted in the episode yet.
    is_first: bool,
    /// Steps for which a decision is held.
    hold: usize,
    /// Steps for which the decision has been held; 0 if the next one is due.
    held: usize,
}

impl Pilot {
    /// Creates the pilot for a building that still has its model, at the beginning of an episode.
    ///
    /// # Errors
    /// The errors of [`attributes`]; [`Error::Weather`](crate::Error::Weather) for an unreadable weather file;
    /// [`Error::Graph`](crate::Error::Graph) for a graph network in a building whose graph cannot be built;
    /// [`Error::NothingToSet`](crate::Error::NothingToSet); [`Error::NotOperation`](crate::Error::NotOperation).
    pub fn new(interface: Interface, spaces: &Arc<Spaces>) -> Result<Self> {
        let plan = interface.nodes.map(|form| NodePlan::of(form, spaces)).transpose()?;
        let attributes = attributes(interface.observation, spaces)?;
        Self::without_model(interface, spaces, plan.as_ref(), &attributes)
    }

    /// Like [`Pilot::new`], for a building whose model has been dropped, as in a worker process: from its attributes
    /// and, for a graph network, its plan.
    ///
    /// # Errors
    /// Same as [`Pilot::new`].
    pub fn without_model(
        interface: Interface,
        spaces: &Arc<Spaces>,
        plan: Option<&NodePlan>,
        attributes: &[f64],
    ) -> Result<Self> {
        let task = &spaces.episode.task;
        if interface.acting.is_supervision() && !task.is_operation() {
            return Err(Error::NotOperation { task: task.to_string() });
        }
        let driver = Driver::new(interface.acting, plan.is_some(), spaces);
        let (observation, graph, actions) = match plan {
            None => {
                let observation = AgentObservation::new(interface.observation, attributes, spaces, &driver)?;
                (observation, None, (0..driver.names().len()).collect())
            }
            Some(plan) => {
                let view = AgentObservation::by_node(interface, spaces, plan)?;
                (view.observation, Some(Arc::new(view.graph)), view.actuators)
            }
        };
        if actions.is_empty() {
            return Err(Error::NothingToSet { building: spaces.building.name.clone() });
        }
        Ok(Self {
            row: vec![0.0; observation.width()],
            observation,
            graph,
            actions,
            previous: vec![0.0; driver.names().len()],
            driver,
            reward: 0.0,
            is_first: true,
            hold: interface.acting.hold(spaces.episode.steps_per_hour),
            held: 0,
        })
    }

    /// Returns the graph of the building; `None` if the network is not a graph network.
    pub fn graph(&self) -> Option<&Arc<Graph>> {
        self.graph.as_ref()
    }

    /// Begins an episode.
    pub fn reset(&mut self) {
        self.observation.reset();
        self.driver.reset();
        self.previous.fill(0.0);
        (self.reward, self.is_first, self.held) = (0.0, true, 0);
    }

    /// Returns the width of the network's observation and the number of its actions.
    pub fn widths(&self) -> (usize, usize) {
        (self.row.len(), self.actions.len())
    }

    /// Returns the names of the actions of a network that is not a graph network.
    pub fn action_names(&self) -> &[String] {
        self.driver.names()
    }

    /// Returns the observation of the agent.
    pub fn observation(&self) -> &AgentObservation {
        &self.observation
    }

    /// Takes the next observation of the environment and returns the network's observation.
    pub fn observe(&mut self, observation: &[f64]) -> &[f32] {
        self.driver.observe(observation);
        let past = Past { action: &self.previous, reward: self.reward, is_first: self.is_first };
        self.observation.write(observation, past, &self.driver, &mut self.row);
        &self.row
    }

    /// Returns the last observation of the network.
    pub fn observed(&self) -> &[f32] {
        &self.row
    }

    /// Returns the decisions of the supervised sequences in the last step; `None` without a supervisor.
    pub fn record(&self) -> Option<&Decisions> {
        self.driver.supervisor()?.guideline().record()
    }

    /// Returns whether the next action is a new decision, rather than the repetition of the last one.
    pub fn is_due(&self) -> bool {
        self.held == 0
    }

    /// Takes the action of the network for a step, whose values beyond ±1 are clipped, and returns it in physical
    /// units.
    pub fn act(&mut self, action: &[f32]) -> &[f64] {
        if self.is_due() {
            (self.reward, self.is_first) = (0.0, false);
        }
        for (place, value) in self.actions.iter().zip(action) {
            self.previous[*place] = value.clamp(-1.0, 1.0);
        }
        self.held = (self.held + 1) % self.hold;
        self.driver.drive(&self.previous)
    }

    /// Takes the environment's unscaled reward of the last step, before the next observation. The next decision
    /// observes the sum over the steps of the last one.
    pub fn reward(&mut self, reward: f64) {
        self.reward += reward;
    }
}
