//! Discovery of the systems of a model: those that can be controlled, and those that cannot, with the reason.

mod notes;
mod outdoor_air;
mod programs;

use std::collections::HashSet;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::actuator::Quantity;
use super::air_loop::{AirLoop, enlarge_heating_coil};
use super::air_loop_graph::supply_components;
use super::candidate::Candidate;
use super::distribution::served_zones;
use super::energy_management::{objects, remove_ems_programs, sets_a_schedule, silence_sensors};
use super::given_thermostat::has_thermostat;
use super::kind::Kind;
use super::references::{Reference, is_one_of, parts};
use super::room_unit;
use super::setpoints::{SetpointZone, has_own_temperatures, passes_regardless};
use super::system::{FromModel, System};
use super::ventilation::Ventilation;
use super::zone_controls;
use super::zone_equipment::{
    DISTRIBUTION, UNCONTROLLED, VENTILATION, is_beside, is_distribution, zone_equipment,
};
use crate::model::{Fields, Model, text};
use crate::{Error, Result};
use notes::Thermostats;
use programs::Programs;

/// What happens to a system that cannot be made controllable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsupported {
    /// It is an error, as in a generated building, whose systems are all controlled.
    Refused,
    /// It keeps its thermostats, schedules and availability, and is listed with the reason, as in a user's model.
    LeftAlone,
}

/// The systems found in a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Discovery {
    /// The controlled systems, in the order of the action.
    pub systems: Vec<Box<dyn System>>,
    /// The systems and the equipment without actuators of their own.
    pub uncontrolled: Vec<Uncontrolled>,
    /// Outdoor air of each air loop without actuators of its own, with the zones that it serves.
    pub outdoor_air: Vec<(Ventilation, Vec<String>)>,
    /// What was changed in the thermostats and the EMS programs of a user's model.
    pub notes: Vec<String>,
}

/// A system or a piece of zone equipment without actuators of its own, which keeps its own controls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Uncontrolled {
    /// The air loop or the equipment.
    pub object: Reference,
    /// The zones it serves.
    pub zones: Vec<String>,
    /// The reason why it is not controlled, or how it works alongside controlled equipment.
    pub reason: String,
    /// Whether it follows the thermostats of its zones, whose setpoints are controlled.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub follows_setpoints: bool,
}

/// Makes the systems of a hard-sized model controllable: air loops in model order, then equipment in the order of its
/// zones, then the thermostats of zones that nothing else controls, if such zones are [`Unsupported::LeftAlone`].
/// `air_density`, kg/m³, turns design volume flows into mass flows. Equipment that is `absent`, because it is switched
/// off all year, does not prevent the control of other equipment in its zone.
///
/// Each system is edited on a copy of the model, which is kept only if the whole edit succeeds.
///
/// # Errors
/// [`Error::MissingObject`] for a dangling reference; [`Error::Unsupported`] naming the object that cannot be made
/// controllable, if such objects are [`Unsupported::Refused`].
pub(crate) fn discover(
    model: &mut Model,
    air_density: f64,
    kinds: &[Kind],
    unsupported: Unsupported,
    absent: &[Reference],
) -> Result<Discovery> {
    if unsupported == Unsupported::Refused {
        // Once all systems are controlled, no schedule has an effect on them.
        remove_ems_programs(model, sets_a_schedule);
    }
    let before = objects(model);
    Search { model, air_density, kinds, unsupported, absent, found: Discovery::default() }.run(|search| {
        for air_loop in search.model.names("AirLoopHVAC") {
            search.air_loop(&air_loop)?;
        }
        for zone in search.model.names("Zone") {
            search.zone(&zone)?;
        }
        if unsupported == Unsupported::LeftAlone {
            search.thermostats()?;
        }
        silence_sensors(search.model, &before);
        Ok(())
    })
}

/// Makes the thermostat of every zone of a hard-sized model controllable, and nothing else.
///
/// # Errors
/// [`Error::MissingObject`] for a dangling reference.
pub(crate) fn discover_setpoints(model: &mut Model, air_density: f64) -> Result<Discovery> {
    let (kinds, unsupported) = (&[Kind::of::<SetpointZone>()], Unsupported::LeftAlone);
    Search { model, air_density, kinds, unsupported, absent: &[], found: Discovery::default() }
        .run(Search::thermostats)
}

