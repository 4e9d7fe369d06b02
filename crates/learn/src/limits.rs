//! Limits of the options of algorithms.

use crate::error::{Error, Result};

/// The value of an option by name.
pub(crate) type Named<T> = (&'static str, T);

/// Checks that numbers are finite and above 0.
pub(crate) fn check_positive<const N: usize>(values: [Named<f64>; N]) -> Result<()> {
    check(values, |value| value.is_finite() && *value > 0.0, "it must be finite and above 0")
}

/// Checks that numbers are finite and at least 0.
pub(crate) fn check_not_negative<const N: usize>(values: [Named<f64>; N]) -> Result<()> {
    check(values, |value| value.is_finite() && *value >= 0.0, "it must be finite and at least 0")
}

/// Checks that numbers are finite.
pub(crate) fn check_finite<const N: usize>(values: [Named<f64>; N]) -> Result<()> {
    check(values, |value| value.is_finite(), "it must be finite")
}

/// Checks that numbers are from 0 to 1.
pub(crate) fn check_shares<const N: usize>(values: [Named<f64>; N]) -> Result<()> {
    check(values, |value| (0.0..=1.0).contains(value), "it must be from 0 to 1")
}

/// Checks that counts are at least 1.
pub(crate) fn check_counts<const N: usize>(values: [Named<usize>; N]) -> Result<()> {
    check(values, |value| *value >= 1, "it must be at least 1")
}

/// Checks that the widths of hidden layers are at least 1.
pub(crate) fn check_widths(values: [Named<&[usize]>; 2]) -> Result<()> {
    values.into_iter().try_for_each(|(name, widths)| {
        let narrowest = widths.iter().min().copied().unwrap_or(1);
        check([(name, narrowest)], |width| *width >= 1, "widths must be at least 1")
    })
}

/// Checks a condition.
///
/// # Errors
/// [`Error::Invalid`] with the reason.
pub(crate) fn require(holds: bool, why: impl FnOnce() -> String) -> Result<()> {
    if holds { Ok(()) } else { Err(Error::Invalid(why())) }
}

fn check<T: Copy + std::fmt::Display, const N: usize>(
    values: [Named<T>; N],
    is_valid: impl Fn(&T) -> bool,
    expected: &'static str,
) -> Result<()> {
    match values.into_iter().find(|(_, value)| !is_valid(value)) {
        Some((name, value)) => Err(Error::config(name, value, expected)),
        None => Ok(()),
    }
}
