//! People in a model, divided as in the engine: a `People` object applies once to every zone or space that it names.

use crate::Result;
use crate::hvac::zone_equipment::has_exhaust;
use crate::model::{Fields, Model, number, text};
use crate::zone::{self, Zone};

/// Share of the people at design occupancy from which a zone counts as in use in operation tasks. Prototypes
/// schedule 5 % of their people at night, on Sundays and before opening, when they supply no outdoor air: a cleaner or
/// a guard does not turn a building on. Infiltration alone gives each of these few people 5 to 35 L/s in a medium
/// office in Tampa.
const IN_USE: f64 = 0.1;
/// Relative difference between a number of people that the engine computes and the same product here.
const ROUNDING: f64 = 1e-9;

/// Returns the least number of people with which a zone is in use. In a room with exhaust fans, anyone counts: a hood
/// runs for a single cook, and needs make-up air.
///
/// # Errors
/// The errors of [`zone_equipment`](crate::hvac::zone_equipment::zone_equipment).
pub fn least_in_use(model: &Model, groups: &[PeopleGroup], zone: &str) -> Result<f64> {
    let share = if has_exhaust(model, zone)? { 0.0 } else { IN_USE * (1.0 - ROUNDING) };
    Ok(share * at_design(groups, zone))
}

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
        let place = zone::place(fields).unwrap_or_default();
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

/// Returns the people of a zone at design occupancy.
pub fn at_design(groups: &[PeopleGroup], zone: &str) -> f64 {
    groups.iter().filter(|group| group.zone.eq_ignore_ascii_case(zone)).map(|group| group.people).sum()
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
    let listed = |name: &str| (!place.eq_ignore_ascii_case(name)).then(|| name.to_owned());
    let covered = zone::covered(model, place, &zone.name);
    if covered != [None] {
        let part = |space: zone::Space| Part {
            prefix: listed(&space.name),
            floor_area: space.floor_area,
            share: 1.0,
            space: Some(space.name),
        };
        return covered.into_iter().flatten().map(part).collect();
    }
    let spaces = zone::spaces(model, &zone.name);
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

/// Returns the number of people that a `People` object assigns to a floor area, by its calculation method.
fn count(fields: &Fields, floor_area: f64) -> f64 {
    let value = |field: &str| number(fields, field);
    let method = text(fields, "number_of_people_calculation_method").unwrap_or_default();
    let people = match method.to_ascii_lowercase().as_str() {
        "people/area" => value("people_per_floor_area").map(|density| density * floor_area),
        "area/person" => value("floor_area_per_person").map(|area| floor_area / area),
        _ => value("number_of_people"),
    };
    people.unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::json;

    use super::*;

    #[test]
    fn the_calculation_method_selects_the_field() {
        let of = |method: Option<&str>| {
            let mut fields =
                json!({"number_of_people": 7, "people_per_floor_area": 0.1, "floor_area_per_person": 20});
            if let Some(method) = method {
                fields["number_of_people_calculation_method"] = json!(method);
            }
            count(fields.as_object().unwrap(), 50.0)
        };
        assert_eq!(
            [None, Some("People"), Some("people/area"), Some("Area/Person")].map(of),
            [7.0, 7.0, 5.0, 2.5]
        );
    }

    #[test]
    fn a_tenth_of_the_people_use_a_zone_and_anyone_a_room_with_a_hood() {
        let place = "zone_or_zonelist_or_space_or_spacelist_name";
        let text = json!({
            "Zone": {"Hall": {"floor_area": 100.0}, "Kitchen": {"floor_area": 50.0}},
            "People": {
                "Guests": {place: "Hall", "number_of_people": 50},
                "Waiters": {place: "Hall", "number_of_people": 5},
                "Cooks": {place: "Kitchen", "number_of_people": 6},
            },
            "ZoneHVAC:EquipmentConnections": {"K": {
                "zone_name": "Kitchen", "zone_conditioning_equipment_list_name": "Equipment"}},
            "ZoneHVAC:EquipmentList": {"Equipment": {"equipment": [{
                "zone_equipment_object_type": "Fan:ZoneExhaust", "zone_equipment_name": "Hood"}]}},
        });
        let model = Model::from_epjson(&text.to_string(), Path::new("test.epJSON")).unwrap();
        let groups = groups(&model).unwrap();
        let least = |zone| least_in_use(&model, &groups, zone).unwrap();
        assert!((least("Hall") - 5.5).abs() < 1e-6 && least("Hall") <= 55.0 * 0.1);
        assert_eq!(least("Kitchen"), 0.0);
    }
}
