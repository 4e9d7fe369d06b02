//! Parameters of the guideline's sequences, with bounds and units. Many defaults are the guideline's figures.

use std::path::Path;

use b2b_building::parameter::Field;
use serde::{Deserialize, Serialize};

use super::trim_respond::Guideline36Reset;
use super::zone::{LoopGains, ZoneRules};
use crate::Result;
use crate::parameter_set::{self, parameter};

/// Parameters of the controller `guideline36`. Four settings are ablations: `air_loop.supply_temperature_reset` 0,
/// `air_loop.min_flow` 0.3, `optimum_start` 0 and `setback` 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Guideline36Parameters {
    /// Longest optimum start, h; 0 to 6, 0 turns it off. 5.4.6.
    pub optimum_start: f64,
    /// Whether setpoints are relaxed in unoccupied hours, 0 or 1.
    pub setback: f64,
    /// Level of demand limiting, 0 to 3. 5.3.2.6.
    pub demand_level: f64,
    /// Parameters of units of a single zone.
    pub unitary: Guideline36UnitaryParameters,
    /// Parameters of central air loops.
    pub air_loop: Guideline36AirLoopParameters,
}

/// Parameters of units of a single zone (5.18, 5.22).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Guideline36UnitaryParameters {
    /// Gains of the zone loops.
    pub gains: LoopGains,
    /// Distance above the heating setpoint at which the heating loop aims, K; 0 to 1.
    pub heating_margin: f64,
    /// Distance below the cooling setpoint at which the cooling loop aims, K; 0 to 1.
    pub cooling_margin: f64,
    /// Minimum flow while the fan runs, as a share of the design flow; 0.05 to 1. Coils need about 0.2.
    pub min_flow: f64,
    /// Largest flow in heating before the supply air gets hotter than its normal limit, as a share of the design flow;
    /// 0.05 to 1. The guideline's default is half of the cooling flow; with heat pumps, more air of a lower temperature
    /// saves energy.
    pub heating_flow: f64,
    /// Supply air temperature above the heating setpoint up to which flow is not raised, K; 0 to 30. 11 K mixes well.
    pub heating_lift: f64,
    /// The same with a heat pump, K; 0 to 30. Its efficiency grows with the flow: in a small office in January, 7
    /// instead of 11 K saves 3 % of energy, while 4 K saves no more.
    pub heat_pump_lift: f64,
    /// Supply air temperature in cooling down to which flow is not raised, °C; 10 to 20.
    pub cooling_temperature: f64,
}

/// Parameters of central air loops (5.6, 5.16).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Guideline36AirLoopParameters {
    /// Gains of the zone loops.
    pub gains: LoopGains,
    /// Distance above the heating setpoint at which the heating loop aims, K; 0 to 1.
    pub heating_margin: f64,
    /// Distance below the cooling setpoint at which the cooling loop aims, K; 0 to 1.
    pub cooling_margin: f64,
    /// Minimum flow of a terminal in occupied mode, as a share of its design flow; 0 to 1. Raised to what
    /// ventilation needs.
    pub min_flow: f64,
    /// Largest flow of a terminal that reheats (Vheat-max), as a share of its design flow; 0 to 1.
    pub heating_flow: f64,
    /// Lowest supply air temperature (Min_ClgSAT), °C; 5 to 20.
    pub min_supply_temperature: f64,
    /// Highest supply air temperature in cooling (Max_ClgSAT), °C; 10 to 30. At most 16 °C in climate zones 0A to 4A.
    pub max_supply_temperature: f64,
    /// Whether the supply air temperature is reset, 0 or 1; it is the lowest otherwise.
    pub supply_temperature_reset: f64,
    /// Temperature rise across the fan at its design flow, K; 0 to 5.
    pub fan_rise: f64,
    /// Reset of the supply air temperature by requests.
    pub trim_respond: Guideline36Reset,
}

impl Default for Guideline36Parameters {
    fn default() -> Self {
        Self {
            optimum_start: 3.0,
            setback: 1.0,
            demand_level: 0.0,
            unitary: Guideline36UnitaryParameters::default(),
            air_loop: Guideline36AirLoopParameters::default(),
        }
    }
}

impl Default for Guideline36UnitaryParameters {
    fn default() -> Self {
        Self {
            gains: LoopGains::UNIT,
            heating_margin: 0.03,
            cooling_margin: 0.03,
            min_flow: 0.2,
            heating_flow: 1.0,
            heating_lift: 11.0,
            heat_pump_lift: 7.0,
            cooling_temperature: 13.0,
        }
    }
}

impl Default for Guideline36AirLoopParameters {
    fn default() -> Self {
        Self {
            gains: LoopGains::TERMINAL,
            heating_margin: 0.05,
            cooling_margin: 0.05,
            min_flow: 0.0,
            heating_flow: 0.5,
            min_supply_temperature: 12.0,
            max_supply_temperature: 18.0,
            supply_temperature_reset: 1.0,
            fan_rise: 1.0,
            trim_respond: Guideline36Reset::default(),
        }
    }
}

