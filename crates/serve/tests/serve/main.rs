//! BOPTEST's interface on the real engine, over HTTP.
#![cfg(target_os = "linux")]

mod client;
mod indicators;
mod nonsense;
mod sequence;
mod server;
