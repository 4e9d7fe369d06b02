//! The universe: the node types of all buildings, with the attribute, observation and action space of each.

use serde::Serialize;

use crate::hvac::actuator::Quantity;

/// Node types. Arrays of nodes are in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NodeType {
    /// Outdoor weather, one per building. Observations only.
    Weather,
    /// Calendar, one per building. Observations only.
    Calendar,
    /// Energy of the step, one per building. Observations only.
    Energy,
    /// The air handler of a central air loop. Actions only.
    AirLoop,
    /// A zone with a unitary system: flow and supply temperature.
    UnitaryZone,
    /// A zone with a terminal of a central air loop: damper and reheat.
    VavZone,
    /// A zone with a heater only.
    HeatingOnlyZone,
    /// A zone without controlled equipment, such as an attic or a plenum. Observations only.
    UncontrolledZone,
    /// A zone whose equipment follows the heating and the cooling setpoint of its thermostat.
    SetpointZone,
    /// A zone with a terminal of a central air loop, and no heat of its own: damper.
    DamperZone,
    /// A zone that shares the air of a unitary system, which the thermostat of another zone controls. Observations
    /// only.
    FollowingZone,
}

/// Observed quantities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Observed {
    /// Air temperature of a zone, °C.
    AirTemperature,
    /// Target temperature of a zone, °C.
    TargetTemperature,
    /// Heating setpoint of a zone's comfort band, °C.
    HeatingSetpoint,
    /// Cooling setpoint of a zone's comfort band, °C.
    CoolingSetpoint,
    /// Heating setpoint of a zone after its next change, °C.
    NextHeatingSetpoint,
    /// Cooling setpoint of a zone after its next change, °C.
    NextCoolingSetpoint,
    /// Hours until the next change of a zone's setpoints.
    HoursToChange,
    /// Electricity price of a coming hour, currency/kWh.
    PriceAhead,
    /// Outdoor temperature of a coming hour, °C.
    OutdoorTemperatureAhead,
    /// Solar radiation of a coming hour, W/m².
    SolarAhead,
    /// Whether a zone is occupied, 0 or 1.
    Occupancy,
    /// Mean radiant temperature of a zone, °C.
    RadiantTemperature,
    /// Relative humidity of a zone, %.
    Humidity,
    /// CO₂ concentration of a zone, ppm.
    CarbonDioxide,
    /// Outdoor air temperature, °C.
    OutdoorTemperature,
    /// Outdoor relative humidity, %.
    OutdoorHumidity,
    /// Hour of the day, h.
    TimeOfDay,
    /// Day of the week, Monday is 0.
    DayOfWeek,
    /// Day of the year, 1 January is 1.
    DayOfYear,
    /// Whether the day is a holiday, 0 or 1.
    Holiday,
    /// HVAC electricity of the step, Wh/m².
    Electricity,
    /// Non-electric HVAC energy of the step: gas, other fuels and district energy, Wh/m².
    Gas,
}

/// Attributes of nodes and buildings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Attribute {
    /// Floor area of a zone, or of all conditioned zones, m².
    FloorArea,
    /// Volume, m³.
    Volume,
    /// Center of a zone from west to east in the bounding box, before rotation.
    CenterX,
    /// Center of a zone from south to north in the bounding box, before rotation.
    CenterY,
    /// Center of a zone from bottom to top in the bounding box.
    CenterZ,
    /// Size of a zone along x, relative to the bounding box.
    ExtentX,
    /// Size of a zone along y, relative to the bounding box.
    ExtentY,
    /// Size of a zone along z, relative to the bounding box.
    ExtentZ,
    /// Exterior walls as a fraction of all walls of a zone.
    ExteriorWallFraction,
    /// Roof-to-floor ratio.
    RoofToFloor,
    /// Area in ground contact as a fraction of all enclosing surfaces of a zone.
    GroundContactFraction,
    /// Window-to-wall ratio; 0 without exterior walls.
    WindowToWall,
    /// Leakage, air changes per hour.
    Infiltration,
    /// Design air flow, kg/s.
    DesignFlow,
    /// Heating capacity, W.
    HeatingCapacity,
    /// Cooling capacity, W.
    CoolingCapacity,
    /// Number of zones that a system serves.
    ZonesServed,
    /// Year of construction or of the building code; 0 if unknown.
    Year,
    /// Degrees north.
    Latitude,
    /// Heating degree-days below 18 °C, K·d.
    HeatingDegreeDays,
    /// Cooling degree-days above 10 °C, K·d.
    CoolingDegreeDays,
    /// Angle from true north to the y axis, clockwise, degrees.
    NorthAxis,
    /// Number of levels with a conditioned floor.
    Levels,
    /// U-factor of the exterior walls, W/m²K; 0 if unknown.
    WallU,
    /// U-factor of the roofs, W/m²K; 0 if unknown.
    RoofU,
    /// U-factor of the windows, W/m²K; 0 without windows or if unknown.
    WindowU,
    /// Solar heat gain coefficient of the windows; 0 without windows or if unknown.
    WindowShgc,
    /// Number of systems.
    Systems,
    /// Number of controlled zones.
    ControlledZones,
    /// Number of actuators.
    Actuators,
}

