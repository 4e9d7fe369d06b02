//! Conversions that need other objects or arithmetic. A step names those that it needs; they run before its rules.

mod heat_recovery;
mod sequential_fractions;
mod shading_controls;
mod tables;
mod uncontrolled_terminals;

use serde::Deserialize;

use super::document::Document;
use super::report::Conversion;

/// A conversion that rules of fields cannot express.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Special {
    /// Windows named their shading control; now the control names its windows, of one zone.
    ShadingControls,
    /// Tables of one variable become lookup tables.
    TablesOfOneVariable,
    /// Terminals that were connected directly become terminals of constant volume in a distribution unit.
    UncontrolledTerminals,
    /// Fractions of the load of a zone's equipment become schedules.
    SequentialFractions,
    /// Effectiveness at 75 % of the flow becomes a curve.
    HeatRecoveryEffectiveness,
}

impl Special {
    /// Converts the objects concerned. Returns those that cannot be converted, each with the reason.
    pub fn convert(self, document: &mut Document, version: &str, report: &mut Conversion) -> Vec<String> {
        match self {
            Self::ShadingControls => shading_controls::convert(document, version, report),
            Self::TablesOfOneVariable => tables::convert(document, version, report),
            Self::UncontrolledTerminals => uncontrolled_terminals::convert(document, version, report),
            Self::SequentialFractions => sequential_fractions::convert(document, version, report),
            Self::HeatRecoveryEffectiveness => heat_recovery::convert(document, version, report),
        }
    }
}
