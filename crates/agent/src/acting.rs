//! The meaning of an agent's actions.

use std::str::FromStr;

use b2b_building::morphology::Owner;
use b2b_control::guideline36::Shift;
use b2b_control::{Controller, Reactive, ReactiveParameters};
use b2b_env::{Spaces, rescale, unscale};
use serde::{Deserialize, Serialize};

use crate::shifted_targets::ShiftedTargets;
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
    /// Shifts of the targets that the reactive controllers follow. The controllers run the equipment at every step.
    /// Their integral terms undo corrections, but not shifts.
    Targets {
        /// Time for which a decision is held, min.
        every: u32,
        /// Shift for -1 and 1, K.
        shift: f64,
    },
    /// Shifts of what the sequences of Guideline 36 choose ([`b2b_control::guideline36::SupervisoryPoint`]): -1 and 1
    /// are the limits of a point, 0 is the guideline. The sequences run the equipment at every step.
    Supervisory {
        /// Time for which a decision is held, min.
        every: u32,
        /// Whether all points of a kind have the same shift. A graph network ignores this and shifts the points of each
        /// node.
        #[serde(default = "yes")]
        shared: bool,
        /// Whether setpoints and start times are shifted, too.
        #[serde(default = "yes", skip_serializing_if = "Clone::clone")]
        setpoints: bool,
        /// Whether 0 is the shift by `linear-supervisor`'s rule for the building's type, to which the action is added,
        /// instead of the guideline.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        rule: bool,
    },
}

const fn yes() -> bool {
    true
}

/// Supervision decided every hour, with the same shifts for all zones.
const HOURLY: Acting = Acting::Supervisory { every: 60, shared: true, setpoints: true, rule: false };

/// Shifts of targets by at most a kelvin, decided every hour.
const HOURLY_TARGETS: Acting = Acting::Targets { every: 60, shift: 1.0 };

impl FromStr for Acting {
    type Err = String;

