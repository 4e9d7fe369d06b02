//! Energy cost.

use super::entry::{Column, Display, Entry, Penalty, Total};

pub(super) const COST: Entry = Entry {
    name: "cost",
    unit: "currency/m²",
    of_step: |step| step.cost,
    total: Total::Sum,
    penalty: Some(Penalty { word: "cost", doc: "its cost, currency/m²", sum: "cost", column: "cost_m2" }),
    column: Some(Column {
        name: "cost_m2",
        unit: "currency/m²",
        divisor: 1.0,
        doc: "energy cost at the task's prices",
        display: Display::lower("cost at the task's prices (per m²)", 1.0, 2),
    }),
    info: Some("cost"),
};
