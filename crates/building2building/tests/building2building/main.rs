//! The crate as a Rust program uses it.

mod builder;
mod examples;
mod extension_points;
mod sources;
