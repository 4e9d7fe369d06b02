//! The observation space, slot by slot.

use std::ops::Range;

use b2b_building::morphology::Observed;
use b2b_building::{Conditioning, PreparedBuilding, Zone};

use crate::setpoints::band::Pair;
use crate::spaces::slots::{Shared, Slot, Slots, controlled};
use crate::task::Task;
use crate::zones::zone_air::ZoneAir;

/// Upper bound of HVAC power, W/m².
const MAX_POWER: f64 = 1000.0;

/// Names, units and bounds of the observation, in order: air temperature of every zone in model order, outdoor air
/// temperature and humidity, time, and the HVAC energy of the step. With setpoints that vary, occupancy and target of
/// every controlled zone follow, in model order.
///
/// With bands, a flag for holidays follows the energy, and a heating and a cooling setpoint replace the target. Where
/// the task needs them, these slots of every controlled zone follow: mean radiant temperature and humidity, CO₂. With a
/// preview: the next setpoints of every controlled zone with the hours until then, and 24 electricity prices, outdoor
/// temperatures and solar radiations of the hours ahead.
///
/// The target is for the next step, whose reward uses it; occupancy is by the people at the end of the last step.
#[derive(Clone, Debug)]
pub struct ObservationSpace {
    slots: Vec<Slot>,
    zones: usize,
    constant_target: Option<f64>,
    /// Slot of the holiday flag, with bands.
    holiday: Option<usize>,
    /// Occupancy and setpoint slots of each controlled zone; empty with constant targets.
    zone_slots: Vec<ZoneSlots>,
    /// Quantities of zone air besides the temperature, and the first of their slots.
    air: Vec<ZoneAir>,
    first_air: usize,
    /// First slot of the preview.
    ahead: Option<usize>,
}

/// Occupancy and setpoint slots of a controlled zone.
#[derive(Clone, Copy, Debug)]
struct ZoneSlots {
    occupancy: usize,
    target: Target,
}

impl ZoneSlots {
    fn add(slots: &mut Slots, zone: (usize, &Zone), has_bands: bool) -> Self {
        let occupancy = slots.add_occupancy(zone, has_bands);
        let mut setpoint = |word: &str, observed| slots.add_setpoint(zone, word, observed);
        let target = match zone.1.conditioning {
            _ if !has_bands => Target::Slot(setpoint("target", Observed::TargetTemperature)),
            Conditioning::HeatingAndCooling => Target::Between([
                setpoint("band heating setpoint", Observed::HeatingSetpoint),
                setpoint("band cooling setpoint", Observed::CoolingSetpoint),
            ]),
            _ => Target::Slot(setpoint("band heating setpoint", Observed::HeatingSetpoint)),
        };
        Self { occupancy, target }
    }
}

/// Source of the target of a zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// In this slot of the observation.
    Slot(usize),
    /// Halfway between the heating and cooling setpoints in these slots.
    Between([usize; 2]),
    /// Constant, °C.
    Always(f64),
}

impl Target {
    /// Returns the target for the step after an observation, °C.
    pub fn of(self, observation: &[f64]) -> f64 {
        match self {
            Self::Slot(slot) => observation[slot],
            Self::Between([heating, cooling]) => 0.5 * (observation[heating] + observation[cooling]),
            Self::Always(target) => target,
        }
    }

    /// Returns the heating and the cooling setpoint for the step after an observation: both are the target in a task
    /// without bands, and the second is infinite where a band has no cooling.
    pub fn pair_of(self, observation: &[f64], has_bands: bool) -> Pair {
        match self {
            Self::Between([heating, cooling]) => {
                Pair { heating: observation[heating], cooling: observation[cooling] }
            }
            _ if has_bands => Pair { heating: self.of(observation), cooling: f64::INFINITY },
            _ => Pair { heating: self.of(observation), cooling: self.of(observation) },
        }
    }
}

