use b2b_building::model::{Fields, number, text};
use serde_json::Value;

use super::*;
use crate::tests::MONTREAL;

const TOLERANCE: f64 = 1e-6;

fn site() -> Site {
    Site::from_epw(MONTREAL, std::path::Path::new("a.epw")).unwrap()
}

/// Every foundation, number of storeys, heating, with and without garage.
fn houses() -> Vec<House> {
    let fuel = Heater::Fuel { efficiency: 0.9 };
    let pump = |backup| Heating::HeatPump { cop: 3.3, cutoff: -12.0, backup };
    let systems =
        [pump(Heater::Electric), pump(fuel), Heating::Furnace(Heater::Electric), Heating::Furnace(fuel)];
    let mut houses = Vec::new();
    for foundation in [Foundation::Basement, Foundation::Slab, Foundation::Crawlspace] {
        for storeys in [1, 2] {
            for garage in [false, true] {
                for heating in systems {
                    houses.push(House { foundation, storeys, garage, heating, ..House::default() });
                }
            }
        }
    }
    houses
}

fn house(parameters: &House, site: &Site) -> Model {
    super::house(parameters, site).unwrap()
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() < TOLERANCE * b.abs().max(1.0), "{a} is not {b}");
}

/// The polygons of a zone, outward.
fn polygons(model: &Model, zone: &str) -> Vec<Vec<[f64; 3]>> {
    let of_zone = |(_, fields): &(&str, &Fields)| text(fields, "zone_name") == Some(zone);
    let surfaces = model.objects("BuildingSurface:Detailed");
    surfaces.iter().filter(|s| of_zone(s)).map(|(_, fields)| vertices(fields)).collect()
}

fn vertices(fields: &Fields) -> Vec<[f64; 3]> {
    let vertices = fields["vertices"].as_array().unwrap();
    let axis = |v: &Value, name: &str| v[format!("vertex_{name}_coordinate")].as_f64().unwrap();
    vertices.iter().map(|v| ["x", "y", "z"].map(|name| axis(v, name))).collect()
}

/// Area times unit normal.
fn area_vector(polygon: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for i in 0..polygon.len() {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        sum[0] += (a[1] * b[2] - a[2] * b[1]) / 2.0;
        sum[1] += (a[2] * b[0] - a[0] * b[2]) / 2.0;
        sum[2] += (a[0] * b[1] - a[1] * b[0]) / 2.0;
    }
    sum
}

/// Volume by the divergence theorem: a third of the sum of position · area vector.
fn volume(polygons: &[Vec<[f64; 3]>]) -> f64 {
    let part = |polygon: &Vec<[f64; 3]>| {
        let normal = area_vector(polygon);
        (0..3).map(|i| polygon[0][i] * normal[i]).sum::<f64>() / 3.0
    };
    polygons.iter().map(part).sum()
}

/// Resistance of a layered construction between its faces, m²K/W.
fn resistance(model: &Model, construction: &str) -> f64 {
    let layers = model.require("Construction", construction).unwrap();
    layers.values().map(|layer| layer_resistance(model, layer.as_str().unwrap())).sum()
}

fn layer_resistance(model: &Model, layer: &str) -> f64 {
    match model.get("Material", layer) {
        Some(material) => number(material, "thickness").unwrap() / number(material, "conductivity").unwrap(),
        None => {
            let material = model.require("Material:NoMass", layer).unwrap();
            number(material, "thermal_resistance").unwrap()
        }
    }
}

#[test]
fn volumes_and_areas_follow_from_the_parameters() {
    let house = House::default();
    let geometry = Geometry::new(&house);
    close(geometry.footprint(), 80.0);
    close(geometry.length / geometry.width, house.aspect);
    close(geometry.living_volume(), 160.0 * 2.44);
    let two_storeys = House { storeys: 2, foundation: Foundation::Slab, ..house };
    close(Geometry::new(&two_storeys).footprint(), 80.0);
    close(Geometry::new(&two_storeys).depth(), 0.0);
}

#[test]
fn floors_add_up_to_the_heated_area() {
    for parameters in houses() {
        let model = house(&parameters, &site());
        let area: f64 = polygons(&model, LIVING)
            .iter()
            .map(|p| area_vector(p)[2])
            .filter(|up| *up < 0.0)
            .map(f64::abs)
            .sum();
        close(area, parameters.floor_area);
    }
}

#[test]
fn surfaces_close_the_zone() {
    for parameters in houses() {
        let model = house(&parameters, &site());
        for zone in model.names("Zone") {
            let polygons = polygons(&model, &zone);
            for axis in 0..3 {
                close(polygons.iter().map(|p| area_vector(p)[axis]).sum(), 0.0);
            }
            let stated = number(model.require("Zone", &zone).unwrap(), "volume").unwrap();
            close(volume(&polygons), stated);
        }
    }
}

