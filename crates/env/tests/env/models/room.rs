//! A room with ideal loads and a thermostat that only heats.

use serde_json::{Map, Value, json};

/// Width, depth and height, m.
const SIZE: [f64; 3] = [10.0, 8.0, 3.0];

/// Corners of the walls, the floor and the roof, seen from outside, as fractions of the size.
const SURFACES: [(&str, &str, [[u8; 3]; 4]); 6] = [
    ("South", "Wall", [[0, 0, 1], [0, 0, 0], [1, 0, 0], [1, 0, 1]]),
    ("East", "Wall", [[1, 0, 1], [1, 0, 0], [1, 1, 0], [1, 1, 1]]),
    ("North", "Wall", [[1, 1, 1], [1, 1, 0], [0, 1, 0], [0, 1, 1]]),
    ("West", "Wall", [[0, 1, 1], [0, 1, 0], [0, 0, 0], [0, 0, 1]]),
    ("Ground", "Floor", [[0, 1, 0], [1, 1, 0], [1, 0, 0], [0, 0, 0]]),
    ("Top", "Roof", [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]),
];

/// Returns the model, as epJSON.
pub fn room() -> Value {
    let constant = |value: f64| json!({"hourly_value": value});
    json!({
        "Version": {"V": {"version_identifier": "25.2"}},
        "Building": {"Room": {"terrain": "Suburbs"}},
        "GlobalGeometryRules": {"G": {
            "starting_vertex_position": "UpperLeftCorner",
            "vertex_entry_direction": "Counterclockwise",
            "coordinate_system": "Relative"}},
        "Material": {"Block": {
            "roughness": "Rough", "thickness": 0.2, "conductivity": 0.1, "density": 600.0, "specific_heat": 900.0}},
        "Construction": {"Wall": {"outside_layer": "Block"}},
        "Zone": {"Room": {}},
        "BuildingSurface:Detailed": surfaces(),
        "Schedule:Constant": {"Single Heating": constant(1.0), "Warm": constant(21.0)},
        "ZoneControl:Thermostat": {"T": {
            "zone_or_zonelist_name": "Room",
            "control_type_schedule_name": "Single Heating",
            "control_1_object_type": "ThermostatSetpoint:SingleHeating",
            "control_1_name": "Heating"}},
        "ThermostatSetpoint:SingleHeating": {"Heating": {"setpoint_temperature_schedule_name": "Warm"}},
        "ZoneHVAC:EquipmentConnections": {"C": {
            "zone_name": "Room",
            "zone_conditioning_equipment_list_name": "List",
            "zone_air_inlet_node_or_nodelist_name": "Inlet",
            "zone_air_node_name": "Air",
            "zone_return_air_node_or_nodelist_name": "Return"}},
        "ZoneHVAC:EquipmentList": {"List": {"equipment": [{
            "zone_equipment_object_type": "ZoneHVAC:IdealLoadsAirSystem",
            "zone_equipment_name": "Ideal",
            "zone_equipment_cooling_sequence": 1,
            "zone_equipment_heating_or_no_load_sequence": 1}]}},
        "ZoneHVAC:IdealLoadsAirSystem": {"Ideal": {"zone_supply_air_node_name": "Inlet"}},
    })
}

/// Returns the model with equipment that the engine sizes and an exhaust fan.
pub fn autosized() -> Value {
    let mut model = room();
    let day = |kind: &str, month: u32, dry_bulb: f64| {
        json!({"month": month, "day_of_month": 21, "day_type": kind, "maximum_dry_bulb_temperature": dry_bulb,
            "daily_dry_bulb_temperature_range": 0.0, "humidity_condition_type": "WetBulb",
            "wetbulb_or_dewpoint_at_maximum_dry_bulb": dry_bulb.min(23.0), "wind_speed": 4.0, "wind_direction": 0,
            "solar_model_indicator": "ASHRAEClearSky", "sky_clearness": 0})
    };
    model["Site:Location"] =
        json!({"Chicago": {"latitude": 41.98, "longitude": -87.92, "time_zone": -6.0, "elevation": 201.0}});
    model["SizingPeriod:DesignDay"] =
        json!({"Cold": day("WinterDesignDay", 1, -20.0), "Hot": day("SummerDesignDay", 7, 33.0)});
    model["SimulationControl"] = json!({"S": {
        "do_zone_sizing_calculation": "Yes",
        "run_simulation_for_sizing_periods": "No",
        "run_simulation_for_weather_file_run_periods": "Yes"}});
    model["Sizing:Zone"] = json!({"S": {
        "zone_or_zonelist_name": "Room",
        "zone_cooling_design_supply_air_temperature": 13.0,
        "zone_heating_design_supply_air_temperature": 45.0,
        "zone_cooling_design_supply_air_humidity_ratio": 0.008,
        "zone_heating_design_supply_air_humidity_ratio": 0.008}});
    let ideal = &mut model["ZoneHVAC:IdealLoadsAirSystem"]["Ideal"];
    ideal["heating_limit"] = json!("LimitFlowRate");
    ideal["maximum_heating_air_flow_rate"] = json!("Autosize");
    model["Fan:ZoneExhaust"] = json!({"Exhaust": {
        "fan_total_efficiency": 0.5,
        "pressure_rise": 100.0,
        "maximum_flow_rate": 0.05,
        "air_inlet_node_name": "To Fan",
        "air_outlet_node_name": "From Fan"}});
    model["ZoneHVAC:EquipmentConnections"]["C"]["zone_air_exhaust_node_or_nodelist_name"] = json!("To Fan");
    let equipment = &mut model["ZoneHVAC:EquipmentList"]["List"]["equipment"];
    let mut fan = equipment[0].clone();
    fan["zone_equipment_object_type"] = json!("Fan:ZoneExhaust");
    fan["zone_equipment_name"] = json!("Exhaust");
    for sequence in ["zone_equipment_cooling_sequence", "zone_equipment_heating_or_no_load_sequence"] {
        fan[sequence] = json!(2);
    }
    equipment.as_array_mut().unwrap().push(fan);
    model
}

fn surfaces() -> Value {
    let coordinate = |corner: [u8; 3], axis: usize| f64::from(corner[axis]) * SIZE[axis];
    let vertex = |corner: [u8; 3]| {
        json!({
            "vertex_x_coordinate": coordinate(corner, 0),
            "vertex_y_coordinate": coordinate(corner, 1),
            "vertex_z_coordinate": coordinate(corner, 2),
        })
    };
    let mut surfaces = Map::new();
    for (name, kind, corners) in SURFACES {
        let [outside, sun, wind] = match kind {
            "Floor" => ["Ground", "NoSun", "NoWind"],
            _ => ["Outdoors", "SunExposed", "WindExposed"],
        };
        let surface = json!({
            "surface_type": kind,
            "construction_name": "Wall",
            "zone_name": "Room",
            "outside_boundary_condition": outside,
            "sun_exposure": sun,
            "wind_exposure": wind,
            "vertices": corners.map(vertex),
        });
        surfaces.insert(name.to_owned(), surface);
    }
    surfaces.into()
}
