//! Edits of a prepared model for episodes, whoever controls the building.

use serde_json::json;

use crate::model::Model;
use crate::{outputs, sizing};

/// Minimum and maximum number of warm-up days. The warm-up controller is the same for every agent, so their number is
/// part of the environment's definition: 4 almost everywhere (measured on all types in Denver, Miami and Fairbanks), up
/// to 9 for a hall without cooling in summer and for cold zones in Fairbanks.
const WARMUP_DAYS: [u32; 2] = [4, 25];
/// Convergence tolerances of warm-up days: K, and fraction of the loads. The widest that the engine accepts.
const WARMUP_TOLERANCES: [f64; 2] = [0.5, 0.5];

/// Makes the edits that every episode needs.
pub(super) fn for_episodes(model: &mut Model) {
    outputs::write_only(model, &[]);
    keep_standard_time(model);
    balance_exhaust(model);
    one_system_step(model);
    bound_warmup(model);
    run_weather_alone(model);
}

/// Removes daylight saving time, so that the observed clock and the occupants' schedules agree all year without jumps.
fn keep_standard_time(model: &mut Model) {
    model.remove_class("RunPeriodControl:DaylightSavingTime");
}

/// Balances exhaust fans by infiltration where they exceed the supply air; otherwise the engine makes up the missing air
/// at room temperature, at no cost.
fn balance_exhaust(model: &mut Model) {
    const CLASS: &str = "ZoneAirMassFlowConservation";
    if model.objects("Fan:ZoneExhaust").is_empty() {
        return;
    }
    model.remove_class(CLASS);
    model.insert(
        CLASS,
        "Mass balance",
        json!({
            "adjust_zone_mixing_and_return_for_air_mass_flow_balance": "None",
            "infiltration_balancing_method": "AddInfiltrationFlow",
            "infiltration_balancing_zones": "AllZones",
        }),
    );
}

/// Forces one system time step per zone time step. The engine could otherwise divide a zone time step to reach its
/// tolerances. The number of iterations is the engine's default: some prototypes allow 5, which sudden actions exceed.
fn one_system_step(model: &mut Model) {
    model.remove_class("ConvergenceLimits");
    model.insert(
        "ConvergenceLimits",
        "One system step",
        json!({"minimum_system_timestep": 60, "maximum_hvac_iterations": 20}),
    );
}

/// Simulates the run period, which some models disable, and not the design days.
fn run_weather_alone(model: &mut Model) {
    let control = sizing::simulation_control(model);
    control.insert("run_simulation_for_weather_file_run_periods".into(), json!("Yes"));
    control.insert("run_simulation_for_sizing_periods".into(), json!("No"));
}

fn bound_warmup(model: &mut Model) {
    for name in model.names("Building") {
        if let Some(building) = model.get_mut("Building", &name) {
            building.insert("minimum_number_of_warmup_days".into(), json!(WARMUP_DAYS[0]));
            building.insert("maximum_number_of_warmup_days".into(), json!(WARMUP_DAYS[1]));
            building.insert("temperature_convergence_tolerance_value".into(), json!(WARMUP_TOLERANCES[0]));
            building.insert("loads_convergence_tolerance_value".into(), json!(WARMUP_TOLERANCES[1]));
        }
    }
}
