//! The kinds of systems.

use std::fmt;

use serde::{Serialize, Serializer};
use serde_json::Value;

use super::KINDS;
use super::references::{Reference, is_one_of};
use super::system::{FromModel, System};
use crate::{Error, Model, Result};

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

/// Name of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KindName {
    /// Identifier in files, for example `air_loop`.
    pub id: &'static str,
    /// Name, for example `air loop`.
    pub name: &'static str,
    /// Name of several, for example `air loops`.
    pub plural: &'static str,
}

/// A kind of system: how it is found, made controllable and read from a file.
#[derive(Clone, Copy)]
pub struct Kind {
    name: KindName,
    claims: fn(&Model, Candidate<'_>) -> Result<bool>,
    make_controllable: fn(&mut Model, Candidate<'_>, f64) -> Result<Box<dyn System>>,
    read: fn(Value) -> serde_json::Result<Box<dyn System>>,
}

impl Kind {
    /// The kind of systems of a type.
    pub const fn of<T: FromModel>() -> Self {
        Self {
            name: T::NAME,
            claims: T::claims,
            make_controllable: |model, candidate, air_density| {
                Ok(Box::new(T::make_controllable(model, candidate, air_density)?))
            },
            read: |fields| Ok(Box::new(serde_json::from_value::<T>(fields)?)),
        }
    }

    /// Returns the kind with an identifier, among [`KINDS`].
    pub fn find(id: &str) -> Option<Self> {
        KINDS.into_iter().find(|kind| kind.id() == id)
    }

    /// Identifier in files, for example `air_loop`.
    pub fn id(self) -> &'static str {
        self.name.id
    }

    /// Name, for example `air loop`.
    pub fn name(self) -> &'static str {
        self.name.name
    }

    /// Name of several, for example `air loops`.
    pub fn plural(self) -> &'static str {
        self.name.plural
    }

    /// As [`FromModel::claims`].
    pub(super) fn claims(self, model: &Model, candidate: Candidate<'_>) -> Result<bool> {
        (self.claims)(model, candidate)
    }

    /// As [`FromModel::make_controllable`].
    pub(super) fn make_controllable(
        self,
        model: &mut Model,
        candidate: Candidate<'_>,
        air_density: f64,
    ) -> Result<Box<dyn System>> {
        (self.make_controllable)(model, candidate, air_density)
    }

    /// Reads the fields of a system.
    pub(super) fn read(self, fields: Value) -> serde_json::Result<Box<dyn System>> {
        (self.read)(fields)
    }
}

impl PartialEq for Kind {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl fmt::Debug for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

impl Serialize for Kind {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_str(self.id())
    }
}
