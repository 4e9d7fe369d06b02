//! Properties of generated commercial models, read from their epJSON without the code that wrote it.

use std::path::Path;
use std::sync::OnceLock;

use b2b_building::{BuildingType, Model};
use b2b_climate::{Place, Site};
use b2b_dataset::archetype;
use b2b_dataset::commercial::{CommercialParameters, generate};
use b2b_energyplus::Library;
use b2b_energyplus::install::{Engine, Quiet};
use serde_json::{Map, Value};

const TYPES: [BuildingType; 5] = [
    BuildingType::OfficeSmall,
    BuildingType::OfficeMedium,
    BuildingType::RetailStandalone,
    BuildingType::RestaurantFastFood,
    BuildingType::Warehouse,
];
/// Zones 1A, 3C, 5B and 8.
const PLACES: [&str; 4] = ["Miami", "San Diego", "Denver", "Fairbanks"];
/// Points of the unit cube: its middle, two corners, and mixed points.
const POINTS: [[f64; 9]; 6] = [
    [0.5; 9],
    [0.0; 9],
    [1.0; 9],
    [0.9, 0.0, 0.1, 0.8, 1.0, 0.2, 0.0, 1.0, 0.3],
    [0.1, 1.0, 0.9, 0.2, 1.0, 0.7, 1.0, 0.0, 0.6],
    [0.3, 0.6, 0.7, 0.6, 0.0, 0.9, 0.1, 0.8, 0.1],
];
/// ASHRAE 90.1 wall and roof U of zones 1, 3, 5 and 8, Btu/h·ft²·°F.
const CODE: [[f64; 2]; 4] = [[0.124, 0.048], [0.077, 0.039], [0.055, 0.032], [0.037, 0.028]];
/// Rounding error between windows and walls in the prototypes, m.
const ROUNDING: f64 = 1e-3;
const SI_PER_IP: f64 = 5.678263;

fn library() -> Library {
    Library::load(&Engine::ensure(&mut Quiet).unwrap().library).unwrap()
}

fn site(place: &Place) -> Site {
    Site::read(&place.epw(&mut Quiet).unwrap()).unwrap()
}

/// The prototypes, read once.
fn bases() -> &'static [(BuildingType, Model)] {
    static BASES: OnceLock<Vec<(BuildingType, Model)>> = OnceLock::new();
    BASES.get_or_init(|| {
        let (engine, library) = (Engine::ensure(&mut Quiet).unwrap(), library());
        let denver = site(Place::find("Denver").unwrap());
        TYPES.map(|t| (t, archetype::base_model(t, &engine, &library, &denver).unwrap())).into()
    })
}

/// A generated model beside its prototype.
struct Case {
    label: String,
    model: Document,
    base: Document,
    parameters: CommercialParameters,
    /// The place's row of [`CODE`].
    code: [f64; 2],
}

/// Every type at every place and point, generated once.
fn cases() -> &'static [Case] {
    static CASES: OnceLock<Vec<Case>> = OnceLock::new();
    CASES.get_or_init(|| {
        let mut cases = Vec::new();
        for (name, code) in PLACES.iter().zip(CODE) {
            let place = Place::find(name).unwrap();
            let site = site(place);
            for (building_type, base) in bases() {
                for point in POINTS {
                    let parameters =
                        CommercialParameters::from_unit(point, *building_type, place.ashrae_zone).unwrap();
                    let model = generate(base, *building_type, place, &site, &parameters).unwrap();
                    let label = format!("{building_type} in {name} at {point:?}");
                    let (model, base) = (Document::of(&model), Document::of(base));
                    cases.push(Case { label, model, base, parameters, code });
                }
            }
        }
        cases
    })
}

/// Calls `check` with every case.
fn each(mut check: impl FnMut(&str, &Document, &Document, &CommercialParameters, [f64; 2])) {
    for case in cases() {
        check(&case.label, &case.model, &case.base, &case.parameters, case.code);
    }
}

/// A model, parsed from its epJSON text.
struct Document(Map<String, Value>);

type Point = [f64; 3];

impl Document {
    fn of(model: &Model) -> Self {
        Self(serde_json::from_str(&model.to_epjson()).unwrap())
    }

    fn objects(&self, class: &str) -> Vec<(&String, &Value)> {
        self.0.get(class).and_then(Value::as_object).into_iter().flatten().collect()
    }

