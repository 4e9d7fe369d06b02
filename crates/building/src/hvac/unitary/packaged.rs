//! What a rule-based controller must know of a packaged unit besides its actuators, read while the unit is made
//! controllable.

use serde::{Deserialize, Serialize};

use super::heat_pump::HEATING_COIL;
use super::unit::{Unit, coil};
use crate::Result;
use crate::hvac::zone_equipment::exhaust_flow;
use crate::model::{Model, number};

/// Density (kg/m³) and specific heat (J/(kg K)) of air at rated conditions.
const RATED_AIR_DENSITY: f64 = 1.2;
const AIR_SPECIFIC_HEAT: f64 = 1006.0;
/// Field of the outdoor temperature below which a compressor does not heat, and its default in the engine, °C.
const CUTOFF: &str = "minimum_outdoor_dry_bulb_temperature_for_compressor_operation";
const ENGINE_CUTOFF: f64 = -8.0;

/// A packaged unit and the room that it serves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Packaged {
    /// Whether it has an economizer.
    pub economizer: bool,
    /// Design flow of the exhaust fans in its zone, kg/s. Air that the unit does not supply infiltrates.
    pub exhaust: f64,
    /// Its compressor, if it heats and its size is known.
    pub heat_pump: Option<HeatPump>,
}

/// A compressor that heats.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatPump {
    /// Temperature rise of the rated flow at rated conditions, K.
    pub lift: f64,
    /// Outdoor temperature below which it does not heat, °C.
    pub cutoff: f64,
}

impl Packaged {
    /// Reads a unit of a hard-sized model, before it is rewritten. `air_density`, kg/m³, turns volume flows into mass
    /// flows.
    pub(super) fn of(model: &Model, unit: &Unit, air_density: f64) -> Result<Self> {
        Ok(Self {
            economizer: unit.outdoor_air.as_ref().is_some_and(|air| air.has_economizer),
            exhaust: exhaust_flow(model, std::slice::from_ref(&unit.served.zone))? * air_density,
            heat_pump: HeatPump::of(model, unit)?,
        })
    }
}

impl HeatPump {
    fn of(model: &Model, unit: &Unit) -> Result<Option<Self>> {
        let object = &unit.component.object;
        let heating = coil(model.require(&object.class, &object.name)?, "heating_coil");
        let Some(heating) = heating.filter(|coil| coil.class.eq_ignore_ascii_case(HEATING_COIL)) else {
            return Ok(None);
        };
        let fields = model.require(HEATING_COIL, &heating.name)?;
        let rated =
            ["gross_rated_heating_capacity", "rated_air_flow_rate"].map(|field| number(fields, field));
        // The engine may size a coil of a user's model itself.
        let [Some(capacity), Some(flow)] = rated else { return Ok(None) };
        let cutoff = number(fields, CUTOFF).unwrap_or(ENGINE_CUTOFF);
        Ok(Some(Self { lift: capacity / (flow * RATED_AIR_DENSITY * AIR_SPECIFIC_HEAT), cutoff }))
    }
}