/// One slot of a space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LocalSlot<Q> {
    /// The quantity.
    pub quantity: Q,
    /// Unit; 1 for ratios, counts and dates.
    pub unit: &'static str,
    /// Typical lowest value, for scaling; values may be lower.
    pub low: f64,
    /// Typical highest value, for scaling; values may be higher.
    pub high: f64,
}

/// The spaces of the universe, as data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Universe {
    /// Attributes of a whole building. There are no common observations and actions, because quantities observed once
    /// per building have a node.
    pub common_attributes: &'static [LocalSlot<Attribute>],
    /// The node types in order, with their spaces.
    pub node_types: Vec<LocalSpaces>,
}

/// The spaces of one node type.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LocalSpaces {
    /// The type.
    pub node_type: NodeType,
    /// Attribute space.
    pub attributes: &'static [LocalSlot<Attribute>],
    /// Observation space.
    pub observation: &'static [LocalSlot<Observed>],
    /// Action space.
    pub action: &'static [LocalSlot<Quantity>],
}

impl Universe {
    /// The universe of all buildings.
    pub fn new() -> Self {
        Self { common_attributes: COMMON, node_types: NodeType::ALL.map(NodeType::spaces).to_vec() }
    }
}

impl<Q> LocalSlot<Q> {
    /// Returns a value scaled from the bounds to [-1, 1] and clipped; 0 if it is unknown (not a number).
    pub fn scaled(&self, value: f64) -> f64 {
        if value.is_nan() {
            return 0.0;
        }
        (2.0 * (value - self.low) / (self.high - self.low) - 1.0).clamp(-1.0, 1.0)
    }
}

impl Default for Universe {
    fn default() -> Self {
        Self::new()
    }
}

impl NodeType {
    /// Every type, in order.
    pub const ALL: [Self; 11] = [
        Self::Weather,
        Self::Calendar,
        Self::Energy,
        Self::AirLoop,
        Self::UnitaryZone,
        Self::VavZone,
        Self::HeatingOnlyZone,
        Self::UncontrolledZone,
        Self::SetpointZone,
        Self::DamperZone,
        Self::FollowingZone,
    ];

    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Weather => "weather",
            Self::Calendar => "calendar",
            Self::Energy => "energy",
            Self::AirLoop => "air loop",
            Self::UnitaryZone => "unitary zone",
            Self::VavZone => "VAV zone",
            Self::HeatingOnlyZone => "heating-only zone",
            Self::UncontrolledZone => "uncontrolled zone",
            Self::SetpointZone => "setpoint zone",
            Self::DamperZone => "damper zone",
            Self::FollowingZone => "following zone",
        }
    }

    /// Returns whether it is a thermal zone.
    pub fn is_zone(self) -> bool {
        !self.attributes().is_empty() && self != Self::AirLoop
    }

    /// Attribute, observation and action space.
    pub fn spaces(self) -> LocalSpaces {
        LocalSpaces {
            node_type: self,
            attributes: self.attributes(),
            observation: self.observation(),
            action: self.action(),
        }
    }

    /// Attribute space: constants of a node.
    pub fn attributes(self) -> &'static [LocalSlot<Attribute>] {
        match self {
            Self::Weather | Self::Calendar | Self::Energy => &[],
            Self::AirLoop => AIR_LOOP,
            Self::UnitaryZone | Self::SetpointZone => UNITARY_ZONE.as_slice(),
            Self::VavZone | Self::HeatingOnlyZone | Self::DamperZone | Self::FollowingZone => {
                HEATED_ZONE.as_slice()
            }
            Self::UncontrolledZone => ZONE.as_slice(),
        }
    }

    /// Observation space. Every controlled zone has a target and an occupancy, even if a task keeps them constant.
    pub fn observation(self) -> &'static [LocalSlot<Observed>] {
        match self {
            Self::Weather => WEATHER,
            Self::Calendar => CALENDAR,
            Self::Energy => ENERGY,
            Self::AirLoop => &[],
            Self::UnitaryZone
            | Self::VavZone
            | Self::HeatingOnlyZone
            | Self::SetpointZone
            | Self::DamperZone
            | Self::FollowingZone => CONTROLLED_ZONE,
            Self::UncontrolledZone => &[AIR_TEMPERATURE],
        }
    }

    /// Action space, in physical units, within the bounds of the building's action space.
    pub fn action(self) -> &'static [LocalSlot<Quantity>] {
        match self {
            Self::AirLoop => SUPPLY_AIR,
            Self::UnitaryZone => UNIT,
            Self::VavZone => TERMINAL,
            Self::HeatingOnlyZone => HEATER,
            Self::SetpointZone => THERMOSTAT,
            Self::DamperZone => DAMPER,
            Self::Weather | Self::Calendar | Self::Energy | Self::UncontrolledZone | Self::FollowingZone => {
                &[]
            }
        }
    }
}

