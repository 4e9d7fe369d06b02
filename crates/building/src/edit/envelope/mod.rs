//! Edits of the envelope.

pub mod glazing;
pub mod infiltration;
pub mod opaque;
pub(super) mod roof;
pub mod windows;
