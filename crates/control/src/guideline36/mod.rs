//! Sequences of operation of ASHRAE Guideline 36, for the systems of this package.
//!
//! Sections are cited by their printed numbers, as in the 2021 edition. One file holds one sequence:
//!
//! - `modes`: modes of zone groups. `zone`: setpoints, optimum start, demand limiting, loops and requests of a zone.
//! - `air_loop`: an air handler of several zones, with trim and respond, the supply air temperature, the economizer,
//!   outdoor air and terminals.
//! - `single_zone`: a unit of one zone. `thermostat`: a heater, or a zone whose equipment follows its setpoints.
//!
//! A sequence reads [`ZoneInput`] and [`SiteInput`]; `inputs` derives them from observations. `supervision` shifts what
//! the sequences choose.
//!
//! Not representable with the actuators: static pressure, discharge temperatures of terminals, return and relief fans,
//! and the stages of freeze protection on coils.

mod air_loop;
mod inputs;
mod kind;
mod modes;
mod parameters;
mod points;
mod record;
mod setpoints;
mod single_zone;
mod supervision;
#[cfg(test)]
mod tests;
mod thermostat;
mod trim_respond;
mod zone;

use std::ops::Range;

use b2b_building::hvac::{Actuator, Sequence, System, SystemLayout};
use b2b_env::{Controller, Decisions, Spaces};

pub(crate) use kind::Kind;
pub use modes::Mode;
pub use parameters::{Guideline36AirLoopParameters, Guideline36Parameters, Guideline36UnitaryParameters};
pub use points::{NextBand, Setpoints, SiteInput, ZoneInput};
pub use supervision::{Shift, SupervisoryPoint};
pub use trim_respond::Guideline36Reset;
pub use zone::LoopGains;
pub use zone::demand::DemandLevel;

use air_loop::AirLoop;
use inputs::Inputs;
use record::{Entry, Writer};
use single_zone::{SingleZone, Unit};
use supervision::Supervision;
use thermostat::Thermostat;

/// Revision of these sequences, raised when a change of them or of the bands of operation tasks changes trajectories.
/// Baselines, evaluations, schedules of `foresight` and agents that supervise state the revision they were made with.
pub const REVISION: u32 = 5;

/// The guideline's sequences, one set per system of a building.
#[derive(Clone, Debug)]
pub struct Guideline36 {
    systems: Vec<ControlledSystem>,
    inputs: Inputs,
    demand: DemandLevel,
    /// Length of a step, h.
    hours: f64,
    /// Points of the controlled zones.
    points: Vec<ZoneInput>,
    /// Modes ([`Mode::number`]), setpoints, requests and loops of the last step.
    record: Decisions,
    supervision: Supervision,
}

/// A system with its sequences.
#[derive(Clone, Debug)]
struct ControlledSystem {
    sequences: Sequences,
    actions: Range<usize>,
    /// Its zones, as indices of controlled zones.
    zones: Vec<usize>,
}

/// The sequences of a system.
#[derive(Clone, Debug)]
enum Sequences {
    AirLoop(Box<AirLoop>),
    SingleZone(Box<SingleZone>),
    Thermostat(Box<Thermostat>),
}

impl Guideline36 {
    /// Creates the sequences of all systems of a building.
    pub fn new(spaces: &Spaces, parameters: &Guideline36Parameters) -> Self {
        let climate_zone = inputs::climate_zone(spaces);
        let mut record = Decisions::default();
        let control = |(system, layout): (&dyn System, &SystemLayout)| {
            let floor_area = spaces.building.zones[layout.zones[0].index].floor_area;
            let sequences = Sequences::of(system, floor_area, parameters, climate_zone.as_deref());
            let zones = &system.zones()[..system.zones_with_loops()];
            record::add(&mut record, system.name(), sequences.entries(), zones);
            let zones = layout.zones.iter().map(|zone| zone.controlled).collect();
            ControlledSystem { sequences, actions: layout.actions.clone(), zones }
        };
        let systems: Vec<_> = spaces.building.laid_out_systems().map(control).collect();
        let inputs = Inputs::new(spaces);
        Self {
            supervision: Supervision::new(spaces, &systems, &inputs),
            systems,
            inputs,
            demand: DemandLevel::new(parameters.demand_level.round() as u8).unwrap_or_default(),
            hours: 1.0 / f64::from(spaces.episode.steps_per_hour),
            points: Vec::with_capacity(spaces.controlled_zones().count()),
            record,
        }
    }

    /// Returns the points that a supervisor may set, with their limits.
    pub fn supervisory_points(&self) -> &[SupervisoryPoint] {
        self.supervision.points()
    }

    /// Shifts what the sequences choose, from the next step to the next call or reset. All zeros are the guideline
    /// itself. Values beyond the limits of their points are clipped.
    ///
    /// # Panics
    /// If there is not one value for every point of [`Guideline36::supervisory_points`].
    pub fn supervise(&mut self, values: &[f64]) {
        assert_eq!(values.len(), self.supervisory_points().len(), "a value for every supervisory point");
        self.supervision.set(&mut self.systems, |point| values[point]);
    }

