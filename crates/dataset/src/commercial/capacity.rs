//! Reset of the Denver prototype's equipment sizes to autosizing.

use std::collections::BTreeSet;

use b2b_building::description::leakage;
use b2b_building::hvac::references::Reference;
use b2b_building::hvac::zone_equipment::zone_equipment;
use b2b_building::model::{Fields, number, text};
use b2b_building::{Model, Result};
use serde_json::{Value, json};

const SIZING: &str = "Sizing:Zone";

/// Sizing factors of the whole building, heating and cooling: the 25 % and 15 % of ASHRAE 90.1 appendix G (G3.1.2.2)
/// where the prototype has less. A controller must be able to warm up a building after setback.
const SIZING_FACTORS: [(&str, f64); 2] = [("heating_sizing_factor", 1.25), ("cooling_sizing_factor", 1.15)];

/// Size fields of each cooling coil speed that are numbers in the prototypes.
const SPEED_SIZES: [&str; 3] =
    ["gross_rated_total_cooling_capacity", "rated_air_flow_rate", "gross_rated_sensible_heat_ratio"];

/// Opening fraction of doors throughout the winter design day, 0 to 1. They open fully for an hour at a time, partly
/// buffered by the thermal mass of the zone.
const DOORS_ON_DESIGN_DAY: f64 = 0.75;

/// Sizing factor of zones with a unit heater. The code's semi-heated storage is designed for about 15 °C; a task may
/// request 21 °C, which takes 10 % more heat at -42 °C outdoors: a factor of 1.38 with the usual 25 %. The factor of
/// dataset v1 has another 9 % in reserve.
const UNIT_HEATER_SIZING_FACTOR: f64 = 1.5;

/// Resets every size computed for Denver to `Autosize`, and makes sizing consider two loads that the prototypes
/// exclude: open doors of entrances, and storage at room temperature.
///
/// # Errors
/// [`b2b_building::Error::MissingObject`] for a dangling reference.
pub(super) fn leave_to_sizing(model: &mut Model) -> Result<()> {
    raise_sizing_factors(model);
    autosize_speeds(model);
    heat_storage_to_room_temperature(model)?;
    open_doors_on_design_day(model);
    Ok(())
}

fn raise_sizing_factors(model: &mut Model) {
    each(model, "Sizing:Parameters", |fields| {
        for (field, minimum) in SIZING_FACTORS {
            let factor = number(fields, field).unwrap_or(1.0).max(minimum);
            fields.insert(field.into(), json!(factor));
        }
    });
}

fn autosize_speeds(model: &mut Model) {
    each(model, "Coil:Cooling:DX:MultiSpeed", |fields| {
        let speeds = number(fields, "number_of_speeds").unwrap_or_default() as u32;
        for field in (1..=speeds).flat_map(|n| SPEED_SIZES.map(|size| format!("speed_{n}_{size}"))) {
            fields.insert(field, Value::from("Autosize"));
        }
    });
}

/// Sizes unit heaters for room temperature.
fn heat_storage_to_room_temperature(model: &mut Model) -> Result<()> {
    for sizing in model.names(SIZING) {
        let zone = text(model.require(SIZING, &sizing)?, "zone_or_zonelist_name").unwrap_or_default();
        let is_unit_heater = |e: &Reference| e.class.eq_ignore_ascii_case("ZoneHVAC:UnitHeater");
        if zone_equipment(model, zone)?.iter().any(is_unit_heater) {
            let fields = model.require_mut(SIZING, &sizing)?;
            fields.insert("zone_heating_sizing_factor".into(), json!(UNIT_HEATER_SIZING_FACTOR));
        }
    }
    Ok(())
}

