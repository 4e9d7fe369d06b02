//! The guideline controller without one of its sequences, to measure what that saves.

use std::collections::BTreeMap;

use b2b_control::{Case, Controller, KindDescription};
use serde_json::Value;

use super::built_in::BuiltIn;
use super::interface::{EpisodeContext, Policy};
use crate::Result;

/// The guideline controller with one parameter changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ablation {
    /// The supply air temperature of central air handlers is always the lowest.
    FixedSupplyTemperature,
    /// Terminals open to at least 30 % while people are present.
    MinimumFlow,
    /// Zones start to recover when the band changes.
    NoOptimumStart,
    /// The band of occupied hours holds day and night.
    NoSetback,
}

impl Ablation {
    /// All ablations.
    pub const ALL: [Self; 4] =
        [Self::FixedSupplyTemperature, Self::MinimumFlow, Self::NoOptimumStart, Self::NoSetback];

    /// Returns a name for tables and folders.
    pub fn label(self) -> &'static str {
        match self {
            Self::FixedSupplyTemperature => "fixed supply temperature",
            Self::MinimumFlow => "minimum flow of 30 %",
            Self::NoOptimumStart => "no optimum start",
            Self::NoSetback => "no setback",
        }
    }

    /// Returns the parameter with its value.
    fn change(self) -> (&'static str, f64) {
        match self {
            Self::FixedSupplyTemperature => ("air_loop.supply_temperature_reset", 0.0),
            Self::MinimumFlow => ("air_loop.min_flow", 0.3),
            Self::NoOptimumStart => ("optimum_start", 0.0),
            Self::NoSetback => ("setback", 0.0),
        }
    }

    /// Returns the parameters of the guideline controller in an episode.
    fn values(self, context: &EpisodeContext<'_>) -> Result<Value> {
        let (kind, spaces) = (BuiltIn::guideline36().kind(), context.spaces);
        let values = kind.tuned(&spaces.building, &spaces.episode.task);
        let (parameter, value) = self.change();
        Ok(kind.changed(values, &BTreeMap::from([(parameter.to_owned(), value)]))?)
    }
}

impl Policy for Ablation {
    fn name(&self) -> String {
        format!("{}, {}", BuiltIn::guideline36(), self.label())
    }

    fn identity(&self) -> String {
        let (parameter, value) = self.change();
        format!("{} {parameter}={value}", BuiltIn::guideline36())
    }

    fn ignores_interface(&self) -> bool {
        true
    }

    fn description(&self, context: &EpisodeContext<'_>) -> Result<Option<Value>> {
        let (name, seed, values) = (BuiltIn::guideline36().to_string(), context.seed, self.values(context)?);
        Ok(Some(KindDescription { name, seed, values }.to_order()))
    }

    fn controller(&self, context: EpisodeContext<'_>) -> Result<Box<dyn Controller>> {
        let values = self.values(&context)?;
        let EpisodeContext { spaces, interface, seed, .. } = context;
        let case = Case { spaces, action: &interface.action, seed, values: &values };
        Ok(BuiltIn::guideline36().kind().make(&case)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ablation_changes_one_parameter_of_the_guideline_controller() {
        let kind = BuiltIn::guideline36().kind();
        for ablation in Ablation::ALL {
            let (parameter, value) = ablation.change();
            let changes = BTreeMap::from([(parameter.to_owned(), value)]);
            assert_ne!(kind.changed(kind.defaults(), &changes).unwrap(), kind.defaults(), "{ablation:?}");
            assert!(!ablation.is_baseline(&"operate".parse().unwrap()));
        }
    }
}
