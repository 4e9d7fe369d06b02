//! Observations of houses with a fixed width: a slot has the same meaning in every house.
//!
//! Houses have two to four zones. In their own observations the zones are in model order, so the same slot is the
//! garage in one house and the outdoor temperature in another. Here, every zone role has its own slot:
//!
//! | slots | quantity | of a house without the zone, or of a task with constant targets |
//! |---|---|---|
//! | 0 to 3 | air temperature of living area, attic, crawlspace and garage, °C | 0 |
//! | 4 to 10 | weather, calendar and energy, as in [`ObservationSpace`](crate::ObservationSpace) | |
//! | 11, 12 | occupancy and target of the living area | 1 and the constant target |
//! | 13 to 16 | presence of living area, attic, crawlspace and garage, 0 or 1 | 0 |
//!
//! The width and the bounds are the same for every house and task. All buildings of a commercial type have the same
//! zones, so their own observations already agree.

use b2b_building::ZoneRole;

use crate::spaces::Spaces;
use crate::spaces::observation::Target;
use crate::spaces::slots::Slot;

/// Number of roles.
const ROLES: usize = ZoneRole::ALL.len();

/// The value of a slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RoleValue {
    /// Value of this slot of the building's own observation.
    Slot(usize),
    /// A constant within an episode.
    Constant(f64),
}

/// A slot of the fixed width.
#[derive(Clone, Debug, PartialEq)]
pub struct RoleSlot {
    /// Name, for example `garage air temperature`.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Lower bound in any plausible run.
    pub low: f64,
    /// Upper bound in any plausible run.
    pub high: f64,
    /// Value in this building.
    pub value: RoleValue,
}

/// The observation of a house with a slot for every zone role.
#[derive(Clone, Debug, PartialEq)]
pub struct RoleObservation {
    slots: Vec<RoleSlot>,
}

impl RoleObservation {
    /// Number of slots.
    pub const WIDTH: usize = 2 * ROLES + 9;

    /// Returns the role observation of a house; `None` for a building that is not a house of the generator, and for a
    /// task with bands.
    pub fn of(spaces: &Spaces) -> Option<Self> {
        let building = &spaces.building;
        let is_house = |class: b2b_building::Class| class.building_type.is_house();
        building.class.filter(|class| is_house(*class))?;
        let roles: Option<Vec<_>> = building.zones.iter().map(|zone| ZoneRole::of_zone(&zone.name)).collect();
        let roles = roles?;
        let zone = |role: ZoneRole| roles.iter().position(|each| *each == role);
        let space = &spaces.observation;
        let zones = space.zone_temperatures();
        // Shared slots are between the temperatures and the occupancy of the only controlled zone.
        let own = &space.slots()[..space.gas() + 1];
        let temperature = |role: ZoneRole| {
            let value =
                zone(role).map_or(RoleValue::Constant(0.0), |index| RoleValue::Slot(zones.start + index));
            RoleSlot { value, ..slot(format!("{} air temperature", role.name()), "°C", [-60.0, 90.0]) }
        };
        let presence = |role: ZoneRole| {
            let value = RoleValue::Constant(f64::from(u8::from(zone(role).is_some())));
            RoleSlot { value, ..slot(format!("{} present", role.name()), "1", [0.0, 1.0]) }
        };
        let shared = own.iter().enumerate().skip(zones.end).map(|(index, slot)| same(index, slot));
        let occupancy = space.occupancy(0).map_or(RoleValue::Constant(1.0), RoleValue::Slot);
        let target = match space.target(0) {
            Target::Slot(index) => RoleValue::Slot(index),
            Target::Always(target) => RoleValue::Constant(target),
            Target::Between(_) => return None,
        };
        let slots = ZoneRole::ALL
            .map(temperature)
            .into_iter()
            .chain(shared)
            .chain([
                RoleSlot { value: occupancy, ..slot("living occupancy".into(), "1", [0.0, 1.0]) },
                RoleSlot { value: target, ..slot("living target".into(), "°C", [0.0, 50.0]) },
            ])
            .chain(ZoneRole::ALL.map(presence))
            .collect();
        Some(Self { slots })
    }

    /// Returns the slots.
    pub fn slots(&self) -> &[RoleSlot] {
        &self.slots
    }

    /// Writes an observation of the building in the fixed width.
    ///
    /// # Panics
    /// When `row` has fewer than [`RoleObservation::WIDTH`] values, or the observation is not one of the building.
    pub fn write(&self, observation: &[f64], row: &mut [f64]) {
        for (value, slot) in row[..Self::WIDTH].iter_mut().zip(&self.slots) {
            *value = match slot.value {
                RoleValue::Slot(index) => observation[index],
                RoleValue::Constant(constant) => constant,
            };
        }
    }
}

fn slot(name: String, unit: &'static str, [low, high]: [f64; 2]) -> RoleSlot {
    RoleSlot { name, unit, low, high, value: RoleValue::Constant(0.0) }
}

/// A slot copied from the building's own observation.
fn same(index: usize, own: &Slot) -> RoleSlot {
    let Slot { name, unit, low, high, .. } = own;
    RoleSlot { value: RoleValue::Slot(index), ..slot(name.clone(), unit, [*low, *high]) }
}
