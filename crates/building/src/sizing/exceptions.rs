//! Fields whose size the engine reports under another description, and fields that it does not size.
//!
//! Found by sizing the 32 models that ship with EnergyPlus 25.2, the models of Sinergym, and models that OpenStudio writes.

/// Fields whose size is reported under another description, without `Design Size`. A description applies to the sizes of
/// the same object only.
pub(super) const ALIASES: &[(&str, &str)] = &[
    // Unitary heat pumps, furnaces and packaged units name the flows by operation.
    ("cooling_supply_air_flow_rate", "Supply Air Flow Rate During Cooling Operation"),
    ("heating_supply_air_flow_rate", "Supply Air Flow Rate During Heating Operation"),
    ("no_load_supply_air_flow_rate", "Supply Air Flow Rate When No Cooling or Heating is Needed"),
    ("cooling_outdoor_air_flow_rate", "Outdoor Air Flow Rate During Cooling Operation"),
    ("heating_outdoor_air_flow_rate", "Outdoor Air Flow Rate During Heating Operation"),
    ("no_load_outdoor_air_flow_rate", "Outdoor Air Flow Rate When No Cooling or Heating is Needed"),
    ("maximum_supply_air_temperature", "Maximum Supply Air Temperature from Supplemental Heater"),
    // Water-to-air heat pump coils leave "Gross" out.
    ("gross_rated_total_cooling_capacity", "Rated Total Cooling Capacity"),
    ("gross_rated_sensible_cooling_capacity", "Rated Sensible Cooling Capacity"),
    ("gross_rated_heating_capacity", "Rated Heating Capacity"),
    // Multi-speed coils too.
    ("speed_1_gross_rated_sensible_heat_ratio", "Speed 1 Rated Sensible Heat Ratio"),
    ("speed_2_gross_rated_sensible_heat_ratio", "Speed 2 Rated Sensible Heat Ratio"),
    ("speed_3_gross_rated_sensible_heat_ratio", "Speed 3 Rated Sensible Heat Ratio"),
    ("speed_4_gross_rated_sensible_heat_ratio", "Speed 4 Rated Sensible Heat Ratio"),
    // Terminals, fan coils and unit heaters with water or steam coils.
    ("maximum_hot_water_or_steam_flow_rate", "Maximum Reheat Water Flow Rate"),
    ("maximum_hot_water_or_steam_flow_rate", "Maximum Reheat Steam Flow Rate"),
    ("maximum_hot_water_or_steam_flow_rate", "Maximum Hot Water Flow"),
    ("maximum_hot_water_or_steam_flow_rate", "Maximum Steam Flow"),
    ("maximum_hot_water_flow_rate", "Maximum Hot Water Flow"),
    ("maximum_cold_water_flow_rate", "Maximum Cold Water Flow"),
    // The high-temperature radiant heater reports the size of an autosized capacity as `User-Specified`.
    ("heating_design_capacity", "User-Specified heating_design_capacity"),
    // Plant.
    ("total_design_flow_rate", "Design Flow Rate"),
    ("design_maximum_flow_rate", "Design Flow Rate"),
    ("design_heat_recovery_water_flow_rate", "Heat Recovery Water Flow Rate"),
    ("design_condenser_fluid_flow_rate", "Design Condenser Water Flow Rate"),
    ("loop_demand_side_design_flow_rate", "Loop Demand Side Design Fluid Flow Rate"),
    ("loop_supply_side_design_flow_rate", "Loop Supply Side Design Fluid Flow Rate"),
    ("design_fan_power", "Fan Power at Design Air Flow Rate"),
    ("design_u_factor_times_area_value", "U-Factor Times Area Value at Design Air Flow Rate"),
    ("free_convection_regime_u_factor_times_area_value", "Free Convection U-Factor Times Area Value"),
    ("high_fan_speed_air_flow_rate", "Air Flow Rate at High Fan Speed"),
    ("high_fan_speed_fan_power", "Fan Power at High Fan Speed"),
    ("high_fan_speed_u_factor_times_area_value", "U-Factor Times Area Value at High Fan Speed"),
    ("low_fan_speed_air_flow_rate", "Air Flow Rate at Low Fan Speed"),
    ("low_fan_speed_fan_power", "Fan Power at Low Fan Speed"),
    ("low_fan_speed_u_factor_times_area_value", "U-Factor Times Area Value at Low Fan Speed"),
    // Evaporative coolers.
    ("recirculating_water_pump_design_power", "Recirculating Pump Power"),
    ("secondary_air_fan_design_power", "Secondary Fan Power"),
];

