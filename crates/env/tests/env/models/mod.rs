//! Small models of users, as epJSON.
#![allow(dead_code, reason = "every test file takes what it needs")]

pub mod fan_coil;
pub mod office;
pub mod packaged;
pub mod room;
