//! Notes on an imported model: what its author should know about how it was read.

use std::collections::HashSet;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::versions::Conversion;
use crate::band::Off;
use crate::hvac::{Discovery, Switch};
use crate::{Conditioning, Zone, ZoneYear};

/// Share of a month from which a schedule counts as mostly off.
const MOSTLY: f64 = 0.9;

/// What was found and changed when a model was read and sized.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Notes {
    /// The conversion of a model of another version.
    pub conversion: Option<Conversion>,
    /// The design days for which equipment was sized.
    pub design_days: Option<String>,
    /// The days of the week and 29 February, where they differ from generated buildings'.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calendar: Option<String>,
    /// Autosized fields for which the engine reports no size and that were left to it.
    pub left_autosized: Vec<String>,
    /// Autosized fields without a reported size that their object does not use; they got a number.
    #[serde(default)]
    pub unused_autosized: Vec<String>,
    /// What was removed or changed to control the model and to simulate episodes.
    #[serde(default)]
    pub changed: Vec<String>,
    /// Schedules of the model that switch off equipment, regardless of its zones' setpoints.
    #[serde(default)]
    pub switched_off: Vec<SwitchedOff>,
    /// What may not be as the author expects.
    pub warnings: Vec<String>,
}

/// A schedule that switches off equipment of zones that are controlled through their setpoints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SwitchedOff {
    /// The schedule.
    pub schedule: String,
    /// The share of the time in which it is zero.
    pub share: f64,
    /// The share of each month, January first.
    #[serde(default)]
    pub by_month: [f64; 12],
    /// The equipment, each `class name`.
    pub equipment: Vec<String>,
    /// The zones.
    pub zones: Vec<String>,
}

impl fmt::Display for SwitchedOff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { schedule, share, equipment, zones, .. } = self;
        let first = equipment.first().map_or("", String::as_str);
        let others = match equipment.len() {
            0 | 1 => String::new(),
            2 => " and 1 other".to_owned(),
            count => format!(" and {} others", count - 1),
        };
        write!(
            f,
            "schedule `{schedule}`, {:.0} % of the year: {first}{others} (zones: {})",
            100.0 * share,
            zones.len()
        )
    }
}

/// Returns the schedules that switch off equipment of zones that a discovery controls through their setpoints. `off`
/// has when each switch is off.
pub(crate) fn switched_off(switches: &[Switch], off: &[Off], found: &Discovery) -> Vec<SwitchedOff> {
    let controlled: HashSet<String> =
        found.setpoint_zones().into_iter().map(|zone| zone.to_lowercase()).collect();
    let mut all: Vec<SwitchedOff> = Vec::new();
    let is_off =
        |(switch, off): &(&Switch, &Off)| off.share > 0.0 && controlled.contains(&switch.zone.to_lowercase());
    for (Switch { zone, object, schedule, .. }, off) in switches.iter().zip(off).filter(is_off) {
        let name = format!("{} `{}`", object.class, object.name);
        let known = all.iter().position(|each| each.schedule.eq_ignore_ascii_case(schedule));
        let known = known.unwrap_or_else(|| {
            let (equipment, zones, Off { share, by_month }) = (Vec::new(), Vec::new(), *off);
            all.push(SwitchedOff { schedule: schedule.clone(), share, by_month, equipment, zones });
            all.len() - 1
        });
        let SwitchedOff { equipment, zones, .. } = &mut all[known];
        for (list, item) in [(equipment, name), (zones, zone.clone())] {
            if !list.contains(&item) {
                list.push(item);
            }
        }
    }
    all
}

/// Returns a warning that names the controlled zones without a comfort band, whose schedules have no setpoints: nothing
/// that an agent does makes them uncomfortable in a task with the model's own bands.
pub(crate) fn without_band(zones: &[Zone], years: &[ZoneYear]) -> Option<String> {
    let has_band = |zone: &Zone, year: &ZoneYear| match zone.conditioning {
        Conditioning::None => true,
        Conditioning::Heating => year.spans().any(|span| span.heating.is_some()),
        Conditioning::HeatingAndCooling => {
            year.spans().any(|span| span.heating.is_some() || span.cooling.is_some())
        }
    };
    let without = zones.iter().zip(years).filter(|(zone, year)| !has_band(zone, year));
    let names: Vec<String> = without.map(|(zone, _)| format!("`{}`", zone.name)).collect();
    (!names.is_empty()).then(|| {
        format!(
            "no thermostat with temperature setpoints in zones {}: with `--task operate`, they are never uncomfortable; give \
             setpoints with people and without, such as `--task operate:21-24/15.6-28`",
            names.join(", ")
        )
    })
}

