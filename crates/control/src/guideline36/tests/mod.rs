//! Closed loops with small models of rooms.

pub(super) mod room;