impl Discovery {
    /// Returns why systems are not controlled, one line for all of a class with the same reason.
    pub(crate) fn reasons(&self) -> Vec<String> {
        let mut groups: Vec<(&str, &str, usize)> = Vec::new();
        for Uncontrolled { object, reason, .. } in &self.uncontrolled {
            match groups.iter_mut().find(|(class, why, _)| *class == object.class && why == reason) {
                Some((_, _, count)) => *count += 1,
                None => groups.push((&object.class, reason, 1)),
            }
        }
        groups.iter().map(|(class, reason, count)| format!("{count} × {class}: {reason}")).collect()
    }

    /// Returns the zones that are controlled through their setpoints.
    pub(crate) fn setpoint_zones(&self) -> Vec<&str> {
        let of_setpoints = |system: &&dyn System| system.kind() == SetpointZone::NAME;
        self.systems.iter().map(|system| &**system).filter(of_setpoints).flat_map(System::zones).collect()
    }

    fn system_of(&self, zone: &str) -> Option<&dyn System> {
        let serves = |system: &&dyn System| system.zones().iter().any(|z| z.eq_ignore_ascii_case(zone));
        self.systems.iter().map(|system| &**system).find(serves)
    }
}

/// Returns whether a zone without controlled equipment has a thermostat and equipment that heats or cools it.
pub(crate) fn has_own_controls(model: &Model, zone: &str) -> Result<bool> {
    let conditions = |e: &Reference| !is_one_of(&e.class, &VENTILATION);
    Ok(has_thermostat(model, zone) && zone_equipment(model, zone)?.iter().any(conditions))
}

/// A search for the systems of a model.
struct Search<'a> {
    model: &'a mut Model,
    air_density: f64,
    kinds: &'a [Kind],
    unsupported: Unsupported,
    absent: &'a [Reference],
    found: Discovery,
}

