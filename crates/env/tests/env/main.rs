//! One environment, on the real engine.

mod authority;
mod case;
mod energy;
mod episode;
mod example_system;
mod faults;
mod imported;
mod models;
mod morphology;
mod operation;
mod pages;
mod presence;
mod random_actions;
mod role_observation;
mod setpoints;
mod tasks;
mod ventilation;
