//! HVAC energy.

use super::entry::{Column, Display, Entry, Penalty, Total};
use super::{Term, Totals};

/// Electricity and all other energy bought for HVAC. The total is their sum, so that it follows from a table's columns.
pub(super) const ENERGY: Entry = Entry {
    name: "energy",
    unit: "Wh/m²",
    of_step: |step| step.electricity() + step.gas(),
    total: Total::Of(|totals: &Totals| totals.of(Term::Electricity) + totals.of(Term::Gas)),
    penalty: Some(Penalty {
        word: "energy",
        doc: "HVAC energy of the step, Wh/m² of conditioned floor, as in the paper",
        sum: "energy",
        column: "energy_wh_m2",
    }),
    column: None,
    info: None,
};

pub(super) const ELECTRICITY: Entry = Entry {
    name: "electricity",
    unit: "Wh/m²",
    of_step: |step| step.electricity(),
    total: Total::Sum,
    penalty: None,
    column: Some(Column {
        name: "electricity_wh_m2",
        unit: "Wh/m²",
        divisor: 1.0,
        doc: "HVAC electricity",
        display: Display::lower("HVAC electricity (kWh/m²)", 1e-3, 2),
    }),
    info: None,
};

pub(super) const GAS: Entry = Entry {
    name: "gas",
    unit: "Wh/m²",
    of_step: |step| step.gas(),
    total: Total::Sum,
    penalty: None,
    column: Some(Column {
        name: "gas_wh_m2",
        unit: "Wh/m²",
        divisor: 1.0,
        doc: "non-electric HVAC energy: gas, other fuels and district energy",
        display: Display::lower("HVAC non-electric (kWh/m²)", 1e-3, 2),
    }),
    info: None,
};
