//! One environment, on the real engine.

mod authority;
mod case;
mod energy;
mod episode;
mod example_system;
mod faults;
mod imported;
mod morphology;
mod operation;
mod pages;
mod presence;
mod random_actions;
mod role_observation;
mod room_unit;
mod setpoints;
mod tasks;
mod ventilation;
