use std::collections::BTreeMap;

use b2b_building::Model;
use b2b_building::model::{number as value, text};
use b2b_building::zone::{SurfaceKind, surfaces};
use b2b_climate::Site;

use super::*;
use crate::house::{Geometry, LIVING, house};
use crate::tests::MONTREAL;

const COUNT: usize = 1000;

/// A Latin hypercube: the values of each coordinate are evenly spread, in a random order.
fn samples() -> Vec<HouseSample> {
    let mut state = 1u64;
    let mut next = move || {
        // Knuth's multiplier; the high bits are good enough to shuffle a test.
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize
    };
    let mut points = vec![[0.0; DIMENSIONS]; COUNT];
    for dimension in 0..DIMENSIONS {
        let mut order: Vec<usize> = (0..COUNT).collect();
        (1..COUNT).rev().for_each(|i| order.swap(i, next() % (i + 1)));
        for (point, rank) in points.iter_mut().zip(order) {
            point[dimension] = (rank as f64 + 0.5) / COUNT as f64;
        }
    }
    points.iter().map(|point| HouseSample::from_unit(point).unwrap()).collect()
}

fn site() -> Site {
    Site::from_epw(MONTREAL, std::path::Path::new("a.epw")).unwrap()
}

fn share_of(samples: &[HouseSample], holds: impl Fn(&HouseSample) -> bool) -> f64 {
    samples.iter().filter(|sample| holds(sample)).count() as f64 / samples.len() as f64
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found:.4} is not {expected:.4}");
}

#[test]
fn vintages_regions_and_foundations_have_their_shares() {
    let samples = samples();
    for (vintage, expected) in Vintage::ALL.iter().zip([0.1004, 0.2609, 0.2664, 0.3285, 0.0438]) {
        close(share_of(&samples, |s| s.vintage == *vintage), expected, 0.0015, vintage.name());
    }
    for (region, expected) in [("Montérégie", 0.1953), ("Côte-Nord", 0.0237), ("Laval", 0.0347)] {
        close(share_of(&samples, |s| s.location.name() == region), expected, 0.0015, region);
    }
    let on = |foundation| share_of(&samples, |s| s.house.foundation == foundation);
    close(on(Foundation::Basement), 0.8376 + 0.0182, 0.0015, "basement");
    close(on(Foundation::Slab), 0.0912, 0.0015, "slab");
    close(on(Foundation::Crawlspace), 0.0529, 0.0015, "crawlspace");
    close(share_of(&samples, |s| s.house.garage), 0.2208, 0.0015, "garage");
}

/// Three standard errors of a share over 1000 independent draws are up to 0.047.
#[test]
fn storeys_windows_people_and_systems_have_their_shares() {
    let samples = samples();
    let levels = |n| {
        share_of(&samples, |s| s.house.storeys + u32::from(s.house.foundation == Foundation::Basement) == n)
    };
    close(levels(1), 0.1204, 0.03, "one level");
    close(levels(2), 0.6259, 0.045, "two levels");
    close(levels(3), 0.2536, 0.04, "three levels");
    let glass = |u: f64| share_of(&samples, |s| (s.house.window_u - u * IMPERIAL_U).abs() < 1e-9);
    close(glass(0.49), 0.604, 0.045, "double clear");
    close(glass(0.37), 0.1697 + 0.0182, 0.035, "low gain");
    close(glass(0.76), 0.073, 0.025, "metal");
    close(glass(0.29), 0.0566, 0.02, "triple");
    for (people, expected) in [(1.0, 0.1807), (2.0, 0.4526), (3.0, 0.1168), (4.0, 0.1478), (5.0, 0.1022)] {
        close(share_of(&samples, |s| s.house.occupants == people), expected, 0.0015, "people");
    }
    let pumps = share_of(&samples, |s| matches!(s.house.heating, Heating::HeatPump { .. }));
    let fuel = share_of(&samples, |s| matches!(s.house.heating.heater(), Heater::Fuel { .. }));
    close(pumps, (0.0839 + 0.0437) / 0.2115, 0.002, "heat pumps");
    close(fuel, (0.0437 + 0.0328) / 0.2115, 0.002, "fuel");
    close(share_of(&samples, |s| s.house.heat_recovery > 0.0), 0.2179, 0.002, "heat recovery");
    for (class, expected) in [(0.09, 0.2682), (0.12, 0.2847), (0.18, 0.1752), (0.30, 0.0365)] {
        let found = share_of(&samples, |s| (s.house.window_to_wall - class).abs() < HALF_WINDOW_CLASS);
        close(found, expected, 0.002, "window to wall");
    }
}

/// Means of the stock table's summary; three standard errors of a mean of some 100 to 300 draws.
#[test]
fn airtightness_and_insulation_follow_the_vintage() {
    let samples = samples();
    let walls = [14.5, 14.2, 18.3, 21.0, 24.5];
    for (i, (expected, tolerance)) in
        [(8.4, 1.1), (6.1, 0.85), (4.0, 0.4), (3.8, 0.35), (2.0, 0.6)].into_iter().enumerate()
    {
        let vintage = Vintage::ALL[i];
        let of = || samples.iter().filter(|s| s.vintage == vintage).map(|s| &s.house);
        close(mean(of().map(|h| h.air_changes_50)), expected, tolerance, vintage.name());
        close(mean(of().map(|h| h.wall_resistance / IMPERIAL_R)), walls[i], 0.35, vintage.name());
        let [first, end] = vintage.years();
        let years = || samples.iter().filter(|s| s.vintage == vintage).map(|s| f64::from(s.year));
        assert!(years().all(|year| (first..end).contains(&year)));
    }
    let newest = samples.iter().filter(|s| s.vintage == Vintage::From2013);
    assert!(newest.into_iter().all(|s| s.house.attic_resistance > 40.0 * IMPERIAL_R));
}

