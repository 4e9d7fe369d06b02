//! A restricted action space: some actuators are withheld from the policy's actions, but not from the building.

use std::fmt;
use std::str::FromStr;

use b2b_building::hvac::Quantity;
use b2b_control::{Controller, Reactive, ReactiveParameters};
use b2b_env::Spaces;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// The actuators withheld from an action space, and how they are controlled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Restriction {
    /// Actuators of this quantity are withheld.
    #[serde(rename = "without")]
    pub withheld: Quantity,
    /// Control of the withheld actuators.
    #[serde(rename = "left_to")]
    pub fallback: Fallback,
    /// Value of pinned actuators in their unit, clamped to their bounds.
    pub pin: f64,
}

/// The control of withheld actuators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fallback {
    /// The reactive controllers, as if they controlled the whole building.
    Reactive,
    /// A fixed value.
    Pin,
}

/// A restriction applied to a building: completes the actions of the remaining actuators.
#[derive(Clone, Debug)]
pub struct RestrictedAction {
    kept: Vec<usize>,
    /// Indices and pinned values of the withheld actuators.
    withheld: Vec<(usize, f64)>,
    reactive: Option<Reactive>,
    /// Action of the reactive controllers.
    reactive_action: Vec<f64>,
}

impl Restriction {
    /// Applies the restriction to a building whose reactive controllers have these parameters.
    ///
    /// # Errors
    /// [`Error::Problem`] if it withholds no actuator or all of them.
    pub fn apply(&self, spaces: &Spaces, parameters: &ReactiveParameters) -> Result<RestrictedAction> {
        let space = &spaces.action;
        let is_withheld = |number: &usize| space.quantities()[*number] == self.withheld;
        let (withheld, kept): (Vec<usize>, Vec<usize>) = (0..space.len()).partition(is_withheld);
        if withheld.is_empty() || kept.is_empty() {
            let (name, which) = (spaces.building.name.clone(), if kept.is_empty() { "all" } else { "no" });
            let why = format!("it withholds {which} actuators of {name}: {}", space.names().join(", "));
            return Err(Error::Problem { name: self.to_string(), why });
        }
        let pinned = |number: usize| (number, self.pin.clamp(space.low()[number], space.high()[number]));
        let steps_per_hour = spaces.episode.steps_per_hour;
        let reactive = || Reactive::new(&spaces.building, &spaces.observation, steps_per_hour, parameters);
        Ok(RestrictedAction {
            kept,
            withheld: withheld.into_iter().map(pinned).collect(),
            reactive: (self.fallback == Fallback::Reactive).then(reactive),
            reactive_action: vec![0.0; space.len()],
        })
    }
}

impl RestrictedAction {
    /// Returns the indices of the remaining actuators in the order of the action.
    pub fn kept(&self) -> &[usize] {
        &self.kept
    }

    /// Resets the state for a new episode.
    pub fn reset(&mut self) {
        if let Some(reactive) = &mut self.reactive {
            reactive.reset();
        }
    }

    /// Completes an action of the remaining actuators to all actuators. Called once per step, with the observation
    /// before it.
    pub fn complete(&mut self, observation: &[f64], chosen: &[f64], action: &mut [f64]) {
        for (number, value) in self.kept.iter().zip(chosen) {
            action[*number] = *value;
        }
        self.overwrite(observation, action);
    }

    /// Overwrites the values of the withheld actuators.
    pub fn overwrite(&mut self, observation: &[f64], action: &mut [f64]) {
        match &mut self.reactive {
            Some(reactive) => {
                reactive.act(observation, &mut self.reactive_action);
                self.withheld.iter().for_each(|(number, _)| action[*number] = self.reactive_action[*number]);
            }
            None => self.withheld.iter().for_each(|(number, pin)| action[*number] = *pin),
        }
    }
}

impl fmt::Display for Fallback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reactive => "reactive",
            Self::Pin => "pin",
        })
    }
}

impl FromStr for Fallback {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "reactive" => Ok(Self::Reactive),
            "pin" => Ok(Self::Pin),
            _ => Err(format!("unknown fallback `{text}`; expected reactive or pin")),
        }
    }
}

impl fmt::Display for Restriction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quantity = serde_json::to_value(self.withheld).unwrap_or_default();
        write!(f, "without {}", quantity.as_str().unwrap_or_default().replace('_', " "))?;
        match self.fallback {
            Fallback::Reactive => write!(f, ", controlled by the reactive controllers"),
            Fallback::Pin => write!(f, ", pinned at {} {}", self.pin, self.withheld.unit()),
        }
    }
}
