//! Kinds of systems.

use std::fmt;

use serde_json::Value;

use super::candidate::Candidate;
use super::system::{FromModel, KindName, System};
use crate::{Model, Result};

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

impl fmt::Debug for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}
