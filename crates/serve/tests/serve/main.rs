//! BOPTEST's interface on the real engine, over HTTP.

mod client;
mod indicators;
mod nonsense;
mod sequence;
mod server;
