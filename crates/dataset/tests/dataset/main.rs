//! Generated buildings on the real engine.

mod any_place;
mod commercial;
mod description;
mod exhaust;