#[test]
fn windows_cover_their_share_of_the_walls() {
    let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    for parameters in houses() {
        let geometry = Geometry::new(&parameters);
        let window = |side: &geometry::Side| geometry.window(*side, 0.18);
        let area: f64 = geometry::Side::ALL.iter().filter_map(window).map(|w| norm(area_vector(&w))).sum();
        close(area, 0.18 * geometry.wall_area());
    }
}

#[test]
fn assembly_u_values_match_the_effective_r() {
    for parameters in houses() {
        let model = house(&parameters, &site());
        let films = shell::construction::FILM_OUTSIDE + shell::construction::FILM_WALL;
        close(resistance(&model, "Wall") + films, parameters.effective_wall_resistance());
        if parameters.garage {
            let films = 2.0 * shell::construction::FILM_WALL;
            close(resistance(&model, "Wall to Garage") + films, parameters.effective_wall_resistance());
        }
        if parameters.foundation == Foundation::Crawlspace {
            let floor = resistance(&model, "Floor") + 2.0 * shell::buffers::FILM_FLOOR;
            close(floor, parameters.effective_foundation_resistance());
        }
        let ceiling = resistance(&model, "Ceiling") + 2.0 * shell::construction::FILM_CEILING;
        close(ceiling, parameters.effective_attic_resistance());
        close(resistance(&model, "Ceiling"), resistance(&model, "Attic Floor"));
        if parameters.foundation == Foundation::Basement {
            let foundation = parameters.effective_foundation_resistance();
            close(resistance(&model, "Foundation Wall") + films, foundation);
            let class = "Construction:CfactorUndergroundWall";
            let wall = model.require(class, "Basement Wall").unwrap();
            close(1.0 / number(wall, "c_factor").unwrap() + shell::construction::FILM_WALL, foundation);
        }
        let glazing = model.require("WindowMaterial:SimpleGlazingSystem", "Glazing").unwrap();
        assert_eq!(number(glazing, "u_factor"), Some(parameters.window_u));
    }
}

#[test]
fn a_poor_assembly_still_has_a_positive_resistance() {
    let parameters = House { wall_resistance: 0.6, attic_resistance: 0.6, ..House::default() };
    assert!(resistance(&house(&parameters, &site()), "Wall") > 0.0);
}

#[test]
fn no_field_is_autosized() {
    for parameters in houses() {
        let text = house(&parameters, &site()).to_epjson().to_lowercase();
        assert!(!text.contains("autosize") && !text.contains("autocalculate"));
    }
}

#[test]
fn same_parameters_same_bytes() {
    for parameters in houses() {
        let write = || house(&parameters, &site()).to_epjson();
        assert_eq!(write(), write());
    }
}

#[test]
fn every_construction_of_a_surface_exists() {
    for parameters in houses() {
        let model = house(&parameters, &site());
        for (name, surface) in model.objects("BuildingSurface:Detailed") {
            let construction = text(surface, "construction_name").unwrap();
            let classes =
                ["Construction", "Construction:CfactorUndergroundWall", "Construction:FfactorGroundFloor"];
            assert!(classes.iter().any(|class| model.contains(class, construction)), "{name}");
        }
    }
}

#[test]
fn the_heated_zone_is_the_first_of_two_to_four() {
    assert_eq!(house(&House::default(), &site()).names("Zone"), [LIVING, ATTIC]);
    let parameters = House { foundation: Foundation::Crawlspace, garage: true, ..House::default() };
    assert_eq!(house(&parameters, &site()).names("Zone"), [LIVING, ATTIC, CRAWLSPACE, GARAGE]);
}

/// A surface between zones and its twin have the same layers, in opposite order.
#[test]
fn surfaces_between_zones_are_pairs() {
    for parameters in houses() {
        let model = house(&parameters, &site());
        for (name, surface) in model.objects("BuildingSurface:Detailed") {
            let Some(other) = text(surface, "outside_boundary_condition_object") else { continue };
            let twin = model.require("BuildingSurface:Detailed", other).unwrap();
            assert_eq!(text(twin, "outside_boundary_condition_object"), Some(name));
            let (ours, theirs) = (area_vector(&vertices(surface)), area_vector(&vertices(twin)));
            (0..3).for_each(|axis| close(ours[axis], -theirs[axis]));
            let layers = |surface: &Fields| {
                let construction = text(surface, "construction_name").unwrap();
                let layers = model.require("Construction", construction).unwrap();
                let fields = ["outside_layer", "layer_2", "layer_3", "layer_4"];
                fields.iter().filter_map(|f| text(layers, f)).map(str::to_owned).collect::<Vec<_>>()
            };
            let mut mirrored = layers(twin);
            mirrored.reverse();
            assert_eq!(layers(surface), mirrored, "{name}");
        }
    }
}

