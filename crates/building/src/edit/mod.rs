//! Changes to a model: envelope, windows, infiltration, shape and internal gains.
//!
//! The generator of commercial buildings and `b2b edit` make the same changes. The generator calls the functions of the
//! modules on prototypes; [`Edits`] apply to any model: they also check for features that only users' models have, and
//! give the changed surfaces their own constructions.
//!
//! The result depends only on the arguments, to the byte: it takes only arithmetic and square roots, which IEEE 754
//! rounds correctly.

mod change;
mod copies;
mod envelope;
mod equipment;
mod file;
pub mod gains;
pub mod geometry;
pub mod loads;
mod measure;
mod separate;

use serde::Serialize;

pub use change::{Change, Edits};
pub use envelope::{glazing, infiltration, opaque, windows};
pub(crate) use file::names_files_elsewhere;
pub use file::{check_other_file, check_output, edit_file, write_aside};

use crate::{Error, Model, Result};

/// The amount of a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// The new value.
    Value(f64),
    /// A multiple of the value in the model.
    Times(f64),
}

impl Amount {
    /// Returns the new value; `None` for a multiple of an unknown value.
    pub fn of(self, current: Option<f64>) -> Option<f64> {
        match self {
            Self::Value(value) => Some(value),
            Self::Times(factor) => current.map(|current| current * factor),
        }
    }
}

/// The effect of edits on a model.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// The changes, in the order of [`Change::ALL`].
    pub changes: Vec<Effect>,
    /// Parts that the edits leave unchanged, which a user may not expect.
    pub warnings: Vec<String>,
}

/// The effect of one change.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// The change.
    pub change: Change,
    /// The quantity that it changes.
    pub quantity: &'static str,
    /// Unit of the quantity; 1 for a ratio.
    pub unit: &'static str,
    /// The quantity of the building before, for example the mean U-factor; `None` if the model does not give it.
    pub before: Option<f64>,
    /// The quantity afterwards.
    pub after: Option<f64>,
    /// Number of objects that were changed: constructions, windows, zones or loads.
    pub objects: usize,
}

/// Applies edits to a model. On failure the model is not changed.
///
/// # Errors
/// [`Error::Parameter`] for a value out of bounds; [`Error::NothingToChange`] when the model has no object that a
/// change applies to; [`Error::Edit`] naming the object that cannot be changed.
pub fn apply(model: &mut Model, edits: &Edits) -> Result<Report> {
    let mut edited = model.clone();
    let mut counts = Vec::new();
    for change in edits.changes() {
        if let Some(amount) = edits.amount(change) {
            counts.push((change, make(&mut edited, change, amount, edits)?));
        }
    }
    let effect = |(change, objects): (Change, usize)| {
        let (quantity, unit, measure) = measure::quantity(change);
        Effect { change, quantity, unit, before: measure(model), after: measure(&edited), objects }
    };
    let report =
        Report { changes: counts.into_iter().map(effect).collect(), warnings: warnings(&edited, edits) };
    *model = edited;
    Ok(report)
}

/// Makes one change and returns the number of objects that it changed.
fn make(model: &mut Model, change: Change, amount: Amount, edits: &Edits) -> Result<usize> {
    let value = match amount {
        Amount::Value(value) | Amount::Times(value) => value,
    };
    let count = match change {
        // Both axes and the loads at once.
        Change::XScale => stretch(model, value, edits.factor(Change::YScale))?,
        Change::YScale if edits.amount(Change::XScale).is_some() => model.objects("Zone").len(),
        Change::YScale => stretch(model, 1.0, value)?,
        Change::NorthAxis => {
            geometry::require_relative_coordinates(model)?;
            geometry::turn(model, value)
        }
        Change::WallU => {
            separate::walls(model)?;
            opaque::insulate(model, Some(amount), None)?.walls
        }
        Change::RoofU => {
            separate::roofs(model)?;
            opaque::insulate(model, None, Some(amount))?.roofs
        }
        Change::WindowU if edits.amount(Change::WindowShgc).is_none() => {
            glazing::glaze(model, Some(amount), None)?
        }
        Change::WindowU => glazing::glaze(model, Some(amount), edits.value(Change::WindowShgc))?,
        Change::WindowShgc if edits.amount(Change::WindowU).is_some() => glazing::count(model)?,
        Change::WindowShgc => glazing::glaze(model, None, Some(value))?,
        Change::WindowToWall => windows::resize(model, value)?,
        Change::Infiltration => infiltration::scale(model, value),
        Change::People => gains::scale(model, &gains::PEOPLE, value),
        Change::Lights => gains::scale(model, &gains::LIGHTS, value),
        Change::Equipment => gains::scale(model, &gains::EQUIPMENT, value),
    };
    if count == 0 {
        return Err(Error::NothingToChange { change: change.name(), what: change.objects() });
    }
    Ok(count)
}

/// Stretches the building with its loads and returns the number of its zones.
fn stretch(model: &mut Model, x: f64, y: f64) -> Result<usize> {
    geometry::require_stretchable(model, x, y)?;
    geometry::stretch(model, x, y)?;
    loads::scale(model, x * y);
    Ok(model.objects("Zone").len())
}

fn warnings(model: &Model, edits: &Edits) -> Vec<String> {
    let is_made = |change: &Change| edits.amount(*change).is_some();
    let mut warnings = Vec::new();
    if [Change::XScale, Change::YScale].iter().any(is_made) {
        warnings.extend(equipment::keeps_sizes(model));
    }
    if is_made(&Change::Infiltration) && !model.objects("AirflowNetwork:MultiZone:Surface").is_empty() {
        warnings.push("leakage through the surfaces of the AirflowNetwork is not changed".into());
    }
    warnings
}

#[cfg(test)]
mod tests;
