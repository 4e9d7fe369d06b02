//! Emissions.

use super::entry::{Column, Display, Entry, Penalty, Total};

pub(super) const EMISSIONS: Entry = Entry {
    name: "emissions",
    unit: "g/m²",
    of_step: |step| step.emissions,
    total: Total::Sum,
    penalty: Some(Penalty {
        word: "carbon",
        doc: "its emissions, g CO₂/m²",
        sum: "emissions",
        column: "emissions_g_m2",
    }),
    column: Some(Column {
        name: "emissions_kg_m2",
        unit: "kg/m²",
        divisor: 1000.0,
        doc: "emissions of CO₂ by the task's factors",
        display: Display::lower("emissions (kg CO₂/m²)", 1.0, 2),
    }),
    info: Some("emissions"),
};
