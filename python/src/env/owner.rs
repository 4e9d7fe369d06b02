//! The part of a building that a slot or a node belongs to, and names of enum variants.

use b2b_building::morphology;
use pyo3::prelude::*;
use serde_json::Value;

/// A part of a building: its weather, calendar or energy, a zone, or the air handler of a central air loop.
#[pyclass(frozen, get_all, eq, module = "building2building._core")]
#[derive(PartialEq)]
pub struct Owner {
    /// `weather`, `calendar`, `energy`, `zone` or `air_loop`.
    kind: &'static str,
    /// Index of the zone or air loop.
    index: Option<usize>,
}

#[pymethods]
impl Owner {
    fn __repr__(&self) -> String {
        match self.index {
            Some(index) => format!("Owner({:?}, {index})", self.kind),
            None => format!("Owner({:?})", self.kind),
        }
    }
}

impl From<morphology::Owner> for Owner {
    fn from(owner: morphology::Owner) -> Self {
        let (kind, index) = match owner {
            morphology::Owner::Weather => ("weather", None),
            morphology::Owner::Calendar => ("calendar", None),
            morphology::Owner::Energy => ("energy", None),
            morphology::Owner::Zone(zone) => ("zone", Some(zone)),
            morphology::Owner::AirLoop(air_loop) => ("air_loop", Some(air_loop)),
        };
        Self { kind, index }
    }
}

/// Returns the JSON name of an enum variant, such as `air_temperature`.
pub fn name_of(variant: impl serde::Serialize) -> String {
    match serde_json::to_value(variant) {
        Ok(Value::String(name)) => name,
        other => unreachable!("{other:?} is not a variant without fields"),
    }
}
