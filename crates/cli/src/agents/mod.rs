//! Agents without training: data, imitation and export.

pub(crate) mod clone;
pub(crate) mod collect;
pub(crate) mod export;
