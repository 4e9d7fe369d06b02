//! Tests of the crate from a Rust program's point of view.

mod builder;
mod examples;
mod extension_points;
mod sources;
