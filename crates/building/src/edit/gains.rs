//! Internal gains: people, lights and equipment.

use super::geometry::multiply;
use crate::Model;
use crate::model::{Fields, number, text};
use crate::people::{self, PeopleGroup};
use crate::zone::{Zone, covered, place, zones};

/// A kind of gains: the classes with their fields.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    classes: &'static [Class],
}

/// The fields of a class that give its gains; the calculation method selects one.
#[derive(Debug)]
struct Class {
    name: &'static str,
    /// Per object, W or people.
    level: &'static str,
    /// Per floor area, W/m² or people/m².
    per_area: &'static str,
    /// Per person, W; for people the floor area of one, m².
    per_person: &'static str,
}

const fn watts(name: &'static str, level: &'static str) -> Class {
    Class { name, level, per_area: "watts_per_floor_area", per_person: "watts_per_person" }
}

const fn power(name: &'static str) -> Class {
    Class { name, level: "design_level", per_area: "power_per_floor_area", per_person: "power_per_person" }
}

/// People.
pub const PEOPLE: Gains = Gains {
    classes: &[Class {
        name: "People",
        level: "number_of_people",
        per_area: "people_per_floor_area",
        per_person: "floor_area_per_person",
    }],
};
/// Lights in zones; exterior lights are not gains.
pub const LIGHTS: Gains = Gains { classes: &[watts("Lights", "lighting_level")] };
/// Equipment in zones.
pub const EQUIPMENT: Gains = Gains {
    classes: &[
        watts("ElectricEquipment", "design_level"),
        watts("ElectricEquipment:ITE:AirCooled", "watts_per_unit"),
        power("GasEquipment"),
        power("HotWaterEquipment"),
        power("SteamEquipment"),
        power("OtherEquipment"),
    ],
};

/// Multiplies gains in every form, and returns the number of objects. A floor area per person is divided.
pub fn scale(model: &mut Model, gains: &Gains, multiplier: f64) -> usize {
    let mut count = 0;
    for class in gains.classes {
        for name in model.names(class.name) {
            let Some(fields) = model.get_mut(class.name, &name) else { continue };
            multiply(fields, class.level, multiplier);
            multiply(fields, class.per_area, multiplier);
            let is_area = class.per_person == "floor_area_per_person";
            multiply(fields, class.per_person, if is_area { 1.0 / multiplier } else { multiplier });
            count += 1;
        }
    }
    count
}

/// Returns the design level of gains per floor area of the zones that are part of it, W/m² or people/m²; `None` if it
/// cannot be computed.
pub(super) fn intensity(model: &Model, gains: &Gains) -> Option<f64> {
    let (mut total, mut floor) = (0.0, 0.0);
    let people = people::groups(model).ok()?;
    for zone in zones(model).ok()? {
        let level = match gains.classes {
            [class] if class.name == "People" => people::at_design(&people, &zone.name),
            classes => power_of(model, classes, &people, &zone)?,
        };
        total += level * zone.multiplier;
        let part = model.get("Zone", &zone.name).and_then(|fields| text(fields, "part_of_total_floor_area"));
        if !part.is_some_and(|part| part.eq_ignore_ascii_case("No")) {
            floor += zone.floor_area * zone.multiplier;
        }
    }
    (floor > 0.0).then(|| total / floor)
}

/// Returns the design level of gains in a zone, W; `None` if a field or the power of server units is missing.
fn power_of(model: &Model, classes: &[Class], people: &[PeopleGroup], zone: &Zone) -> Option<f64> {
    let mut sum = 0.0;
    for class in classes {
        for (_, fields) in model.objects(class.name) {
            for space in covered(model, place(fields)?, &zone.name) {
                let Some(space) = space else {
                    sum += class.level_of(fields, zone.floor_area, people::at_design(people, &zone.name))?;
                    continue;
                };
                let own = people.iter().filter(|group| group.space.as_ref() == Some(&space.name));
                sum += class.level_of(fields, space.floor_area, own.map(|group| group.people).sum())?;
            }
        }
    }
    Some(sum)
}

