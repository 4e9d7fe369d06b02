//! Sequences of operation of ASHRAE Guideline 36, for the systems that exist here.
//!
//! Sections are cited by their printed numbers, as in the 2021 edition. One file holds one sequence:
//!
//! - `modes`: modes of zone groups. `zone`: setpoints, optimum start, demand limiting, loops and requests of a zone.
//! - `air_loop`: an air handler of several zones, with trim and respond, the supply air temperature, the economizer,
//!   outdoor air and terminals.
//! - `single_zone`: a unit of one zone. `heater`: a heater under a thermostat.
//!
//! A sequence reads [`ZoneInput`] and [`SiteInput`]; `inputs` derives them from observations.
//!
//! Not representable with the actuators: static pressure, discharge temperatures of terminals, return and relief fans, and
//! the stages of freeze protection on coils.

mod air_loop;
mod heater;
mod inputs;
mod kind;
mod modes;
mod parameters;
mod points;
mod record;
mod single_zone;
#[cfg(test)]
mod tests;
mod zone;

use std::ops::Range;

use b2b_building::Conditioning;
use b2b_building::hvac::{Sequence, System, SystemLayout};
use b2b_env::{Controller, Spaces};

pub use air_loop::TrimRespond as Guideline36Reset;
pub(crate) use kind::Kind;
pub use modes::Mode;
pub use parameters::{AirLoopParameters, Guideline36Parameters, UnitaryParameters};
pub use points::{NextBand, Setpoints, SiteInput, ZoneInput};
pub use zone::LoopGains;
pub use zone::demand::DemandLevel;

use air_loop::AirLoop;
use heater::Heater;
use inputs::{SiteSlots, ZoneSlots};
use record::{Entry, Record};
use single_zone::{SingleZone, Unit};

/// The guideline's sequences, one set per system of a building.
#[derive(Clone, Debug)]
pub struct Guideline36 {
    systems: Vec<ControlledSystem>,
    site: SiteSlots,
    /// Length of a step, h.
    hours: f64,
    /// Points of the zones of a system.
    points: Vec<ZoneInput>,
    record: Record,
}

/// A system with its sequences.
#[derive(Clone, Debug)]
struct ControlledSystem {
    sequences: Sequences,
    actions: Range<usize>,
    zones: Vec<ZoneSlots>,
}

/// The sequences of a system.
#[derive(Clone, Debug)]
enum Sequences {
    AirLoop(Box<AirLoop>),
    SingleZone(Box<SingleZone>),
    Heater(Box<Heater>),
}

impl Guideline36 {
    /// Creates the sequences of all systems of a building.
    pub fn new(spaces: &Spaces, parameters: &Guideline36Parameters) -> Self {
        let climate_zone = inputs::climate_zone(spaces);
        let mut record = Record::default();
        let control = |(system, layout): (&dyn System, &SystemLayout)| {
            let sequences = Sequences::of(system, parameters, climate_zone.as_deref());
            record.add(system.name(), sequences.entries(), &system.zones());
            let cools = system.conditioning() == Conditioning::HeatingAndCooling;
            let slots = layout
                .zones
                .iter()
                .map(|zone| ZoneSlots::of(&spaces.observation, zone.index, zone.controlled, cools));
            ControlledSystem { sequences, actions: layout.actions.clone(), zones: slots.collect() }
        };
        let systems: Vec<_> = spaces.building.laid_out_systems().map(control).collect();
        let zones = systems.iter().map(|system| system.zones.len()).max().unwrap_or(0);
        let demand = DemandLevel::new(parameters.demand_level.round() as u8).unwrap_or_default();
        Self {
            systems,
            site: SiteSlots::of(&spaces.observation, demand),
            hours: 1.0 / f64::from(spaces.episode.steps_per_hour),
            points: Vec::with_capacity(zones),
            record,
        }
    }

    /// Returns what was decided in the last step: modes ([`Mode::number`]), setpoints, requests and loops, by name.
    pub fn record(&self) -> impl Iterator<Item = (&str, f64)> {
        self.record.iter()
    }
}

impl Controller for Guideline36 {
    fn reset(&mut self) {
        self.systems.iter_mut().for_each(|system| system.sequences.reset());
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        let site = self.site.read(observation);
        let mut writer = self.record.writer();
        for ControlledSystem { sequences, actions, zones } in &mut self.systems {
            self.points.clear();
            self.points.extend(zones.iter().map(|zone| zone.read(observation)));
            sequences.act(site, &self.points, &mut action[actions.clone()], self.hours);
            let entries = sequences.entries();
            match sequences {
                Sequences::AirLoop(own) => writer.write(entries, |entry| own.value(entry), own.zones()),
                Sequences::SingleZone(own) => {
                    writer.write(entries, |entry| own.value(entry), std::iter::once(own.zone()));
                }
                Sequences::Heater(own) => {
                    writer.write(entries, |entry| own.value(entry), std::iter::once(own.zone()));
                }
            }
        }
    }
}

impl Sequences {
    fn of(system: &dyn System, parameters: &Guideline36Parameters, climate_zone: Option<&str>) -> Self {
        let Guideline36Parameters { unitary, air_loop, .. } = parameters;
        match system.sequence() {
            Sequence::MultipleZones(own) => {
                let rules = parameters.zone_rules(air_loop.gains);
                Self::AirLoop(Box::new(AirLoop::new(own, air_loop, rules, climate_zone)))
            }
            Sequence::SingleZone { flow, supply_temperature } => {
                let outdoor_air = system.ventilation().map_or(0.0, |air| air.min_outdoor_air);
                let economizes = unitary.economizer >= 0.5 && system.ventilation().is_some();
                let unit = Unit::new(flow, supply_temperature, outdoor_air, economizes, climate_zone);
                let rules = parameters.zone_rules(unitary.gains);
                Self::SingleZone(Box::new(SingleZone::new(unit, unitary, rules)))
            }
            Sequence::Thermostat => {
                let rules = parameters.zone_rules(LoopGains::UNIT);
                Self::Heater(Box::new(Heater::new(system.actuators()[0], rules)))
            }
        }
    }

    fn entries(&self) -> &'static [Entry] {
        match self {
            Self::AirLoop(_) => Entry::AIR_LOOP,
            Self::SingleZone(_) => Entry::UNIT,
            Self::Heater(_) => Entry::HEATER,
        }
    }

    fn reset(&mut self) {
        match self {
            Self::AirLoop(own) => own.reset(),
            Self::SingleZone(own) => own.reset(),
            Self::Heater(own) => own.reset(),
        }
    }

    fn act(&mut self, site: SiteInput, zones: &[ZoneInput], action: &mut [f64], hours: f64) {
        match self {
            Self::AirLoop(own) => own.act(site, zones, action, hours),
            Self::SingleZone(own) => own.act(site, &zones[0], action, hours),
            Self::Heater(own) => own.act(site, &zones[0], action, hours),
        }
    }
}
