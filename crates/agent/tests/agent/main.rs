//! Agents in buildings, on the real engine.

mod agent;
mod graph;
mod supervision;