#[test]
fn floor_area_has_the_mean_and_the_quartiles_of_the_stock() {
    let samples = samples();
    let mut areas: Vec<f64> = samples.iter().map(|s| s.house.floor_area).collect();
    areas.sort_by(f64::total_cmp);
    close(mean(areas.iter().copied()), 188.0, 8.0, "mean");
    close(areas[COUNT / 4], 137.0, 5.0, "first quartile");
    close(areas[COUNT / 2], 161.0, 5.0, "median");
    close(areas[3 * COUNT / 4], 204.0, 12.0, "third quartile");
    close(mean(samples.iter().map(|s| s.house.aspect)), 1.8, 0.01, "aspect");
}

#[test]
fn two_to_four_zones_and_the_same_bytes_twice() {
    let site = site();
    let write = || -> Vec<(usize, String)> {
        let model = |s: &HouseSample| house(&s.house, &site).unwrap();
        samples().iter().map(model).map(|m| (m.names("Zone").len(), m.to_epjson())).collect()
    };
    let start = std::time::Instant::now();
    let first = write();
    println!("{COUNT} houses in {:?}", start.elapsed());
    let mut counts = BTreeMap::new();
    first.iter().for_each(|(zones, _)| *counts.entry(zones).or_insert(0) += 1);
    assert_eq!(counts.keys().copied().copied().collect::<Vec<_>>(), [2, 3, 4], "{counts:?}");
    assert!(first == write());
}

/// Properties read only from the model.
#[test]
fn the_model_has_the_properties_of_its_sample() {
    let site = site();
    for sample in samples().iter().step_by(10) {
        let (house_, model) = (&sample.house, house(&sample.house, &site).unwrap());
        let surfaces = surfaces(&model).unwrap();
        let of_living = |kind| surfaces.iter().filter(move |s| s.zone == LIVING && s.kind == kind);
        let within = |found: f64, expected: f64, what| close(found, expected, 0.01 * expected, what);
        within(of_living(SurfaceKind::Floor).map(|s| s.area()).sum(), house_.floor_area, "floor area");
        let outer = |construction: &str| {
            let walls = of_living(SurfaceKind::Wall)
                .filter(|s| s.boundary == "Outdoors" && s.construction == construction);
            walls.map(|s| s.area()).sum::<f64>()
        };
        within(window_area(&model) / outer("Wall"), house_.window_to_wall, "window to wall");
        within(1.0 / resistance(&model, "Wall", 0.15), 1.0 / (0.8 * house_.wall_resistance), "wall U");
        within(1.0 / resistance(&model, "Ceiling", 0.22), 1.0 / (0.9 * house_.attic_resistance), "attic U");
        let glazing = model.objects("WindowMaterial:SimpleGlazingSystem")[0].1;
        within(value(glazing, "u_factor").unwrap(), house_.window_u, "window U");
        within(value(glazing, "solar_heat_gain_coefficient").unwrap(), house_.window_shgc, "SHGC");
        let leaks = model.objects("ZoneInfiltration:FlowCoefficient")[0].1;
        let at = |pressure: f64| {
            let exponent = value(leaks, "pressure_exponent").unwrap();
            value(leaks, "flow_coefficient").unwrap() * pressure.powf(exponent)
        };
        let volume = Geometry::new(house_).living_volume();
        within(at(50.0) * 3600.0 / volume, house_.air_changes_50, "air changes at 50 Pa");
        let at_4 = house_.air_changes_50 * volume / 3600.0 * (4.0f64 / 50.0).powf(0.65);
        within(at(4.0), at_4, "infiltration at 4 Pa");
    }
}

fn window_area(model: &Model) -> f64 {
    let windows = model.objects("FenestrationSurface:Detailed");
    let corner = |fields: &b2b_building::model::Fields, n: usize| {
        ["x", "y", "z"].map(|axis| value(fields, &format!("vertex_{n}_{axis}_coordinate")).unwrap())
    };
    let length = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
    let area = |(_, w): &(&str, &b2b_building::model::Fields)| {
        length(corner(w, 1), corner(w, 2)) * length(corner(w, 2), corner(w, 3))
    };
    windows.iter().map(area).sum()
}

/// Resistance with films of a layered construction, m²K/W.
fn resistance(model: &Model, construction: &str, films: f64) -> f64 {
    let layers = model.require("Construction", construction).unwrap();
    let layer = |name: &str| match model.get("Material", name) {
        Some(m) => value(m, "thickness").unwrap() / value(m, "conductivity").unwrap(),
        None => value(model.get("Material:NoMass", name).unwrap(), "thermal_resistance").unwrap(),
    };
    let names = layers.keys().filter_map(|key| text(layers, key));
    films + names.map(layer).sum::<f64>()
}

#[test]
fn a_point_outside_the_unit_cube_is_rejected() {
    for value in [-0.1, 1.1, f64::NAN] {
        let mut point = [0.5; DIMENSIONS];
        point[3] = value;
        let error = HouseSample::from_unit(&point).unwrap_err().to_string();
        assert!(error.contains("coordinate") && error.contains("from 0 to 1"), "{error}");
    }
    assert!(HouseSample::from_unit(&[0.0; DIMENSIONS]).unwrap().house.check().is_ok());
    assert!(HouseSample::from_unit(&[1.0; DIMENSIONS]).unwrap().house.check().is_ok());
}

#[test]
fn ratings_become_plausible_gross_cops() {
    close(heating_cop(7.7), 3.65, 0.05, "HSPF 7.7");
    close(cooling_cop(13.0), 3.87, 0.05, "SEER 13");
}
