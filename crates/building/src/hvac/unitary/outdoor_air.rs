//! Outdoor air of a unit.

use serde_json::json;

use crate::Result;
use crate::hvac::ventilation::Ventilation;
use crate::model::{Model, text};

const CONTROLLER: &str = "Controller:OutdoorAir";

/// The outdoor air mixing upstream of a unit.
pub(super) struct OutdoorAir {
    controller: String,
    pub(super) has_economizer: bool,
}

impl OutdoorAir {
    /// Finds the outdoor air of the unit with this inlet node, if it has any.
    pub(super) fn find(model: &Model, unit_inlet: &str) -> Option<Self> {
        let controllers = model.objects(CONTROLLER);
        let (name, fields) = controllers.iter().find(|(_, fields)| {
            text(fields, "mixed_air_node_name").is_some_and(|node| node.eq_ignore_ascii_case(unit_inlet))
        })?;
        let control = text(fields, "economizer_control_type");
        Some(Self {
            controller: (*name).to_owned(),
            has_economizer: control.is_some_and(|control| !control.eq_ignore_ascii_case("NoEconomizer")),
        })
    }

    /// Makes an economizer follow the supply temperature at `outlet`, lifts the limit on the outdoor air fraction, and
    /// returns the requirements. `fan` is the inlet and the outlet node of the fan.
    pub(super) fn follow(
        &self,
        model: &mut Model,
        air_loop: &str,
        fan: [&str; 2],
        outlet: &str,
        air_density: f64,
    ) -> Result<Ventilation> {
        // Only for an economizer: the heat of the fan is known one iteration late, so that the engine computes the air
        // side about three times.
        if self.has_economizer {
            mix_for_supply_temperature(model, air_loop, fan, outlet);
        }
        // A limit on the outdoor air fraction makes the supply flow collapse where there is an exhaust fan.
        let controller = model.require_mut(CONTROLLER, &self.controller)?;
        controller.remove("maximum_fraction_of_outdoor_air_schedule_name");
        Ventilation::of(model, &self.controller, air_density)?.with_damper(model, &self.controller)
    }
}

/// Gives the mixed air the setpoint of the unit less the heat of the fan, which the economizer follows.
fn mix_for_supply_temperature(
    model: &mut Model,
    air_loop: &str,
    [inlet, fan_outlet]: [&str; 2],
    outlet: &str,
) {
    model.insert(
        "SetpointManager:MixedAir",
        &format!("{} Mixed Air Setpoint", air_loop),
        json!({
            "control_variable": "Temperature",
            "reference_setpoint_node_name": outlet,
            "fan_inlet_node_name": inlet,
            "fan_outlet_node_name": fan_outlet,
            "setpoint_node_or_nodelist_name": inlet,
        }),
    );
}
