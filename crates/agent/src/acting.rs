//! The meaning of an agent's actions.

use std::str::FromStr;

use b2b_control::{Controller, Reactive, ReactiveParameters};
use b2b_env::{Spaces, rescale, unscale};
use serde::{Deserialize, Serialize};

use crate::supervisor::Supervisor;

/// How an agent's actions, each in [-1, 1], drive the actuators.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Acting {
    /// Actuator values: -1 and 1 are the lower and the upper bound.
    Direct,
    /// Corrections to the action of the reactive controllers.
    Residual {
        /// Largest correction, as a share of an actuator's range.
        authority: f64,
    },
    /// Shifts of what the sequences of Guideline 36 choose ([`b2b_control::guideline36::SupervisoryPoint`]): -1 and 1 are the
    /// limits of a point, 0 is the guideline. The sequences run the equipment at every step.
    Supervisory {
        /// Time for which a decision is held, min.
        every: u32,
        /// Whether all points of a kind have the same shift. A graph network shifts the points of each node.
        #[serde(default = "shared")]
        shared: bool,
    },
}

const fn shared() -> bool {
    true
}

/// A supervisor of all zones alike that decides every hour.
const HOURLY: Acting = Acting::Supervisory { every: 60, shared: true };

impl FromStr for Acting {
    type Err = String;

    /// Parses `direct`, `residual` or `supervisory`, with its number after a colon: `residual:0.5`, `supervisory:30`.
    fn from_str(text: &str) -> Result<Self, String> {
        let unknown = || format!("unknown acting `{text}`; expected direct, residual:0.5 or supervisory:60");
        match text.split_once(':').map_or((text, None), |(kind, number)| (kind, Some(number))) {
            ("direct", None) => Ok(Self::Direct),
            ("residual", number) => {
                let authority = number.unwrap_or("0.5").parse().map_err(|_| unknown())?;
                Ok(Self::Residual { authority })
            }
            ("supervisory", None) => Ok(HOURLY),
            ("supervisory", Some(every)) => {
                Ok(Self::Supervisory { every: every.parse().map_err(|_| unknown())?, shared: true })
            }
            _ => Err(unknown()),
        }
    }
}

impl Acting {
    /// Times for which a decision may be held, min.
    pub const HOLDS: [u32; 3] = [15, 30, 60];

    /// Checks the values, for a number of steps per hour.
    ///
    /// # Errors
    /// What is wrong, and what is allowed.
    pub fn check(self, steps_per_hour: u32) -> Result<(), String> {
        match self {
            Self::Residual { authority } if !(authority > 0.0 && authority <= 1.0) => {
                Err(format!("`authority` is {authority}; expected more than 0, at most 1"))
            }
            Self::Supervisory { every, .. } if !Self::HOLDS.contains(&every) => {
                Err(format!("`acting.every` is {every}; expected 15, 30 or 60 min"))
            }
            Self::Supervisory { every, .. } if !(every * steps_per_hour).is_multiple_of(60) => Err(format!(
                "`acting.every` is {every} min; expected whole steps, of which an hour has {steps_per_hour}"
            )),
            _ => Ok(()),
        }
    }

    /// Returns a description of the base controller; `None` with direct actions.
    pub fn base(self) -> Option<String> {
        match self {
            Self::Direct => None,
            Self::Residual { authority } => Some(format!("reactive controllers, authority {authority}")),
            Self::Supervisory { every, .. } => Some(format!("guideline36, shifted every {every} min")),
        }
    }

    /// Returns whether another controller acts where the agent does not.
    pub fn has_base(self) -> bool {
        self != Self::Direct
    }

    /// Returns whether the agent corrects the reactive controllers, whose action it observes.
    pub fn is_correction(self) -> bool {
        matches!(self, Self::Residual { .. })
    }

    /// Returns whether the agent supervises the sequences of Guideline 36.
    pub fn is_supervision(self) -> bool {
        matches!(self, Self::Supervisory { .. })
    }

    /// Returns the steps for which a decision is held.
    pub fn hold(self, steps_per_hour: u32) -> usize {
        match self {
            Self::Direct | Self::Residual { .. } => 1,
            Self::Supervisory { every, .. } => (every * steps_per_hour / 60).max(1) as usize,
        }
    }
}

/// Converts an agent's actions in an episode to physical units.
#[derive(Clone, Debug)]
pub enum Driver {
    /// Sets or corrects the actuators.
    Actuators(ActuatorDriver),
    /// Supervises the sequences of Guideline 36.
    Supervisor(Box<Supervisor>),
}