    /// Parses `direct`, `residual`, `targets` or `supervisory`. A number may follow a colon, except for `direct`:
    /// `residual:0.5`, `targets:30`, `supervisory:30`.
    fn from_str(text: &str) -> Result<Self, String> {
        let unknown = || {
            format!("unknown acting `{text}`; expected direct, residual:0.5, targets:60 or supervisory:60")
        };
        let every = |number: &str| number.parse().map_err(|_| unknown());
        match text.split_once(':').map_or((text, None), |(kind, number)| (kind, Some(number))) {
            ("direct", None) => Ok(Self::Direct),
            ("residual", number) => {
                let authority = number.unwrap_or("0.5").parse().map_err(|_| unknown())?;
                Ok(Self::Residual { authority })
            }
            ("supervisory", None) => Ok(HOURLY),
            ("supervisory", Some(number)) => {
                Ok(Self::Supervisory { every: every(number)?, shared: true, setpoints: true, rule: false })
            }
            ("targets", None) => Ok(HOURLY_TARGETS),
            ("targets", Some(number)) => Ok(Self::Targets { every: every(number)?, shift: 1.0 }),
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
    /// The value that is wrong, and what is allowed.
    pub fn check(self, steps_per_hour: u32) -> Result<(), String> {
        match self {
            Self::Residual { authority } if !(authority > 0.0 && authority <= 1.0) => {
                Err(format!("`acting.authority` is {authority}; expected more than 0, at most 1"))
            }
            Self::Targets { shift, .. } if !(shift > 0.0 && shift <= LARGEST_SHIFT) => {
                Err(format!("`acting.shift` is {shift}; expected more than 0, at most {LARGEST_SHIFT} K"))
            }
            Self::Supervisory { every, .. } | Self::Targets { every, .. } => {
                check_hold(every, steps_per_hour)
            }
            _ => Ok(()),
        }
    }

    /// Returns a description of the base controller; `None` with direct actions.
    pub fn base(self) -> Option<String> {
        match self {
            Self::Direct => None,
            Self::Residual { authority } => Some(format!("reactive controllers, authority {authority}")),
            Self::Targets { every, shift } => {
                Some(format!("reactive controllers, targets shifted every {every} min by at most {shift} K"))
            }
            Self::Supervisory { every, setpoints, rule, .. } => {
                let base = if rule { "linear-supervisor" } else { "guideline36" };
                let but = if setpoints { "" } else { ", except setpoints and start times" };
                Some(format!("{base}, shifted every {every} min{but}"))
            }
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

    /// Returns whether the agent supervises them from the rules of `linear-supervisor`.
    pub fn starts_from_rule(self) -> bool {
        matches!(self, Self::Supervisory { rule: true, .. })
    }

    /// Returns whether the agent sets a kind of shift.
    pub fn sets(self, shift: Shift) -> bool {
        match self {
            Self::Supervisory { setpoints, .. } => setpoints || !Shift::ZONE.contains(&shift),
            _ => false,
        }
    }

    /// Returns the owner of each action of a flat network that sets or corrects actuators or shifts targets.
    pub fn owners(self, spaces: &Spaces) -> Vec<Owner> {
        match self {
            Self::Targets { .. } => spaces.controlled_zones().map(Owner::Zone).collect(),
            _ => spaces.action.owners().to_vec(),
        }
    }

    /// Returns the number of steps for which a decision is held.
    pub fn hold(self, steps_per_hour: u32) -> usize {
        match self {
            Self::Direct | Self::Residual { .. } => 1,
            Self::Supervisory { every, .. } | Self::Targets { every, .. } => {
                (every * steps_per_hour / 60).max(1) as usize
            }
        }
    }
}

/// Largest shift of a target, K.
const LARGEST_SHIFT: f64 = 5.0;

/// Checks the time for which a decision is held, min.
fn check_hold(every: u32, steps_per_hour: u32) -> Result<(), String> {
    if !Acting::HOLDS.contains(&every) {
        return Err(format!("`acting.every` is {every}; expected 15, 30 or 60 min"));
    }
    match (every * steps_per_hour).is_multiple_of(60) {
        true => Ok(()),
        false => Err(format!(
            "`acting.every` is {every} min; expected a whole number of steps, {steps_per_hour} per hour"
        )),
    }
}

/// Converts an agent's actions in an episode to physical units.
#[derive(Clone, Debug)]
pub enum Driver {
    /// Sets or corrects the actuators.
    Actuators(ActuatorDriver),
    /// Shifts the targets of the reactive controllers.
    Targets(Box<ShiftedTargets>),
    /// Supervises the sequences of Guideline 36.
    Supervisor(Box<Supervisor>),
}

impl Driver {
    /// Creates the driver for a building. The reactive controllers use the parameters tuned for the building and the
    /// task. With `by_node`, no two supervisory points share an action.
    pub fn new(acting: Acting, by_node: bool, spaces: &Spaces) -> Self {
        match acting {
            Acting::Supervisory { .. } => {
                Self::Supervisor(Box::new(Supervisor::new(acting, by_node, spaces)))
            }
            Acting::Targets { shift, .. } => Self::Targets(Box::new(ShiftedTargets::new(shift, spaces))),
            _ => Self::Actuators(ActuatorDriver::new(acting, spaces)),
        }
    }

    /// Returns the supervisor of the sequences of Guideline 36, if the agent is one.
    pub fn supervisor(&self) -> Option<&Supervisor> {
        match self {
            Self::Supervisor(own) => Some(own),
            _ => None,
        }
    }

    /// Returns the names of the actions: of the actuators, or of the shifts.
    pub fn names(&self) -> &[String] {
        match self {
            Self::Actuators(own) => &own.names,
            Self::Targets(own) => own.names(),
            Self::Supervisor(own) => own.names(),
        }
    }

    /// Begins an episode.
    pub fn reset(&mut self) {
        match self {
            Self::Actuators(own) => own.reset(),
            Self::Targets(own) => own.reset(),
            Self::Supervisor(own) => own.reset(),
        }
    }

    /// Takes the next observation of the environment.
    pub fn observe(&mut self, observation: &[f64]) {
        match self {
            Self::Actuators(own) => own.observe(observation),
            Self::Targets(own) => own.observe(observation),
            Self::Supervisor(own) => own.observe(observation),
        }
    }

    /// Returns the reactive controllers' next action, from -1 to 1, if the agent corrects it; otherwise, an empty
    /// slice.
    pub fn base(&self) -> &[f32] {
        match self {
            Self::Actuators(own) => &own.base_row,
            _ => &[],
        }
    }

    /// Returns the action in physical units for an action of the agent in [-1, 1].
    pub fn drive(&mut self, row: &[f32]) -> &[f64] {
        match self {
            Self::Actuators(own) => own.drive(row),
            Self::Targets(own) => own.act(row),
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
