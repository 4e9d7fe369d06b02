//! The slots of the observation, group by group.

use b2b_building::morphology::{Observed, Owner};
use b2b_building::{Conditioning, PreparedBuilding, Zone};

use crate::preview::PREVIEW_HOURS;
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

/// A slot: name, owner, quantity, unit, bounds and source.
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
        "engine: meters of HVAC electricity (Electricity:HVAC where the model has no plant), over the step",
    ),
    (
        "HVAC non-electric",
        Owner::Energy,
        Observed::Gas,
        "Wh/m²",
        (0.0, f64::INFINITY),
        "engine: meters of non-electric HVAC energy (NaturalGas:HVAC, other fuels, district energy), of the step",
    ),
];

/// Slots of an observation, in order.
#[derive(Debug, Default)]
pub(crate) struct Slots(Vec<Slot>);

/// Returns the controlled zones of a building, with their indices.
pub(crate) fn controlled(building: &PreparedBuilding) -> impl Iterator<Item = (usize, &Zone)> {
    building.zones.iter().enumerate().filter(|(_, zone)| zone.conditioning != Conditioning::None)
}

impl From<Slots> for Vec<Slot> {
    fn from(slots: Slots) -> Self {
        slots.0
    }
}

impl Slots {
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Adds a slot and returns its index.
    fn add(&mut self, name: &str, (owner, quantity): (Owner, Observed), range: Range) -> usize {
        let Range { unit, bounds: (low, high), source } = range;
        self.0.push(Slot { name: name.to_owned(), owner, quantity, unit, low, high, source });
        self.0.len() - 1
    }

    /// Adds the air temperature of every zone.
    pub(crate) fn add_temperatures(&mut self, building: &PreparedBuilding) {
        for (number, zone) in building.zones.iter().enumerate() {
            let name = format!("{} air temperature", zone.name);
            let range = Range::new("°C", (-60.0, 90.0), "engine: Zone Mean Air Temperature");
            self.add(&name, (Owner::Zone(number), Observed::AirTemperature), range);
        }
    }

    /// Adds the slots that every building has. `energy` is the upper bound of the energy of a step, Wh/m².
    pub(crate) fn add_shared(&mut self, days_of_year: u32, energy: f64) {
        for (name, owner, observed, unit, (low, high), source) in SHARED_SLOTS {
            let high = match (owner, observed) {
                (Owner::Energy, _) => energy,
                (_, Observed::DayOfYear) => f64::from(days_of_year),
                _ => high,
            };
            self.add(name, (owner, observed), Range::new(unit, (low, high), source));
        }
    }

    pub(crate) fn add_holiday(&mut self) -> usize {
        let source =
            "calendar, 1 on a special day of the model, when schedules do not follow the day of the week";
        self.add("holiday", (Owner::Calendar, Observed::Holiday), Range::new("1", (0.0, 1.0), source))
    }

    pub(crate) fn add_occupancy(&mut self, (number, zone): (usize, &Zone), has_bands: bool) -> usize {
        let source = match has_bands {
            true => {
                "engine: Zone People Occupant Count, at least a tenth of design occupancy, for the next step"
            }
            false => "engine: Zone People Occupant Count over 0 (random setpoints: drawn), for the next step",
        };
        let what = (Owner::Zone(number), Observed::Occupancy);
        self.add(&format!("{} occupancy", zone.name), what, Range::new("1", (0.0, 1.0), source))
    }

    /// Adds a setpoint of a zone, named by `word`.
    pub(crate) fn add_setpoint(
        &mut self,
        (number, zone): (usize, &Zone),
        word: &str,
        observed: Observed,
    ) -> usize {
        let range = Range::new("°C", (0.0, 50.0), "task, for the next step");
        self.add(&format!("{} {word}", zone.name), (Owner::Zone(number), observed), range)
    }

    /// Adds quantities of a zone's air besides the temperature.
    pub(crate) fn add_air(&mut self, (number, zone): (usize, &Zone), air: &[ZoneAir]) {
        for quantity in air.iter().map(|quantity| quantity.slot()) {
            let what = (Owner::Zone(number), quantity.observed);
            let range = Range::new(quantity.unit, quantity.bounds, quantity.source);
            self.add(&format!("{} {}", zone.name, quantity.name), what, range);
        }
    }

    /// Adds a preview: the next setpoints of every controlled zone, then prices and weather of the hours ahead. Returns
    /// its first slot.
    pub(crate) fn add_preview(&mut self, building: &PreparedBuilding) -> usize {
        let first = self.len();
        for zone in controlled(building) {
            self.add_next_setpoints(zone);
        }
        let [price, outdoors, sun] = [(-10.0, 10.0), (-60.0, 60.0), (0.0, 1500.0)];
        for (word, owner, quantity, range) in [
            (
                "electricity price",
                Owner::Energy,
                Observed::PriceAhead,
                Range::new("1/kWh", price, "tariff, by the hour; the first is the current one"),
            ),
            (
                "outdoor temperature",
                Owner::Weather,
                Observed::OutdoorTemperatureAhead,
                Range::new("°C", outdoors, "forecast"),
            ),
            ("solar radiation", Owner::Weather, Observed::SolarAhead, Range::new("W/m²", sun, "forecast")),
        ] {
            for hour in 1..=PREVIEW_HOURS {
                self.add(&format!("{word} {hour} h ahead"), (owner, quantity), range);
            }
        }
        first
    }

    fn add_next_setpoints(&mut self, (number, zone): (usize, &Zone)) {
        let by_schedule = |unit, high| Range::new(unit, (0.0, high), "schedules, next change within a week");
        let mut add = |word: &str, quantity, range| {
            self.add(&format!("{} {word}", zone.name), (Owner::Zone(number), quantity), range);
        };
        add("next band heating setpoint", Observed::NextHeatingSetpoint, by_schedule("°C", 50.0));
        if zone.conditioning == Conditioning::HeatingAndCooling {
            add("next band cooling setpoint", Observed::NextCoolingSetpoint, by_schedule("°C", 50.0));
        }
        add("hours to next band", Observed::HoursToChange, by_schedule("h", 168.0));
    }
}

/// Unit, bounds and source of the values in a slot.
#[derive(Clone, Copy, Debug)]
struct Range {
    unit: &'static str,
    bounds: (f64, f64),
    source: &'static str,
}

impl Range {
    const fn new(unit: &'static str, bounds: (f64, f64), source: &'static str) -> Self {
        Self { unit, bounds, source }
    }
}
