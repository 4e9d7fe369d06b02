//! The control interface of a building: what an agent sets.

use std::str::FromStr;

use b2b_building::Controls;
use serde::{Deserialize, Serialize};

use crate::{BuildingName, Error, Result};

/// What an agent sets in a building.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Control {
    /// The actuators of its systems; in a user's model, the setpoints of zones whose equipment has none.
    #[default]
    Actuators,
    /// The heating and the cooling setpoint of every zone. The equipment follows by its own controls.
    Setpoints,
}

impl Control {
    /// Its name on the command line and in Python.
    pub fn name(self) -> &'static str {
        match self {
            Self::Actuators => "actuators",
            Self::Setpoints => "setpoints",
        }
    }

    /// Returns the name of a building with this interface, for example `OfficeSmall+setpoints`.
    pub fn name_of(self, building: &BuildingName) -> String {
        format!("{building}{}", self.suffix())
    }

    /// Returns the name of a building without its interface, and the interface.
    pub fn split_name(name: &str) -> (&str, Self) {
        match name.strip_suffix(Self::Setpoints.suffix()) {
            Some(building) => (building, Self::Setpoints),
            None => (name, Self::Actuators),
        }
    }

    /// Returns the suffix of the names of buildings with this interface.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Actuators => "",
            Self::Setpoints => Controls::SETPOINTS_SUFFIX,
        }
    }
}

impl From<Control> for Controls {
    fn from(control: Control) -> Self {
        match control {
            Control::Actuators => Self::Actuators,
            Control::Setpoints => Self::Setpoints,
        }
    }
}

impl FromStr for Control {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let known = [Self::Actuators, Self::Setpoints].into_iter().find(|control| control.name() == text);
        known.ok_or_else(|| Error::Control { text: text.to_owned() })
    }
}
