//! The terms: quantities with one value per step, which accumulate over an episode.
//!
//! [`Term::ALL`] is the list. A term's [`Entry`] says its name and unit, how the value of a step is computed and how it
//! accumulates, whether a task can penalize it, and which column of the metrics it has. Tasks, metrics, results tables,
//! shipped baselines, Python's `info` and docs/tasks.md follow from the list.

mod amounts;
mod cost;
#[cfg(test)]
mod docs;
mod emissions;
mod end_uses;
mod energy;
mod entry;
mod peak;
mod resource;
mod term_metrics;

use b2b_building::EndUse;

pub use amounts::{Amounts, Totals};
pub use entry::{Column, Display, Entry, Measured, Penalty};
pub use resource::{RESOURCES, Resource};
pub use term_metrics::TermMetrics;

/// Declares the terms and their order, which is the order of their columns.
macro_rules! terms {
    ($($(#[$doc:meta])* $term:ident: $entry:path;)*) => {
        /// A quantity with one value per step.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Term {
            $($(#[$doc])* $term,)*
        }

        impl Term {
            /// All terms, in the order of [`Amounts`].
            pub const ALL: [Self; [$(stringify!($term)),*].len()] = [$(Self::$term),*];

            /// Returns the definition.
            pub const fn entry(self) -> &'static Entry {
                match self {
                    $(Self::$term => &$entry,)*
                }
            }
        }
    };
}

terms! {
    /// HVAC energy, Wh/m².
    Energy: energy::ENERGY;
    /// HVAC electricity, Wh/m².
    Electricity: energy::ELECTRICITY;
    /// Non-electric HVAC energy: gas, other fuels and district energy, Wh/m².
    Gas: energy::GAS;
    /// Energy cost at the task's prices, currency/m².
    Cost: cost::COST;
    /// Emissions by the task's factors, g CO₂/m².
    Emissions: emissions::EMISSIONS;
    /// Increase of the episode's peak electric demand, W/m²; over an episode, the peak.
    PeakElectricity: peak::ELECTRICITY;
    /// Non-electric HVAC demand, W/m²; over an episode, its peak.
    PeakGas: peak::GAS;
    /// HVAC energy for heating, Wh/m².
    Heating: end_uses::HEATING;
    /// HVAC energy for cooling, Wh/m².
    Cooling: end_uses::COOLING;
    /// HVAC energy of fans, Wh/m².
    Fans: end_uses::FANS;
    /// HVAC energy of pumps, Wh/m².
    Pumps: end_uses::PUMPS;
    /// HVAC energy of cooling towers and fluid coolers, Wh/m².
    HeatRejection: end_uses::HEAT_REJECTION;
    /// HVAC energy of heat recovery, Wh/m².
    HeatRecovery: end_uses::HEAT_RECOVERY;
    /// HVAC energy of humidifiers, Wh/m².
    Humidification: end_uses::HUMIDIFICATION;
}

/// Number of terms.
pub const TERMS: usize = Term::ALL.len();

/// Number of terms that Python's `info` has.
pub const IN_INFO: usize = {
    let (mut count, mut index) = (0, 0);
    while index < TERMS {
        count += Term::ALL[index].entry().info.is_some() as usize;
        index += 1;
    }
    count
};

impl Term {
    /// The end uses of HVAC energy.
    pub const END_USES: [Self; EndUse::ALL.len()] = [
        Self::Heating,
        Self::Cooling,
        Self::Fans,
        Self::Pumps,
        Self::HeatRejection,
        Self::HeatRecovery,
        Self::Humidification,
    ];

    /// Returns the terms that Python's `info` has, in order.
    pub fn in_info() -> impl Iterator<Item = (Self, &'static str)> {
        Self::ALL.into_iter().filter_map(|term| Some((term, term.entry().info?)))
    }
}
