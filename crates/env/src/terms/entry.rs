//! The definition of a term.

use b2b_building::{CarrierEnergy, EndUseEnergy};

use super::{Amounts, Totals};

/// The definition of a [`Term`](super::Term).
#[derive(Debug)]
pub struct Entry {
    /// Name in the records of episodes.
    pub name: &'static str,
    /// Unit of a step's value.
    pub unit: &'static str,
    /// Computes the value of a step. Called on every step: it must not allocate.
    pub of_step: fn(&Measured<'_>) -> f64,
    /// How the values of steps accumulate over an episode.
    pub total: Total,
    /// How a task penalizes it; `None` if no task can.
    pub penalty: Option<Penalty>,
    /// Its column in the metrics of an episode.
    pub column: Option<Column>,
    /// Key in Python's `info` of a step.
    pub info: Option<&'static str>,
}

/// Inputs of the terms of a step.
#[derive(Debug)]
pub struct Measured<'a> {
    /// HVAC energy of the step, Wh/m².
    pub energy: &'a CarrierEnergy,
    /// The same by end use. Losses of a building's transformer are only in `energy`.
    pub end_uses: &'a EndUseEnergy,
    /// Cost by the task's tariff, or else at its prices, currency/m².
    pub cost: f64,
    /// Emissions by the task's profile, or else by its factors, g CO₂/m².
    pub emissions: f64,
    /// Length of the step, h.
    pub hours: f64,
    /// The episode before the step.
    pub so_far: &'a Totals,
}

/// How the values of steps accumulate over an episode.
#[derive(Clone, Copy, Debug)]
pub enum Total {
    /// Their sum. Returns follow from sums, so a term with a [`Penalty`] must use this, or [`Total::Of`] such terms.
    Sum,
    /// The largest of them.
    Max,
    /// Follows from the totals of other terms.
    Of(fn(&Totals) -> f64),
}

/// How a task penalizes a term: its weight over its scale, times the value of the step.
#[derive(Debug)]
pub struct Penalty {
    /// Word in tasks: `cost` in `occupancy+cost2` and in `"resource": "cost"`.
    pub word: &'static str,
    /// Description in the list of docs/tasks.md, with the unit.
    pub doc: &'static str,
    /// Name of its sum over an episode, where the sums of baselines are kept.
    pub sum: &'static str,
    /// Column of that sum in the table of shipped baselines.
    pub column: &'static str,
}

/// A column of the metrics of an episode.
#[derive(Debug)]
pub struct Column {
    /// Name in tables, summaries and Python.
    pub name: &'static str,
    /// Unit; `1` where there is none.
    pub unit: &'static str,
    /// Units of the total in a unit of the column.
    pub divisor: f64,
    /// Description.
    pub doc: &'static str,
    /// How `b2b compare` shows it, if it does.
    pub display: Option<Display>,
}

/// How a metric is shown in a comparison of runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Name with the unit in which it is shown.
    pub label: &'static str,
    /// Factor from the unit of the column.
    pub scale: f64,
    /// Digits after the decimal point.
    pub decimals: usize,
    /// Whether higher is better; `None` if neither.
    pub higher_is_better: Option<bool>,
}

impl Display {
    /// A metric where lower is better.
    pub(crate) const fn lower(label: &'static str, scale: f64, decimals: usize) -> Option<Self> {
        Some(Self { label, scale, decimals, higher_is_better: Some(false) })
    }
}

impl Measured<'_> {
    /// HVAC electricity of the step, Wh/m².
    pub fn electricity(&self) -> f64 {
        self.energy[0]
    }

    /// Non-electric HVAC energy of the step: gas, other fuels and district energy, Wh/m².
    pub fn gas(&self) -> f64 {
        self.energy[1..].iter().sum()
    }

    /// Computes all terms.
    pub(crate) fn amounts(&self) -> Amounts {
        Amounts::of(|term| (term.entry().of_step)(self))
    }
}
