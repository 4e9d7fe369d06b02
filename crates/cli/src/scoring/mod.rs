//! Commands that score policies, and what they share.

pub(crate) mod baseline;
pub(crate) mod evaluation;
pub(crate) mod score;
pub(crate) mod shipped;
