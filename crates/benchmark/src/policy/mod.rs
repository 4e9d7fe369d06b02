//! Who acts.

mod onnx;

use std::fmt;
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

use b2b_control::{Constant, Controller, Planner, PlannerParameters, Random, Reactive, Replay};
use b2b_env::{ActionSpace, Spaces, vector};

pub use onnx::{ActionScale, OnnxPolicy};

use crate::baseline::controller_parameters;
use crate::{Error, Result, Subject, Surroundings};

/// Something that acts in any building, or in those of its shapes.
pub trait Policy: Sync {
    /// What it is called in results.
    fn name(&self) -> String;

    /// All that its actions depend on beside what it sees, in one line: two policies of the same identity act alike.
    fn identity(&self) -> String;

    /// Whether it is the reactive controllers that scores are relative to.
    fn is_baseline(&self) -> bool {
        false
    }

    /// Whether it sees and drives a building as a whole, whatever interface it is given.
    fn drives_all(&self) -> bool {
        false
    }

    /// A controller for one episode. It keeps what state it needs.
    ///
    /// # Errors
    /// [`Error::ObservationShape`] and [`Error::ActionShape`] end the evaluation; any other loses the episode.
    fn controller(&self, beginning: Beginning<'_>) -> Result<Box<dyn Controller>>;
}

impl dyn Policy {
    /// A policy by its name: one of the [`BuiltIn`], or an ONNX file whose numbers mean what `scale` says.
    ///
    /// # Errors
    /// [`Error::UnknownPolicy`]; those of [`OnnxPolicy::read`].
    pub fn named(name: &str, scale: ActionScale) -> Result<Box<Self>> {
        let path = Path::new(name);
        if is_onnx(path) {
            return Ok(Box::new(OnnxPolicy::read(path, scale)?));
        }
        Ok(Box::new(name.parse::<BuiltIn>()?))
    }
}

/// Whether a policy is the path of a network, and no name.
pub(crate) fn is_onnx(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("onnx"))
}

/// The episode that a controller is asked for.
pub struct Beginning<'a> {
    /// The building.
    pub subject: &'a Subject,
    /// Where it stands.
    pub surroundings: &'a Surroundings,
    /// What is seen and driven in it.
    pub spaces: &'a Arc<Spaces>,
    /// What of it the policy sees and drives.
    pub interface: &'a Interface,
    /// The seed of the episode.
    pub seed: u64,
    /// The episode before its reset: a planner resets it and tries actions on copies of it.
    pub episode: &'a mut vector::Episode,
}

/// What a policy sees and drives: all of a building's spaces, or what a problem makes of them.
#[derive(Clone, Debug)]
pub struct Interface {
    /// Names of the numbers that it is shown.
    pub observation: Vec<String>,
    /// What it drives.
    pub action: ActionSpace,
}

impl Interface {
    /// Of a building as it is.
    pub fn of(spaces: &Spaces) -> Self {
        let observation = spaces.observation.slots().iter().map(|slot| slot.name.clone()).collect();
        Self { observation, action: spaces.action.clone() }
    }
}

/// The controllers that need no file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuiltIn {
    /// The reactive controllers: the baseline of every score.
    Reactive,
    /// A uniform action at every step, by the seed.
    Random,
    /// The middle of every bound.
    Constant,
    /// Tries actions on copies of the true simulation; minutes a simulated day.
    Planner,
}

impl BuiltIn {
    const ALL: [Self; 4] = [Self::Reactive, Self::Random, Self::Constant, Self::Planner];
}

impl fmt::Display for BuiltIn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reactive => "reactive",
            Self::Random => "random",
            Self::Constant => "constant",
            Self::Planner => "planner",
        })
    }
}

impl FromStr for BuiltIn {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let named = Self::ALL.into_iter().find(|each| each.to_string() == text);
        named.ok_or_else(|| Error::UnknownPolicy { text: text.to_owned() })
    }
}

impl Policy for BuiltIn {
    fn name(&self) -> String {
        self.to_string()
    }

    fn identity(&self) -> String {
        self.to_string()
    }

    fn is_baseline(&self) -> bool {
        *self == Self::Reactive
    }

    fn drives_all(&self) -> bool {
        matches!(self, Self::Reactive | Self::Planner)
    }

    fn controller(&self, beginning: Beginning<'_>) -> Result<Box<dyn Controller>> {
        let space = &beginning.interface.action;
        Ok(match self {
            Self::Reactive => Box::new(reactive(&beginning)),
            Self::Random => Box::new(Random::new(space, beginning.seed)),
            Self::Constant => Box::new(Constant::middle(space)),
            Self::Planner => Box::new(plan(beginning)?),
        })
    }
}

fn reactive(beginning: &Beginning<'_>) -> Reactive {
    let Beginning { subject, surroundings, spaces, .. } = beginning;
    let parameters = controller_parameters(subject, surroundings);
    Reactive::new(&spaces.building, &spaces.observation, spaces.episode.steps_per_hour, &parameters)
}

/// Plans the whole episode on copies of it, to be carried out afterwards.
fn plan(beginning: Beginning<'_>) -> Result<Replay> {
    let reactive = reactive(&beginning);
    let Beginning { spaces, seed, episode, .. } = beginning;
    let mut planner = Planner::new(PlannerParameters::default(), reactive, seed);
    let actions = planner.plan_episode(episode, spaces.episode_steps(), || {})?;
    Ok(Replay::new(actions, spaces.action.len()))
}
