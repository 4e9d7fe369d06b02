//! The fractions of a zone's load that its equipment takes in sequence.
//!
//! Since 9.2 they are schedules. A blank one is 1, as a blank number was. Before 9.1, a list had none.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::import::versions::document::{Body, Document, Object};
use crate::import::versions::report::Conversion;

const CLASS: &str = "ZoneHVAC:EquipmentList";
const SCHEDULE: &str = "Schedule:Constant";
/// Number of fields before the equipment in an IDF, and of fields for each piece of equipment; its last two are the
/// fractions.
const BEFORE: usize = 2;
const EACH: usize = 6;
/// Number of fields for each piece of equipment in a list without fractions.
const EACH_WITHOUT: usize = 4;
/// The fractions in an epJSON.
const FRACTIONS: [&str; 2] =
    ["zone_equipment_sequential_cooling_fraction", "zone_equipment_sequential_heating_fraction"];

pub(super) fn convert(document: &mut Document, version: &str, report: &mut Conversion) -> Vec<String> {
    let taken: Vec<String> = document
        .objects
        .iter()
        .filter(|object| object.class.to_lowercase().starts_with("schedule:"))
        .map(|object| object.name().to_lowercase())
        .collect();
    let mut schedules = BTreeMap::new();
    for object in document.objects.iter_mut().filter(|object| object.is(CLASS)) {
        let mut scheduled = |fraction: f64| -> String {
            if fraction == 1.0 {
                return String::new();
            }
            let mut name = format!("Sequential Fraction {fraction}");
            while taken.contains(&name.to_lowercase()) {
                name.push_str(" of Load");
            }
            schedules.insert(name.clone(), fraction);
            name
        };
        if add_fractions(object) {
            let what = "blank fractions of the load for each piece of equipment";
            report.changed(version, CLASS, what.to_owned());
        }
        if name_schedules(object, &mut scheduled) {
            let what = "fractions of the load are now schedules, or blank for 1";
            report.changed(version, CLASS, what.to_owned());
        }
    }
    let like = document.objects.first().cloned();
    let schedule = |(name, fraction): (String, f64)| {
        let values = [("schedule_type_limits_name", String::new()), ("hourly_value", fraction.to_string())];
        Some(Object::like(like.as_ref()?, SCHEDULE, &name, &values))
    };
    document.objects.extend(schedules.into_iter().filter_map(schedule));
    Vec::new()
}

/// Adds blank fractions to a list of an IDF that has several pieces of equipment without them.
fn add_fractions(list: &mut Object) -> bool {
    let Body::Positions(values) = &mut list.body else { return false };
    let equipment = values.get(BEFORE..).unwrap_or_default();
    let is_class = |value: &String| !value.is_empty() && value.parse::<f64>().is_err();
    let is_in_groups_of = |each: usize| equipment.chunks(each).all(|group| is_class(&group[0]));
    if is_in_groups_of(EACH) || !is_in_groups_of(EACH_WITHOUT) {
        return false;
    }
    let blanks = || std::iter::repeat_n(String::new(), EACH - EACH_WITHOUT);
    let groups = equipment.chunks(EACH_WITHOUT).flat_map(|group| group.iter().cloned().chain(blanks()));
    *values = values[..BEFORE].iter().cloned().chain(groups).collect();
    true
}

/// Replaces the fractions of a list by the names of schedules, blank for none. Returns whether there are any.
fn name_schedules(list: &mut Object, scheduled: &mut impl FnMut(f64) -> String) -> bool {
    let mut found = false;
    match &mut list.body {
        Body::Positions(values) => {
            for (index, value) in values.iter_mut().enumerate().skip(BEFORE) {
                let is_fraction = (index - BEFORE) % EACH >= EACH - FRACTIONS.len();
                if let (true, Ok(fraction)) = (is_fraction, value.trim().parse()) {
                    *value = scheduled(fraction);
                    found = true;
                }
            }
        }
        Body::Names { fields, .. } => {
            let items = fields.values_mut().filter_map(Value::as_array_mut).flatten();
            for item in items.filter_map(Value::as_object_mut) {
                for field in FRACTIONS {
                    let Some(fraction) = item.get(field).and_then(Value::as_f64) else { continue };
                    match scheduled(fraction) {
                        none if none.is_empty() => _ = item.remove(field),
                        name => _ = item.insert(field.to_owned(), name.into()),
                    }
                    found = true;
                }
            }
        }
    }
    found
}
