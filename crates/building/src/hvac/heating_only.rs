//! Zones with a heater and no cooling, controlled by the heating setpoint of their thermostat.

use serde::{Deserialize, Serialize};

use super::actuator::{Actuator, EngineVariable, Quantity};
use super::availability::switch_on;
use super::candidate::Candidate;
use super::references::{Reference, parts};
use super::sequence::Sequence;
use super::system::{FromModel, KindName, System, ZoneState};
use super::thermostat::{OUT_OF_REACH, own_thermostat};
use super::zone_equipment::HEATERS;
use crate::model::{Fields, Model, number, text};
use crate::morphology::universe::NodeType;
use crate::{Conditioning, Error, Result};

/// Bounds of the heating setpoint, °C. The lower bound means "off": no heated zone gets so cold.
pub const SETPOINT: (f64, f64) = (5.0, 35.0);

/// A zone heater without cooling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatingOnly {
    /// Zone it serves.
    pub zone: String,
    /// [`Quantity::HeatingSetpoint`].
    pub setpoint: Actuator,
}

impl HeatingOnly {
    /// Number of the actuator of the heating setpoint.
    pub const SETPOINT: usize = 0;
}

impl System for HeatingOnly {
    fn name(&self) -> &str {
        &self.zone
    }

    fn zones(&self) -> Vec<&str> {
        vec![&self.zone]
    }

    fn actuators(&self) -> Vec<&Actuator> {
        vec![&self.setpoint]
    }

    fn conditioning(&self) -> Conditioning {
        Conditioning::Heating
    }

    fn node_type(&self, _: usize) -> NodeType {
        NodeType::HeatingOnlyZone
    }

    fn warm_up(&self, zone: &dyn Fn(usize) -> ZoneState, action: &mut [f64]) {
        action[Self::SETPOINT] = zone(0).target;
    }

    fn sequence(&self) -> Sequence<'_> {
        Sequence::Thermostat
    }
}

impl FromModel for HeatingOnly {
    const NAME: KindName = KindName { id: "heating_only", name: "heater", plural: "heaters" };

    fn claims(_: &Model, candidate: Candidate<'_>) -> Result<bool> {
        Ok(candidate.is_equipment(&HEATERS))
    }

    fn make_controllable(model: &mut Model, candidate: Candidate<'_>, _: f64) -> Result<Self> {
        let (zone, heater) = candidate.equipment()?;
        make_controllable(model, zone, heater)
    }
}

/// Makes the heater of a zone controllable: always available, under a thermostat of the zone's own.
///
/// # Errors
/// [`crate::Error::Unsupported`] when the zone has no thermostat or the heater no capacity;
/// [`crate::Error::MissingObject`] when the heater's parts are not in the model.
pub fn make_controllable(model: &mut Model, zone: &str, heater: &Reference) -> Result<HeatingOnly> {
    refuse_powerless(model, heater)?;
    switch_on(model, heater)?;
    let setpoints = own_thermostat(model, zone, SETPOINT.0, OUT_OF_REACH)?;
    let heat = heat(model, heater)?;
    let effect = EngineVariable::new("Zone Thermostat Heating Setpoint Temperature", zone);
    let label = format!("{zone} heating setpoint");
    let bounds = [SETPOINT.0, SETPOINT.1];
    let setpoint = Actuator::of_schedule(setpoints.heating, label, Quantity::HeatingSetpoint, bounds, effect);
    Ok(HeatingOnly { zone: zone.to_owned(), setpoint: Actuator { heat: Some(heat), ..setpoint } })
}

/// Rejects a heater of zero capacity, as sized for a zone that needs no heat: its setpoint would have no effect.
pub(super) fn refuse_powerless(model: &Model, heater: &Reference) -> Result<()> {
    let fields = model.require(&heater.class, &heater.name)?;
    let has_none = |part: &Reference| model.get(&part.class, &part.name).is_some_and(is_powerless);
    match is_powerless(fields) || parts(fields).iter().any(has_none) {
        true => {
            let why = "its capacity is zero: the zone needs no heat on the design days";
            Err(Error::unsupported(&heater.class, &heater.name, why))
        }
        false => Ok(()),
    }
}

/// Returns whether a heater or a coil is known to give no heat: its capacity is zero however it may be given (in total,
/// per floor area, by U-factor and area), or no hot water flows.
fn is_powerless(fields: &Fields) -> bool {
    let is_capacity = |field: &str| {
        let is_given = field.contains("capacity") || field == "u_factor_times_area_value";
        is_given && !field.starts_with("fraction_of")
    };
    let capacities =
        fields.keys().filter(|field| is_capacity(field)).filter_map(|field| number(fields, field));
    [capacities.reduce(f64::max), number(fields, "maximum_water_flow_rate")]
        .into_iter()
        .flatten()
        .any(|largest| largest <= 0.0)
}

/// Returns the engine variable of a heater's heating rate: its coil's, or its own if it has no coil.
pub(super) fn heat(model: &Model, heater: &Reference) -> Result<EngineVariable> {
    let coil = text(model.require(&heater.class, &heater.name)?, "heating_coil_name");
    Ok(match coil {
        Some(coil) => EngineVariable::new("Heating Coil Heating Rate", coil),
        None => EngineVariable::new("Baseboard Total Heating Rate", &heater.name),
    })
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    const BASEBOARD: &str = "ZoneHVAC:Baseboard:Convective:Electric";
    const UNIT: &str = "ZoneHVAC:UnitHeater";

    fn is_refused(class: &str, heater: Value, coil: Value) -> bool {
        let mut model = Model::default();
        model.insert(class, "H", heater);
        model.insert("Coil:Heating:Water", "C", coil);
        let heater = Reference { class: class.into(), name: "H".into() };
        refuse_powerless(&model, &heater).is_err()
    }

    #[test]
    fn a_heater_or_a_coil_without_capacity_or_hot_water_is_refused() {
        let baseboard = |fields| is_refused(BASEBOARD, fields, json!({}));
        assert!(baseboard(
            json!({"heating_design_capacity": 0, "fraction_of_autosized_heating_design_capacity": 1})
        ));
        assert!(!baseboard(json!({"heating_design_capacity": 900.0})));
        assert!(!baseboard(json!({"heating_design_capacity": "Autosize"})));
        assert!(!baseboard(
            json!({"heating_design_capacity": 0, "heating_design_capacity_per_floor_area": 50})
        ));
        let unit = json!({"heating_coil_object_type": "Coil:Heating:Water", "heating_coil_name": "C"});
        let coil = |fields| is_refused(UNIT, unit.clone(), fields);
        // As the engine sizes a coil without a load.
        assert!(coil(
            json!({"rated_capacity": 0, "u_factor_times_area_value": 1, "maximum_water_flow_rate": 0})
        ));
        assert!(coil(json!({"rated_capacity": 0.0})));
        assert!(!coil(
            json!({"rated_capacity": 0, "u_factor_times_area_value": 300, "maximum_water_flow_rate": 1e-4})
        ));
    }
}
