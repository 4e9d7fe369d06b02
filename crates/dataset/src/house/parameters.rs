//! The parameters of a house.

use super::Capacities;
use crate::{Error, Result};

/// One Btu-based R (h·ft²·°F/Btu) in m²K/W.
pub(super) const IMPERIAL_R: f64 = 0.1761;
/// One Btu-based U (Btu/h·ft²·°F) in W/m²K.
pub(super) const IMPERIAL_U: f64 = 5.678;

/// Effective over nominal resistance of a wood-frame wall. Parallel paths (NBC note A-9.36.2.4): 23 % studs of
/// 0.0085 m²K/W per mm in a 140 mm cavity of 3.52 m²K/W leave 2.43; sheathing, siding, gypsum and films bring back
/// about 0.45.
const WALL_EFFECTIVENESS: f64 = 0.8;
/// Effective over nominal resistance of an attic floor: parallel paths through 11 % truss chords that the insulation
/// covers give 0.97; compression at the eaves and the hatch take the rest (engineering judgement).
const ATTIC_EFFECTIVENESS: f64 = 0.9;
/// Effective over nominal resistance of a finished basement wall: 89 mm studs lose as the walls above do, and many
/// are insulated over a part of their height (engineering judgement).
const FOUNDATION_EFFECTIVENESS: f64 = 0.8;

/// A detached house. SI units; resistances are nominal, as a renovator or a survey states them.
#[derive(Clone, Debug, PartialEq)]
pub struct House {
    /// Heated floor area over all storeys and the basement, m².
    pub floor_area: f64,
    /// Storeys above the foundation, 1 or 2.
    pub storeys: u32,
    /// Length over width of the footprint; the long sides face south and north before `orientation`.
    pub aspect: f64,
    /// Clockwise turn of the south façade from south, degrees.
    pub orientation: f64,
    /// What the house stands on.
    pub foundation: Foundation,
    /// Whether an unheated garage leans on the east side.
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
    /// People who live there.
    pub occupants: f64,
    /// Lighting and appliance energy over that of the standard operating conditions.
    pub appliance_use: f64,
    /// Mean flow of exhaust fans, opened windows or a balanced ventilator, L/s.
    pub ventilation: f64,
    /// Share of the ventilation's sensible heat that is recovered, 0 without a heat-recovery ventilator.
    pub heat_recovery: f64,
    /// What heats the supply air.
    pub heating: Heating,
    /// Gross COP of the cooling, at 35 °C outdoors.
    pub cooling_cop: f64,
    /// Heat of the furnace or the backup over the design heat loss (CSA F280 accepts up to 1.4).
    pub heating_oversizing: f64,
    /// Least cooling capacity over the design heat gain (CSA F280 accepts up to 1.25).
    pub cooling_oversizing: f64,
    /// Sizes of the equipment; `None` takes them from the design days of the site.
    pub capacities: Option<Capacities>,
}

/// What a house stands on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foundation {
    /// A heated basement of a storey's height, counted in the floor area.
    Basement,
    /// A slab on the ground.
    Slab,
    /// An unheated, vented crawlspace under an insulated floor.
    Crawlspace,
}

/// What heats the supply air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heating {
    /// A heat pump with a heater behind it.
    HeatPump {
        /// Gross COP at 8.3 °C outdoors.
        cop: f64,
        /// Outdoor temperature under which the compressor does not heat, °C.
        cutoff: f64,
        /// The heater behind it.
        backup: Heater,
    },
    /// A furnace, with a cooling coil before it.
    Furnace(Heater),
}

/// A heater in the air stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heater {
    /// Electric resistance.
    Electric,
    /// A gas or oil burner and its efficiency; the fuel is metered as gas.
    Fuel {
        /// Heat delivered over fuel burnt, higher heating value.
        efficiency: f64,
    },
}

impl Heating {
    /// The furnace, or the heater behind the heat pump.
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

    /// Resistance of the basement walls, or of the floor over the crawlspace, with thermal bridges and films,
    /// without soil, m²K/W.
    pub fn effective_foundation_resistance(&self) -> f64 {
        self.foundation_resistance * FOUNDATION_EFFECTIVENESS
    }

    /// Ventilation that the house has to heat, L/s.
    pub fn unrecovered_ventilation(&self) -> f64 {
        self.ventilation * (1.0 - self.heat_recovery)
    }

    /// Checks that every parameter is finite and within what the models of its parts hold for.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<()> {
        for (name, value, [low, high]) in self.bounded() {
            // A comparison with NaN is false.
            if !(low <= value && value <= high) {
                return Err(Error::Parameter { name, value, low, high });
            }
        }
        Ok(())
    }

    /// Every parameter that is a number, with its bounds.
    pub(super) fn bounded(&self) -> Vec<(&'static str, f64, [f64; 2])> {
        let mut bounded = vec![
            ("floor_area (m²)", self.floor_area, [40.0, 1000.0]),
            ("storeys", f64::from(self.storeys), [1.0, 2.0]),
            ("aspect", self.aspect, [1.0, 4.0]),
            ("orientation (°)", self.orientation, [0.0, 360.0]),
            ("wall_resistance (m²K/W)", self.wall_resistance, [0.6, 15.0]),
            ("attic_resistance (m²K/W)", self.attic_resistance, [0.6, 20.0]),
            ("foundation_resistance (m²K/W)", self.foundation_resistance, [0.6, 10.0]),
            ("air_changes_50 (1/h)", self.air_changes_50, [0.1, 40.0]),
            ("window_to_wall", self.window_to_wall, [0.01, 0.6]),
            ("window_u (W/m²K)", self.window_u, [0.5, 7.0]),
            ("window_shgc", self.window_shgc, [0.05, 0.9]),
            ("occupants", self.occupants, [0.0, 12.0]),
            ("appliance_use", self.appliance_use, [0.0, 5.0]),
            ("ventilation (L/s)", self.ventilation, [0.0, 200.0]),
            ("heat_recovery", self.heat_recovery, [0.0, 0.95]),
            ("cooling_cop", self.cooling_cop, [1.5, 8.0]),
            ("heating_oversizing", self.heating_oversizing, [1.0, 3.0]),
            ("cooling_oversizing", self.cooling_oversizing, [0.5, 3.0]),
        ];
        if let Heating::HeatPump { cop, cutoff, .. } = self.heating {
            bounded.push(("heating cop", cop, [1.5, 8.0]));
            bounded.push(("heating cutoff (°C)", cutoff, [-30.0, 10.0]));
        }
        if let Heater::Fuel { efficiency } = self.heating.heater() {
            bounded.push(("heater efficiency", efficiency, [0.5, 1.0]));
        }
        if let Some(sizes) = self.capacities {
            bounded.push(("capacities flow (m³/s)", sizes.flow, [0.02, 5.0]));
            bounded.push(("capacities cooling (W)", sizes.cooling, [500.0, 1e5]));
            bounded.push(("capacities heating (W)", sizes.heating, [500.0, 1e5]));
            bounded.push(("capacities backup (W)", sizes.backup, [500.0, 1e5]));
        }
        bounded
    }
}