impl Notes {
    /// Returns the warnings and a summary of the conversion, a line each.
    pub fn lines(&self) -> impl Iterator<Item = String> + '_ {
        let summary = self.conversion.as_ref().map(|Conversion { from, to, changed, left_out, programs }| {
            let (changed, left_out) = (changed.len(), left_out.len());
            let changes = match (changed, left_out) {
                _ if !programs.is_empty() => format!("by {}", programs.join(", ")),
                (0, 0) => "nothing to change".to_owned(),
                _ => format!("{changed} kinds of changes, {left_out} left out; `b2b import` lists them"),
            };
            format!("converted from EnergyPlus {from} to {to}: {changes}")
        });
        self.warnings.iter().cloned().chain(summary)
    }

    /// Returns whether a schedule of the model switches off equipment of a zone for most of a month; January is 0.
    pub fn is_mostly_off(&self, zone: &str, month: usize) -> bool {
        let mostly = self.switched_off.iter().filter(|off| off.by_month[month] >= MOSTLY);
        mostly.flat_map(|off| &off.zones).any(|other| other.eq_ignore_ascii_case(zone))
    }

    /// Returns whether there are no notes.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::json;

    use super::*;
    use crate::Model;
    use crate::band::Span;
    use crate::hvac::{KINDS, Unsupported, discover, switches_of_all};

    #[test]
    fn controlled_zones_without_a_comfort_band_are_named() {
        let year = |heating, cooling| {
            ZoneYear::of_samples(1, 1, |_| Span { from: 0.0, heating, cooling, people: true })
        };
        let zone = |name: &str, conditioning| Zone {
            name: name.into(),
            floor_area: 1.0,
            multiplier: 1.0,
            conditioning,
            own_controls: false,
        };
        let zones = [
            zone("Attic", Conditioning::None),
            zone("Hall", Conditioning::Heating),
            zone("Office", Conditioning::HeatingAndCooling),
        ];
        let warning = |hall, office| without_band(&zones, &[year(None, None), hall, office]);
        assert_eq!(warning(year(Some(20.0), None), year(None, Some(26.0))), None);
        let said = warning(year(None, Some(26.0)), year(None, None)).unwrap();
        assert!(said.contains("`Hall`, `Office`: ") && said.contains("operate:21-24"), "{said}");
    }

    /// Ideal loads whose heating is switched off by one schedule, and whose cooling is not by another.
    #[test]
    fn schedules_that_switch_off_equipment_are_reported_with_their_share_of_the_year() {
        let mut model = Model::from_epjson(
            &json!({
                "Zone": {"Z": {}},
                "ZoneControl:Thermostat": {"T": {
                    "zone_or_zonelist_name": "Z", "control_type_schedule_name": "Dual",
                    "control_1_object_type": "ThermostatSetpoint:DualSetpoint", "control_1_name": "S"}},
                "ZoneHVAC:EquipmentConnections": {"C": {
                    "zone_name": "Z", "zone_conditioning_equipment_list_name": "L"}},
                "ZoneHVAC:EquipmentList": {"L": {"equipment": [{
                    "zone_equipment_object_type": "ZoneHVAC:IdealLoadsAirSystem", "zone_equipment_name": "Ideal"}]}},
                "ZoneHVAC:IdealLoadsAirSystem": {"Ideal": {
                    "heating_availability_schedule_name": "Season", "cooling_availability_schedule_name": "Always"}},
            })
            .to_string(),
            Path::new("zone.epJSON"),
        )
        .unwrap();
        let switches = switches_of_all(&model).unwrap();
        let mut season = Off { share: 0.95, by_month: [1.0; 12] };
        season.by_month[6] = 0.4;
        let of = |switch: &Switch| if switch.schedule == "Season" { season } else { Off::default() };
        let off: Vec<Off> = switches.iter().map(of).collect();
        assert_eq!(off.len(), 2);
        let found = discover(&mut model, 1.2, &KINDS, Unsupported::LeftAlone, &[]).unwrap();
        let switched_off = switched_off(&switches, &off, &found);
        let [only] = &switched_off[..] else { panic!("{switched_off:?}") };
        let said = only.to_string();
        assert!(said.contains("`Season`, 95 %") && said.contains("IdealLoadsAirSystem `Ideal`"), "{said}");
        let notes = Notes { switched_off, ..Notes::default() };
        assert!(notes.is_mostly_off("z", 0) && !notes.is_mostly_off("z", 6) && !notes.is_mostly_off("Y", 0));
    }
}
