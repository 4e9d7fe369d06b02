//! The observation: what an agent sees, slot by slot.

use std::ops::Range;

use b2b_building::{Conditioning, PreparedBuilding};

/// One slot of the observation.
#[derive(Clone, Debug, PartialEq)]
pub struct Slot {
    /// Name, for example `Core_ZN air temperature`.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Lower bound that no sane run crosses.
    pub low: f64,
    /// Upper bound that no sane run crosses.
    pub high: f64,
    /// Where the value comes from.
    pub source: &'static str,
}

/// Names, units and bounds of the observation, in its order: air temperature of every zone in model order, then
/// outdoor temperature and humidity, the clock, the energy of the step, and for every controlled zone in model order its
/// occupancy and its target.
///
/// Occupancy and target are those of the step to come: its reward is judged by them.
#[derive(Clone, Debug)]
pub struct ObservationSpace {
    slots: Vec<Slot>,
    zones: usize,
    controlled_zones: usize,
}

/// Slots after those of the zones, in their order.
#[derive(Clone, Copy)]
pub(crate) enum Shared {
    OutdoorTemperature,
    OutdoorHumidity,
    TimeOfDay,
    DayOfWeek,
    DayOfYear,
    Electricity,
    Gas,
}

/// How many there are.
const SHARED: usize = Shared::Gas as usize + 1;

/// No building takes more power than this, W/m².
const MAXIMUM_POWER: f64 = 1000.0;

impl ObservationSpace {
    pub(crate) fn of(building: &PreparedBuilding, steps_per_hour: u32) -> Self {
        let energy = MAXIMUM_POWER / f64::from(steps_per_hour);
        let slot = |name: &str, unit, low, high, source| Slot { name: name.into(), unit, low, high, source };
        let mut slots: Vec<_> = building
            .zones
            .iter()
            .map(|zone| {
                let name = format!("{} air temperature", zone.name);
                slot(&name, "°C", -60.0, 90.0, "engine: Zone Mean Air Temperature")
            })
            .collect();
        slots.extend([
            slot(
                "outdoor air temperature",
                "°C",
                -60.0,
                60.0,
                "engine: Site Outdoor Air Drybulb Temperature",
            ),
            slot("outdoor relative humidity", "%", 0.0, 100.0, "engine: Site Outdoor Air Relative Humidity"),
            slot("time of day", "h", 0.0, 24.0, "calendar, end of the step, standard time"),
            slot("day of week", "1", 0.0, 6.0, "calendar, Monday is 0"),
            slot("day of year", "1", 1.0, 365.0, "calendar, 1 January is 1"),
            slot("HVAC electricity", "Wh/m²", 0.0, energy, "engine: meter Electricity:HVAC, of the step"),
            slot("HVAC gas", "Wh/m²", 0.0, energy, "engine: meter NaturalGas:HVAC, of the step"),
        ]);
        let controlled = building.zones.iter().filter(|zone| zone.conditioning != Conditioning::None);
        let controlled_zones = controlled.clone().count();
        for zone in controlled {
            let name = |what: &str| format!("{} {what}", zone.name);
            slots.push(slot(
                &name("occupancy"),
                "1",
                0.0,
                1.0,
                "engine: Zone People Occupant Count over 0 (random setpoints: drawn), for the next step",
            ));
            slots.push(slot(&name("target"), "°C", 0.0, 50.0, "task, for the next step"));
        }
        Self { slots, zones: building.zones.len(), controlled_zones }
    }

    /// The slots in order.
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// Number of slots.
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// Whether there are no slots: never.
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// Slots of the zone air temperatures, in model order of the zones.
    pub fn zone_temperatures(&self) -> Range<usize> {
        0..self.zones
    }

    /// Slot of the outdoor air temperature.
    pub fn outdoor_temperature(&self) -> usize {
        self.shared(Shared::OutdoorTemperature)
    }

    /// Slot of the HVAC electricity of the step, Wh/m².
    pub fn electricity(&self) -> usize {
        self.shared(Shared::Electricity)
    }

    /// Slot of the HVAC gas of the step, Wh/m².
    pub fn gas(&self) -> usize {
        self.shared(Shared::Gas)
    }

    /// Number of controlled zones.
    pub fn controlled_zones(&self) -> usize {
        self.controlled_zones
    }

    /// Slot of the occupancy of a controlled zone, counted in model order among the controlled ones.
    pub fn occupancy(&self, controlled_zone: usize) -> usize {
        self.zones + SHARED + 2 * controlled_zone
    }

    /// Slot of the target of a controlled zone, °C; as [`ObservationSpace::occupancy`].
    pub fn target(&self, controlled_zone: usize) -> usize {
        self.occupancy(controlled_zone) + 1
    }

    pub(crate) fn shared(&self, slot: Shared) -> usize {
        self.zones + slot as usize
    }
}
