//! Supervision: what an operator, a planner or an agent adds to the choices of the sequences, which continue to run at
//! every step.
//!
//! A shift of 0 is the guideline's own choice. Setpoints of zones move out of their band by at most the tolerance with
//! which hours count as too cold or too warm, and into it by up to 2 K. The first level of demand limiting needs no
//! point of its own: it is a shift of both setpoints of all zones.

use b2b_building::Conditioning;
use b2b_building::morphology::Owner;
use b2b_env::Spaces;

use super::inputs::Inputs;
use super::{ControlledSystem, Sequences};

/// Distance by which setpoints may leave their band, K.
const OUT: f64 = 0.5;
/// Distance by which setpoints may move into their band, K.
const IN: f64 = 2.0;

/// What a point shifts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shift {
    /// Heating setpoint of a zone, K.
    HeatingSetpoint,
    /// Cooling setpoint of a zone, K.
    CoolingSetpoint,
    /// Time by which recovery of a zone starts earlier, h.
    Start,
    /// Supply air temperature setpoint of an air handler while it does not heat, K.
    SupplyTemperature,
    /// Outdoor temperature above which the economizer of an air handler is off, K.
    EconomizerLimit,
    /// Minimum flow of a running unit, as a share of its design flow.
    MinimumFlow,
    /// Supply air temperature in heating up to which the flow of a unit is not raised, K.
    HeatingTemperature,
    /// Supply air temperature in cooling down to which the flow of a unit is not raised, K.
    CoolingTemperature,
}

/// A value that a supervisor sets.
#[derive(Clone, Debug, PartialEq)]
pub struct SupervisoryPoint {
    /// Name, for example `Core_ZN heating setpoint shift`.
    pub name: String,
    /// The zone or the air handler that it belongs to; a unit's points belong to its zone.
    pub owner: Owner,
    /// What it shifts.
    pub shift: Shift,
    /// Unit of its values.
    pub unit: &'static str,
    /// Lowest value, at most 0.
    pub low: f64,
    /// Highest value, at least 0.
    pub high: f64,
}

impl SupervisoryPoint {
    /// Returns the value at a share of its limits: -1 is the lowest, 0 is no shift, 1 is the highest.
    pub fn value(&self, share: f64) -> f64 {
        if share < 0.0 { -share * self.low } else { share * self.high }
    }
}

/// Where a point acts.
#[derive(Clone, Copy, Debug)]
struct Place {
    system: usize,
    /// Number of the zone in the system; `None` for the system itself.
    zone: Option<usize>,
}

/// The points of a building.
#[derive(Clone, Debug)]
pub(super) struct Supervision {
    points: Vec<SupervisoryPoint>,
    places: Vec<Place>,
}

impl Shift {
    /// The shifts of an air handler of several zones.
    pub const AIR_LOOP: &[Self] = &[Self::SupplyTemperature, Self::EconomizerLimit];
    /// The shifts of a unit of a single zone.
    pub const UNIT: &[Self] = &[Self::MinimumFlow, Self::HeatingTemperature, Self::CoolingTemperature];
    /// The shifts of a zone.
    pub const ZONE: &[Self] = &[Self::HeatingSetpoint, Self::CoolingSetpoint, Self::Start];

    /// Returns name and unit.
    pub fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::HeatingSetpoint => ("heating setpoint shift", "K"),
            Self::CoolingSetpoint => ("cooling setpoint shift", "K"),
            Self::Start => ("earlier start", "h"),
            Self::SupplyTemperature => ("supply air temperature shift", "K"),
            Self::EconomizerLimit => ("economizer limit shift", "K"),
            Self::MinimumFlow => ("minimum flow shift", "1"),
            Self::HeatingTemperature => ("heating supply air temperature shift", "K"),
            Self::CoolingTemperature => ("cooling supply air temperature shift", "K"),
        }
    }

    /// Returns the lowest and the highest value.
    fn limits(self) -> [f64; 2] {
        match self {
            Self::HeatingSetpoint => [-OUT, IN],
            Self::CoolingSetpoint => [-IN, OUT],
            Self::Start => [-2.0, 3.0],
            Self::SupplyTemperature => [-4.0, 6.0],
            Self::EconomizerLimit => [-6.0, 6.0],
            Self::MinimumFlow => [-0.1, 0.3],
            Self::HeatingTemperature => [-3.0, 6.0],
            Self::CoolingTemperature => [-3.0, 4.0],
        }
    }

    /// Returns the point of the shift at an owner.
    fn point(self, name: &str, owner: Owner) -> SupervisoryPoint {
        let ((what, unit), [low, high]) = (self.described(), self.limits());
        SupervisoryPoint { name: format!("{name} {what}"), owner, shift: self, unit, low, high }
    }
}

impl Supervision {
    /// Returns the points of all systems, each system's own before its zones'.
    pub(super) fn new(spaces: &Spaces, systems: &[ControlledSystem], inputs: &Inputs) -> Self {
        let mut own = Self { points: Vec::new(), places: Vec::new() };
        for (system, (described, layout)) in spaces.building.laid_out_systems().enumerate() {
            let sequences = &systems[system].sequences;
            let (owner, shifts) = match sequences {
                Sequences::AirLoop(_) => (Owner::AirLoop(system), Shift::AIR_LOOP),
                Sequences::SingleZone(_) => (Owner::Zone(layout.zones[0].index), Shift::UNIT),
                Sequences::Thermostat(_) => (Owner::Zone(layout.zones[0].index), [].as_slice()),
            };
            let follows = |shift: &&Shift| match sequences {
                Sequences::AirLoop(own) => own.follows(**shift),
                Sequences::SingleZone(_) | Sequences::Thermostat(_) => true,
            };
            for shift in shifts.iter().filter(follows) {
                own.add(shift.point(described.name(), owner), Place { system, zone: None });
            }
            for (number, served) in layout.zones.iter().take(described.zones_with_loops()).enumerate() {
                let zone = &spaces.building.zones[served.index];
                let bites = |shift: &&Shift| match shift {
                    Shift::CoolingSetpoint => zone.conditioning == Conditioning::HeatingAndCooling,
                    Shift::Start => inputs.band_changes(served.controlled),
                    _ => true,
                };
                for shift in Shift::ZONE.iter().filter(bites) {
                    let point = shift.point(&zone.name, Owner::Zone(served.index));
                    own.add(point, Place { system, zone: Some(number) });
                }
            }
        }
        own
    }

    fn add(&mut self, point: SupervisoryPoint, place: Place) {
        self.points.push(point);
        self.places.push(place);
    }

    pub(super) fn points(&self) -> &[SupervisoryPoint] {
        &self.points
    }

    /// Sets the points in the sequences to their values, clipped to their limits.
    pub(super) fn set(&self, systems: &mut [ControlledSystem], value: impl Fn(usize) -> f64) {
        for (index, (point, place)) in self.points.iter().zip(&self.places).enumerate() {
            let value = value(index).clamp(point.low, point.high);
            systems[place.system].sequences.shift(place.zone, point.shift, value);
        }
    }
}
