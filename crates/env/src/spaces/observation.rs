//! The observation space, slot by slot.

use std::ops::Range;

use b2b_building::morphology::{Observed, Owner};
use b2b_building::{Conditioning, PreparedBuilding};

use crate::preview::PREVIEW_HOURS;
use crate::setpoints::band::Pair;
use crate::task::Task;
use crate::zones::zone_air::ZoneAir;

/// One slot of the observation.
#[derive(Clone, Debug, PartialEq)]
pub struct Slot {
    /// Name, for example `Core_ZN air temperature`.
    pub name: String,
    /// Part of the building to which the slot belongs.
    pub owner: Owner,
    /// Quantity in the slot.
    pub quantity: Observed,
    /// SI unit.
    pub unit: &'static str,
    /// Lower bound in any plausible run.
    pub low: f64,
    /// Upper bound in any plausible run.
    pub high: f64,
    /// Source of the value.
    pub source: &'static str,
}

/// Names, units and bounds of the observation, in order: air temperature of every zone in model order, outdoor air
/// temperature and humidity, time, and the HVAC energy of the step. With setpoints that vary, occupancy and target of every
/// controlled zone follow, in model order.
///
/// With bands, whether the day is a holiday follows the energy, and a heating and a cooling setpoint replace the target.
/// Where the task needs them, these slots of every controlled zone follow: mean radiant temperature and humidity, CO₂. With
/// a preview: the next setpoints of every controlled zone with the hours until then, and 24 electricity prices, outdoor
/// temperatures and solar radiations of the hours ahead.
///
/// Occupancy and target are for the next step, whose reward uses them.
#[derive(Clone, Debug)]
pub struct ObservationSpace {
    slots: Vec<Slot>,
    zones: usize,
    constant_target: Option<f64>,
    /// Slot of the holiday, with bands.
    holiday: Option<usize>,
    /// Occupancy and setpoint slots of each controlled zone; empty with constant targets.
    asked: Vec<AskedSlots>,
    /// Quantities of zone air besides the temperature, and the first of their slots.
    air: Vec<ZoneAir>,
    first_air: usize,
    /// First slot of the preview.
    ahead: Option<usize>,
}

/// Occupancy and setpoint slots of a controlled zone.
#[derive(Clone, Copy, Debug)]
struct AskedSlots {
    occupancy: usize,
    target: Target,
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