/// An autosized field that the engine gives no size because the object does not use it.
pub(super) struct Unused {
    /// Class, or a prefix of several classes.
    pub(super) class: &'static str,
    /// The end of the field's name.
    pub(super) field: &'static str,
    /// The value to write; it has no effect.
    pub(super) value: f64,
    /// The field and its value with which the object does use it.
    pub(super) used_with: Option<(&'static str, &'static str)>,
}

impl Unused {
    const fn new(class: &'static str, field: &'static str, value: f64) -> Self {
        Self { class, field, value, used_with: None }
    }

    const fn unless(self, used_with: (&'static str, &'static str)) -> Self {
        Self { used_with: Some(used_with), ..self }
    }
}

/// Fields without effect that must still hold a number.
pub(super) const UNUSED: &[Unused] = &[
    // The defrost is by reverse cycle; a resistive one is sized and reported.
    Unused::new("Coil:Heating:DX:", "resistive_defrost_heater_capacity", 0.0),
    // The reheat coil is electric or burns gas; the flow of a water or steam coil is reported.
    Unused::new("AirTerminal:SingleDuct:VAV:Reheat", "maximum_hot_water_or_steam_flow_rate", 0.0),
    Unused::new("AirTerminal:SingleDuct:ParallelPIU:Reheat", "maximum_hot_water_or_steam_flow_rate", 0.0),
    Unused::new("AirTerminal:SingleDuct:SeriesPIU:Reheat", "maximum_hot_water_or_steam_flow_rate", 0.0),
    // The same for a unit heater, whose input must be more than zero.
    Unused::new("ZoneHVAC:UnitHeater", "maximum_hot_water_or_steam_flow_rate", 1e-3),
    // The condenser is cooled by air, as in most models that OpenStudio writes. The flow must be more than zero.
    Unused::new("Coil:Cooling:DX:", "evaporative_condenser_air_flow_rate", 1e-3).unless(EVAPORATIVE),
    Unused::new("Coil:Cooling:DX:", "evaporative_condenser_pump_rated_power_consumption", 0.0)
        .unless(EVAPORATIVE),
    // Only the sizing of a tower reads them.
    Unused::new("CoolingTower:", "design_approach_temperature", 3.9),
    Unused::new("CoolingTower:", "design_range_temperature", 5.6),
    // No loop on the source side.
    Unused::new("WaterHeater:", "source_side_design_flow_rate", 0.0),
];

const EVAPORATIVE: (&str, &str) = ("condenser_type", "EvaporativelyCooled");

/// Fields that the engine sizes when a model omits them. A hard-sized model must have them.
pub(super) const OPTIONAL: [(&str, &str); 3] = [
    ("Coil:Heating:Water", "maximum_water_flow_rate"),
    ("Coil:Heating:Water", "rated_capacity"),
    ("Coil:Heating:Water", "u_factor_times_area_value"),
];

/// Fields that the engine may size to zero but that must be positive: a unit heater and its fan in a zone that needs no
/// heat.
pub(super) const POSITIVE: [(&str, &str, f64); 4] = [
    ("ZoneHVAC:UnitHeater", "maximum_supply_air_flow_rate", 1e-3),
    ("Fan:ConstantVolume", "maximum_flow_rate", 1e-3),
    ("Fan:OnOff", "maximum_flow_rate", 1e-3),
    ("Fan:SystemModel", "design_maximum_air_flow_rate", 1e-3),
];