/// Opens doors on the winter design day.
fn open_doors_on_design_day(model: &mut Model) {
    const CLASS: &str = "ZoneInfiltration:DesignFlowRate";
    let doors = model.objects(CLASS).into_iter().filter(|(name, _)| leakage::is_door(name));
    let schedules: BTreeSet<String> =
        doors.filter_map(|(_, fields)| text(fields, "schedule_name")).map(str::to_owned).collect();
    for schedule in schedules {
        let data = model.get_mut("Schedule:Compact", &schedule).and_then(|f| f.get_mut("data"));
        if let Some(data) = data.and_then(Value::as_array_mut) {
            set_winter_design_day(data, DOORS_ON_DESIGN_DAY);
        }
    }
}

/// Sets the winter design day of a compact schedule of one season to a constant, unless all days are alike.
fn set_winter_design_day(data: &mut Vec<Value>, value: f64) {
    let line = |entry: &Value| entry["field"].as_str().unwrap_or_default().to_owned();
    let is_for = |entry: &Value| line(entry).starts_with("For");
    if data.iter().any(|entry| is_for(entry) && line(entry).contains("AllDays")) {
        return;
    }
    let is_winter = |entry: &Value| is_for(entry) && line(entry).contains("WinterDesignDay");
    if let Some(start) = data.iter().position(is_winter) {
        let end = data[start + 1..].iter().position(is_for).map_or(data.len(), |next| start + 1 + next);
        data.drain(start..end);
    }
    let day = [json!("For: WinterDesignDay"), json!("Until: 24:00"), json!(value)];
    data.splice(1..1, day.map(|field| json!({"field": field})));
}

fn each(model: &mut Model, class: &str, edit: impl Fn(&mut Fields)) {
    for name in model.names(class) {
        if let Some(fields) = model.get_mut(class, &name) {
            edit(fields);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_speed_of_a_coil_is_autosized() {
        let mut model = Model::default();
        model.insert(
            "Coil:Cooling:DX:MultiSpeed",
            "C",
            json!({"number_of_speeds": 2, "speed_1_rated_air_flow_rate": 1.0, "speed_2_gross_rated_cooling_cop": 3.0}),
        );
        leave_to_sizing(&mut model).unwrap();
        let coil = model.get("Coil:Cooling:DX:MultiSpeed", "C").unwrap();
        assert_eq!(coil["speed_1_rated_air_flow_rate"], "Autosize");
        assert_eq!(coil["speed_2_gross_rated_total_cooling_capacity"], "Autosize");
        assert_eq!(coil["speed_2_gross_rated_cooling_cop"], 3.0);
    }

    #[test]
    fn doors_open_on_the_winter_design_day() {
        let lines = |text: &[&str]| text.iter().map(|field| json!({"field": field})).collect::<Vec<_>>();
        let winter = ["For: WinterDesignDay", "Until: 24:00"];
        for block in [&[][..], &["For: WinterDesignDay", "Until: 24:00", "0"][..]] {
            let mut data = lines(&["Through: 12/31"]);
            data.extend(lines(block));
            data.extend(lines(&["For: AllOtherDays", "Until: 24:00", "0"]));
            set_winter_design_day(&mut data, 0.5);
            assert_eq!(data[1..3], lines(&winter)[..]);
            assert_eq!((&data[3]["field"], data.len()), (&json!(0.5), 7));
        }
        let mut data = lines(&["Through: 12/31", "For: AllDays", "Until: 24:00", "1"]);
        set_winter_design_day(&mut data, 0.5);
        assert_eq!(data.len(), 4);
    }

    #[test]
    fn sizing_factors_are_raised_and_never_lowered() {
        let mut model = Model::default();
        let shipped = json!({"heating_sizing_factor": 1.0, "cooling_sizing_factor": 1.2});
        model.insert("Sizing:Parameters", "P", shipped);
        leave_to_sizing(&mut model).unwrap();
        let parameters = model.get("Sizing:Parameters", "P").unwrap();
        assert_eq!(parameters["heating_sizing_factor"], 1.25);
        assert_eq!(parameters["cooling_sizing_factor"], 1.2);
    }
}
