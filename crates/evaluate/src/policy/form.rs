//! Forms of observations that policies expect.

use std::fmt;
use std::str::FromStr;

use b2b_control::Controller;
use b2b_env::{Decisions, RoleObservation, Spaces};
use serde::{Deserialize, Serialize};

use super::interface::{EpisodeContext, Policy, PolicyInterface};
use crate::Result;

/// How observations of houses with different numbers of zones are brought to one width.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HouseForm {
    /// A slot and a presence flag for every zone role ([`RoleObservation`]), so that a slot means the same in every
    /// house.
    #[default]
    Roles,
    /// Zones in model order followed by zeros, as in the paper. The meaning of a slot differs between houses.
    Raw,
}

impl HouseForm {
    /// Returns whether it is the form by roles.
    pub fn is_roles(&self) -> bool {
        *self == Self::Roles
    }
}

impl fmt::Display for HouseForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Roles => "roles",
            Self::Raw => "raw",
        })
    }
}

impl FromStr for HouseForm {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "roles" => Ok(Self::Roles),
            "raw" => Ok(Self::Raw),
            _ => Err(format!("unknown form `{text}`; expected roles or raw")),
        }
    }
}

/// The form of the observations of one building.
#[derive(Clone, Debug, PartialEq)]
pub enum PolicyForm {
    /// Unchanged, followed by zeros.
    Raw {
        /// Number of zeros.
        padding: usize,
    },
    /// By the roles of zones.
    Roles(RoleObservation),
}

impl PolicyForm {
    /// Returns the form with this width for a policy; `default` if the width is unknown or no form has it. In a house,
    /// [`RoleObservation::WIDTH`] means the form by roles, and any other width that holds the observation means padding
    /// with zeros.
    pub fn of_width(spaces: &Spaces, width: Option<usize>, default: Self) -> Self {
        let slots = spaces.observation.len();
        match (RoleObservation::of(spaces), width) {
            (Some(roles), Some(RoleObservation::WIDTH)) => Self::Roles(roles),
            (Some(_), Some(width)) if width >= slots => Self::Raw { padding: width - slots },
            _ => default,
        }
    }

    /// Returns the number of values.
    pub fn width(&self, spaces: &Spaces) -> usize {
        match self {
            Self::Roles(_) => RoleObservation::WIDTH,
            Self::Raw { padding } => spaces.observation.len() + padding,
        }
    }

    /// Returns the names of the values.
    pub fn names(&self, spaces: &Spaces) -> Vec<String> {
        match self {
            Self::Roles(roles) => roles.slots().iter().map(|slot| slot.name.clone()).collect(),
            Self::Raw { padding } => {
                let slots = spaces.observation.slots().iter().map(|slot| slot.name.clone());
                slots.chain((0..*padding).map(|_| "padding".to_owned())).collect()
            }
        }
    }

    /// Writes an observation in this form to the beginning of a row that is already filled with zeros.
    pub fn write(&self, observation: &[f64], row: &mut [f64]) {
        match self {
            Self::Roles(roles) => roles.write(observation, row),
            Self::Raw { .. } => row[..observation.len()].copy_from_slice(observation),
        }
    }
}

/// Makes the controller of a policy for the whole building, with observations in the form that the policy expects.
pub fn controller(policy: &dyn Policy, context: EpisodeContext<'_>) -> Result<Box<dyn Controller>> {
    let spaces = context.spaces;
    let form = PolicyForm::of_width(spaces, policy.observation_width(), PolicyForm::Raw { padding: 0 });
    if form == (PolicyForm::Raw { padding: 0 }) {
        return policy.controller(context);
    }
    let interface =
        PolicyInterface { observation: form.names(spaces), action: context.interface.action.clone() };
    let row = vec![0.0; interface.observation.len()];
    let inner = policy.controller(EpisodeContext { interface: &interface, ..context })?;
    Ok(Box::new(FormedController { inner, form, row }))
}

/// A controller behind a form.
struct FormedController {
    inner: Box<dyn Controller>,
    form: PolicyForm,
    row: Vec<f64>,
}

impl Controller for FormedController {
    fn reset(&mut self) {
        self.inner.reset();
    }

    fn next_episode(&mut self) {
        self.inner.next_episode();
    }

    fn reward(&mut self, reward: f64) {
        self.inner.reward(reward);
    }

    fn record(&self) -> Option<&Decisions> {
        self.inner.record()
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        self.form.write(observation, &mut self.row);
        self.inner.act(&self.row, action);
    }
}
