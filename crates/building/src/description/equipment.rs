//! Design flows and capacities of systems.

use serde::Serialize;

use crate::hvac::{Equipment, KindName, System};
use crate::{Model, Result};

/// A system with its capacities.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SystemDescription {
    /// Name of its air loop, its unit or its zone.
    pub name: String,
    /// Its kind.
    pub kind: KindName,
    /// The zones it serves, by number.
    pub zones: Vec<usize>,
    /// Design flow of its fan, kg/s; 0 for a heater and for a zone controlled through its setpoints.
    pub design_flow: f64,
    /// Heating capacity of its central coils, W, without reheat.
    pub heating_capacity: f64,
    /// Cooling capacity of its coils, W.
    pub cooling_capacity: f64,
    /// Capacity of the reheat coils of its terminals, W.
    pub reheat_capacity: f64,
}

/// Describes the systems of a model and the equipment of each of its `zones`.
///
/// # Errors
/// [`crate::Error::MissingObject`] for a dangling reference.
pub(super) fn describe(
    model: &Model,
    systems: &[Box<dyn System>],
    zones: &[String],
) -> Result<(Vec<SystemDescription>, Vec<Option<Equipment>>)> {
    let mut described = Vec::with_capacity(systems.len());
    let mut of_zones = vec![None; zones.len()];
    for system in systems {
        let equipment = system.equipment(model)?;
        let served = system.zones().into_iter().zip(equipment.zones);
        let served =
            served.filter_map(|(zone, equipment)| Some((crate::shape::position(zones, zone)?, equipment)));
        let served: Vec<_> = served.collect();
        let reheat: f64 = served.iter().map(|(_, equipment)| equipment.heating_capacity).sum();
        for (zone, equipment) in &served {
            of_zones[*zone] = Some(*equipment);
        }
        described.push(SystemDescription {
            name: equipment.name,
            kind: system.kind(),
            zones: served.into_iter().map(|(zone, _)| zone).collect(),
            design_flow: equipment.central.design_flow,
            heating_capacity: equipment.central.heating_capacity,
            cooling_capacity: equipment.central.cooling_capacity,
            reheat_capacity: if system.has_air_handler() { reheat } else { 0.0 },
        });
    }
    Ok((described, of_zones))
}