impl Driver {
    /// Creates the driver for a building. The reactive controllers use the parameters tuned for the building and the
    /// task. With `by_node`, no two supervisory points share an action.
    pub fn new(acting: Acting, by_node: bool, spaces: &Spaces) -> Self {
        match acting {
            Acting::Supervisory { shared, .. } => {
                Self::Supervisor(Box::new(Supervisor::new(shared && !by_node, spaces)))
            }
            _ => Self::Actuators(ActuatorDriver::new(acting, spaces)),
        }
    }

    /// Returns the supervisor of the sequences of Guideline 36, if the agent is one.
    pub fn supervisor(&self) -> Option<&Supervisor> {
        match self {
            Self::Actuators(_) => None,
            Self::Supervisor(own) => Some(own),
        }
    }

    /// Returns the names of the actions: of the actuators, or of the shifts.
    pub fn names(&self) -> &[String] {
        match self {
            Self::Actuators(own) => &own.names,
            Self::Supervisor(own) => own.names(),
        }
    }

    /// Begins an episode.
    pub fn reset(&mut self) {
        match self {
            Self::Actuators(own) => own.reset(),
            Self::Supervisor(own) => own.reset(),
        }
    }

    /// Takes the next observation of the environment.
    pub fn observe(&mut self, observation: &[f64]) {
        match self {
            Self::Actuators(own) => own.observe(observation),
            Self::Supervisor(own) => own.observe(observation),
        }
    }

    /// Returns the reactive controllers' next action, from -1 to 1, if the agent corrects it; nothing otherwise.
    pub fn base(&self) -> &[f32] {
        match self {
            Self::Actuators(own) => &own.base_row,
            Self::Supervisor(_) => &[],
        }
    }

    /// Returns the action in physical units for an action of the agent in [-1, 1].
    pub fn drive(&mut self, row: &[f32]) -> &[f64] {
        match self {
            Self::Actuators(own) => own.drive(row),
            Self::Supervisor(own) => own.act(row),
        }
    }
}

/// Sets the actuators, or corrects the action of the reactive controllers.
#[derive(Clone, Debug)]
pub struct ActuatorDriver {
    /// Largest correction, as a share of an actuator's range.
    authority: f64,
    names: Vec<String>,
    low: Vec<f64>,
    high: Vec<f64>,
    base: Option<Reactive>,
    /// The base controller's action, in physical units.
    base_action: Vec<f64>,
    /// The base controller's action, scaled to [-1, 1].
    base_row: Vec<f32>,
    action: Vec<f64>,
}

impl ActuatorDriver {
    fn new(acting: Acting, spaces: &Spaces) -> Self {
        let reactive = || {
            let parameters = ReactiveParameters::tuned_for(&spaces.building, &spaces.episode.task);
            let steps_per_hour = spaces.episode.steps_per_hour;
            Reactive::new(&spaces.building, &spaces.observation, steps_per_hour, &parameters)
        };
        let (authority, base) = match acting {
            Acting::Residual { authority } => (authority, Some(reactive())),
            _ => (0.0, None),
        };
        let actuators = spaces.action.len();
        Self {
            authority,
            names: spaces.action.names().to_vec(),
            low: spaces.action.low().to_vec(),
            high: spaces.action.high().to_vec(),
            base_action: spaces.action.middle(),
            base_row: vec![0.0; base.as_ref().map_or(0, |_| actuators)],
            action: vec![0.0; actuators],
            base,
        }
    }

    fn reset(&mut self) {
        if let Some(base) = &mut self.base {
            base.reset();
        }
    }

    fn observe(&mut self, observation: &[f64]) {
        let Some(base) = &mut self.base else { return };
        base.act(observation, &mut self.base_action);
        for (index, row) in self.base_row.iter_mut().enumerate() {
            let (low, high) = (self.low[index], self.high[index]);
            let action = self.base_action[index].clamp(low, high);
            self.base_action[index] = action;
            *row = unscale(action, low, high) as f32;
        }
    }

    fn drive(&mut self, row: &[f32]) -> &[f64] {
        for (index, value) in row.iter().enumerate() {
            let (low, high, value) = (self.low[index], self.high[index], f64::from(value.clamp(-1.0, 1.0)));
            self.action[index] = match self.base {
                None => rescale(value, low, high),
                Some(_) => (self.base_action[index] + value * self.authority * (high - low)).clamp(low, high),
            };
        }
        if let Some(base) = &mut self.base {
            base.follow(&self.action);
        }
        &self.action
    }
}
