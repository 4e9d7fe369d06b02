//! The facts about a building type, as data.

/// The facts about a building type. A type is one file with these facts in this folder, and a variant of the enum in
/// `mod.rs`.
#[derive(Debug)]
pub struct TypeData {
    /// Name, as in building ids.
    pub name: &'static str,
    /// One-line description.
    pub description: &'static str,
    /// The place of its base model.
    pub home: &'static str,
    /// The prototype from which its buildings are derived; `None` if they are generated from parameters alone.
    pub prototype: Option<Prototype>,
    /// Whether central air loops serve its zones; otherwise units serve one zone each.
    pub has_air_loops: bool,
    /// Distributions of random targets.
    pub day: Day,
}

/// A prototype of ASHRAE 90.1-2019 that comes with the engine.
#[derive(Debug)]
pub struct Prototype {
    /// Model file.
    pub file: &'static str,
    /// Window and glass door area over gross exterior wall area of the whole building.
    pub window_to_wall: f64,
    /// Conditioned floor area, m².
    pub conditioned_floor_area: f64,
    /// Whether the code requires energy recovery for a system, given its name, in zones 7 and 8.
    ///
    /// ASHRAE 90.1-2019, table 6.5.6.1.2-1 (less than 8,000 h a year), by the sizes of the prototypes: in zones 7 and 8
    /// the threshold is 2,120 L/s of supply air with 10 to 20 % of outdoor air, and 1,890 L/s with 20 to 30 %. In humid
    /// zones it is 12,270 and 7,550 L/s, and in dry zones higher or absent; no system here is that large. Kitchens and
    /// their make-up air are exempt, and the other systems are smaller.
    pub recovers_heat: fn(&str) -> bool,
}

/// Distributions of random targets, from the paper's implementation.
#[derive(Clone, Copy, Debug)]
pub struct Day {
    /// Arrival of people: mean, standard deviation, earliest and latest, h.
    pub arrival: [f64; 4],
    /// Departure of people: mean, standard deviation, earliest and latest, h.
    pub departure: [f64; 4],
    /// Range of the target when occupied, °C.
    pub occupied: [f64; 2],
    /// Largest offset of the target when unoccupied, K.
    pub offset: f64,
}

/// Requires energy recovery for no system.
pub(super) fn never(_system: &str) -> bool {
    false
}

/// Random targets of an office.
pub(super) const OFFICE_DAY: Day = Day {
    arrival: [8.0, 0.5, 6.5, 10.0],
    departure: [17.0, 0.5, 15.0, 20.0],
    occupied: [20.0, 23.0],
    offset: 3.0,
};
