//! Edits of a prepared model for episodes, whoever controls the building.

use b2b_climate::Site;
use serde_json::json;

use super::make_up_air;
use crate::model::{Fields, Model, text};
use crate::{outputs, sizing};

/// Minimum and maximum number of warm-up days. The warm-up controller is the same for every agent, so their number is
/// part of the environment's definition: 4 almost everywhere (measured on all types in Denver, Miami and Fairbanks), up
/// to 9 for a hall without cooling in summer and for cold zones in Fairbanks.
const WARMUP_DAYS: [u32; 2] = [4, 25];
/// Convergence tolerances of warm-up days: K, and fraction of the loads. The widest that the engine accepts.
const WARMUP_TOLERANCES: [f64; 2] = [0.5, 0.5];

const EXHAUST_FAN: &str = "Fan:ZoneExhaust";
const DAYLIGHT_SAVING: &str = "RunPeriodControl:DaylightSavingTime";

/// What makes up for the air that exhaust fans remove beyond the supply air.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exhaust {
    /// Infiltration, added while the equipment is simulated.
    Balanced,
    /// The same infiltration, in time for the loads of thermostats.
    Predicted,
    /// As the original model specifies.
    AsGiven,
}

/// Makes the edits that every episode needs.
pub(super) fn for_episodes(model: &mut Model, exhaust: Exhaust) {
    outputs::write_only(model, &[]);
    keep_standard_time(model);
    let is_predicted = exhaust == Exhaust::Predicted && make_up_air::predict(model);
    if exhaust != Exhaust::AsGiven && !is_predicted {
        balance_exhaust(model);
    }
    one_system_step(model);
    bound_warmup(model);
    run_weather_alone(model);
}

/// Returns what these edits change in a user's model and its author may not expect.
pub(super) fn changes(model: &Model, site: &Site, exhaust: Exhaust) -> Vec<String> {
    let wants = |field: &str| {
        let yes = |fields: &Fields| text(fields, field).is_none_or(|word| word.eq_ignore_ascii_case("yes"));
        model.objects("RunPeriod").into_iter().any(|(_, fields)| yes(fields))
    };
    let of_file = site.has_daylight_saving && wants("use_weather_file_daylight_saving_period");
    let saving = (of_file || !model.objects(DAYLIGHT_SAVING).is_empty())
        .then(|| "removed daylight saving time: the clock shows standard time all year".to_owned());
    let holidays = (site.holidays > 0 && wants("use_weather_file_holidays_and_special_days")).then(|| {
        format!(
            "the {} holidays of the weather file are ordinary days: give the model {} for its holidays",
            site.holidays, "RunPeriodControl:SpecialDays"
        )
    });
    let balance = (exhaust != Exhaust::AsGiven && !model.objects(EXHAUST_FAN).is_empty()).then(|| {
        "exhaust fans that remove more than the supply air draw the rest through infiltration, not at room temperature"
            .to_owned()
    });
    [saving, holidays, balance].into_iter().flatten().collect()
}

/// Removes daylight saving time, so that the observed clock and the occupants' schedules agree all year without jumps.
fn keep_standard_time(model: &mut Model) {
    model.remove_class(DAYLIGHT_SAVING);
}

/// Balances exhaust fans with infiltration where they exceed the supply air; otherwise the engine makes up the missing
/// air at room temperature, at no cost.
fn balance_exhaust(model: &mut Model) {
    const CLASS: &str = "ZoneAirMassFlowConservation";
    if model.objects(EXHAUST_FAN).is_empty() {
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
