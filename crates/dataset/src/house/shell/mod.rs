//! The shell: surfaces, their layers, the ground and the air that leaks through.

pub(crate) mod buffers;
pub(crate) mod construction;
pub(crate) mod envelope;
pub(crate) mod ground;
pub(crate) mod infiltration;
pub(crate) mod surface;
