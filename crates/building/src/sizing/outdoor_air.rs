//! Outdoor air of controllers of mechanical ventilation that leave its specification to `Sizing:Zone`.

use serde_json::Value;

use crate::Model;
use crate::model::{Fields, items, text};
use crate::zone::covers_zone;

const CONTROLLER: &str = "Controller:MechanicalVentilation";
/// The list of zones of a controller.
const ZONES: &str = "zone_specifications";
/// Field of a zone or a list of zones, in a controller and in `Sizing:Zone`.
const ZONE: &str = "zone_or_zonelist_name";
/// What a controller may leave to `Sizing:Zone`, under the same name.
const SPECIFICATIONS: [&str; 2] = [
    "design_specification_outdoor_air_object_name",
    "design_specification_zone_air_distribution_object_name",
];

/// Writes into every controller of mechanical ventilation the names that it leaves to `Sizing:Zone`: without them, the
/// engine uses defaults. A list of zones whose specification is blank becomes its zones.
pub(super) fn name_in_controllers(model: &mut Model) {
    for name in model.names(CONTROLLER) {
        let Some(fields) = model.get(CONTROLLER, &name) else { continue };
        let entries: Vec<Value> =
            items(fields, ZONES).flat_map(|entry| complete(model, entry)).map(Value::Object).collect();
        if let Some(fields) = model.get_mut(CONTROLLER, &name)
            && fields.contains_key(ZONES)
        {
            fields.insert(ZONES.into(), entries.into());
        }
    }
}

/// Returns an entry of a controller with the specifications that it leaves to `Sizing:Zone`, one per zone of a list.
fn complete(model: &Model, entry: &Fields) -> Vec<Fields> {
    let is_blank = |field: &&str| text(entry, field).is_none();
    let blank: Vec<&str> = SPECIFICATIONS.into_iter().filter(is_blank).collect();
    let Some(zones) = text(entry, ZONE).filter(|_| !blank.is_empty()) else { return vec![entry.clone()] };
    let list = model.get("ZoneList", zones);
    let zones = list.map_or_else(
        || vec![zones],
        |list| items(list, "zones").filter_map(|item| text(item, "zone_name")).collect(),
    );
    let completed: Vec<Fields> = zones.iter().map(|zone| of_zone(model, entry, zone, &blank)).collect();
    let is_same = completed.iter().all(|own| blank.iter().all(|field| own.get(*field) == entry.get(*field)));
    if is_same { vec![entry.clone()] } else { completed }
}

/// Returns the entry of a zone with what `Sizing:Zone` gives for the blank fields.
fn of_zone(model: &Model, entry: &Fields, zone: &str, blank: &[&str]) -> Fields {
    let mut own = entry.clone();
    let is_of_zone = |(_, fields): &(&str, &Fields)| {
        text(fields, ZONE).is_some_and(|zones| covers_zone(model, zones, zone))
    };
    let Some((_, sizing)) = model.objects("Sizing:Zone").into_iter().find(is_of_zone) else { return own };
    for field in blank {
        if let Some(name) = text(sizing, field) {
            own.insert(ZONE.into(), zone.into());
            own.insert((*field).to_owned(), name.into());
        }
    }
    own
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::json;

    use super::*;

    #[test]
    fn a_controller_names_what_it_left_to_the_sizing_of_its_zones() {
        let [air, distribution] = SPECIFICATIONS;
        let model = json!({
            (CONTROLLER): {"C": {(ZONES): [
                {(ZONE): "All"}, {(ZONE): "C", (air): "Own", (distribution): "Own"}, {(ZONE): "D"}]}},
            "ZoneList": {"All": {"zones": [{"zone_name": "A"}, {"zone_name": "B"}]}},
            "Sizing:Zone": {
                "SA": {(ZONE): "a", (air): "Air A", (distribution): "Even"},
                "SB": {(ZONE): "B", (air): "Air B"},
                "SC": {(ZONE): "C", (air): "Air C"}},
        });
        let mut model = Model::from_epjson(&model.to_string(), Path::new("a.epJSON")).unwrap();
        name_in_controllers(&mut model);
        let entries = json!([
            {(ZONE): "A", (air): "Air A", (distribution): "Even"},
            {(ZONE): "B", (air): "Air B"},
            {(ZONE): "C", (air): "Own", (distribution): "Own"},
            {(ZONE): "D"},
        ]);
        assert_eq!(model.require(CONTROLLER, "C").unwrap()[ZONES], entries);
    }
}