impl Class {
    /// Returns the power of an object in a zone or space with a floor area and people, W.
    fn level_of(&self, fields: &Fields, area: f64, people: f64) -> Option<f64> {
        let method = text(fields, "design_level_calculation_method").unwrap_or_default();
        match method.to_ascii_lowercase().as_str() {
            // The number of server units comes from another field.
            _ if self.level == "watts_per_unit" => None,
            method if method.ends_with("/area") => Some(area * number(fields, self.per_area)?),
            method if method.ends_with("/person") => Some(people * number(fields, self.per_person)?),
            _ => number(fields, self.level),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn every_form_scales_and_the_area_of_a_person_shrinks() {
        let mut model = Model::default();
        let people =
            json!({"number_of_people": 4, "people_per_floor_area": 0.1, "floor_area_per_person": 20});
        model.insert("People", "P", people);
        assert_eq!(scale(&mut model, &PEOPLE, 2.0), 1);
        let people = model.get("People", "P").unwrap();
        assert_eq!(people["number_of_people"], 8.0);
        assert_eq!(people["people_per_floor_area"], 0.2);
        assert_eq!(people["floor_area_per_person"], 10.0);
        for (class, gains) in
            [("Lights", LIGHTS), ("ElectricEquipment", EQUIPMENT), ("OtherEquipment", EQUIPMENT)]
        {
            let of_class = gains.classes.iter().find(|each| each.name == class).unwrap();
            for field in [of_class.level, of_class.per_area, of_class.per_person] {
                model.insert(class, field, json!({field: -2.0}));
            }
            assert_eq!(scale(&mut model, &gains, 1.5), 3 + usize::from(class == "OtherEquipment") * 3);
            for field in [of_class.level, of_class.per_area, of_class.per_person] {
                assert_eq!(model.get(class, field).unwrap()[field], -3.0, "{class} {field}");
            }
        }
    }

    #[test]
    fn the_intensity_covers_the_selected_forms() {
        let mut model = Model::default();
        model.insert("Zone", "A", json!({"floor_area": 50.0, "multiplier": 2}));
        model.insert("Zone", "B", json!({"floor_area": 100.0}));
        let place = "zone_or_zonelist_or_space_or_spacelist_name";
        model.insert(
            "People",
            "P",
            json!({place: "A", "number_of_people_calculation_method": "Area/Person", "floor_area_per_person": 10,
                "clothing_insulation_calculation_method": "ClothingInsulationSchedule"}),
        );
        let method = "design_level_calculation_method";
        model.insert("Lights", "1", json!({place: "a", method: "Watts/Person", "watts_per_person": 100}));
        model.insert("Lights", "2", json!({place: "B", method: "Watts/Area", "watts_per_floor_area": 8}));
        model.insert("Lights", "3", json!({place: "B", method: "LightingLevel", "lighting_level": 200}));
        assert_eq!(intensity(&model, &PEOPLE), Some(10.0 / 200.0));
        assert_eq!(intensity(&model, &LIGHTS), Some((2.0 * 500.0 + 800.0 + 200.0) / 200.0));
        // An attic is not part of the floor area.
        model.insert("Zone", "C", json!({"floor_area": 900.0, "part_of_total_floor_area": "No"}));
        assert_eq!(intensity(&model, &PEOPLE), Some(10.0 / 200.0));
        // In a space, densities apply to its floor and its people; in a list, to each space.
        for (space, floor_area) in [("West", 60.0), ("East", 40.0)] {
            model.insert("Space", space, json!({"zone_name": "B", "floor_area": floor_area}));
        }
        model.insert(
            "SpaceList",
            "Both",
            json!({"spaces": [{"space_name": "West"}, {"space_name": "East"}]}),
        );
        model.insert("People", "Q", json!({place: "west", "number_of_people": 3}));
        model.insert("Lights", "2", json!({place: "Both", method: "LightingLevel", "lighting_level": 100}));
        model.insert("Lights", "3", json!({place: "West", method: "Watts/Person", "watts_per_person": 100}));
        model.insert("Lights", "4", json!({place: "East", method: "Watts/Area", "watts_per_floor_area": 8}));
        assert_eq!(intensity(&model, &PEOPLE), Some(13.0 / 200.0));
        assert_eq!(intensity(&model, &LIGHTS), Some((2.0 * 500.0 + 200.0 + 300.0 + 320.0) / 200.0));
    }
}
