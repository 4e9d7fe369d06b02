//! A room of two nodes: air with furniture, and the mass of the building.

/// Heat capacity of the air and the furniture, J/K: 300 m³ with eight times the capacity of its air.
const AIR: f64 = 300.0 * 1.2 * 1006.0 * 8.0;
/// Heat capacity of the mass, J/K.
const MASS: f64 = 3e7;
/// Conductance between air and mass, W/K.
const INSIDE: f64 = 400.0;
/// Conductance between air and outdoors, W/K.
const LOSSES: f64 = 120.0;
/// Substeps of a step.
const SUBSTEPS: u32 = 60;
/// Specific heat of air, J/(kg K).
pub(crate) const SPECIFIC_HEAT: f64 = 1006.0;

/// A room of 100 m².
#[derive(Clone, Debug)]
pub(crate) struct Room {
    /// Air temperature, °C.
    pub(crate) air: f64,
    mass: f64,
    /// Heat of people, equipment and sun, W.
    pub(crate) gains: f64,
}

impl Room {
    pub(crate) fn new(temperature: f64) -> Self {
        Self { air: temperature, mass: temperature, gains: 0.0 }
    }

    /// Brings air and mass close to a day at an outdoor temperature, °C.
    pub(crate) fn soak(&mut self, outdoor: f64) {
        let near = self.air + 0.1 * (outdoor - self.air);
        (self.air, self.mass) = (near, near);
    }

    /// Advances by a step (h) with heat from a heater, W.
    pub(crate) fn step(&mut self, outdoor: f64, heat: f64, hours: f64) {
        self.blow(outdoor, heat, 0.0, 20.0, hours);
    }

    /// Advances by a step (h) with heat (W) and supply air of a flow (kg/s) and a temperature (°C).
    pub(crate) fn blow(&mut self, outdoor: f64, heat: f64, flow: f64, supply: f64, hours: f64) {
        let seconds = hours * 3600.0 / f64::from(SUBSTEPS);
        for _ in 0..SUBSTEPS {
            let exchange = INSIDE * (self.mass - self.air);
            let air = heat
                + self.gains
                + exchange
                + LOSSES * (outdoor - self.air)
                + flow * SPECIFIC_HEAT * (supply - self.air);
            self.air += air * seconds / AIR;
            self.mass -= exchange * seconds / MASS;
        }
    }
}
