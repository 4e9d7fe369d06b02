//! A room with ideal loads, whose author only heats it.

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
