//! An action space without some of its actuators: between a policy and the environment, whose building stays as it is.

use std::fmt;

use b2b_building::hvac::Quantity;
use b2b_control::{Controller, Reactive, ReactiveParameters};
use b2b_env::Spaces;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// What is taken away from an action, and what becomes of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Restriction {
    /// Actuators of this quantity are taken away.
    pub without: Quantity,
    /// Who drives them.
    pub left_to: LeftTo,
    /// Where they are pinned, in their unit and within their bounds, if they are.
    pub pin: f64,
}

/// Who drives what is taken away.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeftTo {
    /// The reactive controllers, as if they drove all of the building.
    Reactive,
    /// Nobody: they stay where they are pinned.
    Pin,
}

/// A restriction in a building: makes the action of the kept actuators one of all.
#[derive(Clone, Debug)]
pub struct Restricted {
    kept: Vec<usize>,
    /// Numbers and pins of those that were taken away.
    taken: Vec<(usize, f64)>,
    reactive: Option<Reactive>,
    /// What the reactive controllers would do.
    driven: Vec<f64>,
}

impl Restriction {
    /// The restriction in a building whose reactive controllers have these parameters.
    ///
    /// # Errors
    /// [`Error::Problem`] where nothing is taken away, or everything.
    pub fn within(&self, spaces: &Spaces, parameters: &ReactiveParameters) -> Result<Restricted> {
        let space = &spaces.action;
        let is_taken = |number: &usize| space.quantities()[*number] == self.without;
        let (taken, kept): (Vec<usize>, Vec<usize>) = (0..space.len()).partition(is_taken);
        if taken.is_empty() || kept.is_empty() {
            let (name, which) = (spaces.building.name.clone(), if kept.is_empty() { "all" } else { "no" });
            let why =
                format!("{which} actuator of {name} is taken away: they are {}", space.names().join(", "));
            return Err(Error::Problem { name: self.to_string(), why });
        }
        let pinned = |number: usize| (number, self.pin.clamp(space.low()[number], space.high()[number]));
        let steps_per_hour = spaces.episode.steps_per_hour;
        let reactive = || Reactive::new(&spaces.building, &spaces.observation, steps_per_hour, parameters);
        Ok(Restricted {
            kept,
            taken: taken.into_iter().map(pinned).collect(),
            reactive: (self.left_to == LeftTo::Reactive).then(reactive),
            driven: vec![0.0; space.len()],
        })
    }
}

impl Restricted {
    /// Numbers of the actuators that are left, in the order of the action.
    pub fn kept(&self) -> &[usize] {
        &self.kept
    }

    /// Forgets everything: a new episode begins.
    pub fn reset(&mut self) {
        if let Some(reactive) = &mut self.reactive {
            reactive.reset();
        }
    }

    /// Writes the action of all actuators for one of the kept. Once a step, with the observation before it.
    pub fn complete(&mut self, observation: &[f64], chosen: &[f64], action: &mut [f64]) {
        for (number, value) in self.kept.iter().zip(chosen) {
            action[*number] = *value;
        }
        self.overwrite(observation, action);
    }

    /// Drives what was taken away, whatever a policy wrote there.
    pub(super) fn overwrite(&mut self, observation: &[f64], action: &mut [f64]) {
        match &mut self.reactive {
            Some(reactive) => {
                reactive.act(observation, &mut self.driven);
                self.taken.iter().for_each(|(number, _)| action[*number] = self.driven[*number]);
            }
            None => self.taken.iter().for_each(|(number, pin)| action[*number] = *pin),
        }
    }
}

impl fmt::Display for LeftTo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reactive => "reactive",
            Self::Pin => "pin",
        })
    }
}

impl fmt::Display for Restriction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quantity = serde_json::to_value(self.without).unwrap_or_default();
        write!(f, "without {}", quantity.as_str().unwrap_or_default().replace('_', " "))?;
        match self.left_to {
            LeftTo::Reactive => write!(f, ", which the reactive controllers drive"),
            LeftTo::Pin => write!(f, ", pinned at {} {}", self.pin, self.without.unit()),
        }
    }
}
