//! Floor areas of zones and spaces, by the rules of the engine: an area that the model enters comes before its floors, a
//! zone is the sum of its parts, and the parts of a zone with an entered area are scaled to it.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::model::{Fields, Model, begins, number, text};
use crate::zone::{corner, names, polygon_area};

/// Beginnings of the classes of surfaces.
const SURFACES: [&str; 5] = ["BuildingSurface:", "Ceiling:", "Floor:", "Roof", "Wall:"];

/// The surfaces of a model, as far as they bound floors.
pub(super) struct Floors(Vec<Part>);

/// A surface: its floor area, m², is 0 unless it is a floor.
struct Part {
    zone: String,
    space: Option<String>,
    area: f64,
}

/// Floor areas of a zone, m².
pub(super) struct FloorAreas {
    /// The whole zone.
    pub(super) zone: f64,
    /// Its spaces, in model order.
    pub(super) spaces: Vec<f64>,
    /// What belongs to no space, of which the engine makes another; `None` if all surfaces belong to spaces.
    pub(super) remainder: Option<f64>,
}

impl Floors {
    pub(super) fn of(model: &Model) -> Self {
        let part = |(class, _, fields): (&str, &str, &Fields)| {
            let is_floor = kind(class, fields).starts_with("floor");
            Some(Part {
                zone: text(fields, "zone_name")?.to_owned(),
                space: text(fields, "space_name").map(str::to_owned),
                area: if is_floor { drawn_area(fields)? } else { 0.0 },
            })
        };
        Self(surfaces(model).filter_map(part).collect())
    }

    /// Returns the floor areas of a zone and of its spaces.
    pub(super) fn areas(&self, model: &Model, zone: &str) -> FloorAreas {
        let own = spaces(model, zone);
        let of_space = |(name, fields): &(&str, &Fields)| {
            // To the engine, a space with an area of 0 has none, unlike a zone.
            number(fields, "floor_area").map_or_else(|| self.drawn(zone, Some(name)), |area| area.max(0.0))
        };
        let mut parts: Vec<f64> = own.iter().map(of_space).collect();
        let has_remainder = own.is_empty() || self.has_remainder(zone);
        parts.extend(has_remainder.then(|| self.drawn(zone, None)));
        let sum = total(parts.iter().copied());
        let entered = model.get("Zone", zone).and_then(|fields| number(fields, "floor_area"));
        let area = entered.filter(|area| *area > 0.0).unwrap_or(sum);
        match parts.as_mut_slice() {
            [only] => *only = area,
            several if sum > 0.0 => several.iter_mut().for_each(|part| *part *= area / sum),
            _ => {}
        }
        let remainder = if has_remainder { parts.pop() } else { None };
        FloorAreas { zone: area, spaces: parts, remainder }
    }

    /// Returns the area of the floors of a space, or of those in no space of the zone.
    fn drawn(&self, zone: &str, space: Option<&str>) -> f64 {
        let is_own = |part: &&Part| match (&part.space, space) {
            (Some(own), Some(space)) => own.eq_ignore_ascii_case(space),
            (own, space) => own.is_none() && space.is_none(),
        };
        total(self.of_zone(zone).filter(is_own).map(|part| part.area))
    }

    fn has_remainder(&self, zone: &str) -> bool {
        self.of_zone(zone).any(|part| part.space.is_none())
    }

    fn of_zone<'a>(&'a self, zone: &'a str) -> impl Iterator<Item = &'a Part> {
        self.0.iter().filter(move |part| part.zone.eq_ignore_ascii_case(zone))
    }
}

/// Enters into a user's model what the engine computes beyond the floors of a zone: floor areas with the ceilings that
/// the zone above does not repeat as its floors, and volumes by ceiling heights. Generated buildings do not count these.
pub(crate) fn enter(model: &mut Model) {
    for ((class, name), area) in with_ceilings_below(model) {
        if let Some(fields) = model.get_mut(class, &name) {
            fields.insert("floor_area".into(), json!(area));
        }
    }
    let floors = Floors::of(model);
    for zone in model.names("Zone") {
        let area = floors.areas(model, &zone).zone;
        let Some(fields) = model.get_mut("Zone", &zone) else { continue };
        let given = |field| number(fields, field).filter(|value| *value > 0.0);
        if let (None, Some(height), true) = (given("volume"), given("ceiling_height"), area > 0.0) {
            fields.insert("volume".into(), json!(area * height));
        }
    }
}

