//! Supported equipment of central air loops.

pub(super) const OUTDOOR_AIR_SYSTEM: &str = "AirLoopHVAC:OutdoorAirSystem";
pub(super) const DX_COOLING: &str = "CoilSystem:Cooling:DX";
pub(super) const COOLING: [&str; 3] =
    [DX_COOLING, "Coil:Cooling:Water", "Coil:Cooling:Water:DetailedGeometry"];
pub(super) const WATER_HEATING: &str = "Coil:Heating:Water";
pub(super) const HEATING: [&str; 3] = ["Coil:Heating:Fuel", "Coil:Heating:Electric", WATER_HEATING];
/// Variable-flow fans, each with the field of its design flow.
pub(super) const FANS: [(&str, &str); 2] =
    [("Fan:VariableVolume", "maximum_flow_rate"), ("Fan:SystemModel", "design_maximum_air_flow_rate")];
/// Specific heat of air, J/(kg K).
pub(super) const AIR_SPECIFIC_HEAT: f64 = 1006.0;
