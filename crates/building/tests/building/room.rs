//! A room of 10 × 8 × 3 m with an electric baseboard.

use serde_json::{Map, Value, json};

const SIZE: [f64; 3] = [10.0, 8.0, 3.0];

/// Returns the model of the room in the engine's version.
pub fn room() -> Value {
    json!({
        "Version": {"V": {"version_identifier": "25.2"}},
        "Building": {"B": {"terrain": "City"}},
        "GlobalGeometryRules": {"G": {"starting_vertex_position": "UpperLeftCorner",
            "vertex_entry_direction": "Counterclockwise", "coordinate_system": "Relative"}},
        "Timestep": {"T": {"number_of_timesteps_per_hour": 6}},
        "SimulationControl": {"S": {"do_zone_sizing_calculation": "Yes", "do_system_sizing_calculation": "Yes",
            "do_plant_sizing_calculation": "Yes"}},
        "SizingPeriod:DesignDay": {"Cold": day("Winter", 1, -20.0), "Hot": day("Summer", 7, 33.0)},
        "RunPeriod": {"R": {"begin_month": 1, "begin_day_of_month": 1, "end_month": 12, "end_day_of_month": 31}},
        "Material": {"Block": {"roughness": "Rough", "thickness": 0.2, "conductivity": 0.1, "density": 600,
            "specific_heat": 900}},
        "Construction": {"Wall": {"outside_layer": "Block"}},
        "Zone": {"Room": {}},
        "BuildingSurface:Detailed": surfaces(),
        "ScheduleTypeLimits": {"Any": {}},
        "Schedule:Constant": {"On": constant(1.0), "Warm": constant(21.0)},
        "ZoneControl:Thermostat": {"T": {"zone_or_zonelist_name": "Room", "control_type_schedule_name": "On",
            "control_1_object_type": "ThermostatSetpoint:SingleHeating", "control_1_name": "H"}},
        "ThermostatSetpoint:SingleHeating": {"H": {"setpoint_temperature_schedule_name": "Warm"}},
        "Sizing:Zone": {"Room": {"zone_or_zonelist_name": "Room", "zone_cooling_design_supply_air_temperature": 13,
            "zone_heating_design_supply_air_temperature": 45, "zone_cooling_design_supply_air_humidity_ratio": 0.008,
            "zone_heating_design_supply_air_humidity_ratio": 0.008}},
        "ZoneHVAC:EquipmentConnections": {"E": {"zone_name": "Room", "zone_conditioning_equipment_list_name": "L",
            "zone_air_node_name": "Air", "zone_return_air_node_or_nodelist_name": "Return"}},
        "ZoneHVAC:EquipmentList": {"L": {"load_distribution_scheme": "SequentialLoad", "equipment": [{
            "zone_equipment_object_type": "ZoneHVAC:Baseboard:Convective:Electric", "zone_equipment_name": "Heater",
            "zone_equipment_cooling_sequence": 1, "zone_equipment_heating_or_no_load_sequence": 1}]}},
        "ZoneHVAC:Baseboard:Convective:Electric": {"Heater": {"availability_schedule_name": "On",
            "heating_design_capacity": "Autosize"}},
    })
}

fn constant(value: f64) -> Value {
    json!({"schedule_type_limits_name": "Any", "hourly_value": value})
}

fn day(kind: &str, month: u32, dry_bulb: f64) -> Value {
    json!({"month": month, "day_of_month": 21, "day_type": format!("{kind}DesignDay"),
        "maximum_dry_bulb_temperature": dry_bulb, "daily_dry_bulb_temperature_range": 0.0,
        "humidity_condition_type": "WetBulb", "wetbulb_or_dewpoint_at_maximum_dry_bulb": dry_bulb.min(23.0),
        "wind_speed": 4.0, "wind_direction": 0, "solar_model_indicator": "ASHRAEClearSky", "sky_clearness": 0})
}

fn surfaces() -> Value {
    let [x, y, z] = SIZE;
    let walls = [
        ("South", [[0.0, 0.0, z], [0.0, 0.0, 0.0], [x, 0.0, 0.0], [x, 0.0, z]]),
        ("East", [[x, 0.0, z], [x, 0.0, 0.0], [x, y, 0.0], [x, y, z]]),
        ("North", [[x, y, z], [x, y, 0.0], [0.0, y, 0.0], [0.0, y, z]]),
        ("West", [[0.0, y, z], [0.0, y, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, z]]),
    ];
    let mut surfaces: Map<String, Value> = walls
        .iter()
        .map(|(name, corners)| ((*name).to_owned(), surface("Wall", "Outdoors", corners)))
        .collect();
    let roof = [[0.0, 0.0, z], [x, 0.0, z], [x, y, z], [0.0, y, z]];
    surfaces.insert("Roof".into(), surface("Roof", "Outdoors", &roof));
    let floor = [[0.0, y, 0.0], [x, y, 0.0], [x, 0.0, 0.0], [0.0, 0.0, 0.0]];
    surfaces.insert("Floor".into(), surface("Floor", "Adiabatic", &floor));
    Value::Object(surfaces)
}

fn surface(kind: &str, boundary: &str, corners: &[[f64; 3]]) -> Value {
    let vertex = |corner: &[f64; 3]| json!({"vertex_x_coordinate": corner[0], "vertex_y_coordinate": corner[1], "vertex_z_coordinate": corner[2]});
    let (sun, wind) =
        if boundary == "Outdoors" { ("SunExposed", "WindExposed") } else { ("NoSun", "NoWind") };
    json!({"surface_type": kind, "construction_name": "Wall", "zone_name": "Room",
        "outside_boundary_condition": boundary, "sun_exposure": sun, "wind_exposure": wind,
        "vertices": corners.iter().map(vertex).collect::<Vec<_>>()})
}
