//! Controls of a zone besides its thermostat, which set its setpoints instead of it or shift them. They give way to
//! commanded setpoints, which are air temperatures.

use serde_json::{Value, json};

use super::given_thermostat::thermostat;
use crate::model::{Fields, items, text};
use crate::zone::covers_zone;
use crate::{Error, Model, Result};

const THERMOSTAT: &str = "ZoneControl:Thermostat";
/// Controls that set the setpoints of a zone instead of its thermostat.
const INSTEAD: [&str; 2] =
    ["ZoneControl:Thermostat:ThermalComfort", "ZoneControl:Thermostat:StagedDualSetpoint"];
/// Controls that shift the setpoints of the thermostat that they name, by radiant temperature or by humidity.
const SHIFTS: [&str; 2] =
    ["ZoneControl:Thermostat:OperativeTemperature", "ZoneControl:Thermostat:TemperatureAndHumidity"];

/// Removes the controls that set or shift the setpoints of a zone. A zone without another thermostat gets one, without
/// setpoints.
///
/// # Errors
/// [`Error::Unsupported`] for a control of a list of zones.
pub(super) fn remove(model: &mut Model, zone: &str) -> Result<()> {
    for class in INSTEAD {
        for name in model.names(class) {
            let Some(zones) = model.get(class, &name).and_then(zones) else { continue };
            if !covers_zone(model, zones, zone) {
                continue;
            }
            if !zones.eq_ignore_ascii_case(zone) {
                let why = format!("it controls the zone list `{zones}`; give each zone a thermostat");
                return Err(Error::unsupported(class, &name, &why));
            }
            model.remove(class, &name);
            if thermostat(model, zone).is_none() {
                let own = format!("{zone} Thermostat");
                model.insert(THERMOSTAT, &own, json!({"zone_or_zonelist_name": zone}));
            }
        }
    }
    let Some((own, _)) = thermostat(model, zone) else { return Ok(()) };
    for (class, name, _) in shifts(model, &own) {
        model.remove(class, &name);
    }
    Ok(())
}

/// Replaces each thermostat or other control of a list of zones with one per zone, with what shifts its setpoints.
pub(in crate::hvac) fn split(model: &mut Model) {
    for class in [THERMOSTAT, INSTEAD[0], INSTEAD[1]] {
        for name in model.names(class) {
            let Some(fields) = model.get(class, &name).cloned() else { continue };
            let Some(list) = zones(&fields).and_then(|list| model.get("ZoneList", list)) else { continue };
            let zones: Vec<_> =
                items(list, "zones").filter_map(|item| text(item, "zone_name")).map(str::to_owned).collect();
            let shifts = if class == THERMOSTAT { shifts(model, &name) } else { Vec::new() };
            model.remove(class, &name);
            shifts.iter().for_each(|(class, name, _)| _ = model.remove(class, name));
            for zone in zones {
                let own = format!("{zone} {name}");
                insert_with(model, [class, &own], &fields, ["zone_or_zonelist_name", &zone]);
                for (class, name, fields) in &shifts {
                    let shift = format!("{zone} {name}");
                    insert_with(model, [class, &shift], fields, ["thermostat_name", &own]);
                }
            }
        }
    }
}

/// Inserts an object with these fields, one of them changed.
fn insert_with(model: &mut Model, [class, name]: [&str; 2], fields: &Fields, [field, value]: [&str; 2]) {
    let mut own = fields.clone();
    own.insert(field.into(), value.into());
    model.insert(class, name, Value::Object(own));
}

/// The controls of a model that set or shift the setpoints of its zones.
pub(in crate::hvac) struct ZoneControls(Vec<(&'static str, String)>);

impl ZoneControls {
    pub(in crate::hvac) fn of(model: &Model) -> Self {
        let of_class = |class: &'static str| model.names(class).into_iter().map(move |name| (class, name));
        Self(INSTEAD.into_iter().chain(SHIFTS).flat_map(of_class).collect())
    }

    /// Returns a note for every class of which a model has lost controls.
    pub(in crate::hvac) fn lost(&self, model: &Model) -> Vec<String> {
        let lost = |class: &str| {
            let of_class = self.0.iter().filter(|(other, _)| *other == class);
            of_class.filter(|(_, name)| !model.contains(class, name)).map(|(_, name)| name.as_str()).collect()
        };
        let note = |class: &&str| {
            let names: Vec<&str> = lost(class);
            let [first, others @ ..] = &names[..] else { return None };
            let others =
                if others.is_empty() { String::new() } else { format!(" and {} others", others.len()) };
            Some(format!("removed {class} `{first}`{others}: commanded setpoints are air temperatures"))
        };
        INSTEAD.iter().chain(&SHIFTS).filter_map(note).collect()
    }
}

/// Returns what shifts the setpoints of a thermostat: class, name and fields.
fn shifts(model: &Model, thermostat: &str) -> Vec<(&'static str, String, Fields)> {
    let names = |fields: &Fields| {
        text(fields, "thermostat_name").is_some_and(|name| name.eq_ignore_ascii_case(thermostat))
    };
    let of_class = |class: &'static str| {
        let objects = model.objects(class).into_iter().filter(|(_, fields)| names(fields));
        objects.map(move |(name, fields)| (class, name.to_owned(), fields.clone())).collect::<Vec<_>>()
    };
    SHIFTS.into_iter().flat_map(of_class).collect()
}

fn zones(fields: &Fields) -> Option<&str> {
    text(fields, "zone_or_zonelist_name")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const COMFORT: &str = INSTEAD[0];
    const STAGED: &str = INSTEAD[1];
    const OPERATIVE: &str = SHIFTS[0];

    fn model(text: Value) -> Model {
        Model::from_epjson(&text.to_string(), Path::new("test.epJSON")).unwrap()
    }

    #[test]
    fn a_thermostat_of_a_zone_list_becomes_one_per_zone_with_what_shifts_it() {
        let mut model = model(json!({
            (THERMOSTAT): {"T": {"zone_or_zonelist_name": "ALL", "control_1_name": "Shared"}},
            (OPERATIVE): {"O": {"thermostat_name": "t", "fixed_radiative_fraction": 0.5}},
            "ZoneList": {"All": {"zones": [{"zone_name": "ZA"}, {"zone_name": "ZB"}]}},
        }));
        split(&mut model);
        assert_eq!(model.names(THERMOSTAT), ["ZA T", "ZB T"]);
        assert_eq!(model.require(OPERATIVE, "ZB O").unwrap()["thermostat_name"], "ZB T");
        let before = ZoneControls::of(&model);
        assert!(before.lost(&model).is_empty());
        remove(&mut model, "ZA").unwrap();
        assert_eq!(model.names(OPERATIVE), ["ZB O"]);
        let [note] = &before.lost(&model)[..] else { panic!("one class") };
        assert!(note.contains("`ZA O`") && note.contains("air temperatures"), "{note}");
    }

    #[test]
    fn comfort_and_staged_controls_are_replaced_by_a_thermostat() {
        for class in [COMFORT, STAGED] {
            let mut model = model(json!({
                (class): {"Comfort": {"zone_or_zonelist_name": "z"}, "Other": {"zone_or_zonelist_name": "y"}}
            }));
            remove(&mut model, "Z").unwrap();
            assert_eq!(model.names(class), ["Other"]);
            assert_eq!(model.names(THERMOSTAT), ["Z Thermostat"]);
        }
    }
}
