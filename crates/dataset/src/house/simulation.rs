//! Simulation settings: site, run period and time step.

use b2b_building::{Model, UNNAMED_HOUSE};
use b2b_climate::Site;
use serde_json::json;

use super::parameters::House;

/// Zone time steps per hour.
const STEPS_PER_HOUR: u32 = 12;

pub(super) fn add(model: &mut Model, house: &House, site: &Site) {
    let version = json!({"version_identifier": "25.2"});
    model.insert("Version", "Version", version);
    control(model);
    run_period(model);
    building(model, house);
    location(model, site);
}

fn control(model: &mut Model) {
    let control = json!({
        "do_zone_sizing_calculation": "No",
        "do_system_sizing_calculation": "No",
        "do_plant_sizing_calculation": "No",
        "run_simulation_for_sizing_periods": "No",
        "run_simulation_for_weather_file_run_periods": "Yes",
    });
    model.insert("SimulationControl", "Simulation Control", control);
    let steps = json!({"number_of_timesteps_per_hour": STEPS_PER_HOUR});
    model.insert("Timestep", "Timestep", steps);
    // Longer than a zone step, so the engine never subdivides a step.
    let limits = json!({"minimum_system_timestep": 60});
    model.insert("ConvergenceLimits", "Convergence Limits", limits);
}

fn run_period(model: &mut Model) {
    let week = json!({
        "begin_month": 1, "begin_day_of_month": 1,
        "end_month": 1, "end_day_of_month": 7,
        "day_of_week_for_start_day": "Sunday",
        "use_weather_file_holidays_and_special_days": "No",
        "use_weather_file_daylight_saving_period": "No",
    });
    model.insert("RunPeriod", "Run Period", week);
}

fn building(model: &mut Model, house: &House) {
    let building = json!({
        "north_axis": house.orientation,
        "terrain": "Suburbs",
        "solar_distribution": "FullExterior",
        "minimum_number_of_warmup_days": 1,
        "maximum_number_of_warmup_days": 25,
    });
    model.insert("Building", UNNAMED_HOUSE, building);
    let rules = json!({
        "starting_vertex_position": "UpperLeftCorner",
        "vertex_entry_direction": "Counterclockwise",
        "coordinate_system": "Relative",
    });
    model.insert("GlobalGeometryRules", "Geometry Rules", rules);
}

fn location(model: &mut Model, site: &Site) {
    let location = json!({
        "latitude": site.latitude,
        "longitude": site.longitude,
        "time_zone": site.time_zone,
        "elevation": site.elevation,
    });
    model.insert("Site:Location", &site.name, location);
}