impl Search<'_> {
    /// Returns the systems that a search finds, with notes on what it changes in the thermostats and the EMS programs.
    fn run(mut self, find: impl FnOnce(&mut Self) -> Result<()>) -> Result<Discovery> {
        zone_controls::split(self.model);
        let (thermostats, programs) = (Thermostats::of(self.model), Programs::of(self.model));
        find(&mut self)?;
        let mut notes = thermostats.notes(self.model, &self.found.systems);
        if self.unsupported == Unsupported::LeftAlone {
            notes.extend(programs.notes(self.model));
        }
        Ok(Discovery { notes, ..self.found })
    }

    fn air_loop(&mut self, air_loop: &str) -> Result<()> {
        let candidate = Candidate::AirLoop(air_loop);
        let own = belongings(self.model, air_loop)?;
        let refused = self
            .refuse_second_system(air_loop)
            .and_then(|()| refuse_ducts(self.model, air_loop, &own))
            .and_then(|()| self.enlarge_heating_coil(air_loop));
        let made = refused.and_then(|()| self.make_controllable(candidate));
        match made {
            Ok(system) => {
                remove_ems_programs(self.model, |actuator| acts_on(actuator, &own));
                self.found.systems.push(system);
                Ok(())
            }
            Err(error) => {
                let served = served_zones(self.model, air_loop).unwrap_or_default();
                let object = Reference { class: "AirLoopHVAC".into(), name: air_loop.to_owned() };
                self.leave(object, served.into_iter().map(|served| served.zone).collect(), error)
            }
        }
    }

    /// Enlarges the main heating coil of a central air loop of a generated building.
    fn enlarge_heating_coil(&mut self, air_loop: &str) -> Result<()> {
        let kind = self.kind_of(Candidate::AirLoop(air_loop))?;
        if self.unsupported == Unsupported::LeftAlone || kind.is_none_or(|kind| kind.id() != AirLoop::NAME.id)
        {
            return Ok(());
        }
        enlarge_heating_coil(self.model, air_loop, self.air_density)
    }

    /// Makes the equipment of a zone controllable if nothing else conditions the zone.
    fn zone(&mut self, zone: &str) -> Result<()> {
        let equipment = zone_equipment(self.model, zone)?;
        let has_air_system = self.found.system_of(zone).is_some();
        for item in equipment.iter().filter(|item| !is_distribution(&item.class)) {
            let candidate = Candidate::Equipment { zone, object: item };
            let own = with_parts(self.model, item);
            let made = match self.objection(candidate, &equipment, has_air_system)? {
                Some(reason) => Err(Error::unsupported(&item.class, &item.name, &reason)),
                None => self.make_controllable(candidate),
            };
            match made {
                Ok(system) => {
                    remove_ems_programs(self.model, |actuator| acts_on(actuator, &own));
                    self.found.systems.push(system);
                }
                Err(error) => self.leave(item.clone(), vec![zone.to_owned()], error)?,
            }
        }
        Ok(())
    }

    /// Makes the thermostats controllable in zones that nothing else controls.
    fn thermostats(&mut self) -> Result<()> {
        let first = self.found.systems.len();
        for zone in self.model.names("Zone") {
            let candidate = Candidate::Zone(&zone);
            if self.found.system_of(&zone).is_some()
                || self.kind_of(candidate)?.is_none()
                || !has_own_controls(self.model, &zone)?
            {
                continue;
            }
            match self.make_controllable(candidate) {
                Ok(system) => self.found.systems.push(system),
                Err(error) => {
                    let object = Reference { class: "Zone".into(), name: zone.clone() };
                    self.leave(object, vec![zone], error)?;
                }
            }
        }
        let driven: Vec<String> = self.found.systems.iter().skip(first).flat_map(|s| owned(&**s)).collect();
        let is_driven = |zone: &String| driven.iter().any(|other| other.eq_ignore_ascii_case(zone));
        for item in &mut self.found.uncontrolled {
            item.follows_setpoints =
                item.zones.iter().any(is_driven) && !has_own_temperatures(self.model, &item.object);
        }
        self.found.outdoor_air = outdoor_air::left_alone(self.model, &self.found.systems, self.air_density)?;
        Ok(())
    }

    /// Returns why equipment of a zone cannot be controlled, regardless of its parts; `None` if they decide.
    fn objection(
        &self,
        candidate: Candidate<'_>,
        equipment: &[Reference],
        has_air_system: bool,
    ) -> Result<Option<String>> {
        let (zone, item) = candidate.equipment()?;
        let is_supported = self.kind_of(candidate)?.is_some();
        let others = equipment.iter().any(|other| !self.is_absent(other));
        if self.is_absent(item) && (others || !is_supported) {
            return Ok(Some("its availability schedule is 0 all year".to_owned()));
        }
        if !is_supported {
            let reason = match is_one_of(&item.class, &VENTILATION) {
                true => "it ventilates by its own schedule",
                false if has_own_temperatures(self.model, item) => {
                    "it holds temperatures of its own schedules, not those of the zone's thermostat"
                }
                false if has_air_system => "unsupported component: it follows the controlled thermostat",
                false => "unsupported component",
            };
            return Ok(Some(reason.to_owned()));
        }
        if let Some(system) = self.found.system_of(zone) {
            let holds_setpoint =
                system.actuators().iter().any(|actuator| actuator.quantity == Quantity::HeatingSetpoint);
            let reason = match holds_setpoint {
                true => "it holds the heating setpoint together with the controlled equipment of the zone",
                false => {
                    "it stays off: the air system of the zone heats, and the thermostat never calls for heat"
                }
            };
            return Ok(Some(reason.to_owned()));
        }
        let is_other = |other: &&Reference| *other != item && !self.is_beside(other);
        for other in equipment.iter().filter(is_other) {
            if !(room_unit::is_unit(&item.class) && passes_regardless(self.model, zone, other)?) {
                return Ok(Some(format!("a {} in the zone follows the same thermostat", other.class)));
            }
        }
        Ok(None)
    }

    /// Rejects an air loop with a second system in one of its zones: a packaged unit or another air loop would follow
    /// the same thermostat.
    fn refuse_second_system(&self, air_loop: &str) -> Result<()> {
        let mut units = HashSet::new();
        let served = served_zones(self.model, air_loop)?;
        for zone in &served {
            if !units.insert(zone.zone.to_lowercase()) {
                let why = format!("two of its terminals are in zone `{}`", zone.zone);
                return Err(Error::unsupported("AirLoopHVAC", air_loop, &why));
            }
            for equipment in zone_equipment(self.model, &zone.zone)? {
                let own = equipment.name.eq_ignore_ascii_case(&zone.unit);
                if own || self.is_beside(&equipment) {
                    continue;
                }
                let terminal = Reference { class: DISTRIBUTION.into(), name: zone.unit.clone() };
                let why = match passes_regardless(self.model, &zone.zone, &terminal)? {
                    true => "it does not follow the thermostats of its zones, like dedicated outdoor air"
                        .to_owned(),
                    false => {
                        format!("one of its zones also has a {} under the same thermostat", equipment.class)
                    }
                };
                return Err(Error::unsupported("AirLoopHVAC", air_loop, &why));
            }
        }
        Ok(())
    }

    /// Returns whether equipment may share a zone with a controlled system.
    fn is_beside(&self, equipment: &Reference) -> bool {
        is_beside(&equipment.class)
            || self.is_absent(equipment)
            || has_own_temperatures(self.model, equipment)
    }

    fn is_absent(&self, equipment: &Reference) -> bool {
        self.absent.contains(equipment)
    }

    fn kind_of(&self, candidate: Candidate<'_>) -> Result<Option<Kind>> {
        for kind in self.kinds {
            if kind.claims(self.model, candidate)? {
                return Ok(Some(*kind));
            }
        }
        Ok(None)
    }

    /// Makes a candidate controllable; on failure the model is not changed.
    fn make_controllable(&mut self, candidate: Candidate<'_>) -> Result<Box<dyn System>> {
        let kind = self.kind_of(candidate)?.ok_or_else(|| candidate.unsupported("unsupported component"))?;
        let mut edited = self.model.clone();
        let system = kind.make_controllable(&mut edited, candidate, self.air_density)?;
        *self.model = edited;
        Ok(system)
    }

    /// Records a system or a piece of equipment that cannot be made controllable, or returns the error unless its class
    /// may stay uncontrolled.
    fn leave(&mut self, object: Reference, zones: Vec<String>, error: Error) -> Result<()> {
        match self.unsupported {
            Unsupported::LeftAlone => {
                let reason = reason(error, &object.name)?;
                let follows_setpoints = false;
                self.found.uncontrolled.push(Uncontrolled { object, zones, reason, follows_setpoints });
                Ok(())
            }
            Unsupported::Refused if is_one_of(&object.class, &UNCONTROLLED) => Ok(()),
            Unsupported::Refused => Err(error.in_zones(&zones)),
        }
    }
}

