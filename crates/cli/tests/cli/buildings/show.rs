//! `b2b show`, `b2b view` and `b2b list` from the outside, on the real engine.

use std::collections::HashMap;

use crate::program::sandbox::Sandbox;
use crate::program::stderr;
use b2b_building::BuildingType;
use b2b_energyplus::Library;
use b2b_energyplus::install::{Engine, Quiet};
use serde_json::Value;

#[test]
fn show_lists_bounds_and_units_of_observation_and_action() {
    let object = Sandbox::new().json("show RestaurantFastFood");
    let (action, observation) =
        (object["action"].as_array().unwrap(), object["observation"].as_array().unwrap());
    assert_eq!(action.len(), 4);
    for each in action.iter().chain(observation) {
        assert!(each["low"].as_f64().unwrap() < each["high"].as_f64().unwrap(), "{each}");
        assert!(each["unit"].is_string(), "{each}");
    }
}

#[test]
fn show_fits_a_screen_and_has_details_on_request() {
    let sandbox = Sandbox::new();
    let text = |arguments: &str| String::from_utf8(sandbox.b2b(arguments).stdout).unwrap();
    let short = text("show RestaurantFastFood-0042");
    for word in [
        "kitchen",
        "heating degree days",
        "U ",
        "SHGC",
        "of the exterior walls",
        "Dining",
        "x scale",
        "17 values",
        "4 values",
    ] {
        assert!(short.contains(word), "no {word} in {short}");
    }
    assert!(short.lines().count() <= 40, "{short}");
    assert!(short.lines().all(|line| line.chars().count() <= 100), "{short}");
    assert!(!short.contains("Schedule:Constant") && !short.contains("engine:"), "{short}");
    assert!(text("show RestaurantFastFood --actions").contains("Schedule:Constant"));
    let all = text("show RestaurantFastFood --all");
    for word in ["infiltration (1/h)", "Schedule:Constant", "engine: Zone Mean Air Temperature"] {
        assert!(all.contains(word), "no {word} in {all}");
    }
}

#[test]
fn show_as_json_has_the_description_and_the_morphology() {
    let object = Sandbox::new().json("show Warehouse-0042");
    assert!(object["parameters"]["window_u"].is_number(), "{}", object["parameters"]);
    assert_eq!(object["description"]["zones"].as_array().unwrap().len(), 3);
    let nodes = object["morphology"]["nodes"].as_array().unwrap();
    for slot in object["action"].as_array().unwrap().iter().chain(object["observation"].as_array().unwrap()) {
        let node = &nodes[slot["node"].as_u64().unwrap() as usize];
        let node_type = node["node_type"].as_str().unwrap();
        let types = object["universe"]["node_types"].as_array().unwrap();
        assert!(types.iter().any(|each| each["node_type"] == node_type), "{node_type}");
    }
}

/// The warehouse has floors with a reentrant corner.
#[test]
fn the_page_of_a_building_draws_every_surface_at_its_size_and_needs_no_network() {
    let sandbox = Sandbox::new();
    let output = sandbox.b2b("view Warehouse --out here/page.html");
    assert!(output.status.success(), "{}", stderr(&output));
    let page = std::fs::read_to_string(sandbox.work.path().join("here/page.html")).unwrap();
    assert!(!page.contains("<script src") && !page.contains("<link"));
    let data = page.split(r#"<script id="data" type="application/json">"#).nth(1).unwrap();
    let data: Value = serde_json::from_str(data.split("</script>").next().unwrap()).unwrap();
    let drawn = areas_by_surface(&data["solid"]["data"]);

    let engine = Engine::ensure(&mut Quiet).unwrap();
    let library = Library::load(&engine.library).unwrap();
    let model = b2b_dataset::archetype::prototype(BuildingType::Warehouse, &engine, &library).unwrap();
    let surfaces = b2b_building::zone::surfaces(&model).unwrap();
    assert!(surfaces.iter().any(|surface| surface.corners.len() == 6));
    for surface in &surfaces {
        let area = drawn.get(&surface.name).unwrap_or_else(|| panic!("{} is not drawn", surface.name));
        assert!((area / surface.area() - 1.0).abs() < 1e-6, "{}: {area} of {}", surface.name, surface.area());
    }
    for opening in b2b_building::opening::openings(&model) {
        // Drawn on both sides of its wall.
        let area = drawn[&opening.name] / 2.0;
        assert!((area / opening.area() - 1.0).abs() < 1e-6, "{}: {area} of {}", opening.name, opening.area());
    }
    let nodes = data["graph"]["data"].as_array().unwrap();
    for name in ["weather", "unitary zone", "heating-only zone", "adjacent"] {
        assert!(nodes.iter().any(|trace| trace["name"] == name), "no {name}");
    }
}

/// Areas of the triangles of each surface, by the bold first line of its hover text.
fn areas_by_surface(traces: &Value) -> HashMap<String, f64> {
    let mut areas = HashMap::new();
    for mesh in traces.as_array().unwrap().iter().filter(|trace| trace["type"] == "mesh3d") {
        let coordinate = |axis: &str, point: usize| mesh[axis][point].as_f64().unwrap();
        let point = |index: usize| ["x", "y", "z"].map(|axis| coordinate(axis, index));
        for triangle in 0..mesh["i"].as_array().unwrap().len() {
            let corners = ["i", "j", "k"].map(|corner| mesh[corner][triangle].as_u64().unwrap() as usize);
            let text = mesh["hovertext"][corners[0]].as_str().unwrap();
            let Some(name) = text.split("<b>").nth(1).and_then(|text| text.split("</b>").next()) else {
                continue;
            };
            let area = b2b_building::zone::polygon_area(&corners.map(point));
            *areas.entry(name.to_owned()).or_insert(0.0) += area;
        }
    }
    areas
}

#[test]
fn list_names_every_type_place_and_tariff() {
    let sandbox = Sandbox::new();
    let types = sandbox.json("list");
    assert_eq!(types.as_array().unwrap().len(), 6);
    assert!(types.as_array().unwrap().iter().any(|each| each["type"] == "OfficeMedium"));
    let places = sandbox.json("list places");
    assert!(places.as_array().unwrap().iter().any(|each| each["place"] == "Montréal"));
    let tariffs = sandbox.json("list tariffs");
    assert!(tariffs.as_array().unwrap().iter().any(|each| each["tariff"] == "pge-b10"));
}