#[test]
fn the_commands_are_constant_schedules_and_the_damper_starts_closed() {
    let model = house(&House::default(), &site());
    let value = |name| number(model.require("Schedule:Constant", name).unwrap(), "hourly_value");
    assert_eq!(value("Living Supply Air Flow Fraction"), Some(0.0));
    assert_eq!(value("Living Supply Air Temperature"), Some(21.0));
    assert!(value("Living Heating Setpoint") < value("Living Cooling Setpoint"));
    let managers = model.objects("SetpointManager:Scheduled");
    assert_eq!(managers.len(), 4);
    for (_, manager) in managers {
        assert_eq!(text(manager, "schedule_name"), Some("Living Supply Air Temperature"));
    }
}

#[test]
fn the_design_flow_carries_the_backup_at_45_degrees() {
    for parameters in houses() {
        let sizes = Capacities::for_design_days(&parameters, &site());
        let rise = sizes.backup / (sizes.flow * 1.204 * 1006.0);
        assert!(rise <= 24.0 + TOLERANCE, "{rise}");
        let loss = hvac::loads::heat_loss(&parameters, &site());
        close(sizes.backup, 1.3 * loss);
        let model = house(&parameters, &site());
        let terminal = model.objects("AirTerminal:SingleDuct:VAV:NoReheat");
        assert_eq!(number(terminal[0].1, "maximum_air_flow_rate"), Some(sizes.flow));
    }
}

#[test]
fn leakage_increases_heat_loss_and_given_sizes_are_kept() {
    let tight = House::default();
    let leaky = House { air_changes_50: 8.0, ..tight.clone() };
    assert!(hvac::loads::heat_loss(&leaky, &site()) > 1.1 * hvac::loads::heat_loss(&tight, &site()));
    let sizes = Capacities { flow: 0.2, cooling: 4000.0, heating: 3500.0, backup: 8600.0 };
    let model = house(&House { capacities: Some(sizes), ..tight }, &site());
    let heater = model.require("Coil:Heating:Electric", "Backup Heater").unwrap();
    assert_eq!(number(heater, "nominal_capacity"), Some(8600.0));
}

#[test]
fn a_house_in_a_hot_place_has_heating_equipment() {
    let mut site = site();
    site.heating.dry_bulb = 25.0;
    site.ground_temperatures = [25.0; 12];
    let sizes = Capacities::for_design_days(&House::default(), &site);
    assert!(sizes.flow > 0.0 && sizes.cooling > 0.0);
}

#[test]
fn the_coils_follow_the_heating_system() {
    for parameters in houses() {
        let model = house(&parameters, &site());
        let class = match parameters.heating.heater() {
            Heater::Electric => "Coil:Heating:Electric",
            Heater::Fuel { .. } => "Coil:Heating:Fuel",
        };
        let unit = model.objects("AirLoopHVAC:UnitarySystem")[0].1;
        let coil = |role: &str| text(unit, &format!("{role}_object_type"));
        match parameters.heating {
            Heating::HeatPump { .. } => {
                assert_eq!(coil("heating_coil"), Some("Coil:Heating:DX:SingleSpeed"));
                assert_eq!(coil("supplemental_heating_coil"), Some(class));
                assert!(model.contains(class, "Backup Heater"));
            }
            Heating::Furnace(_) => {
                assert_eq!(coil("heating_coil"), Some(class));
                assert_eq!(coil("supplemental_heating_coil"), None);
                assert!(model.contains(class, "Furnace"));
            }
        }
    }
}

#[test]
fn a_parameter_out_of_bounds_is_named_with_its_value_and_bounds() {
    let refused = |house: House| super::house(&house, &site()).unwrap_err().to_string();
    let why = refused(House { floor_area: 5.0, ..House::default() });
    assert_eq!(why, "parameter `floor_area` is 5; expected a number from 40 to 1000 m²");
    for house in [
        House { window_u: f64::NAN, ..House::default() },
        House { storeys: 3, ..House::default() },
        House { air_changes_50: f64::INFINITY, ..House::default() },
        House { heating: Heating::Furnace(Heater::Fuel { efficiency: 1.2 }), ..House::default() },
        House { heat_recovery: -0.1, ..House::default() },
    ] {
        assert!(refused(house).contains("expected a number from"));
    }
}
