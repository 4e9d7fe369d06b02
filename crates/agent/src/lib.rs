//! Agents: what they observe, how they act, their networks and their folders.

pub mod network;