    /// Returns the heating and the cooling setpoint for the step after an observation: both are the target in a task without
    /// bands, and the second is infinite where a band has no cooling.
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

/// Slots shared by all zones, in order; they follow the zone air temperatures.
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

/// Number of shared slots.
const SHARED: usize = Shared::Gas as usize + 1;

/// Upper bound of HVAC power, W/m².
const MAX_POWER: f64 = 1000.0;

/// A slot: name, owner, value, unit, bounds and source.
type SharedSlot = (&'static str, Owner, Observed, &'static str, (f64, f64), &'static str);

/// The slots that every building has, in the order of [`Shared`].
const SHARED_SLOTS: [SharedSlot; SHARED] = [
    (
        "outdoor air temperature",
        Owner::Weather,
        Observed::OutdoorTemperature,
        "°C",
        (-60.0, 60.0),
        "engine: Site Outdoor Air Drybulb Temperature",
    ),
    (
        "outdoor relative humidity",
        Owner::Weather,
        Observed::OutdoorHumidity,
        "%",
        (0.0, 100.0),
        "engine: Site Outdoor Air Relative Humidity",
    ),
    (
        "time of day",
        Owner::Calendar,
        Observed::TimeOfDay,
        "h",
        (0.0, 24.0),
        "calendar, end of the step, standard time",
    ),
    ("day of week", Owner::Calendar, Observed::DayOfWeek, "1", (0.0, 6.0), "calendar, Monday is 0"),
    ("day of year", Owner::Calendar, Observed::DayOfYear, "1", (1.0, 365.0), "calendar, 1 January is 1"),
    (
        "HVAC electricity",
        Owner::Energy,
        Observed::Electricity,
        "Wh/m²",
        (0.0, f64::INFINITY),
        "engine: meters of HVAC electricity (Electricity:HVAC without a plant), of the step",
    ),
    (
        "HVAC gas",
        Owner::Energy,
        Observed::Gas,
        "Wh/m²",
        (0.0, f64::INFINITY),
        "engine: meters of HVAC gas, other fuels and district energy (NaturalGas:HVAC), of the step",
    ),
];

/// Adds the slots of a preview: the next setpoints of every controlled zone, then prices and weather of the hours
/// ahead.
fn preview_slots(
    building: &PreparedBuilding,
    mut give: impl FnMut((String, Owner, Observed, &'static str, (f64, f64), &'static str)),
) {
    const BY_SCHEDULE: &str = "schedules, next change within a week";
    for (number, zone) in building.zones.iter().enumerate() {
        if zone.conditioning == Conditioning::None {
            continue;
        }
        let owner = Owner::Zone(number);
        let name = |word: &str| format!("{} {word}", zone.name);
        let temperature = (0.0, 50.0);
        give((
            name("next band heating setpoint"),
            owner,
            Observed::NextHeatingSetpoint,
            "°C",
            temperature,
            BY_SCHEDULE,
        ));
        if zone.conditioning == Conditioning::HeatingAndCooling {
            let quantity = Observed::NextCoolingSetpoint;
            give((name("next band cooling setpoint"), owner, quantity, "°C", temperature, BY_SCHEDULE));
        }
        give((name("hours to next band"), owner, Observed::HoursToChange, "h", (0.0, 168.0), BY_SCHEDULE));
    }
    let hours = 1..=PREVIEW_HOURS;
    for (word, owner, quantity, unit, bounds, source) in [
        (
            "electricity price",
            Owner::Energy,
            Observed::PriceAhead,
            "1/kWh",
            (-10.0, 10.0),
            "tariff, by the hour",
        ),
        (
            "outdoor temperature",
            Owner::Weather,
            Observed::OutdoorTemperatureAhead,
            "°C",
            (-60.0, 60.0),
            "forecast",
        ),
        ("solar radiation", Owner::Weather, Observed::SolarAhead, "W/m²", (0.0, 1500.0), "forecast"),
    ] {
        for hour in hours.clone() {
            give((format!("{word} {hour} h ahead"), owner, quantity, unit, bounds, source));
        }
    }
}

impl ObservationSpace {
    pub(crate) fn of(building: &PreparedBuilding, steps_per_hour: u32, task: &Task) -> Self {
        let setpoints = &task.setpoints;
        let energy = MAX_POWER / f64::from(steps_per_hour);
        let slot = |name: &str, (owner, quantity), unit, (low, high), source| Slot {
            name: name.into(),
            owner,
            quantity,
            unit,
            low,
            high,
            source,
        };
        let zone_temperature = |(number, zone): (usize, &b2b_building::Zone)| {
            let name = format!("{} air temperature", zone.name);
            let what = (Owner::Zone(number), Observed::AirTemperature);
            slot(&name, what, "°C", (-60.0, 90.0), "engine: Zone Mean Air Temperature")
        };
        let mut slots: Vec<_> = building.zones.iter().enumerate().map(zone_temperature).collect();
        slots.extend(SHARED_SLOTS.iter().map(|(name, owner, observed, unit, (low, high), source)| {
            // The bound of energy depends on the length of a step, that of the day of the year on 29 February.
            let high = match (owner, observed) {
                (Owner::Energy, _) => energy,
                (_, Observed::DayOfYear) => f64::from(building.calendar().days()),
                _ => *high,
            };
            slot(name, (*owner, *observed), unit, (*low, high), source)
        }));
        let holiday = setpoints.is_band().then(|| {
            let what = (Owner::Calendar, Observed::Holiday);
            let source =
                "calendar, 1 on a special day of the model, when schedules do not follow the day of the week";
            slots.push(slot("holiday", what, "1", (0.0, 1.0), source));
            slots.len() - 1
        });
        let constant_target = setpoints.constant_target();
        let has_target =
            |zone: &b2b_building::Zone| constant_target.is_none() && zone.conditioning != Conditioning::None;
        let controlled = building.zones.iter().enumerate().filter(|(_, zone)| has_target(zone));
        let mut asked = Vec::new();
        for (number, zone) in controlled {
            let occupancy = slots.len();
            slots.push(slot(
                &format!("{} occupancy", zone.name),
                (Owner::Zone(number), Observed::Occupancy),
                "1",
                (0.0, 1.0),
                "engine: Zone People Occupant Count over 0 (random setpoints: drawn), for the next step",
            ));
            let mut setpoint = |word: &str, observed| {
                let name = format!("{} {word}", zone.name);
                let what = (Owner::Zone(number), observed);
                slots.push(slot(&name, what, "°C", (0.0, 50.0), "task, for the next step"));
                slots.len() - 1
            };
            let target = match zone.conditioning {
                _ if !setpoints.is_band() => Target::Slot(setpoint("target", Observed::TargetTemperature)),
                Conditioning::HeatingAndCooling => Target::Between([
                    setpoint("band heating setpoint", Observed::HeatingSetpoint),
                    setpoint("band cooling setpoint", Observed::CoolingSetpoint),
                ]),
                _ => Target::Slot(setpoint("band heating setpoint", Observed::HeatingSetpoint)),
            };
            asked.push(AskedSlots { occupancy, target });
        }
        let (air, first_air) = (ZoneAir::of(task), slots.len());
        for (number, zone) in building.zones.iter().enumerate() {
            let controlled = zone.conditioning != Conditioning::None;
            slots.extend(air.iter().filter(|_| controlled).map(|quantity| {
                let quantity = quantity.slot();
                let (name, what) =
                    (format!("{} {}", zone.name, quantity.name), (Owner::Zone(number), quantity.observed));
                slot(&name, what, quantity.unit, quantity.bounds, quantity.source)
            }));
        }
        let ahead = task.preview.map(|_| {
            let first = slots.len();
            preview_slots(building, |(name, owner, quantity, unit, bounds, source)| {
                slots.push(slot(&name, (owner, quantity), unit, bounds, source));
            });
            first
        });
        let zones = building.zones.len();
        Self { slots, zones, constant_target, holiday, asked, air, first_air, ahead }
    }

    /// Returns a space of arbitrary slots.
    #[cfg(test)]
    pub(crate) fn of_slots(slots: Vec<Slot>) -> Self {
        Self {
            slots,
            zones: 0,
            constant_target: Some(21.0),
            holiday: None,
            asked: Vec::new(),
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

    /// Slot of whether the day is a holiday, in a task with bands.
    pub fn holiday(&self) -> Option<usize> {
        self.holiday
    }

    /// Slot of the HVAC electricity of the step, Wh/m².
    pub fn electricity(&self) -> usize {
        self.shared(Shared::Electricity)
    }

    /// Slot of the HVAC gas of the step, with other fuels and district energy, Wh/m².
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
        self.asked.get(controlled_zone).map(|asked| asked.occupancy)
    }

    /// Target of a controlled zone, given its index among the controlled zones.
    pub fn target(&self, controlled_zone: usize) -> Target {
        match self.constant_target {
            Some(target) => Target::Always(target),
            None => self.asked[controlled_zone].target,
        }
    }

    /// Slot of a quantity of the air of a controlled zone, given its index among the controlled zones; `None` if the task
    /// does not observe it.
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