    fn find(&self, class: &str, name: &str) -> Option<&Value> {
        self.objects(class).into_iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, v)| v)
    }

    fn surfaces(&self) -> Vec<(&String, &Value)> {
        self.objects("BuildingSurface:Detailed")
    }

    /// Surfaces of a kind with a boundary condition.
    fn facing(&self, kind: &str, boundary: &str) -> Vec<&Value> {
        let wanted = |v: &&Value| v["surface_type"] == kind && v["outside_boundary_condition"] == boundary;
        self.surfaces().into_iter().map(|(_, v)| v).filter(wanted).collect()
    }

    /// Glazing with the kind of its surface.
    fn glass(&self) -> Vec<(&Value, String)> {
        let fenestration = self.objects("FenestrationSurface:Detailed").into_iter().map(|(_, v)| v);
        fenestration
            .filter(|v| v["surface_type"] != "Door")
            .map(|v| {
                let parent = v["building_surface_name"].as_str().unwrap();
                let parent = self.find("BuildingSurface:Detailed", parent).unwrap();
                (v, parent["surface_type"].as_str().unwrap().to_owned())
            })
            .collect()
    }

    fn floor_area(&self) -> f64 {
        let floor = |v: &&Value| {
            v["surface_type"] == "Floor" && v["outside_boundary_condition"] != "Surface" && !is_soffit(v)
        };
        self.surfaces().into_iter().map(|(_, v)| v).filter(floor).map(|v| area(&corners(v))).sum()
    }

    fn gross_wall(&self) -> f64 {
        self.facing("Wall", "Outdoors").into_iter().map(|v| area(&corners(v))).sum()
    }

    /// Thermal resistance of the layers of a construction, m²K/W.
    fn layers(&self, construction: &str) -> Vec<f64> {
        let fields = self.find("Construction", construction).unwrap().as_object().unwrap();
        let layers = fields.iter().filter(|(key, _)| key.contains("layer")).map(|(_, v)| v.as_str().unwrap());
        layers
            .map(|layer| match self.find("Material:NoMass", layer) {
                Some(material) => material["thermal_resistance"].as_f64().unwrap(),
                None => {
                    let material = self.find("Material", layer).unwrap();
                    material["thickness"].as_f64().unwrap() / material["conductivity"].as_f64().unwrap()
                }
            })
            .collect()
    }
}

fn is_soffit(surface: &Value) -> bool {
    surface["outside_boundary_condition"] == "Outdoors"
}

fn corners(fields: &Value) -> Vec<Point> {
    if let Some(vertices) = fields["vertices"].as_array() {
        let axis = |v: &Value, a: &str| v[format!("vertex_{a}_coordinate")].as_f64().unwrap();
        return vertices.iter().map(|v| [axis(v, "x"), axis(v, "y"), axis(v, "z")]).collect();
    }
    let axis = |i: usize, a: &str| fields[format!("vertex_{i}_{a}_coordinate")].as_f64().unwrap();
    (1..=4).map(|i| [axis(i, "x"), axis(i, "y"), axis(i, "z")]).collect()
}

/// Area of a convex polygon: triangles from its first corner.
fn area(p: &[Point]) -> f64 {
    let minus = |a: Point, b: Point| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let mut sum = [0.0; 3];
    for pair in p[1..].windows(2) {
        let (u, v) = (minus(pair[0], p[0]), minus(pair[1], p[0]));
        let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        (0..3).for_each(|i| sum[i] += cross[i] / 2.0);
    }
    sum.iter().map(|s| s * s).sum::<f64>().sqrt()
}

#[track_caller]
fn within_a_percent(got: f64, expected: f64, label: &str) {
    assert!((got / expected - 1.0).abs() < 0.01, "{label}: {got} instead of {expected}");
}

/// One test, because a test is a process and would generate all models again.
#[test]
fn generated_models_have_the_properties_of_their_parameters() {
    windows_have_the_u_factor_and_gain_of_the_parameters_and_skylights_keep_their_own();
    walls_and_roofs_have_the_u_of_the_parameters();
    windows_take_their_share_of_the_walls();
    nothing_in_a_wall_overlaps_and_nothing_leaves_it();
    floor_area_and_orientation_follow_the_parameters();
    leakage_scales_in_every_zone_and_doors_only_with_the_floor();
    loads_per_floor_area_are_preserved();
    exhaust_air_warms_outdoor_air_where_the_code_requires_it();
    the_same_parameters_give_the_same_bytes();
    the_error_for_a_parameter_out_of_bounds_has_its_name();
}