/// Returns the zones and spaces without an entered area that are above such ceilings, by class and name, with their
/// floor areas, m².
fn with_ceilings_below(model: &Model) -> BTreeMap<(&'static str, String), f64> {
    let floors = Floors::of(model);
    let mut areas = BTreeMap::new();
    for (class, _, fields) in surfaces(model) {
        let kind = kind(class, fields);
        if !kind.starts_with("ceiling") && !kind.starts_with("roof") {
            continue;
        }
        if let (Some((zone, space)), Some(area)) = (above(model, &floors, fields), drawn_area(fields)) {
            let key = space.map_or(("Zone", zone), |space| ("Space", space));
            let own = || floors.drawn(zone, space);
            *areas.entry((key.0, key.1.to_lowercase())).or_insert_with(own) += area;
        }
    }
    areas.retain(|(class, name), _| {
        let entered = model.get(class, name).and_then(|fields| number(fields, "floor_area"));
        entered.is_none_or(|area| *class == "Zone" && area <= 0.0)
    });
    areas
}

/// Returns the zone, and the space in it, of which a ceiling is the floor but that has no such surface. The engine gives
/// it to the last space of the zone; nothing can be entered for what belongs to no space.
fn above<'a>(model: &'a Model, floors: &Floors, ceiling: &'a Fields) -> Option<(&'a str, Option<&'a str>)> {
    let object = text(ceiling, "outside_boundary_condition_object")?;
    // A `Ceiling:Interzone` has no condition, but names a zone or a surface.
    let condition = text(ceiling, "outside_boundary_condition").unwrap_or("Zone");
    if condition.eq_ignore_ascii_case("Space") {
        return Some((text(model.get("Space", object)?, "zone_name")?, Some(object)));
    }
    model.get("Zone", object).filter(|_| condition.eq_ignore_ascii_case("Zone"))?;
    match spaces(model, object).pop() {
        None => Some((object, None)),
        Some((last, _)) => (!floors.has_remainder(object)).then_some((object, Some(last))),
    }
}

/// Returns the spaces of a zone, in model order.
pub(super) fn spaces<'a>(model: &'a Model, zone: &str) -> Vec<(&'a str, &'a Fields)> {
    let mut spaces = model.objects("Space");
    spaces.retain(|(_, fields)| names(fields, "zone_name", zone));
    spaces
}

/// Returns the surfaces of a model: class, name and fields.
pub(super) fn surfaces(model: &Model) -> impl Iterator<Item = (&str, &str, &Fields)> {
    let of_class = |class| model.objects(class).into_iter().map(move |(name, fields)| (class, name, fields));
    classes(model).flat_map(of_class)
}

/// Returns the classes of surfaces that a model has.
pub(super) fn classes(model: &Model) -> impl Iterator<Item = &str> {
    model.classes().filter(|class| SURFACES.iter().any(|beginning| begins(class, beginning)))
}

/// Returns the kind of a surface in lower case: its type, or the class of one without a type.
pub(super) fn kind(class: &str, fields: &Fields) -> String {
    text(fields, "surface_type").unwrap_or(class).to_ascii_lowercase()
}

/// Returns the area of a surface from its corners, or else from its length and width, m².
fn drawn_area(fields: &Fields) -> Option<f64> {
    match fields.get("vertices").and_then(Value::as_array) {
        Some(vertices) => Some(polygon_area(&vertices.iter().map(corner).collect::<Option<Vec<_>>>()?)),
        None => Some(number(fields, "length")? * number(fields, "width")?),
    }
}

/// Returns a sum of areas. `sum` would return -0 for an empty list.
fn total(areas: impl Iterator<Item = f64>) -> f64 {
    areas.fold(0.0, |sum, area| sum + area)
}
