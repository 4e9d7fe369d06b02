//! Notes on an imported model: what its author should know about how it was read.

use serde::{Deserialize, Serialize};

use super::versions::Conversion;

/// What was found and changed when a model was read and sized.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Notes {
    /// The conversion of a model of another version.
    pub conversion: Option<Conversion>,
    /// The design days for which equipment was sized.
    pub design_days: Option<String>,
    /// Autosized fields that the engine does not size and that were left to it.
    pub left_autosized: Vec<String>,
    /// What may not be as the author expects.
    pub warnings: Vec<String>,
}

impl Notes {
    /// Returns the warnings and a summary of the conversion, a line each.
    pub fn lines(&self) -> impl Iterator<Item = String> + '_ {
        let summary = self.conversion.as_ref().map(|Conversion { from, to, changed, left_out }| {
            let (changed, left_out) = (changed.len(), left_out.len());
            let changes = match (changed, left_out) {
                (0, 0) => "nothing to change".to_owned(),
                _ => format!("{changed} kinds of changes, {left_out} left out; `b2b import` lists them"),
            };
            format!("converted from EnergyPlus {from} to {to}: {changes}")
        });
        self.warnings.iter().cloned().chain(summary)
    }

    /// Returns whether there is nothing to say.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