fn windows_have_the_u_factor_and_gain_of_the_parameters_and_skylights_keep_their_own() {
    each(|label, model, base, parameters, _| {
        let glazing = |document: &Document, fenestration: &Value| -> Value {
            let construction = fenestration["construction_name"].as_str().unwrap();
            let construction = document.find("Construction", construction).unwrap();
            let glass = construction["outside_layer"].as_str().unwrap();
            document.find("WindowMaterial:SimpleGlazingSystem", glass).unwrap().clone()
        };
        for (fenestration, kind) in model.glass() {
            let glass = glazing(model, fenestration);
            if kind == "Wall" {
                within_a_percent(glass["u_factor"].as_f64().unwrap(), parameters.window_u, label);
                let shgc = glass["solar_heat_gain_coefficient"].as_f64().unwrap();
                within_a_percent(shgc, parameters.window_shgc, label);
            } else {
                assert_eq!(glass, glazing(base, fenestration), "{label}");
            }
        }
    });
}

fn walls_and_roofs_have_the_u_of_the_parameters() {
    each(|label, model, _, parameters, code| {
        for (u, code) in [parameters.wall_u, parameters.roof_u].iter().zip(code) {
            let share = u / (code * SI_PER_IP);
            assert!((0.499..1.301).contains(&share), "{label}: {share}");
        }
        let u = |surface: &Value, films: f64| {
            1.0 / (model.layers(surface["construction_name"].as_str().unwrap()).iter().sum::<f64>() + films)
        };
        for surface in model.facing("Wall", "Outdoors") {
            within_a_percent(u(surface, 0.03 + 0.12), parameters.wall_u, label);
        }
        // The decks of attics are bare; the ceilings under them are insulated.
        let mut roofs = model.facing("Roof", "Outdoors");
        roofs.retain(|roof| roof["construction_name"] != "AtticRoofDeck");
        roofs.extend(model.facing("Ceiling", "Surface"));
        assert!(!roofs.is_empty(), "{label}");
        for surface in roofs {
            within_a_percent(u(surface, 0.03 + 0.11), parameters.roof_u, label);
        }
    });
}

fn windows_take_their_share_of_the_walls() {
    each(|label, model, _, parameters, _| {
        let in_walls = model.glass().into_iter().filter(|(_, kind)| kind == "Wall");
        let glass: f64 = in_walls.map(|(v, _)| area(&corners(v))).sum();
        within_a_percent(glass / model.gross_wall(), parameters.window_to_wall, label);
    });
}

fn nothing_in_a_wall_overlaps_and_nothing_leaves_it() {
    each(|label, model, _, _, _| {
        for (name, wall) in model.surfaces().into_iter().filter(|(_, v)| v["surface_type"] == "Wall") {
            let boxes: Vec<[f64; 6]> = model
                .objects("FenestrationSurface:Detailed")
                .into_iter()
                .filter(|(_, v)| v["building_surface_name"].as_str().unwrap().eq_ignore_ascii_case(name))
                .map(|(_, v)| extent(&corners(v)))
                .collect();
            let outer = extent(&corners(wall));
            for (i, inner) in boxes.iter().enumerate() {
                let inside = (0..3)
                    .all(|a| inner[a] >= outer[a] - ROUNDING && inner[a + 3] <= outer[a + 3] + ROUNDING);
                assert!(inside, "{label}: {name} {inner:?} {outer:?}");
                for other in &boxes[..i] {
                    let apart = (0..3).any(|a| inner[a] > other[a + 3] || other[a] > inner[a + 3]);
                    assert!(apart, "{label}: {name} {inner:?} {other:?}");
                }
            }
        }
    });
}

/// Lowest and highest coordinates.
fn extent(corners: &[Point]) -> [f64; 6] {
    let mut extent = [f64::INFINITY, f64::INFINITY, f64::INFINITY, -1e9, -1e9, -1e9];
    for corner in corners {
        for axis in 0..3 {
            extent[axis] = extent[axis].min(corner[axis]);
            extent[axis + 3] = extent[axis + 3].max(corner[axis]);
        }
    }
    extent
}

