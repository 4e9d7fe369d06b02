//! Peak demand, averaged over a step.

use super::Term;
use super::entry::{Column, Display, Entry, Penalty, Total};

/// Only the increase of the peak counts in a step, so that the increases add up to the peak.
pub(super) const ELECTRICITY: Entry = Entry {
    name: "peak_electricity",
    unit: "W/m²",
    of_step: |step| (step.electricity() / step.hours - step.so_far.of(Term::PeakElectricity)).max(0.0),
    total: Total::Sum,
    penalty: Some(Penalty {
        word: "peak",
        doc: "increase in the episode's peak electric demand during the step, W/m²; the increases add up to the peak",
        sum: "peak",
        column: "peak_w_m2",
    }),
    column: Some(Column {
        name: "peak_electricity_w_m2",
        unit: "W/m²",
        divisor: 1.0,
        doc: "peak electric HVAC demand, averaged over a step",
        display: Display::lower("peak electric demand (W/m²)", 1.0, 1),
    }),
    info: None,
};

pub(super) const GAS: Entry = Entry {
    name: "peak_gas",
    unit: "W/m²",
    of_step: |step| step.gas() / step.hours,
    total: Total::Max,
    penalty: None,
    column: Some(Column {
        name: "peak_gas_w_m2",
        unit: "W/m²",
        divisor: 1.0,
        doc: "peak non-electric HVAC demand, averaged over a step",
        display: Display::lower("peak gas demand (W/m²)", 1.0, 1),
    }),
    info: None,
};
