//! Outdoor air of a central air loop.

use crate::hvac::actuator::{Actuator, EngineVariable, Quantity};
use crate::hvac::references::Reference;
use crate::hvac::schedules::constant_schedule;
use crate::model::text;
use crate::{Error, Model, Result};

/// Schedule that is always 0.
const ALWAYS_OFF: &str = "B2B Always Off";

/// Hands outdoor air over to its actuator, without an economizer. The ventilation requirement of the controller is
/// kept: it applies when the actuator is not set, and can be read.
pub(super) fn release(
    model: &mut Model,
    air_loop: &str,
    controller: &str,
    fan_flow: f64,
) -> Result<Actuator> {
    let fields = model.require_mut("Controller:OutdoorAir", controller)?;
    fields.insert("economizer_control_type".into(), "NoEconomizer".into());
    fields.insert("lockout_type".into(), "NoLockout".into());
    let node = text(fields, "actuator_node_name").unwrap_or_default().to_owned();
    Ok(Actuator {
        name: format!("{air_loop} outdoor air flow"),
        quantity: Quantity::OutdoorAirFlow,
        low: 0.0,
        high: fan_flow,
        component: "Outdoor Air Controller".into(),
        control: "Air Mass Flow Rate".into(),
        key: controller.to_owned(),
        scale: 1.0,
        effect: EngineVariable::new("System Node Mass Flow Rate", &node),
        effect_scale: 1.0,
        heat: None,
    })
}

/// Like [`release`], but through a schedule of the minimum outdoor air, for a loop whose zones have exhaust fans. The
/// engine makes up for the air that they remove with outdoor air, but not beyond the value of an actuator of its flow:
/// the missing air would be free.
pub(super) fn schedule(
    model: &mut Model,
    air_loop: &str,
    controller: &str,
    fan_flow: f64,
    air_density: f64,
) -> Result<Actuator> {
    let schedule = format!("{air_loop} Outdoor Air Share");
    constant_schedule(model, &schedule, 0.0);
    let free = release(model, air_loop, controller, fan_flow)?;
    let fields = model.require_mut("Controller:OutdoorAir", controller)?;
    fields.retain(|field, _| {
        !field.contains("fraction_of_outdoor_air")
            && !field.contains("time_of_day")
            && !field.contains("humid")
    });
    let ventilation = text(fields, "mechanical_ventilation_controller_name").map(str::to_owned);
    for limit in ["minimum_outdoor_air_flow_rate", "maximum_outdoor_air_flow_rate"] {
        fields.insert(limit.into(), (fan_flow / air_density).into());
    }
    fields.insert("minimum_limit_type".into(), "FixedMinimum".into());
    fields.insert("minimum_outdoor_air_schedule_name".into(), schedule.clone().into());
    if let Some(name) = ventilation {
        // It is kept so that it can be read, but requests nothing.
        constant_schedule(model, ALWAYS_OFF, 0.0);
        let ventilation = model.require_mut("Controller:MechanicalVentilation", &name)?;
        ventilation.insert("availability_schedule_name".into(), ALWAYS_OFF.into());
    }
    let actuator =
        Actuator::of_schedule(schedule, free.name, free.quantity, [free.low, free.high], free.effect);
    Ok(Actuator { scale: 1.0 / fan_flow, ..actuator })
}

/// Returns the outdoor air controller of an outdoor air system.
pub(super) fn controller(model: &Model, system: &Reference) -> Result<String> {
    let list = text(model.require(&system.class, &system.name)?, "controller_list_name").unwrap_or_default();
    let controllers = model.require("AirLoopHVAC:ControllerList", list)?;
    (1..=8)
        .filter(|i| {
            text(controllers, &format!("controller_{i}_object_type"))
                .is_some_and(|class| class.eq_ignore_ascii_case("Controller:OutdoorAir"))
        })
        .find_map(|i| text(controllers, &format!("controller_{i}_name")))
        .map(str::to_owned)
        .ok_or_else(|| Error::unsupported(&system.class, &system.name, "it has no Controller:OutdoorAir"))
}
