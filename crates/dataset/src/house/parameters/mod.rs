//! The parameters of a house.

pub(crate) mod bounds;

use super::household::Household;
use super::hvac::capacities::Capacities;

/// One Btu-based R (h·ft²·°F/Btu) in m²K/W.
pub(super) const IMPERIAL_R: f64 = 0.1761;
/// One Btu-based U (Btu/h·ft²·°F) in W/m²K.
pub(super) const IMPERIAL_U: f64 = 5.678;

/// Effective over nominal resistance of a wood-frame wall. Parallel paths (NBC note A-9.36.2.4): 23 % studs of
/// 0.0085 m²K/W per mm in a 140 mm cavity of 3.52 m²K/W leave 2.43; sheathing, siding, gypsum and films bring back
/// about 0.45.
const WALL_EFFECTIVENESS: f64 = 0.8;
/// Effective over nominal resistance of an attic floor: parallel paths through 11 % truss chords that the insulation
/// covers give 0.97; compression at the eaves and the hatch take the rest (engineering judgment).
const ATTIC_EFFECTIVENESS: f64 = 0.9;
/// Effective over nominal resistance of a finished basement wall: 89 mm studs are thermal bridges as in the walls
/// above, and many walls are insulated over part of their height (engineering judgment).
const FOUNDATION_EFFECTIVENESS: f64 = 0.8;

/// Seed of a household of two who are both out on every weekday.
const COUPLE_AT_WORK: u64 = 17;

/// A detached house. SI units; resistances are nominal, as in surveys.
#[derive(Clone, Debug, PartialEq)]
pub struct House {
    /// Heated floor area over all storeys and the basement, m².
    pub floor_area: f64,
    /// Storeys above the foundation, 1 or 2.
    pub storeys: u32,
    /// Length over width of the footprint; the long sides face south and north before `orientation`.
    pub aspect: f64,
    /// Clockwise rotation of the south façade from south, degrees.
    pub orientation: f64,
    /// Foundation.
    pub foundation: Foundation,
    /// Whether there is an unheated garage on the east side.
    pub garage: bool,
    /// Nominal resistance of the walls, m²K/W.
    pub wall_resistance: f64,
    /// Nominal resistance of the attic floor, m²K/W.
    pub attic_resistance: f64,
    /// Nominal resistance of the basement walls, of the insulation at the edge of the slab, or of the floor over the
    /// crawlspace, m²K/W.
    pub foundation_resistance: f64,
    /// Air changes per hour at 50 Pa.
    pub air_changes_50: f64,
    /// Window area over the area of the outer walls above the foundation.
    pub window_to_wall: f64,
    /// Window U-factor with films, W/m²K.
    pub window_u: f64,
    /// Window solar heat gain coefficient.
    pub window_shgc: f64,
    /// Number of occupants, rounded to whole people.
    pub occupants: f64,
    /// Seed of the occupants' weekly presence ([`Household::draw`]).
    pub household: u64,
    /// Lighting and appliance energy relative to the standard operating conditions.
    pub appliance_use: f64,
    /// Mean flow of exhaust fans, opened windows or a balanced ventilator, L/s.
    pub ventilation: f64,
    /// Share of the ventilation's sensible heat that is recovered, 0 without a heat-recovery ventilator.
    pub heat_recovery: f64,
    /// Heating system.
    pub heating: Heating,
    /// Gross COP of the cooling, at 35 °C outdoors.
    pub cooling_cop: f64,
    /// Heat of the furnace or the backup over the design heat loss (CSA F280 accepts up to 1.4).
    pub heating_oversizing: f64,
    /// Minimum cooling capacity over the design heat gain (CSA F280 accepts up to 1.25).
    pub cooling_oversizing: f64,
    /// Sizes of the equipment; `None` takes them from the design days of the site.
    pub capacities: Option<Capacities>,
}

/// Foundations of a house.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foundation {
    /// A heated basement of a storey's height, counted in the floor area.
    Basement,
    /// A slab on the ground.
    Slab,
    /// An unheated, vented crawlspace under an insulated floor.
    Crawlspace,
}

/// Heating systems of a house.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heating {
    /// A heat pump with a backup heater.
    HeatPump {
        /// Gross COP at 8.3 °C outdoors.
        cop: f64,
        /// Outdoor temperature under which the compressor does not heat, °C.
        cutoff: f64,
        /// The backup heater.
        backup: Heater,
    },
    /// A furnace with a cooling coil upstream.
    Furnace(Heater),
}

/// A heater in the air stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heater {
    /// Electric resistance.
    Electric,
    /// A gas or oil burner and its efficiency; the fuel is metered as gas.
    Fuel {
        /// Heat delivered over fuel burned, higher heating value.
        efficiency: f64,
    },
}

impl Heating {
    /// Returns the furnace or the backup heater.
    pub fn heater(&self) -> Heater {
        match *self {
            Self::HeatPump { backup, .. } => backup,
            Self::Furnace(heater) => heater,
        }
    }
}

impl Default for House {
    /// A typical 1971-86 detached house: one storey over a heated basement, 160 m² (medians of the stock survey of
    /// Québec's detached houses for that vintage).
    fn default() -> Self {
        Self {
            floor_area: 160.0,
            storeys: 1,
            aspect: 1.8,
            orientation: 0.0,
            foundation: Foundation::Basement,
            garage: false,
            wall_resistance: 17.2 * IMPERIAL_R,
            attic_resistance: 27.3 * IMPERIAL_R,
            foundation_resistance: 14.4 * IMPERIAL_R,
            air_changes_50: 4.0,
            window_to_wall: 0.12,
            window_u: 0.49 * IMPERIAL_U,
            window_shgc: 0.56,
            occupants: 2.0,
            household: COUPLE_AT_WORK,
            appliance_use: 1.0,
            ventilation: 25.0,
            heat_recovery: 0.0,
            heating: Heating::HeatPump { cop: 3.3, cutoff: -12.0, backup: Heater::Electric },
            cooling_cop: 3.5,
            heating_oversizing: 1.3,
            cooling_oversizing: 1.25,
            capacities: None,
        }
    }
}

impl House {
    /// Resistance of the walls with thermal bridges and films, m²K/W.
    pub fn effective_wall_resistance(&self) -> f64 {
        self.wall_resistance * WALL_EFFECTIVENESS
    }

    /// Resistance of the attic floor with thermal bridges and films, m²K/W.
    pub fn effective_attic_resistance(&self) -> f64 {
        self.attic_resistance * ATTIC_EFFECTIVENESS
    }

    /// Resistance of the basement walls, of the insulation at the edge of the slab, or of the floor over the
    /// crawlspace, with thermal bridges and films, without soil, m²K/W.
    pub fn effective_foundation_resistance(&self) -> f64 {
        self.foundation_resistance * FOUNDATION_EFFECTIVENESS
    }

    /// Returns the occupants and their week.
    pub fn draw_household(&self) -> Household {
        Household::draw(self.occupants.round() as u32, self.household)
    }

    /// Returns the ventilation without heat recovery, L/s.
    pub fn unrecovered_ventilation(&self) -> f64 {
        self.ventilation * (1.0 - self.heat_recovery)
    }
}