/// Returns the names of the zones of a system.
fn owned(system: &dyn System) -> Vec<String> {
    system.zones().into_iter().map(str::to_owned).collect()
}

/// Rejects an air loop whose ducts are part of an AirflowNetwork, which names its nodes and components.
fn refuse_ducts(model: &Model, air_loop: &str, belongings: &HashSet<String>) -> Result<()> {
    const NODE: &str = "AirflowNetwork:Distribution:Node";
    let names_ours = |(_, fields): &(&str, &Fields)| {
        text(fields, "component_name_or_node_name")
            .is_some_and(|name| belongings.contains(&name.to_lowercase()))
    };
    match model.objects(NODE).iter().find(|node| names_ours(node)) {
        Some(_) => {
            Err(Error::unsupported("AirLoopHVAC", air_loop, "its ducts are part of an AirflowNetwork"))
        }
        None => Ok(()),
    }
}

/// Returns the reason in an error, with the class of its object unless that is the system itself.
fn reason(error: Error, system: &str) -> Result<String> {
    match error {
        Error::Unsupported { name, why, .. } if name.eq_ignore_ascii_case(system) => Ok(why),
        Error::Unsupported { class, why, .. } => Ok(format!("its {class}: {why}")),
        other => Err(other),
    }
}

/// Returns every name in the objects of an air loop, in lower case: its components and their parts, nodes, terminals,
/// zones.
fn belongings(model: &Model, air_loop: &str) -> Result<HashSet<String>> {
    let mut names = HashSet::from([air_loop.to_lowercase()]);
    for component in supply_components(model, air_loop)? {
        collect(model, &component, &mut names);
    }
    for served in served_zones(model, air_loop).unwrap_or_default() {
        collect(model, &served.terminal, &mut names);
        names.insert(served.zone.to_lowercase());
    }
    for (controller, fields) in model.objects("Controller:OutdoorAir") {
        if text(fields, "mixed_air_node_name").is_some_and(|node| names.contains(&node.to_lowercase())) {
            names.insert(controller.to_lowercase());
        }
    }
    Ok(names)
}

/// Returns the names of a piece of equipment, its parts and theirs, in lower case.
fn with_parts(model: &Model, object: &Reference) -> HashSet<String> {
    let own = model.get(&object.class, &object.name).map(parts).unwrap_or_default();
    let of_parts = own.iter().flat_map(|part| with_parts(model, part));
    [object.name.to_lowercase()].into_iter().chain(of_parts).collect()
}

fn collect(model: &Model, object: &Reference, names: &mut HashSet<String>) {
    names.insert(object.name.to_lowercase());
    let Some(fields) = model.get(&object.class, &object.name) else { return };
    names.extend(fields.values().filter_map(Value::as_str).map(str::to_lowercase));
    for part in parts(fields) {
        collect(model, &part, names);
    }
}

/// Returns whether an EMS actuator acts on a component of a controlled system. Schedules do not count: a controlled
/// system no longer follows the model's.
fn acts_on(actuator: &Fields, names: &HashSet<String>) -> bool {
    !sets_a_schedule(actuator)
        && text(actuator, "actuated_component_unique_name").is_some_and(|n| names.contains(&n.to_lowercase()))
}

#[cfg(test)]
mod tests;
