//! Edits of a small model.

use std::path::Path;

use serde_json::{Value, json};

use super::*;
use crate::construction::SIMPLE_GLAZING;
use crate::opening::FENESTRATION;

fn corners(points: &[[f64; 3]]) -> Value {
    let corner = |[x, y, z]: &[f64; 3]| json!({"vertex_x_coordinate": x, "vertex_y_coordinate": y, "vertex_z_coordinate": z});
    points.iter().map(corner).collect()
}

fn surface(kind: &str, boundary: &str, construction: &str, points: &[[f64; 3]]) -> Value {
    json!({"surface_type": kind, "zone_name": "Room", "construction_name": construction,
        "outside_boundary_condition": boundary, "vertices": corners(points)})
}

/// A room of 10 by 5 by 3 m with a window of 4 m² in its south wall; the wall to a neighbor has the construction of the
/// exterior wall.
fn room() -> Model {
    let wall = |a: [f64; 2], b: [f64; 2]| {
        [[a[0], a[1], 3.0], [a[0], a[1], 0.0], [b[0], b[1], 0.0], [b[0], b[1], 3.0]]
    };
    let mut window =
        json!({"surface_type": "Window", "building_surface_name": "South", "construction_name": "Glass"});
    for (corner, (x, z)) in [(2.0, 2.0), (2.0, 1.0), (6.0, 1.0), (6.0, 2.0)].into_iter().enumerate() {
        for (axis, value) in [("x", x), ("y", 0.0), ("z", z)] {
            window[format!("vertex_{}_{axis}_coordinate", corner + 1)] = json!(value);
        }
    }
    let place = "zone_or_zonelist_or_space_or_spacelist_name";
    let text = json!({
        "Building": {"B": {"north_axis": 0}},
        "Zone": {"Room": {}},
        "BuildingSurface:Detailed": {
            "South": surface("Wall", "Outdoors", "Wall", &wall([0.0, 0.0], [10.0, 0.0])),
            "East": surface("Wall", "Adiabatic", "Wall", &wall([10.0, 0.0], [10.0, 5.0])),
            "Floor": surface("Floor", "Ground", "Wall", &[[0.0, 0.0, 0.0], [0.0, 5.0, 0.0], [10.0, 5.0, 0.0], [10.0, 0.0, 0.0]]),
            "Roof": surface("Roof", "Outdoors", "Wall", &[[0.0, 0.0, 3.0], [10.0, 0.0, 3.0], [10.0, 5.0, 3.0], [0.0, 5.0, 3.0]])},
        FENESTRATION: {"Window": window},
        "Construction": {"Wall": {"outside_layer": "Wool"}, "Glass": {"outside_layer": "Pane"}},
        "Material": {"Wool": {"thickness": 0.1, "conductivity": 0.05}},
        SIMPLE_GLAZING: {"Pane": {"u_factor": 2.0, "solar_heat_gain_coefficient": 0.5}},
        "ZoneInfiltration:DesignFlowRate": {"Leak": {place: "Room", "design_flow_rate": 0.01}},
        "Lights": {"L": {place: "Room", "design_level_calculation_method": "LightingLevel", "lighting_level": 400}},
        "Fan:OnOff": {"Fan": {"maximum_flow_rate": 0.5}},
    });
    Model::from_epjson(&text.to_string(), Path::new("room.epJSON")).unwrap()
}

fn edits(changes: &[(Change, f64)]) -> Edits {
    let mut edits = Edits::default();
    changes.iter().for_each(|(change, value)| edits.set(*change, *value).unwrap());
    edits
}

#[test]
fn means_of_the_envelope_count_identical_zones() {
    let mut model = room();
    model.insert("Zone", "Hall", json!({"multiplier": 3}));
    let wall = [[0.0, 9.0, 3.0], [0.0, 9.0, 0.0], [10.0, 9.0, 0.0], [10.0, 9.0, 3.0]];
    let mut north = surface("Wall", "Outdoors", "Thin wall", &wall);
    north["zone_name"] = json!("Hall");
    model.insert("BuildingSurface:Detailed", "North", north);
    model.insert("Construction", "Thin wall", json!({"outside_layer": "Board"}));
    model.insert("Material", "Board", json!({"thickness": 0.1, "conductivity": 0.5}));
    let report = apply(&mut model, &edits(&[(Change::WallU, 0.3)])).unwrap();
    let [before, after] = [report.changes[0].before, report.changes[0].after].map(Option::unwrap);
    let expected = (26.0 / 2.15 + 3.0 * 30.0 / 0.35) / (26.0 + 3.0 * 30.0);
    assert!((before - expected).abs() < 1e-9 && (after - 0.3).abs() < 1e-9, "{before}, {after}");
}

