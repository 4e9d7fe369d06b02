//! The changes that a user can make, with their bounds.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::Amount;
use crate::{Error, Parameter, Result};

/// A change of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// Stretch along the building's own x axis.
    XScale,
    /// Stretch along the building's own y axis.
    YScale,
    /// Angle from true north to the building's y axis, clockwise.
    NorthAxis,
    /// U-factor of the exterior walls with the air films of the energy code.
    WallU,
    /// U-factor of the roofs with the air films of the energy code.
    RoofU,
    /// U-factor of the windows and glass doors in walls.
    WindowU,
    /// Solar heat gain coefficient of the windows and glass doors in walls.
    WindowShgc,
    /// Window and glass door area over gross exterior wall area.
    WindowToWall,
    /// Multiplier of all infiltration, except through opened doors.
    Infiltration,
    /// Multiplier of the number of people.
    People,
    /// Multiplier of the power of lights in zones.
    Lights,
    /// Multiplier of the power of equipment in zones: electric, gas, hot water, steam and other.
    Equipment,
}

impl Change {
    /// All changes, in the order in which they are made.
    pub const ALL: [Self; 12] = [
        Self::XScale,
        Self::YScale,
        Self::NorthAxis,
        Self::WallU,
        Self::RoofU,
        Self::WindowU,
        Self::WindowShgc,
        Self::WindowToWall,
        Self::Infiltration,
        Self::People,
        Self::Lights,
        Self::Equipment,
    ];

    /// Returns its name, unit and bounds. The bounds contain every real building; the highest U-factors are near bare
    /// air films.
    pub const fn parameter(self) -> Parameter {
        match self {
            Self::XScale => Parameter::new("x_scale", "1", 0.1, 10.0),
            Self::YScale => Parameter::new("y_scale", "1", 0.1, 10.0),
            Self::NorthAxis => Parameter::new("north_axis", "°", 0.0, 360.0),
            Self::WallU => Parameter::new("wall_u", "W/m²K", 0.03, 6.0),
            Self::RoofU => Parameter::new("roof_u", "W/m²K", 0.03, 6.0),
            Self::WindowU => Parameter::new("window_u", "W/m²K", 0.3, 7.0),
            Self::WindowShgc => Parameter::new("window_shgc", "1", 0.05, 0.90),
            Self::WindowToWall => Parameter::new("window_to_wall", "1", 0.001, 0.95),
            Self::Infiltration => Parameter::new("infiltration", "1", 0.0, 20.0),
            // Without people an area per person would be infinite.
            Self::People => Parameter::new("people", "1", 0.01, 20.0),
            Self::Lights => Parameter::new("lights", "1", 0.0, 20.0),
            Self::Equipment => Parameter::new("equipment", "1", 0.0, 20.0),
        }
    }

    /// Returns its name, for example `wall_u`.
    pub const fn name(self) -> &'static str {
        self.parameter().name
    }

    /// Returns whether its value multiplies the model's value.
    pub fn is_multiplier(self) -> bool {
        matches!(
            self,
            Self::XScale | Self::YScale | Self::Infiltration | Self::People | Self::Lights | Self::Equipment
        )
    }

    /// Returns the objects that it changes, as in "the model has no …".
    pub(super) const fn objects(self) -> &'static str {
        match self {
            Self::XScale | Self::YScale => "zone to stretch",
            Self::NorthAxis => "Building object to turn",
            Self::WallU => "exterior wall to insulate",
            Self::RoofU => "roof to insulate",
            Self::WindowU | Self::WindowShgc => "window or glass door in a wall",
            Self::WindowToWall => "window in an exterior wall to resize",
            Self::Infiltration => "infiltration to scale",
            Self::People => "people to scale",
            Self::Lights => "lights to scale",
            Self::Equipment => "equipment gains to scale",
        }
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Change {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let same = |change: &Self| change.name().eq_ignore_ascii_case(&text.replace('-', "_"));
        Self::ALL.into_iter().find(same).ok_or_else(|| Error::UnknownChange {
            text: text.to_owned(),
            known: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// Changes with their amounts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edits {
    amounts: BTreeMap<Change, Amount>,
}

impl Edits {
    /// Adds a change to this value, or by this factor if it is a multiplier.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the value is out of bounds.
    pub fn set(&mut self, change: Change, value: f64) -> Result<()> {
        change.parameter().check(value)?;
        let amount = if change.is_multiplier() { Amount::Times(value) } else { Amount::Value(value) };
        self.amounts.insert(change, amount);
        Ok(())
    }

    /// Scales the value of each object by a factor. The change must be a U-factor or a multiplier.
    ///
    /// # Panics
    /// If it is neither.
    pub fn multiply(&mut self, change: Change, factor: f64) {
        let is_u = matches!(change, Change::WallU | Change::RoofU | Change::WindowU);
        assert!(is_u || change.is_multiplier(), "{change} cannot be scaled");
        self.amounts.insert(change, Amount::Times(factor));
    }

    /// Returns whether there are no changes.
    pub fn is_empty(&self) -> bool {
        self.amounts.is_empty()
    }

    /// Returns the changes, in the order in which they are made.
    pub fn changes(&self) -> impl Iterator<Item = Change> {
        self.amounts.keys().copied()
    }

    /// Returns the amount of a change; `None` if it is not made.
    pub fn amount(&self, change: Change) -> Option<Amount> {
        self.amounts.get(&change).copied()
    }

    /// Returns the new value that a change sets.
    pub(super) fn value(&self, change: Change) -> Option<f64> {
        self.amount(change).and_then(|amount| amount.of(None))
    }

    /// Returns the factor of a multiplier; 1 if it is not changed.
    pub(super) fn factor(&self, change: Change) -> f64 {
        self.amount(change).and_then(|amount| amount.of(Some(1.0))).unwrap_or(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_read_by_its_name_or_its_option() {
        for change in Change::ALL {
            assert_eq!(change.name().parse::<Change>().unwrap(), change);
            assert_eq!(change.name().replace('_', "-").parse::<Change>().unwrap(), change);
        }
        let error = "wall".parse::<Change>().unwrap_err().to_string();
        assert!(error.contains("`wall`") && error.contains("wall_u"), "{error}");
    }

    #[test]
    fn a_value_out_of_bounds_is_rejected_with_them() {
        let mut edits = Edits::default();
        for (change, value) in [
            (Change::WallU, 0.0),
            (Change::People, 0.0),
            (Change::XScale, f64::NAN),
            (Change::NorthAxis, 400.0),
        ] {
            let error = edits.set(change, value).unwrap_err().to_string();
            assert!(error.contains(change.name()) && error.contains("expected"), "{error}");
        }
        assert!(edits.is_empty());
    }
}
