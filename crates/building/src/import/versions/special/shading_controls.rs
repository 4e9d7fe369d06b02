//! Shading controls of windows.
//!
//! Before 9.0, a window named its control. Now a control names its windows, which are of one zone.

use std::collections::BTreeMap;

use super::tables::with_values;
use crate::import::versions::document::{Document, Field, Object};
use crate::import::versions::report::Conversion;
use crate::model::begins;

const CLASS: &str = "WindowProperty:ShadingControl";
/// Position of the control's name in a window.
const WINDOWS: [(&str, usize); 3] = [("FenestrationSurface:Detailed", 7), ("Window", 4), ("GlazedDoor", 4)];
/// The fields after the sequence number: old position, old name and new name.
const KEPT: [(usize, &str, &str); 11] = [
    (2, "shading_type", "shading_type"),
    (3, "construction_with_shading_name", "construction_with_shading_name_"),
    (4, "shading_control_type", "shading_control_type"),
    (5, "schedule_name", "schedule_name"),
    (6, "setpoint", "setpoint"),
    (7, "shading_control_is_scheduled", "shading_control_is_scheduled"),
    (8, "glare_control_is_active", "glare_control_is_active"),
    (9, "shading_device_material_name", "shading_device_material_name"),
    (10, "type_of_slat_angle_control_for_blinds", "type_of_slat_angle_control_for_blinds"),
    (11, "slat_angle_schedule_name", "slat_angle_schedule_name"),
    (12, "setpoint_2", "setpoint_2"),
];

pub(super) fn convert(document: &mut Document, version: &str, report: &mut Conversion) -> Vec<String> {
    let windows = take_controlled(document);
    let zones: BTreeMap<String, String> = document.objects.iter().filter_map(zone_of_surface).collect();
    let daylighting = document.of("Daylighting:Controls");
    let zone = Field { at: 2, name: "zone_name" };
    let daylit: BTreeMap<String, String> =
        daylighting.filter_map(|object| Some((object.get(zone)?.to_lowercase(), object.name()))).collect();
    let mut objects = Vec::new();
    for object in std::mem::take(&mut document.objects) {
        if !object.is(CLASS) {
            objects.push(object);
            continue;
        }
        for (zone, names) in of_control(&object, &windows, &zones) {
            let daylit = daylit.get(&zone.to_lowercase());
            objects.push(control(&object, &zone, daylit.map_or("", String::as_str), &names));
        }
        report.changed(version, CLASS, "is now a WindowShadingControl for each zone".to_owned());
    }
    document.objects = objects;
    Vec::new()
}

/// A window with a shading control, in lower case where it is compared.
struct Window {
    name: String,
    surface: String,
    control: String,
}

/// Returns the windows with a control, and blanks its name in them.
fn take_controlled(document: &mut Document) -> Vec<Window> {
    let mut windows = Vec::new();
    for object in &mut document.objects {
        let Some((class, at)) = WINDOWS.iter().find(|(class, _)| object.is(class)) else { continue };
        let field = Field { at: *at, name: "shading_control_name" };
        let Some(control) = object.get(field) else { continue };
        object.set(field, "");
        let surface_at = if class.starts_with('F') { 4 } else { 3 };
        let surface = object.get(Field { at: surface_at, name: "building_surface_name" }).unwrap_or_default();
        windows.push(Window {
            name: object.name(),
            surface: surface.to_lowercase(),
            control: control.to_lowercase(),
        });
    }
    windows
}

/// Returns the name of a surface in lower case, and its zone.
fn zone_of_surface(object: &Object) -> Option<(String, String)> {
    let at = if object.is("BuildingSurface:Detailed") { 4 } else { 3 };
    let is_surface = ["BuildingSurface:", "Wall:", "Roof", "Ceiling:", "Floor:"];
    is_surface.iter().any(|beginning| begins(&object.class, beginning)).then_some(())?;
    Some((object.name().to_lowercase(), object.get(Field { at, name: "zone_name" })?))
}

/// Returns the windows of a control by zone, in the order of the file.
fn of_control(
    control: &Object,
    windows: &[Window],
    zones: &BTreeMap<String, String>,
) -> Vec<(String, Vec<String>)> {
    let name = control.name().to_lowercase();
    let mut of_zones: Vec<(String, Vec<String>)> = Vec::new();
    for window in windows.iter().filter(|window| window.control == name) {
        let zone = zones.get(&window.surface).cloned().unwrap_or_default();
        match of_zones.iter_mut().find(|(known, _)| known.eq_ignore_ascii_case(&zone)) {
            Some((_, names)) => names.push(window.name.clone()),
            None => of_zones.push((zone, vec![window.name.clone()])),
        }
    }
    of_zones
}

fn control(before: &Object, zone: &str, daylighting: &str, windows: &[String]) -> Object {
    let mut values =
        vec![("zone_name", zone.to_owned()), ("shading_control_sequence_number", "1".to_owned())];
    let kept = |(at, from, to): &(usize, &'static str, &'static str)| {
        (*to, before.get(Field { at: *at, name: from }).unwrap_or_default())
    };
    values.extend(KEPT.iter().map(kept));
    values.push(("daylighting_control_object_name", daylighting.to_owned()));
    values.push(("multiple_surface_control_type", "Sequential".to_owned()));
    let name = format!("{} {zone}", before.name());
    let object = Object::like(before, "WindowShadingControl", &name, &values);
    with_values(object, "fenestration_surfaces", "fenestration_surface_name", windows)
}