impl ObservationSpace {
    pub(crate) fn of(building: &PreparedBuilding, steps_per_hour: u32, task: &Task) -> Self {
        let setpoints = &task.setpoints;
        let (constant_target, has_bands) = (setpoints.constant_target(), setpoints.is_band());
        let mut slots = Slots::default();
        slots.add_temperatures(building);
        slots.add_shared(building.calendar().days(), MAX_POWER / f64::from(steps_per_hour));
        let holiday = has_bands.then(|| slots.add_holiday());
        let zone_slots = match constant_target {
            Some(_) => Vec::new(),
            None => controlled(building).map(|zone| ZoneSlots::add(&mut slots, zone, has_bands)).collect(),
        };
        let (air, first_air) = (ZoneAir::of(task), slots.len());
        for zone in controlled(building) {
            slots.add_air(zone, &air);
        }
        let ahead = task.preview.map(|_| slots.add_preview(building));
        let zones = building.zones.len();
        Self { slots: slots.into(), zones, constant_target, holiday, zone_slots, air, first_air, ahead }
    }

    /// Returns a space of arbitrary slots.
    #[cfg(test)]
    pub(crate) fn of_slots(slots: Vec<Slot>) -> Self {
        Self {
            slots,
            zones: 0,
            constant_target: Some(21.0),
            holiday: None,
            zone_slots: Vec::new(),
            air: Vec::new(),
            first_air: 0,
            ahead: None,
        }
    }

    /// The slots in order.
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// Number of slots.
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// Returns whether there are no slots. Always `false`.
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

    /// Slot of the outdoor relative humidity.
    pub fn outdoor_humidity(&self) -> usize {
        self.shared(Shared::OutdoorHumidity)
    }

    /// Slot of the time of day, h.
    pub fn time_of_day(&self) -> usize {
        self.shared(Shared::TimeOfDay)
    }

    /// Slot of the day of the week.
    pub fn day_of_week(&self) -> usize {
        self.shared(Shared::DayOfWeek)
    }

    /// Slot of the day of the year.
    pub fn day_of_year(&self) -> usize {
        self.shared(Shared::DayOfYear)
    }

    /// Slot of the holiday flag, in a task with bands.
    pub fn holiday(&self) -> Option<usize> {
        self.holiday
    }

    /// Slot of the HVAC electricity of the step, Wh/m².
    pub fn electricity(&self) -> usize {
        self.shared(Shared::Electricity)
    }

    /// Slot of the non-electric HVAC energy of the step, Wh/m².
    pub fn gas(&self) -> usize {
        self.shared(Shared::Gas)
    }

    /// The target of every controlled zone, °C, if it is constant.
    pub fn constant_target(&self) -> Option<f64> {
        self.constant_target
    }

    /// Slot of the occupancy of a controlled zone, given its index among the controlled zones. `None` if targets are
    /// constant.
    pub fn occupancy(&self, controlled_zone: usize) -> Option<usize> {
        self.zone_slots.get(controlled_zone).map(|slots| slots.occupancy)
    }

    /// Target of a controlled zone, given its index among the controlled zones.
    pub fn target(&self, controlled_zone: usize) -> Target {
        match self.constant_target {
            Some(target) => Target::Always(target),
            None => self.zone_slots[controlled_zone].target,
        }
    }

    /// Slot of a quantity of the air of a controlled zone, given its index among the controlled zones; `None` if the
    /// task does not observe it.
    pub fn zone_air(&self, quantity: ZoneAir, controlled_zone: usize) -> Option<usize> {
        let index = self.air.iter().position(|each| *each == quantity)?;
        Some(self.first_air + controlled_zone * self.air.len() + index)
    }

    /// First slot of the quantities of zone air besides the temperature: of each controlled zone, all quantities.
    pub(crate) fn first_air(&self) -> usize {
        self.first_air
    }

    /// Quantities of zone air besides the temperature.
    pub(crate) fn air(&self) -> &[ZoneAir] {
        &self.air
    }

    /// First slot of the preview, if the task has one: see [`ObservationSpace`].
    pub fn preview(&self) -> Option<usize> {
        self.ahead
    }

    pub(crate) fn shared(&self, slot: Shared) -> usize {
        self.zones + slot as usize
    }
}