fn floor_area_and_orientation_follow_the_parameters() {
    each(|label, model, base, parameters, _| {
        let ratio = parameters.x_scale * parameters.y_scale;
        within_a_percent(model.floor_area() / base.floor_area(), ratio, label);
        let (_, building) = model.objects("Building")[0];
        assert_eq!(building["north_axis"].as_f64().unwrap(), parameters.north_axis, "{label}");
    });
}

fn leakage_scales_in_every_zone_and_doors_only_with_the_floor() {
    each(|label, model, base, parameters, _| {
        let floor = parameters.x_scale * parameters.y_scale;
        let class = "ZoneInfiltration:DesignFlowRate";
        for (name, fields) in model.objects(class) {
            let before = base.find(class, name).unwrap();
            let leak = if name.contains("Door") { 1.0 } else { parameters.infiltration };
            for (field, scale) in
                [("design_flow_rate", leak * floor), ("flow_rate_per_exterior_surface_area", leak)]
            {
                match before[field].as_f64() {
                    Some(flow) if flow > 0.0 => {
                        within_a_percent(
                            fields[field].as_f64().unwrap(),
                            flow * scale,
                            &format!("{label}: {name}"),
                        );
                    }
                    _ => {}
                }
            }
        }
    });
}

fn loads_per_floor_area_are_preserved() {
    each(|label, model, base, _, _| {
        for class in ["ElectricEquipment", "GasEquipment", "Exterior:Lights"] {
            for (name, fields) in model.objects(class) {
                let Some(before) = base.find(class, name).unwrap()["design_level"].as_f64() else { continue };
                let density = fields["design_level"].as_f64().unwrap() / model.floor_area();
                within_a_percent(density, before / base.floor_area(), &format!("{label}: {name}"));
            }
        }
    });
}

/// Checks the path from the controlled outdoor air node through the wheel to the mixer, and back from the mixer.
fn exhaust_air_warms_outdoor_air_where_the_code_requires_it() {
    each(|label, model, _, _, _| {
        let wheels = model.objects("HeatExchanger:AirToAir:SensibleAndLatent");
        let asked = match label {
            _ if !label.contains("Fairbanks") => 0,
            _ if label.starts_with("OfficeMedium") => 3,
            _ => usize::from(label.starts_with("RetailStandalone")),
        };
        assert_eq!(wheels.len(), asked, "{label}");
        for (name, wheel) in wheels {
            let is = |fields: &Value, field: &str, node: &str| fields[field] == wheel[node];
            let mixers = model.objects("OutdoorAir:Mixer");
            let mixed = |(_, mixer): &(&String, &Value)| {
                is(mixer, "outdoor_air_stream_node_name", "supply_air_outlet_node_name")
                    && is(mixer, "relief_air_stream_node_name", "exhaust_air_inlet_node_name")
            };
            let moved = |(_, controller): &(&String, &Value)| {
                is(controller, "actuator_node_name", "supply_air_inlet_node_name")
            };
            assert!(mixers.iter().any(mixed), "{label}: {name}");
            assert!(model.objects("Controller:OutdoorAir").iter().any(moved), "{label}: {name}");
        }
    });
}

fn the_same_parameters_give_the_same_bytes() {
    let place = Place::find("Miami").unwrap();
    let site = site(place);
    for (building_type, base) in bases() {
        let parameters = CommercialParameters::from_unit(POINTS[3], *building_type, "1A").unwrap();
        let text = || generate(base, *building_type, place, &site, &parameters).unwrap().to_epjson();
        assert_eq!(text(), text());
        let read = Model::from_epjson(&text(), Path::new("a.epJSON")).unwrap();
        assert_eq!(read.to_epjson(), text());
    }
}

fn the_error_for_a_parameter_out_of_bounds_has_its_name() {
    let place = Place::find("Miami").unwrap();
    let (building_type, base) = &bases()[0];
    let good = CommercialParameters::from_unit([0.5; 9], *building_type, "1A").unwrap();
    for bad in [f64::NAN, f64::NEG_INFINITY, 9.0] {
        let parameters = CommercialParameters { infiltration: bad, ..good };
        let error = generate(base, *building_type, place, &site(place), &parameters).unwrap_err().to_string();
        assert!(error.contains("infiltration") && error.contains("0.5 to 2"), "{error}");
    }
}
