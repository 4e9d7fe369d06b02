//! The parts of a model that systems may control.

use super::references::{Reference, is_one_of};
use crate::{Error, Result};

/// A part of a model that a system may control.
#[derive(Clone, Copy, Debug)]
pub enum Candidate<'a> {
    /// An `AirLoopHVAC`, by name.
    AirLoop(&'a str),
    /// A piece of equipment of a zone.
    Equipment {
        /// Name of the zone.
        zone: &'a str,
        /// The equipment.
        object: &'a Reference,
    },
    /// A zone, by name, with equipment that nothing else controls.
    Zone(&'a str),
}

impl<'a> Candidate<'a> {
    /// Returns the name of an air loop.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for another candidate.
    pub fn air_loop(self) -> Result<&'a str> {
        match self {
            Self::AirLoop(air_loop) => Ok(air_loop),
            _ => Err(self.unsupported("it is not an air loop")),
        }
    }

    /// Returns the zone of a piece of equipment, and the equipment.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for another candidate.
    pub fn equipment(self) -> Result<(&'a str, &'a Reference)> {
        match self {
            Self::Equipment { zone, object } => Ok((zone, object)),
            _ => Err(self.unsupported("it is not equipment of a zone")),
        }
    }

    /// Returns the name of a zone whose equipment nothing else controls.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for another candidate.
    pub fn zone(self) -> Result<&'a str> {
        match self {
            Self::Zone(zone) => Ok(zone),
            _ => Err(self.unsupported("it is not a zone")),
        }
    }

    /// An [`Error::Unsupported`] for it.
    pub fn unsupported(self, why: &str) -> Error {
        match self {
            Self::AirLoop(air_loop) => Error::unsupported("AirLoopHVAC", air_loop, why),
            Self::Equipment { object, .. } => Error::unsupported(&object.class, &object.name, why),
            Self::Zone(zone) => Error::unsupported("Zone", zone, why),
        }
    }

    /// Returns whether it is a piece of equipment of one of these classes.
    pub fn is_equipment(self, classes: &[&str]) -> bool {
        matches!(self, Self::Equipment { object, .. } if is_one_of(&object.class, classes))
    }
}