impl Guideline36Parameters {
    /// All parameters. A name is the JSON keys joined by dots.
    pub const TABLE: [Field<Self>; 27] = [
        parameter!(optimum_start, "h", 0.0, 6.0),
        parameter!(setback, "1", 0.0, 1.0),
        parameter!(demand_level, "1", 0.0, 3.0),
        parameter!(unitary.gains.proportional, "1/K", 0.001, 10.0),
        parameter!(unitary.gains.integral_time, "s", 60.0, 100_000.0),
        parameter!(unitary.heating_margin, "K", 0.0, 1.0),
        parameter!(unitary.cooling_margin, "K", 0.0, 1.0),
        parameter!(unitary.min_flow, "1", 0.05, 1.0),
        parameter!(unitary.heating_flow, "1", 0.05, 1.0),
        parameter!(unitary.heating_lift, "K", 0.0, 30.0),
        parameter!(unitary.heat_pump_lift, "K", 0.0, 30.0),
        parameter!(unitary.cooling_temperature, "°C", 10.0, 20.0),
        parameter!(air_loop.gains.proportional, "1/K", 0.001, 10.0),
        parameter!(air_loop.gains.integral_time, "s", 60.0, 100_000.0),
        parameter!(air_loop.heating_margin, "K", 0.0, 1.0),
        parameter!(air_loop.cooling_margin, "K", 0.0, 1.0),
        parameter!(air_loop.min_flow, "1", 0.0, 1.0),
        parameter!(air_loop.heating_flow, "1", 0.0, 1.0),
        parameter!(air_loop.min_supply_temperature, "°C", 5.0, 20.0),
        parameter!(air_loop.max_supply_temperature, "°C", 10.0, 30.0),
        parameter!(air_loop.supply_temperature_reset, "1", 0.0, 1.0),
        parameter!(air_loop.fan_rise, "K", 0.0, 5.0),
        parameter!(air_loop.trim_respond.delay, "h", 0.0, 24.0),
        parameter!(air_loop.trim_respond.ignored_requests, "1", 0.0, 100.0),
        parameter!(air_loop.trim_respond.trim, "K/h", 0.0, 100.0),
        parameter!(air_loop.trim_respond.respond, "K/h", 0.0, 100.0),
        parameter!(air_loop.trim_respond.max_respond, "K/h", 0.0, 100.0),
    ];

    /// Sets a parameter by its name in [`Guideline36Parameters::TABLE`]; [`Guideline36Parameters::check`] checks its
    /// value.
    ///
    /// # Errors
    /// [`Error::UnknownParameter`](crate::Error::UnknownParameter).
    pub fn set(&mut self, name: &str, value: f64) -> Result<()> {
        parameter_set::set(self, &Self::TABLE, "guideline36", name, value)
    }

    /// Reads parameters from a JSON file; omitted fields keep their defaults.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io); [`Error::ParameterFile`](crate::Error::ParameterFile) with the reason; the
    /// errors of [`Guideline36Parameters::check`].
    pub fn read(path: &Path) -> Result<Self> {
        let parameters: Self = parameter_set::read(path)?;
        parameters.check()?;
        Ok(parameters)
    }

    /// Checks that every value is within the bounds of its parameter, and the minimum supply air temperature at most
    /// the maximum.
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) for the first that is not.
    pub fn check(&self) -> Result<()> {
        let Guideline36AirLoopParameters { min_supply_temperature, max_supply_temperature, .. } =
            self.air_loop;
        parameter_set::check(self, &Self::TABLE, [min_supply_temperature, max_supply_temperature])
    }

    /// Returns the rules of zones, without the margins of a system.
    pub(super) fn zone_rules(&self, gains: LoopGains) -> ZoneRules {
        let setback = self.setback >= 0.5;
        ZoneRules { gains: [gains; 2], margins: [0.0; 2], optimum_start: self.optimum_start, setback }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of all numbers in a JSON object, keys joined by dots.
    fn names(value: &serde_json::Value, level: &str, found: &mut Vec<String>) {
        match value.as_object() {
            Some(object) => object.iter().for_each(|(key, value)| {
                names(value, [level, key].join(".").trim_start_matches('.'), found);
            }),
            None => found.push(level.to_owned()),
        }
    }

    #[test]
    fn every_number_has_bounds_and_the_defaults_are_within() {
        let mut found = Vec::new();
        names(&serde_json::to_value(Guideline36Parameters::default()).unwrap(), "", &mut found);
        found.sort();
        let mut known: Vec<_> =
            Guideline36Parameters::TABLE.iter().map(|field| field.parameter.name).collect();
        known.sort_unstable();
        assert_eq!(found, known);
        Guideline36Parameters::default().check().unwrap();
    }

    #[test]
    fn a_parameter_sets_the_field_of_its_name() {
        for field in Guideline36Parameters::TABLE {
            let mut parameters = Guideline36Parameters::default();
            parameters.set(field.parameter.name, field.parameter.low).unwrap();
            let json = serde_json::to_value(&parameters).unwrap();
            let pointer = format!("/{}", field.parameter.name.replace('.', "/"));
            assert_eq!(json.pointer(&pointer).unwrap(), field.parameter.low, "{pointer}");
        }
        let said = Guideline36Parameters::default().set("margins", 0.1).unwrap_err().to_string();
        assert!(
            said.contains("`margins` of guideline36") && said.contains("unitary.heating_margin"),
            "{said}"
        );
    }

    #[test]
    fn supply_temperatures_that_cross_are_rejected() {
        let mut crossed = Guideline36Parameters::default();
        crossed.air_loop.min_supply_temperature = 19.0;
        assert!(crossed.check().unwrap_err().to_string().contains("min_supply_temperature"));
    }
}