const fn slot<Q>(quantity: Q, unit: &'static str, low: f64, high: f64) -> LocalSlot<Q> {
    LocalSlot { quantity, unit, low, high }
}

const AIR_TEMPERATURE: LocalSlot<Observed> = slot(Observed::AirTemperature, "°C", -20.0, 50.0);

const CONTROLLED_ZONE: &[LocalSlot<Observed>] = &[
    AIR_TEMPERATURE,
    slot(Observed::TargetTemperature, "°C", 10.0, 32.0),
    slot(Observed::Occupancy, "1", 0.0, 1.0),
];
const WEATHER: &[LocalSlot<Observed>] = &[
    slot(Observed::OutdoorTemperature, "°C", -40.0, 45.0),
    slot(Observed::OutdoorHumidity, "%", 0.0, 100.0),
];
const CALENDAR: &[LocalSlot<Observed>] = &[
    slot(Observed::TimeOfDay, "h", 0.0, 24.0),
    slot(Observed::DayOfWeek, "1", 0.0, 6.0),
    slot(Observed::DayOfYear, "1", 1.0, 365.0),
];
const ENERGY: &[LocalSlot<Observed>] =
    &[slot(Observed::Electricity, "Wh/m²", 0.0, 20.0), slot(Observed::Gas, "Wh/m²", 0.0, 20.0)];

const SUPPLY_AIR: &[LocalSlot<Quantity>] = &[
    slot(Quantity::SupplyAirTemperature, "°C", 10.0, 55.0),
    slot(Quantity::OutdoorAirFlow, "kg/s", 0.0, 20.0),
];
const UNIT: &[LocalSlot<Quantity>] = &[
    slot(Quantity::SupplyAirFlow, "kg/s", 0.0, 20.0),
    slot(Quantity::SupplyAirTemperature, "°C", 10.0, 45.0),
];
const TERMINAL: &[LocalSlot<Quantity>] =
    &[slot(Quantity::DamperOpening, "1", 0.0, 1.0), slot(Quantity::HeatingSetpoint, "°C", 10.0, 30.0)];
const DAMPER: &[LocalSlot<Quantity>] = &[slot(Quantity::DamperOpening, "1", 0.0, 1.0)];
const HEATER: &[LocalSlot<Quantity>] = &[slot(Quantity::HeatingSetpoint, "°C", 5.0, 35.0)];
const THERMOSTAT: &[LocalSlot<Quantity>] =
    &[slot(Quantity::HeatingSetpoint, "°C", 10.0, 30.0), slot(Quantity::CoolingSetpoint, "°C", 15.0, 35.0)];

/// Attributes of a whole building.
pub const COMMON: &[LocalSlot<Attribute>] = &[
    slot(Attribute::FloorArea, "m²", 0.0, 12_000.0),
    slot(Attribute::Volume, "m³", 0.0, 100_000.0),
    slot(Attribute::Year, "1", 1900.0, 2030.0),
    slot(Attribute::Latitude, "°", -90.0, 90.0),
    slot(Attribute::HeatingDegreeDays, "K·d", 0.0, 9000.0),
    slot(Attribute::CoolingDegreeDays, "K·d", 0.0, 6000.0),
    slot(Attribute::NorthAxis, "°", 0.0, 360.0),
    slot(Attribute::Levels, "1", 1.0, 10.0),
    slot(Attribute::WallU, "W/m²K", 0.0, 2.0),
    slot(Attribute::RoofU, "W/m²K", 0.0, 1.0),
    slot(Attribute::WindowU, "W/m²K", 0.0, 7.0),
    slot(Attribute::WindowShgc, "1", 0.0, 1.0),
    slot(Attribute::WindowToWall, "1", 0.0, 1.0),
    slot(Attribute::Infiltration, "1/h", 0.0, 2.0),
    slot(Attribute::Systems, "1", 0.0, 20.0),
    slot(Attribute::ControlledZones, "1", 0.0, 50.0),
    slot(Attribute::Actuators, "1", 0.0, 100.0),
];

