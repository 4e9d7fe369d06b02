//! Forms: observations and actions of one width for buildings of different sizes.

use std::sync::Arc;

use b2b_env::ActionSpace;
use b2b_env::Slot;
use b2b_env::Spaces;
use b2b_env::{Error, Result};
use b2b_env::{RoleObservation, RoleSlot, RoleValue};

/// Gives observations and actions of all buildings the same width.
pub trait Form: Send {
    /// Widths of a row of actions and a row of observations.
    fn widths(&self) -> (usize, usize);

    /// The form of an episode of a building.
    ///
    /// # Errors
    /// If the building does not fit; the environment is then lost.
    fn episode(&mut self, spaces: &Arc<Spaces>) -> Result<Box<dyn EpisodeForm>>;
}

/// The form of one episode.
pub trait EpisodeForm: Send {
    /// Names and bounds of the actuators at the beginning of a row of actions; the rest is padding.
    fn actions(&self) -> &ActionSpace;

    /// The layout of a row of observations.
    fn slots(&self) -> Vec<RowSlot>;

    /// Converts a row of actions to the building's action in physical units, given the observation before the step.
    fn act(&mut self, observation: &[f64], row: &[f64], action: &mut [f64]);

    /// Writes an observation to the whole row.
    fn observe(&self, observation: &[f64], row: &mut [f64]);
}

/// A number in a row of observations.
#[derive(Clone, Debug, PartialEq)]
pub struct RowSlot {
    /// Name, `padding` if it is always 0.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
}

impl RowSlot {
    /// A slot that is always 0.
    pub fn padding() -> Self {
        Self { name: "padding".into(), unit: "1", low: 0.0, high: 0.0 }
    }
}

impl From<&RoleSlot> for RowSlot {
    fn from(slot: &RoleSlot) -> Self {
        Self { name: slot.name.clone(), unit: slot.unit, low: slot.low, high: slot.high }
    }
}

impl From<&Slot> for RowSlot {
    fn from(slot: &Slot) -> Self {
        Self { name: slot.name.clone(), unit: slot.unit, low: slot.low, high: slot.high }
    }
}

/// The arrangement of a building's observation in a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arrangement {
    /// Unchanged. A slot can have different quantities in houses with different zones.
    #[default]
    InOrder,
    /// By the roles of zones in houses (see [`RoleObservation`]); unchanged in other buildings.
    ByRole,
}

/// The arrangement of a building's observations.
#[derive(Clone, Debug)]
pub struct Arranged {
    spaces: Arc<Spaces>,
    roles: Option<RoleObservation>,
}

impl Arrangement {
    /// The arrangement of a building's observations.
    pub fn of(self, spaces: &Arc<Spaces>) -> Arranged {
        let roles = match self {
            Self::InOrder => None,
            Self::ByRole => RoleObservation::of(spaces),
        };
        Arranged { spaces: Arc::clone(spaces), roles }
    }
}

impl Arranged {
    /// Returns the names and bounds of the slots.
    pub fn slots(&self) -> Vec<RowSlot> {
        match &self.roles {
            None => self.spaces.observation.slots().iter().map(RowSlot::from).collect(),
            Some(roles) => roles.slots().iter().map(RowSlot::from).collect(),
        }
    }

    /// The sources of the values of the slots.
    pub fn values(&self) -> Vec<RoleValue> {
        match &self.roles {
            None => (0..self.spaces.observation.len()).map(RoleValue::Slot).collect(),
            Some(roles) => roles.slots().iter().map(|slot| slot.value).collect(),
        }
    }

    /// Returns whether the slots are arranged by the roles of zones.
    pub fn is_by_role(&self) -> bool {
        self.roles.is_some()
    }

    /// Number of slots.
    pub fn width(&self) -> usize {
        self.roles.as_ref().map_or(self.spaces.observation.len(), |roles| roles.slots().len())
    }

    /// Writes an observation, followed by zeros.
    pub fn write(&self, observation: &[f64], row: &mut [f64]) {
        let (values, padding) = row.split_at_mut(self.width());
        match &self.roles {
            None => values.copy_from_slice(observation),
            Some(roles) => roles.write(observation, values),
        }
        padding.fill(0.0);
    }
}

/// The building's vectors, padded with zeros.
#[derive(Clone, Copy, Debug)]
pub struct Padded {
    /// Widths of a row of actions and a row of observations.
    pub widths: (usize, usize),
    /// How observations are arranged.
    pub arrangement: Arrangement,
}

impl Padded {
    /// Returns the form with the widths of the largest of these buildings.
    pub fn fitting<'a>(all: impl IntoIterator<Item = &'a Arc<Spaces>>, arrangement: Arrangement) -> Self {
        let largest = |(actions, observations): (usize, usize), spaces: &Arc<Spaces>| {
            (actions.max(spaces.action.len()), observations.max(arrangement.of(spaces).width()))
        };
        Self { widths: all.into_iter().fold((0, 0), largest), arrangement }
    }
}

impl Form for Padded {
    fn widths(&self) -> (usize, usize) {
        self.widths
    }

    fn episode(&mut self, spaces: &Arc<Spaces>) -> Result<Box<dyn EpisodeForm>> {
        let (actions, observations) = self.widths;
        let arranged = self.arrangement.of(spaces);
        check_width(spaces, "actuators", spaces.action.len(), actions)?;
        check_width(spaces, "observation slots", arranged.width(), observations)?;
        Ok(Box::new(PaddedEpisode { arranged, width: observations }))
    }
}

/// Checks that a building fits into a row of this width.
///
/// # Errors
/// [`Error::TooWide`].
pub fn check_width(spaces: &Spaces, what: &'static str, width: usize, maximum: usize) -> Result<()> {
    let name = || spaces.building.name.clone();
    if width > maximum { Err(Error::TooWide { name: name(), what, width, maximum }) } else { Ok(()) }
}

struct PaddedEpisode {
    arranged: Arranged,
    /// Width of a row of observations.
    width: usize,
}

impl EpisodeForm for PaddedEpisode {
    fn actions(&self) -> &ActionSpace {
        &self.arranged.spaces.action
    }

    fn slots(&self) -> Vec<RowSlot> {
        let slots = self.arranged.slots().into_iter();
        slots.chain(std::iter::repeat_with(RowSlot::padding)).take(self.width).collect()
    }

    fn act(&mut self, _: &[f64], row: &[f64], action: &mut [f64]) {
        action.copy_from_slice(&row[..action.len()]);
    }

    fn observe(&self, observation: &[f64], row: &mut [f64]) {
        self.arranged.write(observation, row);
    }
}