    /// Writes the action for the points of the controlled zones, in model order, and of the site.
    pub fn act_on(&mut self, site: SiteInput, zones: &[ZoneInput], action: &mut [f64]) {
        let mut writer = Writer::new(&mut self.record);
        for system in &mut self.systems {
            let zones = system.zones.iter().map(|&zone| &zones[zone]);
            system.sequences.act(site, zones, &mut action[system.actions.clone()], self.hours);
            system.sequences.write(&mut writer);
        }
    }
}

impl Controller for Guideline36 {
    fn reset(&mut self) {
        self.systems.iter_mut().for_each(|system| system.sequences.reset());
        self.record.values.fill(0.0);
        self.supervision.set(&mut self.systems, |_| 0.0);
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        let mut points = std::mem::take(&mut self.points);
        let outdoor_temperature = self.inputs.read(observation, &mut points);
        self.act_on(SiteInput { outdoor_temperature, demand: self.demand }, &points, action);
        self.points = points;
    }

    fn record(&self) -> Option<&Decisions> {
        Some(&self.record)
    }
}

impl Sequences {
    /// Returns the sequences of a system with the floor area of its first zone, m².
    fn of(
        system: &dyn System,
        floor_area: f64,
        parameters: &Guideline36Parameters,
        climate_zone: Option<&str>,
    ) -> Self {
        let Guideline36Parameters { unitary, air_loop, .. } = parameters;
        match system.sequence() {
            Sequence::MultipleZones(own) => {
                let rules = parameters.zone_rules(air_loop.gains);
                Self::AirLoop(Box::new(AirLoop::new(own, air_loop, rules, climate_zone)))
            }
            Sequence::SingleZone { flow, supply_temperature, packaged } => {
                let outdoor_air = system.ventilation().map_or(0.0, |air| air.min_outdoor_air);
                let actuators = [flow, supply_temperature];
                let unit = Unit::new(actuators, floor_area, outdoor_air, packaged, climate_zone);
                let rules = parameters.zone_rules(unitary.gains);
                Self::SingleZone(Box::new(SingleZone::new(unit, unitary, rules)))
            }
            Sequence::Thermostat => Self::thermostat(system.actuators()[0], None, parameters),
            Sequence::Setpoints { heating, cooling } => Self::thermostat(heating, cooling, parameters),
        }
    }

    fn thermostat(
        heating: &Actuator,
        cooling: Option<&Actuator>,
        parameters: &Guideline36Parameters,
    ) -> Self {
        let rules = parameters.zone_rules(LoopGains::UNIT);
        Self::Thermostat(Box::new(Thermostat::new(heating, cooling, rules)))
    }

    fn entries(&self) -> &'static [Entry] {
        match self {
            Self::AirLoop(_) => Entry::AIR_LOOP,
            Self::SingleZone(_) => Entry::UNIT,
            Self::Thermostat(_) => Entry::THERMOSTAT,
        }
    }

    fn reset(&mut self) {
        match self {
            Self::AirLoop(own) => own.reset(),
            Self::SingleZone(own) => own.reset(),
            Self::Thermostat(own) => own.reset(),
        }
    }

    /// Shifts a choice of the system, or of one of its zones.
    fn shift(&mut self, zone: Option<usize>, shift: Shift, value: f64) {
        match (self, zone) {
            (Self::AirLoop(own), None) => own.shift(shift, value),
            (Self::AirLoop(own), Some(zone)) => own.zone_mut(zone).shift(shift, value),
            (Self::SingleZone(own), None) => own.shift(shift, value),
            (Self::SingleZone(own), Some(_)) => own.zone_mut().shift(shift, value),
            (Self::Thermostat(own), _) => own.zone_mut().shift(shift, value),
        }
    }

    fn act<'z>(
        &mut self,
        site: SiteInput,
        zones: impl Iterator<Item = &'z ZoneInput>,
        action: &mut [f64],
        hours: f64,
    ) {
        match self {
            Self::AirLoop(own) => own.act(site, zones, action, hours),
            Self::SingleZone(own) => {
                in_one(zones).iter().for_each(|zone| own.act(site, zone, action, hours));
            }
            Self::Thermostat(own) => zones.take(1).for_each(|zone| own.act(site, zone, action, hours)),
        }
    }

    fn write(&self, writer: &mut Writer<'_>) {
        let entries = self.entries();
        match self {
            Self::AirLoop(own) => writer.write(entries, |entry| own.value(entry), own.zones()),
            Self::SingleZone(own) => {
                writer.write(entries, |entry| own.value(entry), std::iter::once(own.zone()));
            }
            Self::Thermostat(own) => {
                writer.write(entries, |entry| own.value(entry), std::iter::once(own.zone()));
            }
        }
    }
}

/// Returns the points of a unit that serves several zones: the temperature of the first one, which has the thermostat,
/// in the band of the first zone with people, if there is one.
fn in_one<'z>(zones: impl Iterator<Item = &'z ZoneInput>) -> Option<ZoneInput> {
    zones.copied().reduce(|first, other| match other.people && !first.people {
        true => ZoneInput { temperature: first.temperature, ..other },
        false => first,
    })
}
