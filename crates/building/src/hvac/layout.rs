//! The layout of systems: their places in the action vector and the zones that they serve.
//!
//! The actuators of a building follow each other in the order of its systems.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::system::System;
use crate::{Error, Result};

/// Place of a system in the action vector and in the zones of its building.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SystemLayout {
    /// Range of its actuators in the action.
    pub actions: Range<usize>,
    /// Zones it serves, in the order of [`System::zones`].
    pub zones: Vec<ServedZone>,
}

/// A zone that a system serves, by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ServedZone {
    /// Index among all zones of the building.
    pub index: usize,
    /// Index among the controlled zones of the building.
    pub controlled: usize,
}

impl SystemLayout {
    /// Returns the layouts of a building's systems; `zones` are the names of all its zones, in model order.
    ///
    /// # Errors
    /// [`Error::MissingObject`] for a system whose zone is not in `zones`.
    pub(crate) fn of_all(systems: &[Box<dyn System>], zones: &[&str]) -> Result<Vec<Self>> {
        let served = |system: &dyn System| system.zones().into_iter().map(|zone| find(zone, zones)).collect();
        let served: Vec<Vec<usize>> =
            systems.iter().map(|system| served(&**system)).collect::<Result<_>>()?;
        let controlled =
            |index: usize| (0..index).filter(|zone| served.iter().flatten().any(|z| z == zone)).count();
        let mut first = 0;
        let layouts = systems.iter().zip(&served).map(|(system, served)| {
            let actions = first..first + system.actuators().len();
            first = actions.end;
            let zones = served.iter().map(|&index| ServedZone { index, controlled: controlled(index) });
            Self { actions, zones: zones.collect() }
        });
        Ok(layouts.collect())
    }

    /// Returns whether the system serves a zone, given its index in the building.
    pub fn serves(&self, zone: usize) -> bool {
        self.zones.iter().any(|served| served.index == zone)
    }
}

fn find(name: &str, zones: &[&str]) -> Result<usize> {
    let index = zones.iter().position(|zone| zone.eq_ignore_ascii_case(name));
    index.ok_or_else(|| Error::MissingObject { class: "Zone".to_owned(), name: name.to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hvac::{
        Actuator, AirLoop, EngineVariable, HeatingOnly, Packaged, Quantity, Terminal, Unitary, Ventilation,
    };

    fn actuator(name: &str) -> Actuator {
        Actuator {
            name: name.to_owned(),
            quantity: Quantity::SupplyAirFlow,
            low: 0.0,
            high: 1.0,
            component: String::new(),
            control: String::new(),
            key: String::new(),
            scale: 1.0,
            effect: EngineVariable::new("", ""),
            effect_scale: 1.0,
            heat: None,
        }
    }

    fn terminal(zone: &str) -> Terminal {
        Terminal {
            zone: zone.to_owned(),
            damper: actuator(&format!("{zone} damper")),
            reheat: Some(actuator(&format!("{zone} reheat"))),
            design_flow: 1.0,
            heating_opening: 1.0,
        }
    }

    fn systems() -> [Box<dyn System>; 3] {
        let unit = Unitary {
            zone: "core".to_owned(),
            followers: Vec::new(),
            flow: actuator("flow"),
            supply_temperature: actuator("unit supply"),
            ventilation: None,
            packaged: Packaged::default(),
        };
        let air_loop = AirLoop {
            name: "loop".to_owned(),
            supply_temperature: actuator("supply"),
            outdoor_air: actuator("outdoor"),
            fan_flow: 1.0,
            exhaust_flow: 0.0,
            ventilation: Ventilation {
                min_outdoor_air: 0.1,
                damper: None,
                outdoor_air: EngineVariable::new("", ""),
            },
            terminals: vec![
                terminal("East"),
                Terminal { reheat: None, ..terminal("South") },
                terminal("West"),
            ],
        };
        let heater = HeatingOnly { zone: "Hall".to_owned(), setpoint: actuator("setpoint") };
        [Box::new(unit), Box::new(air_loop), Box::new(heater)]
    }

    const ZONES: [&str; 6] = ["Attic", "West", "Core", "Hall", "South", "East"];

    #[test]
    fn named_offsets_match_the_actuators() {
        let [unit, air_loop, heater] = systems();
        let of_terminals: Vec<_> =
            air_loop.as_any().downcast_ref::<AirLoop>().unwrap().of_terminals().collect();
        let name = |system: &dyn System, offset: usize| system.actuators()[offset].name.clone();
        assert_eq!(name(&*unit, Unitary::FLOW), "flow");
        assert_eq!(name(&*unit, Unitary::SUPPLY_TEMPERATURE), "unit supply");
        assert_eq!(name(&*air_loop, AirLoop::SUPPLY_TEMPERATURE), "supply");
        assert_eq!(name(&*air_loop, AirLoop::OUTDOOR_AIR), "outdoor");
        for (zone, (damper, reheat)) in ["East", "South", "West"].into_iter().zip(of_terminals) {
            assert_eq!(name(&*air_loop, damper), format!("{zone} damper"));
            match reheat {
                Some(reheat) => assert_eq!(name(&*air_loop, reheat), format!("{zone} reheat")),
                None => assert_eq!(zone, "South"),
            }
        }
        assert_eq!(
            [0, 1, 2, 3, 4, 5, 6].map(|actuator| air_loop.zone_of(actuator)),
            [None, None, Some(0), Some(0), Some(1), Some(2), Some(2)]
        );
        assert_eq!(name(&*heater, HeatingOnly::SETPOINT), "setpoint");
    }

    #[test]
    fn ranges_are_contiguous_and_zones_are_found_in_any_case() {
        let layouts = SystemLayout::of_all(&systems(), &ZONES).unwrap();
        let ranges: Vec<_> = layouts.iter().map(|layout| layout.actions.clone()).collect();
        assert_eq!(ranges, [0..2, 2..9, 9..10]);
        let zones: Vec<Vec<[usize; 2]>> = layouts
            .iter()
            .map(|layout| layout.zones.iter().map(|zone| [zone.index, zone.controlled]).collect())
            .collect();
        assert_eq!(zones, [vec![[2, 1]], vec![[5, 4], [4, 3], [1, 0]], vec![[3, 2]]]);
    }

    #[test]
    fn an_unknown_zone_is_an_error_with_its_name() {
        let error = SystemLayout::of_all(&systems(), &ZONES[..5]).unwrap_err().to_string();
        assert!(error.contains("Zone") && error.contains("`East`"), "{error}");
    }
}
