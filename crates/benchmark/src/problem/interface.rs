//! What a problem shows a policy of an environment, and what it lets it drive.

use b2b_building::Description;
use b2b_building::morphology::{COMMON, Morphology};
use b2b_control::Controller;

use super::restriction::Restricted;
use super::{Attributes, Problem, Side};
use crate::baseline::controller_parameters;
use crate::policy::{Beginning, Interface, Policy};
use crate::problem::LeftTo;
use crate::subject::hex;
use crate::{Error, Result};

/// A policy as one side of a problem lets it see and act.
pub struct Through<'a> {
    policy: &'a dyn Policy,
    problem: &'a Problem,
    side: &'a Side,
}

impl<'a> Through<'a> {
    /// A policy on a side of a problem.
    pub fn new(policy: &'a dyn Policy, problem: &'a Problem, side: &'a Side) -> Self {
        Self { policy, problem, side }
    }

    /// Common attributes of the building, in the order of [`COMMON`]; 0 for what is not known.
    fn attributes(&self, beginning: &Beginning<'_>) -> Result<Vec<f64>> {
        if self.problem.protocol.attributes == Attributes::Withheld {
            return Ok(Vec::new());
        }
        let Beginning { subject, spaces, .. } = beginning;
        let origin = subject.placement.origin(&subject.name);
        let description = Description::of(&spaces.building, &spaces.episode.weather, origin)?;
        let known = |value: f64| if value.is_finite() { value } else { 0.0 };
        Ok(Morphology::of(&spaces.building, &description).common_attributes.into_iter().map(known).collect())
    }

    /// Zeros behind an observation of so many slots.
    fn padding(&self, slots: usize) -> Result<usize> {
        let Some(width) = self.problem.protocol.observation_width else { return Ok(0) };
        width.checked_sub(slots).ok_or_else(|| Error::Problem {
            name: self.problem.name.clone(),
            why: format!("an observation has {slots} slots, more than observation_width, {width}"),
        })
    }
}

impl Policy for Through<'_> {
    fn name(&self) -> String {
        self.policy.name()
    }

    fn identity(&self) -> String {
        let about = (
            &self.side.restriction,
            self.problem.protocol.attributes,
            self.problem.protocol.observation_width,
        );
        let about = serde_json::to_vec(&about).unwrap_or_default();
        format!("{}, interface {}", self.policy.identity(), &hex(&about)[..16])
    }

    fn is_baseline(&self) -> bool {
        let pinned = self.side.restriction.is_some_and(|restriction| restriction.left_to == LeftTo::Pin);
        self.policy.is_baseline() && !pinned
    }

    fn controller(&self, beginning: Beginning<'_>) -> Result<Box<dyn Controller>> {
        let Beginning { subject, surroundings, spaces, seed, .. } = beginning;
        let parameters = controller_parameters(subject, surroundings);
        let restricted = self.side.restriction.map(|each| each.within(spaces, &parameters)).transpose()?;
        let attributes = self.attributes(&beginning)?;
        let slots = spaces.observation.slots();
        let padding = self.padding(slots.len())?;
        let action = match &restricted {
            Some(restricted) => spaces.action.select(restricted.kept()),
            None => spaces.action.clone(),
        };
        if let Some(building_type) = subject.name.building_type()
            && let Some(why) = self.side.misfit(building_type, spaces, action.len())
        {
            return Err(Error::Problem { name: self.problem.name.clone(), why });
        }
        let given = COMMON.iter().take(attributes.len()).map(|slot| attribute_name(slot.quantity));
        let interface = Interface {
            observation: slots
                .iter()
                .map(|slot| slot.name.clone())
                .chain((0..padding).map(|_| "padding".to_owned()))
                .chain(given)
                .collect(),
            action,
        };
        let mut seen = vec![0.0; slots.len() + padding];
        seen.extend(attributes);
        let (whole, chosen) = (self.policy.drives_all(), vec![0.0; interface.action.len()]);
        if whole && restricted.is_some() && !self.policy.is_baseline() {
            let why = format!("{} drives all actuators or none", self.policy.name());
            return Err(Error::Problem { name: self.problem.name.clone(), why });
        }
        let inner = self.policy.controller(Beginning {
            subject,
            surroundings,
            spaces,
            interface: &interface,
            seed,
            ..beginning
        })?;
        Ok(Box::new(Shown { inner, whole, restricted, seen, chosen }))
    }
}

/// A controller behind an interface.
struct Shown {
    inner: Box<dyn Controller>,
    /// Whether it sees and drives the building itself; what is taken away is overwritten.
    whole: bool,
    restricted: Option<Restricted>,
    /// What it is shown: the observation, zeros, attributes.
    seen: Vec<f64>,
    chosen: Vec<f64>,
}

impl Controller for Shown {
    fn reset(&mut self) {
        self.inner.reset();
        if let Some(restricted) = &mut self.restricted {
            restricted.reset();
        }
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        if self.whole {
            self.inner.act(observation, action);
            if let Some(restricted) = &mut self.restricted {
                restricted.overwrite(observation, action);
            }
            return;
        }
        self.seen[..observation.len()].copy_from_slice(observation);
        match &mut self.restricted {
            None => self.inner.act(&self.seen, action),
            Some(restricted) => {
                self.inner.act(&self.seen, &mut self.chosen);
                restricted.complete(observation, &self.chosen, action);
            }
        }
    }
}

fn attribute_name(attribute: b2b_building::morphology::Attribute) -> String {
    let name = serde_json::to_value(attribute).unwrap_or_default();
    format!("building {}", name.as_str().unwrap_or_default())
}
