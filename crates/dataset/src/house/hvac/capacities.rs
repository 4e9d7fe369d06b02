//! Sizes of a house's equipment.

/// Sizes of a house's equipment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capacities {
    /// Design air flow of fan and terminal, m³/s.
    pub flow: f64,
    /// Gross total cooling at rated conditions, W.
    pub cooling: f64,
    /// Gross heating of the heat pump at 8.3 °C outdoors, W.
    pub heating: f64,
    /// Heat of the furnace or of the backup heater, W.
    pub backup: f64,
}
