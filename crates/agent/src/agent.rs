//! Agents: a trained actor with its observation and action interface.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use b2b_control::{Controller, linear_supervisor};
use b2b_env::{Decisions, Spaces};

use crate::folder;
use crate::info::AgentInfo;
use crate::interface::Interface;
use crate::network::{Actor, MemorySpan, Scratch};
use crate::observation::{NodeSpaces, attributes};
use crate::pilot::Pilot;
use crate::plan::{NodeForm, NodePlan, PlannedNode};
use crate::{Error, Result};

/// A trained agent.
#[derive(Clone, Debug)]
pub struct Agent {
    name: String,
    folder: PathBuf,
    info: AgentInfo,
    actor: Arc<Actor>,
    sha256: String,
    identity: String,
}

impl Agent {
    /// Reads an agent's folder.
    ///
    /// # Errors
    /// [`Error::NotAnAgent`] without a readable description; [`Error::Damaged`] when a file has a wrong hash or shape.
    pub fn read(path: &Path) -> Result<Self> {
        let folder::Contents { info, actor, sha256 } = folder::read(path)?;
        check_rules(path, &info)?;
        let identity = format!("agent {sha256}");
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Ok(Self { name, folder: path.to_owned(), info, actor: Arc::new(actor), sha256, identity })
    }

    /// Creates an agent without a folder.
    pub fn new(name: &str, info: AgentInfo, actor: Actor) -> Self {
        let (identity, folder) = (format!("agent {name}"), PathBuf::from(name));
        Self { name: name.to_owned(), folder, info, actor: Arc::new(actor), sha256: String::new(), identity }
    }

    /// Writes an agent's folder, or replaces the agent in it. Other files are kept.
    ///
    /// # Errors
    /// [`Error::Io`]. The previous agent is then intact, unless only the second of the two files could not be moved
    /// into place.
    pub fn write(path: &Path, info: AgentInfo, actor: &Actor) -> Result<()> {
        folder::write(path, info, actor)
    }

    /// Returns the name: of the folder it was read from, or the given one.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns its folder.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the description of the agent: what it observes and controls, and how it was trained.
    pub fn info(&self) -> &AgentInfo {
        &self.info
    }

    /// Returns the network.
    pub fn actor(&self) -> &Arc<Actor> {
        &self.actor
    }

    /// Returns the SHA-256 of its description and weights; empty for an agent without a folder.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Returns one line that identifies the agent: agents read from folders act alike if they have the same identity.
    pub fn identity(&self) -> &str {
        &self.identity
    }

    /// Returns a controller for an episode of a building. A graph agent does not observe nodes of types that it was not
    /// trained with. Such nodes follow its base controller alone, if it has one.
    ///
    /// # Errors
    /// [`Error::OtherBuilding`] when the building's observation or actuators differ from training;
    /// [`Error::UnknownNodeType`] when a graph agent with direct actions does not know the type of a node that has
    /// actuators; the errors of [`Pilot::new`].
    pub fn controller(&self, spaces: &Arc<Spaces>) -> Result<AgentController> {
        Ok(self.controller_of(self.pilot(spaces)?))
    }

    /// Returns a controller with its own pilot for a building.
    pub(crate) fn controller_of(&self, pilot: Pilot) -> AgentController {
        let controller = AgentController::new(pilot, Arc::clone(&self.actor));
        AgentController { memory: MemorySpan::new(self.info.memory_episodes), ..controller }
    }

    /// Creates the pilot for a building that still has its model.
    pub(crate) fn pilot(&self, spaces: &Arc<Spaces>) -> Result<Pilot> {
        let (plan, attributes) = self.model_parts(spaces)?;
        self.pilot_without_model(spaces, plan.as_ref(), &attributes)
    }

    /// Returns what the agent needs of a building's model: attributes and, for a graph network, the nodes of its
    /// trained types.
    pub(crate) fn model_parts(&self, spaces: &Spaces) -> Result<(Option<NodePlan>, Vec<f64>)> {
        let Interface { observation, nodes, .. } = self.info.interface;
        let plan = nodes.map(|form| self.plan(form, spaces)).transpose()?;
        Ok((plan, attributes(observation, spaces)?))
    }

    /// Like [`Agent::pilot`], with the result of [`Agent::model_parts`].
    pub(crate) fn pilot_without_model(
        &self,
        spaces: &Arc<Spaces>,
        plan: Option<&NodePlan>,
        attributes: &[f64],
    ) -> Result<Pilot> {
        let pilot = Pilot::without_model(self.info.interface, spaces, plan, attributes)?;
        match pilot.graph() {
            None => self.check(&pilot.observation().names(), pilot.action_names(), spaces)?,
            Some(_) => {
                let types = NodeSpaces::of(self.info.interface).first(self.node_types());
                self.check(&types.slots(), &types.actuators(), spaces)?;
            }
        }
        Ok(pilot)
    }

