//! CO₂ in zones, by EnergyPlus's contaminant balance.

use b2b_building::Model;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::Result;
use crate::limits::within;

/// Class of EnergyPlus's contaminant balance.
const BALANCE: &str = "ZoneAirContaminantBalance";
/// Name of the outdoor concentration's schedule.
const OUTDOOR: &str = "Outdoor CO2 of the task";

/// CO₂ in the zones of an operation task: exhaled by people, diluted by outdoor air and infiltration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CarbonDioxide {
    /// Concentration above which the discomfort of indoor air quality (`idis_tot`) accumulates, ppm.
    pub limit: f64,
    /// Outdoor concentration, ppm.
    pub outdoor: f64,
}

impl Default for CarbonDioxide {
    /// 894 ppm, the limit of BOPTEST and the setpoint of Guideline 36 for offices, which assumes 400 ppm outdoors.
    fn default() -> Self {
        Self { limit: 894.0, outdoor: 400.0 }
    }
}

impl CarbonDioxide {
    pub(crate) fn check(self) -> Result<()> {
        within("carbon_dioxide.limit", self.limit, 0.0, 1e5)?;
        within("carbon_dioxide.outdoor", self.outdoor, 0.0, 1e5)
    }

    /// Adds the balance to a model.
    pub(crate) fn turn_on(self, model: &mut Model) {
        model.insert("Schedule:Constant", OUTDOOR, json!({"hourly_value": self.outdoor}));
        let balances = model.names(BALANCE);
        let name = balances.first().map_or("Balance", String::as_str);
        let mut fields = model.get(BALANCE, name).cloned().unwrap_or_default();
        fields.insert("carbon_dioxide_concentration".into(), json!("Yes"));
        fields.insert("outdoor_carbon_dioxide_schedule_name".into(), json!(OUTDOOR));
        model.insert(BALANCE, name, fields.into());
    }
}
