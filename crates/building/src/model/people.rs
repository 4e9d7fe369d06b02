//! People in a model, divided like in the engine: a `People` object applies once to every zone or space that it names.

use crate::Result;
use crate::model::{Fields, Model, number, text};
use crate::zone::{self, Zone, covers_space, covers_zone};

/// The people that a `People` object assigns to a zone or a space.
#[derive(Clone, Debug, PartialEq)]
pub struct PeopleGroup {
    /// Name in the engine.
    pub name: String,
    /// Zone.
    pub zone: String,
    /// Space, if the zone is divided.
    pub space: Option<String>,
    /// Schedule of the share of people who are present.
    pub schedule: String,
    /// People at design occupancy.
    pub people: f64,
}

/// Returns the groups of people of a model.
///
/// # Errors
/// The errors of [`zone::zones`].
pub fn groups(model: &Model) -> Result<Vec<PeopleGroup>> {
    let zones = zone::zones(model)?;
    let mut groups = Vec::new();
    for (object, fields) in model.objects("People") {
        let place = text(fields, "zone_or_zonelist_or_space_or_spacelist_name").unwrap_or_default();
        for zone in &zones {
            groups.extend(parts(model, place, zone).into_iter().map(|part| PeopleGroup {
                name: part.prefix.map_or(object.to_owned(), |prefix| format!("{prefix} {object}")),
                zone: zone.name.clone(),
                space: part.space,
                schedule: text(fields, "number_of_people_schedule_name").unwrap_or_default().to_owned(),
                people: count(fields, part.floor_area) * part.share,
            }));
        }
    }
    Ok(groups)
}

/// A part of a zone to which a `People` object applies.
struct Part {
    /// Prefix that the engine adds to the name of the object.
    prefix: Option<String>,
    space: Option<String>,
    /// Floor area for which the object counts people, m², and the share of the people in this part.
    floor_area: f64,
    share: f64,
}

/// Returns the parts of a zone that a place covers: the name of a zone, of a space or of a list.
fn parts(model: &Model, place: &str, zone: &Zone) -> Vec<Part> {
    let spaces = zone::spaces(model, &zone.name);
    let listed = |name: &str| (!place.eq_ignore_ascii_case(name)).then(|| name.to_owned());
    if !covers_zone(model, place, &zone.name) {
        let spaces = spaces.into_iter().filter(|space| covers_space(model, place, &space.name));
        let part = |space: zone::Space| Part {
            prefix: listed(&space.name),
            floor_area: space.floor_area,
            share: 1.0,
            space: Some(space.name),
        };
        return spaces.map(part).collect();
    }
    let mut rooms: Vec<_> =
        spaces.into_iter().map(|space| (space.floor_area, space.name.clone(), Some(space.name))).collect();
    if !rooms.is_empty()
        && let Some(floor_area) = zone::undivided_floor_area(model, &zone.name)
    {
        rooms.push((floor_area, format!("{}-Remainder", zone.name), None));
    }
    if rooms.len() < 2 {
        let (floor_area, space) =
            rooms.pop().map_or((zone.floor_area, None), |(floor_area, _, space)| (floor_area, space));
        return vec![Part { prefix: listed(&zone.name), space, floor_area, share: 1.0 }];
    }
    let total: f64 = rooms.iter().map(|(floor_area, ..)| floor_area).sum();
    let part = |(floor_area, name, space)| Part {
        prefix: Some(name),
        space,
        floor_area: total,
        share: floor_area / total,
    };
    rooms.into_iter().map(part).collect()
}

/// Returns the number of people that a `People` object assigns to a floor area.
fn count(fields: &Fields, floor_area: f64) -> f64 {
    let value = |field: &str| number(fields, field);
    value("number_of_people")
        .or_else(|| Some(value("people_per_floor_area")? * floor_area))
        .or_else(|| Some(floor_area / value("floor_area_per_person")?))
        .unwrap_or(0.0)
}
