//! Controller parameters: a JSON object whose numbers are listed in a table with their bounds.

use std::path::Path;

use b2b_building::parameter::Field;
use b2b_building::{Parameter, user_file};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::{Error, Result};

/// A row of a table: the keys of a number, its unit and its bounds. Its name is the keys joined by dots.
macro_rules! parameter {
    ($first:ident $(. $next:ident)*, $unit:literal, $low:literal, $high:literal) => {
        b2b_building::parameter::Field::new(
            b2b_building::Parameter::new(
                concat!(stringify!($first) $(, ".", stringify!($next))*), $unit, $low, $high,
            ),
            |parameters| &mut parameters.$first $(.$next)*,
        )
    };
}

pub(crate) use parameter;

/// Sets a parameter by its name in a table, without checking its value. `controller` is for the message.
///
/// # Errors
/// [`Error::UnknownParameter`].
pub(crate) fn set<P: Clone>(
    parameters: &mut P,
    table: &[Field<P>],
    controller: &'static str,
    name: &str,
    value: f64,
) -> Result<()> {
    let field = table.iter().find(|field| field.parameter.name == name);
    let field = field.ok_or_else(|| Error::UnknownParameter {
        controller,
        name: name.to_owned(),
        known: table.iter().map(|field| field.parameter.name).collect(),
    })?;
    field.set(parameters, value);
    Ok(())
}

/// Checks that every value is within its bounds, and the minimum supply air temperature (°C) at most the maximum.
///
/// # Errors
/// [`Error::Parameter`] for the first value that is not.
pub(crate) fn check<P: Clone>(parameters: &P, table: &[Field<P>], supply: [f64; 2]) -> Result<()> {
    table.iter().try_for_each(|field| field.check(parameters))?;
    let [min, max] = supply;
    Ok(Parameter::new("air_loop.min_supply_temperature", "°C", 5.0, max).check(min)?)
}

/// Reads parameters from a JSON file, without checking their values.
///
/// # Errors
/// [`Error::Io`]; [`Error::ParameterFile`] with the reason.
pub(crate) fn read<P: DeserializeOwned>(path: &Path) -> Result<P> {
    let text = user_file::read(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
    user_file::parse_object(&text).map_err(|why| Error::ParameterFile { path: path.to_owned(), why })
}

/// Returns parameters as JSON.
pub(crate) fn to_json(parameters: &impl Serialize) -> Value {
    serde_json::to_value(parameters).expect("plain numbers always serialize")
}

/// Returns JSON as parameters.
///
/// # Errors
/// [`Error::Values`].
pub(crate) fn from_json<P: DeserializeOwned>(values: &Value) -> Result<P> {
    P::deserialize(values).map_err(|error| Error::Values { why: error.to_string() })
}