    /// Returns the number of node types of its graph network.
    fn node_types(&self) -> usize {
        self.info.network.graph().map_or(0, |network| network.types.len())
    }

    fn plan(&self, form: NodeForm, spaces: &Spaces) -> Result<NodePlan> {
        let known = &self.info.node_types;
        let plan = NodePlan::of(form, spaces)?.restricted_to(known);
        let acts = |node: &&PlannedNode| !node.kind().action().is_empty();
        match plan.left_out.iter().find(acts) {
            Some(node) if !self.info.interface.acting.has_base() => Err(Error::UnknownNodeType {
                agent: self.folder.display().to_string(),
                building: spaces.building.name.clone(),
                node: node.name.clone(),
                node_type: node.kind().name(),
                known: known.join(", "),
            }),
            _ => Ok(plan),
        }
    }

    fn check(&self, slots: &[String], actuators: &[String], spaces: &Spaces) -> Result<()> {
        let why = difference("observation", &self.info.slots, slots)
            .or_else(|| difference("actuator", &self.info.actuators, actuators));
        match why {
            None => Ok(()),
            // The spaces of a graph agent are the same in all buildings.
            Some(why) if self.info.interface.nodes.is_some() => {
                Err(Error::OtherVersion { agent: self.folder.display().to_string(), why })
            }
            Some(why) => Err(Error::OtherBuilding {
                agent: self.folder.display().to_string(),
                building: spaces.building.name.clone(),
                why,
                trained_on: self.info.training.buildings.clone(),
            }),
        }
    }
}

/// Describes the first difference between two lists of names.
fn difference(what: &str, agent: &[String], building: &[String]) -> Option<String> {
    if agent.len() != building.len() {
        let (has, takes) = (building.len(), agent.len());
        return Some(format!("the building has {has} {what} slots and the agent {takes}"));
    }
    let mut pairs = agent.iter().zip(building).enumerate();
    pairs.find(|(_, (there, here))| there != here).map(|(index, (there, here))| {
        format!("{what} slot {index} is `{here}` in the building and `{there}` in the agent")
    })
}

/// A controller that runs an agent in one building, without exploration. A network with a memory keeps its state in
/// [`Controller::next_episode`], for as many episodes as in training. Steps after the first allocate nothing.
#[derive(Clone, Debug)]
pub struct AgentController {
    pilot: Pilot,
    actor: Arc<Actor>,
    scratch: Scratch,
    row: Vec<f32>,
    /// Episodes that its state spans.
    memory: MemorySpan,
}

impl AgentController {
    /// Creates a controller from a pilot and an actor of the same widths, which forgets only at a reset.
    pub fn new(pilot: Pilot, actor: Arc<Actor>) -> Self {
        let scratch = actor.scratch(pilot.graph());
        let row = vec![0.0; scratch.actions()];
        Self { row, scratch, pilot, actor, memory: MemorySpan::new(None) }
    }

    /// Returns the number of its actions: actuators that it controls or corrects, or shifts of targets or of what
    /// Guideline 36 chooses.
    pub fn actions(&self) -> usize {
        self.row.len()
    }
}

impl Controller for AgentController {
    fn reset(&mut self) {
        self.pilot.reset();
        self.scratch.state_mut().fill(0.0);
        self.memory.reset();
    }

    /// Keeps the state of a network with a memory, unless it spans as many episodes as in training.
    fn next_episode(&mut self) {
        match self.memory.next_episode() {
            true => self.reset(),
            false => self.pilot.reset(),
        }
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        self.pilot.observe(observation);
        if self.pilot.is_due() {
            self.actor.mean(self.pilot.observed(), &mut self.scratch, &mut self.row);
        }
        action.copy_from_slice(self.pilot.act(&self.row));
    }

    fn reward(&mut self, reward: f64) {
        self.pilot.reward(reward);
    }

    fn record(&self) -> Option<&Decisions> {
        self.pilot.record()
    }
}

/// Checks that the rules from which an agent supervises are this version's.
fn check_rules(path: &Path, info: &AgentInfo) -> Result<()> {
    let (trained, here) = (&info.training.base_controllers, linear_supervisor::identity());
    match trained {
        Some(trained) if info.interface.acting.starts_from_rule() && !trained.ends_with(&here) => {
            Err(Error::OtherRules { path: path.to_owned(), trained: trained.clone(), here })
        }
        _ => Ok(()),
    }
}
