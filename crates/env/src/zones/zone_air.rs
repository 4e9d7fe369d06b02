//! Quantities of the air of zones besides its temperature, observed where a task's comfort model or indicators need
//! them.

use b2b_building::morphology::Observed;

use crate::task::Task;
use crate::zones::comfort::Comfort;

/// A quantity of the air of a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneAir {
    /// Mean radiant temperature, °C.
    RadiantTemperature,
    /// Relative humidity, %.
    Humidity,
    /// CO₂ concentration, ppm.
    CarbonDioxide,
}

/// The slot of a quantity in the observation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AirSlot {
    /// Name after the name of the zone.
    pub(crate) name: &'static str,
    pub(crate) observed: Observed,
    pub(crate) unit: &'static str,
    pub(crate) bounds: (f64, f64),
    /// The engine's output.
    pub(crate) variable: &'static str,
    pub(crate) source: &'static str,
}

impl ZoneAir {
    /// Returns the quantities that a task observes in every controlled zone, in the order of their slots: for a comfort
    /// by predicted mean vote in an operation task, and for the CO₂ balance.
    pub(crate) fn of(task: &Task) -> Vec<Self> {
        let votes = task.is_operation() && matches!(task.comfort, Comfort::Pmv(_));
        let thermal = votes.then_some([Self::RadiantTemperature, Self::Humidity]);
        let carbon_dioxide = task.carbon_dioxide.map(|_| Self::CarbonDioxide);
        thermal.into_iter().flatten().chain(carbon_dioxide).collect()
    }

    pub(crate) fn slot(self) -> AirSlot {
        match self {
            Self::RadiantTemperature => AirSlot {
                name: "mean radiant temperature",
                observed: Observed::RadiantTemperature,
                unit: "°C",
                bounds: (-60.0, 90.0),
                variable: "Zone Mean Radiant Temperature",
                source: "engine: Zone Mean Radiant Temperature",
            },
            Self::Humidity => AirSlot {
                name: "relative humidity",
                observed: Observed::Humidity,
                unit: "%",
                bounds: (0.0, 100.0),
                variable: "Zone Air Relative Humidity",
                source: "engine: Zone Air Relative Humidity",
            },
            Self::CarbonDioxide => AirSlot {
                name: "CO2 concentration",
                observed: Observed::CarbonDioxide,
                unit: "ppm",
                bounds: (0.0, 10_000.0),
                variable: "Zone Air CO2 Concentration",
                source: "engine: Zone Air CO2 Concentration",
            },
        }
    }
}
