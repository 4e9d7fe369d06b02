//! HVAC energy by end use.

use b2b_building::EndUse;

use super::entry::{Column, Display, Entry, Measured, Total};

pub(super) const HEATING: Entry = entry(
    "heating",
    "heating_wh_m2",
    "HVAC energy for heating, all carriers",
    "heating energy (kWh/m²)",
    |step| of(step, EndUse::Heating),
);
pub(super) const COOLING: Entry = entry(
    "cooling",
    "cooling_wh_m2",
    "HVAC energy for cooling, all carriers",
    "cooling energy (kWh/m²)",
    |step| of(step, EndUse::Cooling),
);
pub(super) const FANS: Entry =
    entry("fans", "fans_wh_m2", "HVAC energy of fans", "fan energy (kWh/m²)", |step| of(step, EndUse::Fans));
pub(super) const PUMPS: Entry =
    entry("pumps", "pumps_wh_m2", "HVAC energy of pumps", "pump energy (kWh/m²)", |step| {
        of(step, EndUse::Pumps)
    });
pub(super) const HEAT_REJECTION: Entry = entry(
    "heat_rejection",
    "heat_rejection_wh_m2",
    "HVAC energy of cooling towers and fluid coolers",
    "heat rejection energy (kWh/m²)",
    |step| of(step, EndUse::HeatRejection),
);
pub(super) const HEAT_RECOVERY: Entry = entry(
    "heat_recovery",
    "heat_recovery_wh_m2",
    "HVAC energy of heat recovery: wheels and pumps",
    "heat recovery energy (kWh/m²)",
    |step| of(step, EndUse::HeatRecovery),
);
pub(super) const HUMIDIFICATION: Entry = entry(
    "humidification",
    "humidification_wh_m2",
    "HVAC energy of humidifiers",
    "humidification energy (kWh/m²)",
    |step| of(step, EndUse::Humidification),
);

const fn entry(
    name: &'static str,
    column: &'static str,
    doc: &'static str,
    label: &'static str,
    of_step: fn(&Measured<'_>) -> f64,
) -> Entry {
    let column =
        Column { name: column, unit: "Wh/m²", divisor: 1.0, doc, display: Display::lower(label, 1e-3, 2) };
    let column = Some(column);
    Entry { name, unit: "Wh/m²", of_step, total: Total::Sum, penalty: None, column, info: None }
}

fn of(step: &Measured<'_>, end_use: EndUse) -> f64 {
    step.end_uses[end_use as usize]
}