#[test]
fn every_change_reports_its_quantity_before_and_after() {
    let mut model = room();
    let changes = [
        (Change::XScale, 2.0),
        (Change::NorthAxis, 90.0),
        (Change::WallU, 0.3),
        (Change::RoofU, 0.2),
        (Change::WindowU, 1.2),
        (Change::WindowShgc, 0.3),
        (Change::WindowToWall, 0.2),
        (Change::Infiltration, 1.5),
        (Change::Lights, 0.5),
    ];
    let report = apply(&mut model, &edits(&changes)).unwrap();
    let expected = [
        (Change::XScale, [10.0, 20.0]),
        (Change::NorthAxis, [0.0, 90.0]),
        (Change::WallU, [1.0 / 2.15, 0.3]),
        (Change::RoofU, [1.0 / 2.14, 0.2]),
        (Change::WindowU, [2.0, 1.2]),
        (Change::WindowShgc, [0.5, 0.3]),
        (Change::WindowToWall, [4.0 / 30.0, 0.2]),
        (Change::Infiltration, [36.0 / 150.0, 1.5 * 36.0 / 150.0]),
        (Change::Lights, [8.0, 4.0]),
    ];
    assert_eq!(report.changes.len(), expected.len());
    for (effect, (change, [before, after])) in report.changes.iter().zip(expected) {
        assert_eq!((effect.change, effect.objects), (change, 1));
        for (actual, expected) in [(effect.before, before), (effect.after, after)] {
            assert!((actual.unwrap() - expected).abs() < 1e-9, "{change}: {actual:?}, {expected}");
        }
    }
    assert!(report.warnings.len() == 1 && report.warnings[0].contains("Fan:OnOff `Fan`"), "{report:?}");
}

#[test]
fn other_surfaces_keep_the_construction_that_they_shared() {
    let mut model = room();
    apply(&mut model, &edits(&[(Change::WallU, 0.3), (Change::RoofU, 0.2)])).unwrap();
    let construction = |surface: &str| {
        let fields = model.get("BuildingSurface:Detailed", surface).unwrap();
        fields["construction_name"].as_str().unwrap().to_owned()
    };
    let u = |surface: &str| {
        1.0 / (crate::construction::assembly_resistance(&model, &construction(surface)).unwrap() + 0.15)
    };
    assert!((u("South") - 0.3).abs() < 1e-12 && (u("East") - 1.0 / 2.15).abs() < 1e-12);
    assert_eq!(construction("Floor"), construction("East"));
    assert_ne!(construction("Roof"), construction("South"));
}

#[test]
fn surfaces_of_every_class_with_corners_change_alike() {
    let mut detailed = room();
    for (class, surface) in [
        ("Wall:Detailed", "South"),
        ("Wall:Detailed", "East"),
        ("Floor:Detailed", "Floor"),
        ("RoofCeiling:Detailed", "Roof"),
    ] {
        let mut fields = detailed.remove("BuildingSurface:Detailed", surface).unwrap();
        fields.remove("surface_type");
        detailed.insert(class, surface, fields.into());
    }
    let edits = edits(&[
        (Change::XScale, 2.0),
        (Change::WallU, 0.3),
        (Change::RoofU, 0.2),
        (Change::WindowU, 1.2),
        (Change::WindowToWall, 0.2),
    ]);
    assert_eq!(apply(&mut detailed, &edits).unwrap(), apply(&mut room(), &edits).unwrap());
    let construction = |surface| &detailed.get("Wall:Detailed", surface).unwrap()["construction_name"];
    assert_ne!(construction("South"), construction("East"));
}

#[test]
fn a_change_without_an_object_is_an_error_and_leaves_the_model_unchanged() {
    let shipped = room();
    let mut model = shipped.clone();
    let error = apply(&mut model, &edits(&[(Change::Lights, 2.0), (Change::People, 2.0)])).unwrap_err();
    assert_eq!(error.to_string(), "cannot change people: the model has no people to scale");
    assert_eq!(model, shipped);
    model.remove_class("ZoneInfiltration:DesignFlowRate");
    let error = apply(&mut model, &edits(&[(Change::Infiltration, 2.0)])).unwrap_err().to_string();
    assert!(error.contains("has no infiltration to scale"), "{error}");
}

#[test]
fn a_stretched_room_has_the_same_lights_per_area() {
    let mut model = room();
    let report = apply(&mut model, &edits(&[(Change::XScale, 2.0), (Change::YScale, 3.0)])).unwrap();
    assert_eq!(report.changes[1].after, Some(15.0));
    assert_eq!(model.get("Lights", "L").unwrap()["lighting_level"], 2400.0);
}

#[test]
fn the_output_is_epjson() {
    let error = check_output(Path::new("out.idf")).unwrap_err().to_string();
    assert!(error.contains("out.idf") && error.contains(".epJSON"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.epJSON");
    write_aside(&room(), &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(Model::from_epjson(&text, &path).unwrap(), room());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
