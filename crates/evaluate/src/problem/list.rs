//! Lists in messages.

use std::fmt;

/// Joins items with commas.
pub(super) fn joined<T: fmt::Display>(items: &[T]) -> String {
    items.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}

/// Joins the first few items and counts the others.
pub(super) fn shortened<T: fmt::Display>(items: &[T]) -> String {
    const SHOWN: usize = 5;
    match items.len().checked_sub(SHOWN) {
        None | Some(0) => joined(items),
        Some(more) => format!("{} and {more} more", joined(&items[..SHOWN])),
    }
}
