//! Limits of the numbers of a task.

use crate::{Error, Result};

/// Checks that a number of a task is finite and within its limits.
///
/// # Errors
/// [`Error::TaskValue`] with name, value and limits.
pub(crate) fn within(name: &'static str, value: f64, low: f64, high: f64) -> Result<()> {
    if (low..=high).contains(&value) && value.is_finite() {
        return Ok(());
    }
    Err(Error::TaskValue { name, value, low, high })
}