const AIR_LOOP: &[LocalSlot<Attribute>] = &[
    slot(Attribute::DesignFlow, "kg/s", 0.0, 20.0),
    slot(Attribute::HeatingCapacity, "W", 0.0, 1e6),
    slot(Attribute::CoolingCapacity, "W", 0.0, 1e6),
    slot(Attribute::ZonesServed, "1", 1.0, 20.0),
];

/// Attributes of every zone.
const ZONE: [LocalSlot<Attribute>; 13] = [
    slot(Attribute::FloorArea, "m²", 0.0, 8000.0),
    slot(Attribute::Volume, "m³", 0.0, 80_000.0),
    slot(Attribute::CenterX, "1", 0.0, 1.0),
    slot(Attribute::CenterY, "1", 0.0, 1.0),
    slot(Attribute::CenterZ, "1", 0.0, 1.0),
    slot(Attribute::ExtentX, "1", 0.0, 1.0),
    slot(Attribute::ExtentY, "1", 0.0, 1.0),
    slot(Attribute::ExtentZ, "1", 0.0, 1.0),
    slot(Attribute::ExteriorWallFraction, "1", 0.0, 1.0),
    slot(Attribute::RoofToFloor, "1", 0.0, 1.5),
    slot(Attribute::GroundContactFraction, "1", 0.0, 1.0),
    slot(Attribute::WindowToWall, "1", 0.0, 1.0),
    slot(Attribute::Infiltration, "1/h", 0.0, 20.0),
];
const DESIGN_FLOW: LocalSlot<Attribute> = slot(Attribute::DesignFlow, "kg/s", 0.0, 20.0);
const HEATING: LocalSlot<Attribute> = slot(Attribute::HeatingCapacity, "W", 0.0, 500_000.0);
const COOLING: LocalSlot<Attribute> = slot(Attribute::CoolingCapacity, "W", 0.0, 500_000.0);
static HEATED_ZONE: [LocalSlot<Attribute>; 15] = with([DESIGN_FLOW, HEATING]);
static UNITARY_ZONE: [LocalSlot<Attribute>; 16] = with([DESIGN_FLOW, HEATING, COOLING]);

/// The attributes of every zone and additional ones.
const fn with<const MORE: usize, const ALL: usize>(
    more: [LocalSlot<Attribute>; MORE],
) -> [LocalSlot<Attribute>; ALL] {
    let mut all = [DESIGN_FLOW; ALL];
    let mut index = 0;
    while index < ALL {
        all[index] = if index < ZONE.len() { ZONE[index] } else { more[index - ZONE.len()] };
        index += 1;
    }
    all
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn quantities_are_unique_in_a_space_and_bounds_are_ordered() {
        fn check<Q: std::hash::Hash + Eq + Copy>(space: &[LocalSlot<Q>]) {
            assert_eq!(space.iter().map(|slot| slot.quantity).collect::<HashSet<_>>().len(), space.len());
            assert!(space.iter().all(|slot| slot.low < slot.high));
        }
        check(COMMON);
        for spaces in Universe::new().node_types {
            check(spaces.attributes);
            check(spaces.observation);
            check(spaces.action);
        }
    }

    #[test]
    fn a_scaled_value_is_relative_to_the_bounds_and_clipped() {
        let area = slot((), "m²", 0.0, 12_000.0);
        let scaled = [0.0, 6000.0, 12_000.0, 20_000.0, f64::NAN].map(|value| area.scaled(value));
        assert_eq!(scaled, [-1.0, 0.0, 1.0, 1.0, 0.0]);
    }

    #[test]
    fn controlled_zones_have_a_target_and_actions_have_the_units_of_actuators() {
        for node_type in NodeType::ALL {
            let has = |observed| node_type.observation().iter().any(|slot| slot.quantity == observed);
            assert_eq!(has(Observed::AirTemperature), node_type.is_zone());
            assert_eq!(
                has(Observed::TargetTemperature),
                node_type.is_zone() && node_type != NodeType::UncontrolledZone
            );
            for slot in node_type.action() {
                assert_eq!(slot.unit, slot.quantity.unit());
            }
        }
    }
}
